//! Walls: nothing passes them, and nothing hovers above them.
//!
//! A wall's face is where the scene says; a particle's centre may be a quarter of a spacing behind it, where the last
//! resort of `boundary::contact` stops it (it keeps a quarter of the spacing from the layer of samples, which lies half
//! a spacing in). On curved and slanted solids a few hundredths more, as samples lie beside each other at angles.

#[path = "physics_support/mod.rs"]
mod support;

use std::f32::consts::PI;

use glam::Vec3;
use overfall::state::particle::BoundaryNormal;
use support::{measured, particles_of, run, shoot, simulation, simulation_of};

/// Signed distance [m] of a point from the fluid's side of a solid: positive in the fluid.
#[derive(Debug, Clone, Copy)]
enum Solid {
    Tank { max: Vec3, flat: bool },
    Block { min: Vec3, max: Vec3, flat: bool },
    Ball { center: Vec3, radius: f32 },
    Slope { center: Vec3, normal: Vec3 },
}

impl Solid {
    fn distance(self, x: Vec3) -> f32 {
        // In the plane, z is as far from everything as can be.
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

/// Least distance of all particles from the solids, in spacings.
fn clearance(simulation: &mut overfall::Simulation, solids: &[Solid], spacing: f32) -> f32 {
    particles_of(simulation)
        .iter()
        .flat_map(|p| solids.iter().map(|solid| solid.distance(p.position)))
        .fold(f32::INFINITY, f32::min)
        / spacing
}

/// A column of 4 000 particles falls over a block and a ball. The contact keeps −0.25 spacings; 0.02 more for the
/// ball's curvature and rounding.
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
        // At a box's edges the samples' normals point between its faces.
        assert!(least > -0.36, "{figures}");
    }
}

/// Points of an even grid of directions in a half space about −`axis`.
fn directions(axis: Vec3, flat: bool) -> Vec<Vec3> {
    let (side, up) = if flat {
        (Vec3::new(-axis.y, axis.x, 0.0), Vec3::ZERO)
    } else {
        axis.any_orthonormal_pair()
    };
    let mut out = Vec::new();
    for tilt in [0.0_f32, 0.3, 0.7, 1.2] {
        for turn in 0..5 {
            let turn = 0.4 + 2.0 * PI * turn as f32 / 5.0;
            let across = if flat {
                side * turn.cos().signum()
            } else {
                turn.cos() * side + turn.sin() * up
            };
            out.push((-axis * tilt.cos() + across * tilt.sin()).normalize());
        }
    }
    out
}

/// Shots: a lone particle at a place, moving so that it meets the wall there.
struct Shot {
    target: Vec3,
    /// From the solid into the fluid.
    normal: Vec3,
}

/// Fires every shot from every direction, one particle at a time, at `speed` [support radii a step] in a scene of
/// spacing 0.05 m without gravity, and returns the least distance from the solids in spacings.
fn fire(
    boundaries: &str,
    flat: bool,
    shots: &[Shot],
    solids: &[Solid],
    speed: f32,
) -> (f32, String) {
    let (dx, dt) = (0.05, 1e-3);
    let velocity = speed * 2.0 * dx / dt;
    let text = format!(
        "(name: \"jet\", dimension: {}, spacing: {dx}, gravity: (0, 0, 0), time_step: Fixed({dt}),
          reorder_interval: 7, fluid: (viscosity: None),
          bodies: [(shape: Box(min: (0.1, 0.9, 0.1), max: (0.15, 0.95, 0.15)))], boundaries: [{boundaries}])",
        if flat { 2 } else { 3 }
    )
    .replace("0.1), max: (0.15, 0.95, 0.15", if flat { "0), max: (0.15, 0.95, 0" } else { "0.1), max: (0.15, 0.95, 0.15" });
    let mut jet = simulation_of(&text, &[]);
    let samples = jet
        .world_mut()
        .query::<&BoundaryNormal>()
        .iter(jet.world())
        .count();
    assert!(samples > 10, "{samples} boundary particles");
    let mut least = f32::INFINITY;
    let mut worst = String::new();
    let all: Vec<(Vec3, Vec3)> = shots
        .iter()
        .flat_map(|shot| {
            directions(shot.normal, flat)
                .into_iter()
                .enumerate()
                .map(|(k, direction)| {
                    // Starts at a different part of a step's way each time.
                    let way = (2.1 + 0.13 * k as f32) * dx;
                    (shot.target - way * direction, velocity * direction)
                })
        })
        .filter(|(start, _)| solids.iter().all(|solid| solid.distance(*start) > 0.5 * dx))
        .collect();
    assert!(
        all.len() >= shots.len() * 5,
        "{} of {} shots",
        all.len(),
        shots.len()
    );
    for shot in all {
        shoot(&mut jet, shot, 12, speed > 0.45, |jet, at| {
            let now = clearance(jet, solids, dx);
            if now < least {
                worst = format!("shot from {} with {} m/s is at {at}", shot.0, shot.1);
                least = now;
            }
            true
        });
    }
    (least, worst)
}

const SPEEDS: [f32; 3] = [0.1, 0.4, 0.49];

/// `bound` [spacings] is the least distance of a particle from the solid's face.
#[track_caller]
fn nothing_passes(
    what: &str,
    boundaries: &str,
    flat: bool,
    shots: &[Shot],
    solids: &[Solid],
    bound: f32,
) {
    let mut leaks = Vec::new();
    for speed in SPEEDS {
        let (least, worst) = fire(boundaries, flat, shots, solids, speed);
        let figures =
            format!("{what}, {speed} h a step: least distance {least:.3} spacings, {worst}");
        measured(&figures);
        if least < bound {
            leaks.push(figures);
        }
    }
    assert!(leaks.is_empty(), "{leaks:#?}");
}

#[test]
fn fast_lone_particles_do_not_pass_the_walls_edges_and_corners_of_a_tank() {
    for flat in [true, false] {
        let deep = if flat { 0.0 } else { 1.0 };
        let max = Vec3::new(1.0, 1.0, deep);
        let boundaries = format!("Tank(min: (0, 0, 0), max: (1, 1, {deep}))");
        let middle = 0.5 * deep;
        let shot = |target: [f32; 3], normal: [f32; 3]| Shot {
            target: Vec3::from(target),
            normal: Vec3::from(normal).normalize(),
        };
        let mut shots = vec![
            shot([0.513, 0.0, middle], [0.0, 1.0, 0.0]),
            shot([0.525, 0.0, middle], [0.0, 1.0, 0.0]),
            shot([1.0, 0.5, middle], [-1.0, 0.0, 0.0]),
            shot([0.0, 0.0, middle], [1.0, 1.0, 0.0]),
            shot([0.03, 0.0, middle], [0.0, 1.0, 0.0]),
            shot([1.0, 1.0, middle], [-1.0, -1.0, 0.0]),
        ];
        if !flat {
            shots.push(shot([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]));
            shots.push(shot([0.02, 0.0, 0.01], [1.0, 1.0, 1.0]));
            shots.push(shot([1.0, 0.0, 1.0], [-1.0, 1.0, -1.0]));
            shots.push(shot([0.5, 0.0, 1.0], [0.0, 1.0, -1.0]));
        }
        let solids = [Solid::Tank { max, flat }];
        nothing_passes(
            &format!("tank, flat {flat}"),
            &boundaries,
            flat,
            &shots,
            &solids,
            -0.27,
        );
    }
}

#[test]
fn fast_lone_particles_do_not_pass_faces_edges_and_corners_of_a_box() {
    for flat in [true, false] {
        let deep = if flat { 0.0 } else { 0.32 };
        let (min, max) = (Vec3::ZERO, Vec3::new(0.32, 0.32, deep));
        let boundaries = format!("Box(min: (0, 0, 0), max: (0.32, 0.32, {deep}))");
        let signs: &[f32] = if flat { &[0.0] } else { &[-1.0, 0.0, 1.0] };
        let mut shots = Vec::new();
        for x in [-1.0_f32, 0.0, 1.0] {
            for y in [-1.0_f32, 0.0, 1.0] {
                for &z in signs {
                    let normal = Vec3::new(x, y, z);
                    if normal != Vec3::ZERO {
                        let target = 0.5 * max + 0.5 * normal * max;
                        shots.push(Shot {
                            target,
                            normal: normal.normalize(),
                        });
                    }
                }
            }
        }
        let solids = [Solid::Block { min, max, flat }];
        // A convex edge keeps its clearance along the mean of the normals, from a sample that is half a spacing inside
        // of every face: 0.5 − 0.25/√3 in a corner.
        nothing_passes(
            &format!("box, flat {flat}"),
            &boundaries,
            flat,
            &shots,
            &solids,
            -0.36,
        );
    }
}

#[test]
fn fast_lone_particles_do_not_pass_a_sphere() {
    for flat in [true, false] {
        let (center, radius) = (Vec3::new(0.2, 0.1, 0.0), 0.2);
        let boundaries = "Sphere(center: (0.2, 0.1, 0), radius: 0.2)";
        let count = 60;
        let shots: Vec<Shot> = (0..count)
            .map(|k| {
                let turn = 2.4 * k as f32;
                let height = if flat {
                    0.0
                } else {
                    1.0 - (2.0 * k as f32 + 1.0) / count as f32
                };
                let ring = (1.0 - height * height).sqrt();
                let normal = Vec3::new(ring * turn.cos(), ring * turn.sin(), height);
                Shot {
                    target: center + radius * normal,
                    normal,
                }
            })
            .collect();
        let solids = [Solid::Ball { center, radius }];
        nothing_passes(
            &format!("sphere, flat {flat}"),
            boundaries,
            flat,
            &shots,
            &solids,
            -0.27,
        );
    }
}

#[test]
fn fast_lone_particles_do_not_pass_a_slanted_plane() {
    for flat in [true, false] {
        let center = Vec3::new(0.1, -0.1, 0.0);
        let normal = Vec3::new(0.5, 1.0, if flat { 0.0 } else { 0.3 });
        let boundaries = format!(
            "Plane(center: (0.1, -0.1, 0), normal: (0.5, 1, {}), half_size: 0.8)",
            normal.z
        );
        let along = Vec3::new(1.0, -0.5, 0.0).normalize();
        let shots: Vec<Shot> = (-5..5)
            .map(|k| Shot {
                target: center + 0.013 * k as f32 * along,
                normal: normal.normalize(),
            })
            .collect();
        let solids = [Solid::Slope { center, normal }];
        nothing_passes(
            &format!("plane, flat {flat}"),
            &boundaries,
            flat,
            &shots,
            &solids,
            -0.27,
        );
    }
}

/// A lone particle falls 0.2 m onto a floor and a block. With PCISPH it must end under one spacing from the surface,
/// without a vertical speed of more than a tenth of its fall's: farther away, a wall that repels by the density it
/// lends would hold it. With an equation of state a wall is a spring without friction and the particle bounces for
/// ever: it must keep under the height it fell from.
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
