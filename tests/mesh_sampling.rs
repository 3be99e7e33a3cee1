//! Samples of meshes: as even and as complete as those of the built-in shapes, and where these have theirs.

#[path = "mesh_support/mod.rs"]
mod meshes;

use glam::Vec3;
use meshes::{Files, Surface};
use overfall::boundary::{BoundarySample, layer_depth, sample};
use overfall::scene::Scene;

const DX: f32 = 0.05;

/// A scene with nothing but boundaries to speak of: its fluid is out of their way.
fn scene(boundaries: &str) -> Scene {
    let text = format!(
        "(name: \"samples\", spacing: {DX},
          bodies: [(shape: Box(min: (50, 50, 50), max: (50.2, 50.2, 50.2)))])"
    );
    let mut scene = Scene::parse(&text, "samples.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
    scene.boundaries = ron::from_str(&format!("[{boundaries}]")).expect("boundaries");
    scene
}

fn samples(boundaries: &str) -> Vec<BoundarySample> {
    sample(&scene(boundaries)).unwrap_or_else(|error| panic!("{error}"))
}

/// Distances of every sample to the nearest other one of its side, in spacings: least, mean, largest.
fn evenness(samples: &[BoundarySample]) -> [f32; 3] {
    let mut nearest: Vec<f32> = samples
        .iter()
        .enumerate()
        .map(|(k, a)| {
            let others = samples[..k].iter().chain(&samples[k + 1..]);
            let side = others.filter(|b| b.normal.dot(a.normal) > -0.3);
            side.map(|b| b.position.distance(a.position)).fold(f32::INFINITY, f32::min) / DX
        })
        .collect();
    nearest.sort_by(f32::total_cmp);
    let mean = nearest.iter().sum::<f32>() / nearest.len() as f32;
    [nearest[0], mean, nearest[nearest.len() - 1]]
}

/// Distance of the point of a surface that is farthest from all samples that face its way, in spacings.
fn largest_hole(surface: &Surface, samples: &[BoundarySample], flip: f32) -> f32 {
    let mut largest = (0.0_f32, Vec3::ZERO);
    for [a, b, c] in surface.triangles() {
        let normal = flip * (b - a).cross(c - a).normalize();
        let n = ((a.distance(b).max(b.distance(c)).max(c.distance(a))) / (0.2 * DX)).ceil() as i32;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
                let point = a + u * (b - a) + v * (c - a);
                let near = samples
                    .iter()
                    .filter(|s| s.normal.dot(normal) > -0.3)
                    .map(|s| s.position.distance_squared(point))
                    .fold(f32::INFINITY, f32::min);
                if near > largest.0 { largest = (near, point) }
            }
        }
    }
    println!("hole at {}", largest.1);
    largest.0.sqrt() / DX
}

fn mesh(file: &str, side: &str) -> String {
    format!("Mesh((file: {file:?}, side: {side}))")
}

#[test]
fn explore() {
    let files = Files::new();
    let (min, max) = (Vec3::ZERO, Vec3::new(0.73, 0.51, 0.6));
    let block = Surface::block(min, max);
    let ball: Vec<(f32, f32)> = (0..=24)
        .map(|k| {
            let (sin, cos) = (std::f32::consts::PI * k as f32 / 24.0).sin_cos();
            (if k % 24 == 0 { 0.0 } else { 0.4 * sin }, -0.4 * cos)
        })
        .collect();
    let ball = Surface::turned(&ball, 48);
    let wedge = Surface::prism(&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.3)], 0.4);
    let plate = Surface::block(Vec3::ZERO, Vec3::new(0.7, 0.01, 0.5));
    let shapes: &[(&str, &Surface, &str, f32, f32)] = &[
        ("block", &block, "Outside", 1.0, 2.0 * (0.73 * 0.51 + 0.73 * 0.6 + 0.51 * 0.6)),
        ("tank", &block, "Inside", -1.0, 2.0 * (0.73 * 0.51 + 0.73 * 0.6 + 0.51 * 0.6)),
        ("sheet", &block, "Both", 1.0, 2.0 * (0.73 * 0.51 + 0.73 * 0.6 + 0.51 * 0.6)),
        ("ball", &ball, "Outside", 1.0, 0.64 * std::f32::consts::PI),
        ("bowl", &ball, "Inside", -1.0, 0.64 * std::f32::consts::PI),
        ("wedge", &wedge, "Outside", 1.0, 0.4 * (1.3 + 1.04) + 0.3),
        ("groove", &wedge, "Inside", -1.0, 0.4 * (1.3 + 1.04) + 0.3),
        ("plate", &plate, "Outside", 1.0, 0.7),
    ];
    println!("depth {}", layer_depth(&scene("")) / DX);
    for (name, surface, side, flip, area) in shapes {
        let file = files.put(&format!("{name}.obj"), surface.obj());
        let start = std::time::Instant::now();
        let found = samples(&mesh(&file, side));
        let time = start.elapsed();
        println!(
            "{name}: {} samples, {:.3} of area/dx², evenness {:?}, hole {:.3}, {time:?}",
            found.len(),
            found.len() as f32 / (area / DX / DX),
            evenness(&found),
            largest_hole(surface, &found, *flip)
        );
    }
    let built_in = samples("Tank(min: (0, 0, 0), max: (0.73, 0.51, 0.6))");
    println!("built-in: {} evenness {:?} hole {}", built_in.len(), evenness(&built_in), largest_hole(&block, &built_in, -1.0));
    let built_in = samples("Box(min: (0, 0, 0), max: (0.73, 0.51, 0.6))");
    println!("built-in: {} evenness {:?} hole {}", built_in.len(), evenness(&built_in), largest_hole(&block, &built_in, 1.0));
    let built_in = samples("Sphere(center: (0, 0, 0), radius: 0.4)");
    println!("built-in sphere: {} evenness {:?} hole {}", built_in.len(), evenness(&built_in), largest_hole(&ball, &built_in, 1.0));
}
