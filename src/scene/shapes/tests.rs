//! Tests of shapes and their lattices.

use super::*;
use crate::filling::{fluid_particles, volume};
use crate::scene::{Scene, Shape};

fn count(shape: Shape, spacing: f64, dimension: Dimension) -> usize {
    let mut count = 0;
    Lattice::new(&shape, spacing, dimension).for_each(|_| count += 1);
    count
}

fn scene(rest: &str) -> Scene {
    let text = format!(
        "(name: \"a\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0.5)){rest})])"
    );
    Scene::parse(&text, "a.ron", &[]).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_box_of_n_spacings_has_n_particles_an_axis_whatever_the_rounding() {
    for n in [1, 2, 3, 7, 49, 50, 51, 333] {
        for spacing in [0.02_f32, 0.1, 1.0 / 3.0, 0.146 / 40.0, 7e-4] {
            // Rounding takes up to half of 1/100 spacing far away.
            for start in [0.0_f32, -0.7, 0.3, 7e4 * spacing, -6.1e4 * spacing] {
                let end = start + n as f32 * spacing;
                let (min, max) = (Vec3::splat(start), Vec3::new(end, start + spacing, end));
                let shape = Shape::Box { min, max };
                let expected = n * n;
                let found = count(shape, f64::from(spacing), Dimension::Three);
                assert_eq!(found, expected, "{n} × {spacing} from {start}");
            }
        }
    }
}

#[test]
fn a_rest_that_holds_no_whole_spacing_stays_empty() {
    let (min, max) = (Vec3::ZERO, Vec3::new(0.19, 0.1, 0.1));
    assert_eq!(count(Shape::Box { min, max }, 0.1, Dimension::Three), 1);
}

#[test]
fn shapes_thinner_than_the_spacing_hold_nothing_and_are_not_searched() {
    let (min, max) = (Vec3::ZERO, Vec3::new(1e-4, 1e6, 1e6));
    assert_eq!(count(Shape::Box { min, max }, 0.1, Dimension::Three), 0);
    let needle = Shape::Cylinder {
        start: Vec3::ZERO,
        end: Vec3::new(0.0, 1e8, 0.0),
        radius: 1e-4,
    };
    assert_eq!(count(needle, 0.1, Dimension::Three), 0);
}

#[test]
fn round_shapes_hold_their_volume_in_particles() {
    let center = Vec3::new(0.3, -0.2, 0.0);
    let (start, end) = (center, Vec3::new(1.0, 0.4, 0.7));
    let radius = 0.5;
    let shapes = [
        (Shape::Sphere { center, radius }, Dimension::Three),
        (Shape::Sphere { center, radius }, Dimension::Two),
        (Shape::Cylinder { start, end, radius }, Dimension::Three),
    ];
    for (shape, dimension) in shapes {
        let spacing = 0.5 / 20.0;
        let exponent = if dimension == Dimension::Two { 2 } else { 3 };
        let filled = count(shape.clone(), spacing, dimension) as f64 * spacing.powi(exponent);
        let ratio = filled / volume(&shape, dimension);
        assert!((ratio - 1.0).abs() < 0.02, "{shape:?}: {ratio}");
    }
}

#[test]
fn a_sphere_is_symmetric_about_its_centre() {
    let center = Vec3::new(0.3, -0.2, 0.7);
    let mut sum = DVec3::ZERO;
    let sphere = Shape::Sphere {
        center,
        radius: 0.26,
    };
    let mut n = 0;
    Lattice::new(&sphere, 0.1, Dimension::Three).for_each(|point| {
        n += 1;
        sum += point - center.as_dvec3();
    });
    assert!(n > 0 && sum.length() < 1e-9, "{n} {sum}");
}

#[test]
fn a_cylinder_along_an_axis_has_whole_layers() {
    let cylinder = Shape::Cylinder {
        start: Vec3::ZERO,
        end: Vec3::new(0.0, 0.5, 0.0),
        radius: 0.2,
    };
    let mut heights = Vec::new();
    Lattice::new(&cylinder, 0.1, Dimension::Three).for_each(|point| heights.push(point.y));
    assert_eq!(heights.len(), 5 * 12);
    assert!(heights.iter().all(|y| (0.049..0.451).contains(y)));
}

#[test]
fn jitter_is_bounded_and_the_same_for_a_seed() {
    let plain = fluid_particles(&scene(""));
    let one = fluid_particles(&scene(", jitter: (amplitude: 0.2, seed: 1)"));
    let again = fluid_particles(&scene(", jitter: (amplitude: 0.2, seed: 1)"));
    let two = fluid_particles(&scene(", jitter: (amplitude: 0.2, seed: 2)"));
    assert_eq!(one, again);
    assert_ne!(one, two);
    let mut largest = 0.0_f32;
    for (a, b) in plain.iter().zip(&one) {
        largest = largest.max((a.position - b.position).abs().max_element());
    }
    assert!(largest > 0.019 && largest < 0.02 + 1e-6, "{largest}");
    // SplitMix64 from seed 1 starts with 0x910a2dec89025cc1: the displacement is 0.2 × 0.1 × (2 × 0.5665615 − 1).
    let moved = one[0].position.x - plain[0].position.x;
    assert!((moved - 0.002_662_46).abs() < 1e-7, "{moved}");
}

#[test]
fn the_axes_of_a_wall_are_perpendicular() {
    for normal in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(1.0, -2.0, 0.5)] {
        let (u, v) = wall_axes(normal, Dimension::Three);
        assert!(u.dot(v).abs() < 1e-6 && u.dot(normal).abs() < 1e-6);
        assert!(v.dot(normal).abs() < 1e-6 && (u.length() - 1.0).abs() < 1e-6);
    }
    let (u, _) = wall_axes(Vec3::new(0.0, 2.0, 0.0), Dimension::Two);
    assert_eq!(u, -Vec3::X);
}

#[test]
fn points_near_a_box_are_those_of_the_lattice_in_it() {
    for shape in [
        Shape::Box {
            min: Vec3::new(-0.3, 0.1, 0.2),
            max: Vec3::new(0.9, 0.8, 0.7),
        },
        Shape::Sphere {
            center: Vec3::new(0.2, 0.3, 0.4),
            radius: 0.55,
        },
        Shape::Cylinder {
            start: Vec3::new(-0.2, 0.1, 0.0),
            end: Vec3::new(0.7, 0.5, 0.9),
            radius: 0.3,
        },
    ] {
        let lattice = Lattice::new(&shape, 0.05, Dimension::Three);
        let mut all = Vec::new();
        lattice.for_each(|point| all.push(point));
        for k in 0..200 {
            let low = DVec3::new(f64::from(k % 7), f64::from(k % 5), f64::from(k % 11)) * 0.2 - 0.7;
            let high = low + DVec3::new(0.05, 0.3, 0.6) * f64::from(1 + k % 4);
            let is_in = |point: &DVec3| point.cmpge(low).all() && point.cmple(high).all();
            let expected: Vec<DVec3> = all.iter().copied().filter(is_in).collect();
            let mut found = Vec::new();
            let mut asked = 0;
            lattice.for_each_near(low, high, |point| {
                asked += 1;
                found.extend(is_in(&point).then_some(point));
            });
            assert_eq!(found, expected, "{shape:?} from {low} to {high}");
            assert!(asked <= all.len());
        }
        let mut asked = 0;
        lattice.for_each_near(DVec3::splat(2.0), DVec3::splat(3.0), |_| asked += 1);
        assert!(
            asked < all.len() / 10,
            "{shape:?}: {asked} of {}",
            all.len()
        );
    }
}
