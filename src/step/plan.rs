//! Describes what a scene would run, without running it. To find the initial density, memory is allocated only for part
//! of the particles at a time.

use glam::{DVec3, Vec3};

use super::{
    error::{Burst, InstallError, StartDensity},
    limits, memory,
    order::{Flow, order_of},
    start_density,
    start_errors::{burst, thrown},
    start_slabs, warnings,
};
use crate::{
    boundary,
    filling::{self, Filling},
    index,
    loading::Size,
    registry::Stages,
    sampling,
    scene::{Scene, shapes::Inlet},
    state::{Execution, Material, Phase},
};

/// A mesh with at most this many candidates is sampled to count its particles: 30 MB.
const FEW_CANDIDATES: f64 = 5e5;

/// The plan of a scene.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Plan {
    /// Fluid particles at the start, those behind emitters' faces included.
    pub particles: usize,
    /// The emitters, in the order of the scene.
    pub emitters: Vec<PlannedEmitter>,
    /// Boundary particles.
    pub boundary_particles: usize,
    /// Whether the number of boundary particles is estimated: meshes with many particles are not sampled for a plan.
    pub boundary_is_estimate: bool,
    /// The box around the fluid at the start \[m].
    pub fluid_box: (Vec3, Vec3),
    /// The box around fluid and boundaries \[m].
    pub whole_box: (Vec3, Vec3),
    /// Support radius h \[m].
    pub support_radius: f32,
    /// Mass of a particle \[kg; kg/m in 2-D].
    pub particle_mass: f32,
    /// Phases with their stages, in order.
    pub phases: Vec<(Phase, Vec<String>)>,
    /// The flow of data through the stages.
    pub flow: Vec<Flow>,
    /// Memory by purpose \[bytes per fluid particle].
    pub bytes_per_particle: Vec<(&'static str, f64)>,
    /// Memory by purpose \[bytes per boundary particle].
    pub bytes_per_boundary_particle: Vec<(&'static str, f64)>,
    /// Upper limits of the time step by cause \[s].
    pub time_step_limits: Vec<(String, f32)>,
    /// Expected number of neighbours of a particle inside the fluid.
    pub expected_neighbours: f32,
    /// Steps until the end of the scene if every step is as long as the limits at the largest speed of free fall allow.
    pub expected_steps: f64,
    /// Peak memory of the simulation, tables of a dense index included, without output \[bytes].
    pub memory: f64,
    /// The same by what holds it \[bytes].
    pub memory_by_part: Vec<(&'static str, f64)>,
    /// Fluid particles at once, at most: those that emitters add included.
    pub most_particles: f64,
    /// Allowed settings that are probably mistakes.
    pub warnings: Vec<String>,
    /// Initial density of the fluid; `None` if meshes have too many samples to compute it for a plan.
    pub start_density: Option<StartDensity>,
}

/// What an emitter adds to a scene.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PlannedEmitter {
    /// Particles in a layer.
    pub layer: usize,
    /// Distance between layers \[m].
    pub pitch: f64,
    /// Layers that wait behind the face.
    pub waiting: u32,
    /// Volume that enters per second \[m³/s; m²/s in 2-D].
    pub flow: f64,
    /// Particles until the end of the scene, those behind the face included.
    pub particles: u64,
}

/// The emitters of a scene. Adds what they have emitted at the start to a number of particles, and to the box around
/// them.
fn emitters(
    scene: &Scene,
    (particles, low, high): (&mut usize, &mut Vec3, &mut Vec3),
) -> Vec<PlannedEmitter> {
    let numbered = scene.emitters.iter();
    numbered
        .map(|emitter| {
            let inlet = Inlet::new(emitter, scene);
            *particles += inlet.particles(emitter, 0.0) as usize;
            let (min, max) = inlet.bounds();
            (*low, *high) = (low.min(min.as_vec3()), high.max(max.as_vec3()));
            PlannedEmitter {
                layer: inlet.points.len(),
                pitch: inlet.pitch,
                waiting: inlet.waiting,
                flow: inlet.area * f64::from(emitter.speed),
                particles: inlet.particles(emitter, scene.duration.into()),
            }
        })
        .collect()
}

/// Plans a scene. Refuses what [`install`](super::install) would refuse.
pub fn plan(scene: &Scene) -> Result<Plan, InstallError> {
    plan_beside(scene, |_, _| 0.0)
}

/// Plans a scene that is to run beside what else needs memory: `beside` says how much \[bytes] for so many fluid and
/// boundary particles. Refuses also what does not fit together.
pub fn plan_beside(
    scene: &Scene,
    beside: impl FnOnce(f64, f64) -> f64,
) -> Result<Plan, InstallError> {
    let size = scene.checked_size()?;
    let order = order_of(scene, &Stages::default())?;
    let beside = beside(size.fluid + size.emitted, size.boundary);
    // Its checks run on one thread.
    memory::check(scene, &size, beside, 1)?;
    let material = Material::new(scene);
    let (mut particles, mut low, mut high) = (0, Vec3::INFINITY, Vec3::NEG_INFINITY);
    Filling::new(scene).for_each(|seed| {
        particles += 1;
        (low, high) = (low.min(seed.position), high.max(seed.position));
    });
    let in_bodies = particles as f64;
    let emitters = emitters(scene, (&mut particles, &mut low, &mut high));
    index::table_bytes(scene, low.as_dvec3(), high.as_dvec3()).map_err(InstallError::Fluid)?;
    let (start_density, sampled) = if start_density::is_small(scene, &size) {
        let (density, samples) = ask(scene)?;
        (Some(density), Some(samples))
    } else {
        let execution = Execution::new(1).map_err(InstallError::Threads)?;
        let density = start_slabs::of_large(scene, &size, None, &execution)?;
        (density, None)
    };
    let mut warnings = warnings::of_size(scene, &size);
    warnings.extend(start_density.and_then(|found| thrown(scene, &found)));
    let burst = start_density.and_then(|found| burst(scene, &found));
    warnings.extend(burst.filter(Burst::is_felt).map(|burst| burst.to_string()));
    let is_exact = sampled.is_some() || size.boundary == 0.0 || size.candidates <= FEW_CANDIDATES;
    let mut boundary_particles = sampled.unwrap_or(size.boundary as usize);
    if is_exact && sampled.is_none() {
        boundary_particles = 0;
        sampling::for_each_sample(scene, &mut |_| boundary_particles += 1)?;
    }
    let counted = Size {
        fluid: in_bodies,
        boundary: boundary_particles as f64,
        ..size
    };
    let need = memory::need(scene, &counted)?;
    let expected_neighbours = memory::expected_neighbours(scene, &material);
    let limits = limits::of(scene, low, high);
    let single = |(low, high): (DVec3, DVec3)| (low.as_vec3(), high.as_vec3());
    Ok(Plan {
        particles,
        emitters,
        boundary_particles,
        boundary_is_estimate: !is_exact,
        fluid_box: (low, high),
        whole_box: single(size.whole_box),
        support_radius: scene.support_radius(),
        particle_mass: material.particle_mass,
        phases: order.lines(),
        flow: order.flow(),
        bytes_per_particle: Stages::default().bytes(scene, expected_neighbours),
        bytes_per_boundary_particle: memory::bytes_per_boundary_particle(scene),
        expected_steps: f64::from(scene.duration)
            / f64::from(limits::expected_step(scene, &limits)),
        time_step_limits: limits,
        expected_neighbours,
        memory: need.most,
        memory_by_part: need.parts,
        most_particles: in_bodies + size.emitted,
        warnings,
        start_density,
    })
}

/// Initial density of the fluid, and the number of boundary particles.
fn ask(scene: &Scene) -> Result<(StartDensity, usize), InstallError> {
    let execution = Execution::new(1).map_err(InstallError::Threads)?;
    let samples = sampling::sample(scene)?;
    let walls = boundary::pack(scene, &samples, &execution).map_err(InstallError::Boundary)?;
    let walls = (!samples.is_empty()).then_some(&walls);
    let seeds = filling::fluid_particles(scene);
    let density = start_density::of(scene, &seeds, walls, &execution)?;
    Ok((density, samples.len()))
}
