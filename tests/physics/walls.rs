//! Walls: no particle passes through them, and none floats above them.
//!
//! The face of a wall is where the scene defines it. The centre of a particle may be a quarter of a spacing behind it,
//! where `boundary::contact` stops it (a quarter of the spacing from the layer of samples, which is half a spacing
//! inside). On curved and slanted solids it may be a few hundredths more, because normals of neighbouring samples
//! differ.

use glam::Vec3;
use overfall::Simulation;

use crate::support::{measured, particles_of, run, simulation, simulation_of};

/// Signed distance \[m] of a point from a solid: positive in the fluid.
#[derive(Debug, Clone, Copy)]
pub(super) enum Solid {
    Tank { max: Vec3, flat: bool },
    Block { min: Vec3, max: Vec3, flat: bool },
    Ball { center: Vec3, radius: f32 },
    Slope { center: Vec3, normal: Vec3 },
}

impl Solid {
    pub(super) fn distance(self, x: Vec3) -> f32 {
        // In 2-D, faces along z are infinitely far away.
        let planar = |v: Vec3, flat: bool, far: f32| if flat { v.with_z(far) } else { v };
        match self {
            Self::Tank { max, flat } => planar(x.min(max - x), flat, f32::INFINITY).min_element(),
            Self::Block { min, max, flat } => {
                let over = planar((min - x).max(x - max), flat, f32::NEG_INFINITY);
                let outside = over.max(Vec3::ZERO).length();
                if outside > 0.0 {
                    outside
                } else {
                    over.max_element()
                }
            }
            Self::Ball { center, radius } => x.distance(center) - radius,
            Self::Slope { center, normal } => (x - center).dot(normal.normalize()),
        }
    }
}

/// Least distance of all particles from the solids \[spacings].
pub(super) fn clearance(simulation: &mut Simulation, solids: &[Solid], spacing: f32) -> f32 {
    particles_of(simulation)
        .iter()
        .flat_map(|p| solids.iter().map(|solid| solid.distance(p.position)))
        .fold(f32::INFINITY, f32::min)
        / spacing
}

/// A column of 4 000 particles falls over a block and a ball. Contact allows −0.25 spacings; 0.02 more for the
/// curvature of the ball and rounding.
#[test]
fn violent_dam_break_leaks_nowhere() {
    for method in [
        "pressure: Pcisph((max_density_error: 0.02))",
        "pressure: Sesph((equation: Tait(stiffness: 50000)))",
        "pressure: Iisph(())",
        "pressure: Dfsph(())",
    ] {
        let mut dam = simulation(&format!(
            "(name: \"violent\", spacing: 0.025, {method},
              fluid: (viscosity: Artificial(alpha: 0.05, sound_speed: 20)),
              bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.7, 0.3)))],
              boundaries: [
                Tank(min: (0, 0, 0), max: (0.9, 0.9, 0.3)),
                Box(min: (0.5, 0, 0.1), max: (0.6, 0.15, 0.2)),
                Sphere(center: (0.75, 0.15, 0.15), radius: 0.1),
              ])"
        ));
        let solids = [
            Solid::Tank {
                max: Vec3::new(0.9, 0.9, 0.3),
                flat: false,
            },
            Solid::Block {
                min: Vec3::new(0.5, 0.0, 0.1),
                max: Vec3::new(0.6, 0.15, 0.2),
                flat: false,
            },
            Solid::Ball {
                center: Vec3::new(0.75, 0.15, 0.15),
                radius: 0.1,
            },
        ];
        let count = particles_of(&mut dam).len();
        let (mut least, mut steps, mut speed) = (f32::INFINITY, 0, 0.0_f32);
        run(&mut dam, 1.5, |dam, report| {
            least = least.min(clearance(dam, &solids, 0.025));
            (steps, speed) = (report.step, speed.max(report.max_speed));
            assert_eq!(report.particles, count);
        });
        let figures = format!(
            "{count} particles, {steps} steps, up to {speed:.1} m/s: least distance {least:.3} spacings"
        );
        measured(&figures);
        // At the edges of a box the samples' normals point between those of the faces: √2 times as far, and 0.02.
        assert!(least > -0.375, "{figures}");
    }
}

/// A single particle falls 0.2 m onto a floor and a block. With PCISPH it must end less than one spacing from the
/// surface with a vertical speed below a tenth of its impact speed; at a larger distance, a wall that repels by its
/// contribution to the density would carry it. With an equation of state a wall acts as a spring without friction, and
/// the particle bounces for ever: it must stay below its initial height.
#[test]
fn lone_particle_falls_onto_the_wall_and_rests_there() {
    for dimension in [2, 3] {
        for method in [
            "Pcisph(())",
            "Iisph(())",
            "Dfsph(())",
            "Sesph((equation: Tait(stiffness: 10000)))",
        ] {
            let deep = if dimension == 2 { "0" } else { "1" };
            let z = if dimension == 2 { 0.0 } else { 0.5 };
            let text = format!(
                "(name: \"lone\", dimension: {dimension}, spacing: 0.05, pressure: {method},
                  bodies: [(shape: Box(min: (0.4, 0.9, 0), max: (0.45, 0.95, 0.05)))],
                  boundaries: [
                    Tank(min: (0, 0, 0), max: (1, 1, {deep})),
                    Box(min: (0.6, 0, {}), max: (0.9, 0.25, {})),
                  ])",
                z - 0.2 * z,
                z + 0.4 * z,
            );
            let starts = [
                // Above the floor, off the lattice of samples; beside a wall; above the block.
                (Vec3::new(0.333, 0.2, z), 0.0),
                (Vec3::new(0.03, 0.3, z), 0.0),
                (Vec3::new(0.75, 0.45, z), 0.25),
            ];
            let mut fall = simulation_of(&text, &starts.map(|(x, _)| (x, Vec3::ZERO)));
            let entities = starts.map(|(x, _)| {
                let before = particles_of(&mut fall);
                before
                    .iter()
                    .find(|p| p.position == x)
                    .expect("a particle")
                    .entity
            });
            run(&mut fall, 1.0, |_, _| {});
            for (entity, (start, top)) in entities.into_iter().zip(starts) {
                let after = particles_of(&mut fall);
                let particle = after
                    .iter()
                    .find(|p| p.entity == entity)
                    .expect("the particle");
                // Walls have no friction and are bumpy: a particle may have slid off the block.
                let floor = if particle.position.y > 0.5 * top {
                    top
                } else {
                    0.0
                };
                let height = (particle.position.y - floor) / 0.05;
                let figures = format!(
                    "{dimension}-D {method}, from {start}: {height:.3} spacings above at {}, {:.1e} m/s",
                    particle.position,
                    particle.velocity.length()
                );
                measured(&figures);
                if method.starts_with("Sesph") {
                    assert!(height > -0.5 && particle.position.y < start.y, "{figures}");
                    continue;
                }
                assert!(
                    height.abs() < 1.0 && particle.velocity.y.abs() < 0.2,
                    "{figures}"
                );
            }
        }
    }
}
