//! Single particles that are shot at thin meshes do not pass through them.

use glam::Vec3;
use overfall::scene::Scene;

use super::meshes::{DX, Distance};
use crate::mesh_support::{Files, Surface};
use crate::support::{measured, shoot, simulation_of};

fn block_distance(min: Vec3, max: Vec3) -> impl Fn(Vec3) -> f32 {
    move |x| {
        let over = (min - x).max(x - max);
        over.max(Vec3::ZERO).length() + over.max_element().min(0.0)
    }
}

/// Shoots single particles at targets from both sides and all directions, and counts those that `crossed` the solid,
/// given their start and current position. They start `from` spacings away, or a little further.
fn fire(
    what: &str,
    boundaries: &str,
    (targets, from): (&[(Vec3, Vec3)], f32),
    distance: Distance,
    crossed: &dyn Fn(Vec3, Vec3) -> bool,
) -> usize {
    let dt = 1e-3;
    let mut least = f32::INFINITY;
    let mut leaks = Vec::new();
    let mut shots = 0;
    let text = format!(
        "(name: \"jet\", spacing: {DX}, gravity: (0, 0, 0), time_step: Fixed({dt}), fluid: (viscosity: None),
          bodies: [(shape: Box(min: (3, 3, 3), max: (3.03, 3.03, 3.03)))], {boundaries})"
    );
    let mut jet = simulation_of(&text, &[]);
    for speed in [0.1, 0.4, 0.49] {
        for &(target, normal) in targets {
            let (u, v) = normal.any_orthonormal_pair();
            for (k, tilt) in [0.0_f32, 0.3, 0.3, 0.7, 0.7, 1.2, 1.2]
                .into_iter()
                .enumerate()
            {
                let turn = 0.4 + 2.4 * k as f32;
                let across = turn.cos() * u + turn.sin() * v;
                let direction = (-normal * tilt.cos() + across * tilt.sin()).normalize();
                let way = (from + 0.13 * k as f32) * DX;
                let start = target - way * direction;
                if distance(start) < 0.5 * DX {
                    continue;
                }
                let velocity = speed * 2.0 * DX / dt * direction;
                shots += 1;
                shoot(&mut jet, (start, velocity), 14, speed > 0.45, |_, x| {
                    least = least.min(distance(x) / DX);
                    let through = crossed(start, x);
                    if through {
                        leaks.push(format!("{speed} from {start} with {direction} is at {x}"));
                    }
                    !through
                });
            }
        }
    }
    measured(&format!(
        "{what}: {shots} shots, least distance {least:.3} spacings, {} leaks",
        leaks.len()
    ));
    if let Some(leak) = leaks.first() {
        measured(leak);
    }
    leaks.len()
}

/// A plate that is thinner than a hundredth of the spacing encloses nothing: it is refused, with what would be right.
#[test]
fn plates_that_count_as_flat_are_refused() {
    let files = Files::new();
    for thickness in [0.001, 0.004] {
        let plate = Surface::block(Vec3::ZERO, Vec3::new(0.31, thickness * DX, 0.27));
        let file = files.put("flat.obj", plate.obj());
        for handling in ["Akinci", "DirectForcing()"] {
            let text = format!(
                "(name: \"flat\", spacing: {DX}, boundary_handling: {handling},
                  bodies: [(shape: Box(min: (3, 3, 3), max: (3.03, 3.03, 3.03)))],
                  boundaries: [Mesh(file: {file:?}, side: Outside)])"
            );
            let error = Scene::parse(&text, "flat.ron", &[]).expect_err("a flat plate");
            let told = error.to_string();
            assert!(
                told.contains("encloses nothing") && told.contains("side: Both"),
                "{told}"
            );
        }
    }
}

#[test]
fn lone_particles_pass_no_plate_however_thin() {
    let files = Files::new();
    for (handling, thickness) in [
        ("Akinci", 0.0),
        // Just thicker than what counts as flat, a hundredth of the spacing.
        ("Akinci", 0.02),
        ("Akinci", 0.2),
        ("Akinci", 1.3),
        ("DirectForcing(())", 0.0),
        ("DirectForcing(())", 0.02),
        ("DirectForcing(())", 0.2),
    ] {
        let max = Vec3::new(0.31, thickness * DX, 0.27);
        let mut plate = Surface::block(Vec3::ZERO, max);
        let side = if thickness == 0.0 {
            // The floor only.
            plate.faces = vec![plate.faces.swap_remove(2)];
            "Both"
        } else {
            "Outside"
        };
        let file = files.put("plate.obj", plate.obj());
        let targets: Vec<(Vec3, Vec3)> = (0..4)
            .map(|k| Vec3::new(0.06 + 0.047 * k as f32, 0.0, 0.05 + 0.043 * k as f32))
            .flat_map(|at| [(at.with_y(max.y), Vec3::Y), (at, Vec3::NEG_Y)])
            .collect();
        let distance = block_distance(Vec3::ZERO, max);
        let middle = 0.5 * max.y;
        let crossed = |start: Vec3, x: Vec3| {
            let over = x.x > 0.0 && x.x < max.x && x.z > 0.0 && x.z < max.z;
            over && (start.y > middle) != (x.y > middle) && (x.y - middle).abs() < 4.0 * DX
        };
        let mut boundaries = vec![format!("Mesh((file: {file:?}, side: {side}))")];
        if thickness == 0.2 {
            boundaries.push(format!("Box(min: (0, 0, 0), max: (0.31, {}, 0.27))", max.y));
        }
        for boundary in boundaries {
            let leaks = fire(
                &format!("{handling}, {} of {thickness} spacings", &boundary[..3]),
                &format!("boundary_handling: {handling}, boundaries: [{boundary}]"),
                (&targets, 2.1),
                &distance,
                &crossed,
            );
            assert_eq!(leaks, 0, "{handling}, {boundary}, {thickness}");
        }
    }
}

/// In acute edges the samples of a face end far before those of the edge.
#[test]
fn lone_particles_leave_no_tetrahedron_through_its_edges() {
    let files = Files::new();
    let center = Vec3::splat(3.015);
    for (angle, width) in [(26.3_f32, 0.06), (15.0, 0.1), (35.0, 0.05), (20.0, 0.04)] {
        let size = 15.0 * DX;
        let (height, half) = (angle.to_radians().tan() * size, width * size / 0.3);
        let corners = [
            Vec3::ZERO,
            Vec3::new(size, 0.0, -half),
            Vec3::new(size, 0.0, half),
            Vec3::new(size, height, 0.0),
        ];
        let middle = corners.iter().sum::<Vec3>() / 4.0;
        let corners = corners.map(|corner| corner - middle + center);
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let surface = Surface {
            vertices: corners.into(),
            faces: faces.iter().map(|face| face.to_vec()).collect(),
        };
        let distance = |x: Vec3| {
            let behind = faces.iter().map(|face| {
                let [a, b, c] = face.map(|k| corners[k]);
                let normal = (b - a).cross(c - a).normalize();
                let normal = normal * (a - center).dot(normal).signum();
                (a - x).dot(normal)
            });
            behind.fold(f32::INFINITY, f32::min)
        };
        let edges = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
        let targets: Vec<(Vec3, Vec3)> = edges
            .iter()
            .flat_map(|&(a, b)| {
                [0.2, 0.35, 0.5, 0.65, 0.8].map(|part| corners[a].lerp(corners[b], part))
            })
            .map(|at| (at, (center - at).normalize()))
            .collect();
        let file = files.put("tetrahedron.obj", surface.obj());
        for from in [2.1, 4.0] {
            let leaks = fire(
                &format!("a tetrahedron of {angle}°, {width}"),
                &format!("boundaries: [Mesh(file: {file:?}, side: Inside)]"),
                (&targets, from),
                &distance,
                &|_, x| distance(x) < -0.5 * DX,
            );
            assert_eq!(leaks, 0, "{angle}, {width}, {from}");
        }
    }
}
