//! Tests of the samples of ground.

use glam::DVec3;

use super::*;
use crate::scene::{BoundaryShape, Scene};

fn ground(heights: &str) -> (crate::mesh::Mesh, f32) {
    let text = format!(
        "(name: \"t\", spacing: 0.1, bodies: [(shape: Box(min: (-0.5, 4, -0.5), max: (0.5, 5, 0.5)))], \
         boundaries: [Terrain(size: (9, 7), rotation: (0, 30, -5), {heights})])"
    );
    let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
    let BoundaryShape::Terrain(_) = scene.boundaries[0] else {
        panic!("a ground")
    };
    let mesh = scene.boundaries[0].mesh(scene.spacing);
    (mesh.expect("a surface").expect("a ground"), scene.spacing)
}

/// On flat and on steep ground alike a sample stands for a square of the spacing, none is nearer to another than
/// nine tenths of it, no place is further from all than 1.1, and all lie at the depth of the layer.
#[test]
fn ground_is_covered_evenly_on_its_slopes() {
    for (heights, steep) in [
        ("heights: Generated(cell: 1, amplitude: 0)", 0.0),
        (
            "heights: Generated(seed: 1, cell: 0.2, amplitude: 1.5, wavelength: 4)",
            0.8,
        ),
        (
            "heights: Generated(cell: 0.2, channel: (depth: 1, width: 3, meander: 1, meander_length: 9))",
            0.8,
        ),
    ] {
        let (mesh, spacing) = ground(heights);
        let field = mesh.heights.as_ref().expect("heights");
        let mut samples = Vec::new();
        sample_ground(field, spacing, 0.06, &mut samples);
        let area = mesh.area() / f64::from(spacing).powi(2);
        let (flat, whole) = (63.0 / 0.01, samples.len() as f64);
        assert!(area > flat * (0.999 + 0.1 * steep), "{area}: {heights}");
        let edge = 16.0 / f64::from(spacing);
        assert!(
            (whole / (area + edge) - 1.0).abs() < 0.04,
            "{whole} for {area}: {heights}"
        );
        let on = |sample: &BoundarySample| (sample.position + 0.06 * sample.normal).as_dvec3();
        let points: Vec<DVec3> = samples.iter().map(on).collect();
        for (k, point) in points.iter().enumerate() {
            let others = points.iter().enumerate().filter(|(other, _)| *other != k);
            let nearest = others.map(|(_, x)| x.distance(*point));
            let nearest = nearest.fold(f64::INFINITY, f64::min) / f64::from(spacing);
            assert!(
                (0.85..1.1).contains(&nearest),
                "{nearest} at {point}: {heights}"
            );
            assert!(mesh.nearest(*point).distance.abs() < 1e-5);
            assert!(samples[k].normal.y > 0.3);
        }
        for k in 0..2000 {
            let k = f64::from(k);
            let at = 0.5 * field.size * DVec2::new((1.3 * k).sin(), (0.7 * k).cos());
            let place = field.place.point(field.point(at));
            let nearest = points.iter().map(|x| x.distance(place));
            let nearest = nearest.fold(f64::INFINITY, f64::min) / f64::from(spacing);
            assert!(nearest < 1.1, "{nearest} at {place}: {heights}");
        }
    }
}

#[test]
fn samples_do_not_depend_on_the_number_of_threads() {
    let (mesh, spacing) = ground("heights: Generated(seed: 2, cell: 0.3, amplitude: 1)");
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let mut samples = Vec::new();
        let heights = mesh.heights.as_ref().expect("heights");
        (pool.expect("threads")).install(|| sample_ground(heights, spacing, 0.06, &mut samples));
        samples
    };
    assert_eq!(with(1), with(3));
}
