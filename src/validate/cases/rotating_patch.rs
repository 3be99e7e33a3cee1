//! The rotating square patch (Colagrossi 2005), which negative pressure holds together.

use super::{reference, texts};
use crate::{
    scene::Scene,
    validate::{
        Case, Comparison, Figure, Findings, Runner, Stopped,
        figure::{at, exact_curve},
        particles_of, rigid_motion,
    },
};

pub(in crate::validate) const CASE: Case = Case {
    name: "rotating_square_patch",
    title: "A square of fluid that turns",
    texts: texts!("rotating_square_patch"),
    across: "edge",
    resolution: 40,
    resolutions: [20, 40, 80],
    // Ten times the speed of the corners.
    sound_speed: 7.1,
    measure,
};

const KNOWN: &str = include_str!("../../../assets/reference/rotating_square_patch_p0.csv");
/// Duration of the start, in which the pressure is that of the square \[s].
const START: f64 = 0.1;
/// Radius of the core \[m].
const CORE: f32 = 0.25;

fn measure(scene: &Scene, patch: &mut Runner) -> Result<Findings, Stopped> {
    // For ρ = 1000 kg/m³, ω = 1/s, L = 1 m.
    let line = reference(KNOWN, ["x_over_L", "p_centreline"], |[x, p]| {
        (x, 1000.0 * p)
    })?;
    let start = rigid_motion(&particles_of(patch.world()));
    let mut energies = Vec::new();
    let mut core = Vec::new();
    patch.steps(f64::from(scene.duration), |world, report| {
        energies.push(report.kinetic_energy);
        let particles = particles_of(world);
        let within = particles.iter().filter(|p| p.position.length() < CORE);
        let (sum, count) = within.fold((0.0, 0.0), |(sum, count), p| {
            (sum + f64::from(p.density), count + 1.0)
        });
        core.push((report.time, sum / count / 1000.0));
    })?;
    let end = rigid_motion(&particles_of(patch.world()));
    let turn = end.angular_momentum.z / start.angular_momentum.z;
    let kept = match energies[..] {
        [first, .., last] => last / first,
        _ => f64::NAN,
    };
    let pressures = patch.readings("centre", "pressure_Pa");
    let early = pressures.iter().take_while(|reading| reading.0 <= START);
    let (sum, count) = early.fold((0.0, 0.0), |(sum, count), p| (sum + p.1, count + 1.0));
    Ok(Findings {
        figures: vec![
            Figure::exact(
                "centre pressure at the start [Pa]",
                sum / count,
                at(&line.points, 0.5),
            ),
            Figure::exact(
                "density of the core at the end [rho0]",
                core.last().map_or(f64::NAN, |core| core.1),
                1.0,
            ),
            Figure::exact("kinetic energy at the end [its start]", kept, 1.0),
            Figure::exact("angular momentum at the end [its start]", turn, 1.0),
        ],
        comparisons: vec![Comparison {
            name: "core",
            x: "t [s]",
            y: "mean density of the core [rho0]",
            measured: core,
            known: exact_curve("ρ0", (0..=20).map(|k| (f64::from(k) / 10.0, 1.0))),
        }],
    })
}
