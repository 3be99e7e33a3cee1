//! Single particles that are shot at the walls of built-in solids do not pass through them.

use std::f32::consts::PI;

use glam::Vec3;
use overfall::state::particle::BoundaryNormal;

use super::walls::{Solid, clearance};
use crate::support::{measured, shoot, simulation_of};

/// Directions on a regular grid in the half space about −`axis`.
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

/// Shots: a single particle starts at a position from which it meets the wall at the target.
struct Shot {
    target: Vec3,
    /// Unit vector from the solid into the fluid.
    normal: Vec3,
}

/// Executes every shot from every direction, one particle at a time, with `speed` \[support radii per step] in a scene
/// of spacing 0.05 m without gravity. Returns the least distance from the solids \[spacings].
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
    .replace("0.1), max: (0.15, 0.95, 0.15", if flat { "0), max: (0.15, 0.95, 0" } else { "0.1), max: (0.15, 0.95, \
     0.15" });
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
                    // Each shot starts at a different fraction of a step.
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

/// `bound` is the least distance of a particle from the face of the solid \[spacings].
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
        // At a convex edge the clearance is measured along the mean of the normals, from a sample that is half a
        // spacing inside every face: 0.5 − 0.25/√3 in a corner.
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
