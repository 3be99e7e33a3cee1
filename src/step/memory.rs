//! Memory that a scene needs, by purpose, compared with what the machine has.

use super::{error::InstallError, numbers::short, warnings};
use crate::{
    boundary::{friction, moving},
    index,
    loading::Size,
    memory,
    registry::{Stages, columns},
    reorder,
    scene::{Scene, TimeStep},
    state::Material,
};

/// Components that every particle has: position, velocity, density, pressure.
const COMPONENTS: usize = 4;

/// A candidate sample of a mesh, with its entries in the lists of the advancing front \[bytes].
const BYTES_A_CANDIDATE: f64 = 60.0;

/// The program, its threads, and what else does not grow with the particles \[bytes].
const PROGRAM: f64 = 16e6;

/// Memory that a scene needs \[bytes].
pub(crate) struct Need {
    /// While it runs.
    running: f64,
    /// At the peak: during setup, if that needs more.
    pub(crate) most: f64,
    /// The part of it that no other spacing changes.
    fixed: f64,
    /// By what holds it.
    pub(crate) parts: Vec<(&'static str, f64)>,
}

/// Expected number of neighbours of a particle inside the fluid.
pub(super) fn expected_neighbours(scene: &Scene, material: &Material) -> f32 {
    let lattice = material.kernel.lattice(scene.dimension, scene.spacing);
    lattice.count() as f32 - 1.0
}

/// Memory that a scene of this size needs. Fails if a dense index cannot cover it.
pub(crate) fn need(scene: &Scene, size: &Size) -> Result<Need, InstallError> {
    let material = Material::new(scene);
    let sum = |bytes: Vec<(&'static str, f64)>| bytes.iter().map(|(_, bytes)| bytes).sum::<f64>();
    let neighbours = expected_neighbours(scene, &material);
    let a_particle = sum(Stages::default().bytes(scene, neighbours));
    let a_sample = sum(bytes_per_boundary_particle(scene));
    let cells = |(low, high)| index::table_bytes(scene, low, high);
    let mut tables = cells(size.fluid_box).map_err(InstallError::Fluid)?;
    if !scene.boundaries.is_empty() {
        tables += cells(size.whole_box).map_err(InstallError::Boundary)?;
    }
    let fluid = size.fluid + size.emitted;
    // The places by entity grow to powers of two.
    let entities = fluid + size.boundary;
    let places = 24.0 * (entities.max(1.0).log2().ceil().exp2() - entities);
    let mut parts = vec![
        ("fluid particles", fluid * a_particle),
        ("boundary particles", size.boundary * a_sample),
        ("room in the places by entity", places),
        ("reordering", reordering(scene, fluid)),
        ("tables of the spatial index", tables as f64),
        ("the program", PROGRAM),
    ];
    let running = parts.iter().map(|part| part.1).sum();
    let sampling = size.fluid * a_particle + size.boundary * a_sample;
    let most = f64::max(running, sampling + size.candidates * BYTES_A_CANDIDATE);
    parts.push(("more while walls are sampled", most - running));
    parts.retain(|part| part.1 > 0.0);
    Ok(Need {
        running,
        most,
        fixed: PROGRAM,
        parts,
    })
}

/// Memory of the reordering of so many rows, if the scene lasts until the first \[bytes].
fn reordering(scene: &Scene, rows: f64) -> f64 {
    let longest = match scene.time_step {
        TimeStep::Fixed(dt) => dt,
        TimeStep::Cfl(cfl) => cfl.max,
        TimeStep::Adaptive(scheme) => scheme.max,
    };
    let least_steps = scene.duration / longest;
    if scene.reorder_interval == 0 || least_steps < scene.reorder_interval as f32 {
        return 0.0;
    }
    let components = columns(scene).filter(|column| column.lasting.is_some());
    reorder::bytes(rows, components.count().saturating_sub(COMPONENTS))
}

/// What a run takes beside what is planned: vectors that grow \[parts of the need].
const BESIDE: f64 = 1.25;

/// Refuses a scene that needs more memory than there is `beside` what else needs it \[bytes], before any is allocated.
/// It runs with a number of threads.
pub(super) fn check(
    scene: &Scene,
    size: &Size,
    beside: f64,
    threads: usize,
) -> Result<(), InstallError> {
    let mut need = need(scene, size)?;
    need.running += beside;
    need.fixed += beside;
    need.most = need.most.max(need.running);
    enough(scene, size, &need, memory::of_machine() as f64)?;
    if !memory::is_left_by_limit(BESIDE * need.most, threads) {
        let needed = memory::in_words(BESIDE * need.most);
        return Err(InstallError::MemoryLimit { needed });
    }
    Ok(())
}

/// As [`warnings`](super::warnings()), of a scene that is to run beside what else needs memory: refused if both do not
/// fit, as [`install`](super::install) refuses one that does not fit alone. `beside` says how much that is \[bytes] for
/// so many fluid and boundary particles.
pub fn warnings_beside(
    scene: &Scene,
    beside: impl FnOnce(f64, f64) -> f64,
) -> Result<Vec<String>, InstallError> {
    let size = scene.checked_size()?;
    let beside = beside(size.fluid + size.emitted, size.boundary);
    check(scene, &size, beside, 1)?;
    Ok(warnings::of_size(scene, &size))
}

/// Memory that a scene may take \[bytes]: the machine's, or less where it says so.
pub(crate) fn allowed(scene: &Scene, machine: f64) -> f64 {
    (scene.memory_limit).map_or(machine, |limit| machine.min(1e9 * f64::from(limit)))
}

fn enough(scene: &Scene, size: &Size, need: &Need, machine: f64) -> Result<(), InstallError> {
    let allowed = allowed(scene, machine);
    if need.most <= allowed {
        return Ok(());
    }
    let by_limit = if allowed < machine {
        " by `memory_limit`"
    } else {
        ""
    };
    let machine = allowed;
    let mut parts = vec![format!("{} fluid particles", many(size.fluid))];
    if size.emitted > 0.0 {
        parts.push(format!("{} from emitters", many(size.emitted)));
    }
    if size.boundary > 0.0 {
        parts.push(format!("{} boundary particles", many(size.boundary)));
    }
    if need.most > need.running {
        let candidates = size.candidates / 1e6;
        parts.push(format!(
            "{candidates:.0} million candidates for the samples of a mesh"
        ));
    }
    // The number of particles on surfaces grows with spacing⁻², in bodies with spacing⁻³: the square is the safe
    // choice.
    let left = machine - need.fixed;
    let better = f64::from(scene.spacing) * (1.2 * (need.most - need.fixed) / left).sqrt();
    let remedy = if left <= 0.01 * machine {
        format!(
            "no spacing would do, because {} of it are the program and what does not grow with the particles; it needs \
             more",
            memory::in_words(need.fixed)
        )
    } else {
        format!(
            "a spacing of {} m would do, or a smaller scene",
            short(better)
        )
    };
    Err(InstallError::Memory {
        needed: memory::in_words(need.most),
        machine: memory::in_words(machine) + by_limit,
        parts: parts.join(", "),
        remedy,
    })
}

/// A number of particles in words.
fn many(count: f64) -> String {
    match count {
        count if count < 1e5 => format!("{count:.0}"),
        count => format!("{:.1} million", count / 1e6),
    }
}

pub(super) fn bytes_per_boundary_particle(scene: &Scene) -> Vec<(&'static str, f64)> {
    let mut bytes = vec![
        // Three columns of 28 bytes together, 8 bytes of change ticks per column, and the entity's entries in table,
        // archetype and list of places.
        (
            "tables: position, normal, volume",
            28.0 + 3.0 * 8.0 + 8.0 + 16.0 + 24.0,
        ),
        ("packed positions and normals", 16.0 + 12.0),
        ("spatial index", index::bytes_per_particle(scene)),
    ];
    if scene.skin().is_some() {
        bytes.push(("places of the last search", 16.0));
    }
    if moving::is_wanted(scene) {
        // Places at the end of the step, velocities, and poses in columns and in rows.
        bytes.push(("walls in motion", 32.0 + 28.0 + 8.0 + 32.0));
    }
    if friction::is_wanted(scene) {
        bytes.push(("friction of walls", 8.0 + 12.0 + 4.0 + 4.0 + 8.0));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hollow tank with a drop: nearly all of its particles are boundary particles.
    fn hollow(spacing: f32) -> Scene {
        let text = format!(
            "(name: \"t\", spacing: {spacing}, bodies: [(shape: Box(min: (0, 0, 0), max: (0.1, 0.1, 0.1)))],
            boundaries: [Tank(min: (0, 0, 0), max: (3, 3, 3))])"
        );
        Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn what_the_machine_does_not_have_is_refused_with_a_spacing_that_would_do() {
        let scene = hollow(0.01);
        let size = scene.checked_size().expect("a scene");
        let need = need(&scene, &size).expect("an index");
        // 540 000 boundary particles of about 180 bytes each.
        assert!((8e7..2e8).contains(&need.most), "{}", need.most);
        assert!(enough(&scene, &size, &need, 2.0 * need.most).is_ok());
        let machine = 0.25 * need.most;
        let error = enough(&scene, &size, &need, machine).expect_err("a small machine");
        let text = error.to_string();
        assert!(text.contains("boundary particles"), "{text}");
        let better = text
            .split("a spacing of ")
            .nth(1)
            .and_then(|rest| rest.split(' ').next())
            .and_then(|number| number.parse().ok())
            .expect("a spacing");
        let mut limited = scene.clone();
        limited.memory_limit = Some((0.5e-9 * need.most) as f32);
        let error = enough(&limited, &size, &need, 2.0 * need.most).expect_err("a small limit");
        assert!(
            error.to_string().contains("MB by `memory_limit`"),
            "{error}"
        );
        limited.memory_limit = Some((1.5e-9 * need.most) as f32);
        assert!(enough(&limited, &size, &need, 2.0 * need.most).is_ok());
        let scene = hollow(better);
        let size = scene.checked_size().expect("a scene");
        let need = super::need(&scene, &size).expect("an index");
        assert!(enough(&scene, &size, &need, machine).is_ok());
    }
}
