//! Samples of meshes: as even and complete as those of the built-in shapes, and at the same positions.

use std::f32::consts::PI;

use glam::Vec3;
use overfall::sampling::{BoundarySample, layer_depth, sample};
use overfall::scene::Scene;

use crate::mesh_support::{Files, Surface};
use crate::support::measured;

const DX: f32 = 0.05;

/// A scene that consists of boundaries; its fluid is far from them.
fn scene(boundaries: &str) -> Scene {
    let text = format!(
        "(name: \"samples\", spacing: {DX},
          bodies: [(shape: Box(min: (50, 50, 50), max: (50.2, 50.2, 50.2)))])"
    );
    let mut scene =
        Scene::parse(&text, "samples.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
    scene.boundaries = ron::from_str(&format!("[{boundaries}]")).expect("boundaries");
    scene
}

fn samples(boundaries: &str) -> Vec<BoundarySample> {
    sample(&scene(boundaries)).unwrap_or_else(|error| panic!("{error}"))
}

/// Distance of every sample from the nearest other sample of its side \[spacings]: least, mean, largest.
fn evenness(samples: &[BoundarySample]) -> [f32; 3] {
    let mut nearest: Vec<f32> = samples
        .iter()
        .enumerate()
        .map(|(k, a)| {
            let others = samples[..k].iter().chain(&samples[k + 1..]);
            let side = others.filter(|b| b.normal.dot(a.normal) > -0.3);
            side.map(|b| b.position.distance(a.position))
                .fold(f32::INFINITY, f32::min)
                / DX
        })
        .collect();
    nearest.sort_by(f32::total_cmp);
    let mean = nearest.iter().sum::<f32>() / nearest.len() as f32;
    [nearest[0], mean, nearest[nearest.len() - 1]]
}

/// Distance of the point of a surface that is farthest from all samples facing its way \[spacings].
fn largest_hole(surface: &Surface, samples: &[BoundarySample], flip: f32) -> f32 {
    let mut largest = 0.0_f32;
    for [a, b, c] in surface.triangles() {
        let normal = flip * (b - a).cross(c - a).normalize();
        let n = ((a.distance(b).max(b.distance(c)).max(c.distance(a))) / (0.35 * DX)).ceil() as i32;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
                let point = a + u * (b - a) + v * (c - a);
                let near = samples
                    .iter()
                    .filter(|s| s.normal.dot(normal) > -0.3)
                    .map(|s| s.position.distance_squared(point))
                    .fold(f32::INFINITY, f32::min);
                largest = largest.max(near);
            }
        }
    }
    largest.sqrt() / DX
}

fn mesh(file: &str, side: &str) -> String {
    format!("Mesh((file: {file:?}, side: {side}))")
}

/// A surface, its name, its solid side, and its area \[m²].
struct Shape {
    name: &'static str,
    surface: Surface,
    side: &'static str,
    area: f32,
}

fn shapes() -> Vec<Shape> {
    let (max, box_area) = (
        Vec3::new(0.73, 0.51, 0.6),
        2.0 * (0.73 * 0.51 + 0.73 * 0.6 + 0.51 * 0.6),
    );
    let block = Surface::block(Vec3::ZERO, max);
    let arc: Vec<(f32, f32)> = (0..=24)
        .map(|k| {
            let (sin, cos) = (PI * k as f32 / 24.0).sin_cos();
            (if k % 24 == 0 { 0.0 } else { 0.4 * sin }, -0.4 * cos)
        })
        .collect();
    let ball = Surface::turned(&arc, 48);
    // Its edge is acute: 17°.
    let wedge = Surface::prism(&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.3)], 0.4);
    let wedge_area = 0.4 * (1.3 + 1.09f32.sqrt()) + 0.3;
    let plate = Surface::block(Vec3::ZERO, Vec3::new(0.7, 0.01, 0.5));
    let shape = |name, surface: &Surface, side, area| Shape {
        name,
        surface: surface.clone(),
        side,
        area,
    };
    vec![
        shape("block", &block, "Outside", box_area),
        shape("tank", &block, "Inside", box_area),
        shape("sheet", &block, "Both", box_area),
        shape("ball", &ball, "Outside", 0.64 * PI),
        shape("bowl", &ball, "Inside", 0.64 * PI),
        shape("wedge", &wedge, "Outside", wedge_area),
        shape("groove", &wedge, "Inside", wedge_area),
        shape("plate", &plate, "Outside", 0.7),
    ]
}

#[test]
fn samples_lie_evenly_and_leave_no_hole() {
    let files = Files::new();
    for Shape {
        name,
        surface,
        side,
        area,
    } in shapes()
    {
        let file = files.put(&format!("{name}.obj"), surface.obj());
        let found = samples(&mesh(&file, side));
        let [least, mean, largest] = evenness(&found);
        let flip = if side == "Inside" { -1.0 } else { 1.0 };
        let hole = largest_hole(&surface, &found, flip);
        let share = found.len() as f32 / (area / DX / DX);
        let figures = format!(
            "{name}: {} samples, {share:.3} for an area of spacing², nearest other {least:.3}–{largest:.3}, mean \
             {mean:.3}, no point of the surface farther than {hole:.3}",
            found.len()
        );
        measured(&figures);
        // At an acute edge, here 17°, each face has samples of its own.
        let least_allowed = if name == "groove" { 0.3 } else { 0.85 };
        assert!(
            least > least_allowed && largest < 1.2 && (0.95..1.02).contains(&mean),
            "{figures}"
        );
        // A built-in tank leaves 0.90 and a box 1.04, at its corners. Samples are 0.6 deep; contact considers 1.15
        // along a face.
        assert!(hole < 1.2, "{figures}");
        // The layer of an obstacle is smaller than its surface, that of a tank larger; a sheet is sampled twice.
        let expected = match side {
            "Both" => 1.85..2.1,
            "Inside" => 1.0..1.28,
            _ => 0.75..1.1,
        };
        assert!(expected.contains(&share), "{figures}");
        assert_eq!(found, samples(&mesh(&file, side)), "the same each time");
    }
}

#[test]
fn the_layer_of_a_mesh_lies_where_that_of_the_same_built_in_shape_lies() {
    let files = Files::new();
    let block = &shapes()[0].surface;
    let file = files.put("block.obj", block.obj());
    let (min, max) = (Vec3::ZERO, Vec3::new(0.73, 0.51, 0.6));
    let depth = layer_depth(&scene(""));
    for (side, built_in, inset) in [("Outside", "Box", depth), ("Inside", "Tank", -depth)] {
        let built_in = samples(&format!(
            "{built_in}(min: (0, 0, 0), max: (0.73, 0.51, 0.6))"
        ));
        let found = samples(&mesh(&file, side));
        let (low, high) = (min + inset, max - inset);
        let off = |s: &BoundarySample| {
            let over = (low - s.position).max(s.position - high);
            (over.max(Vec3::ZERO).length() + over.max_element().min(0.0)).abs() / DX
        };
        for samples in [&found, &built_in] {
            let worst = samples.iter().map(off).fold(0.0, f32::max);
            assert!(worst < 0.01, "{side}: {worst} spacings off the layer");
            let count = |corner: Vec3| {
                samples
                    .iter()
                    .filter(|s| s.position.distance(corner) < 0.02 * DX)
                    .count()
            };
            assert_eq!(
                [count(low), count(high)],
                [1, 1],
                "{side}: a sample in each corner"
            );
        }
        // The fluid's side of every sample.
        let sign = if side == "Outside" { 1.0 } else { -1.0 };
        assert!(
            found
                .iter()
                .all(|s| sign * s.normal.dot(s.position - 0.5 * max) > 0.0)
        );
    }
}
