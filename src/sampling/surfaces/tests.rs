//! Tests of the samples of shapes.

use super::*;

fn tank(open: bool) -> BoundaryShape {
    BoundaryShape::Tank {
        min: Vec3::ZERO,
        max: Vec3::new(0.4, 0.3, 0.2),
        open,
        rotation: glam::DVec3::ZERO,
        name: None,
        motion: None,
        slip: crate::scene::WallSlip::Free,
    }
}

fn sampled(shape: BoundaryShape, dimension: Dimension) -> Vec<Vec3> {
    let mut out = Vec::new();
    let lattice = (dimension, 0.1, &Period::NONE);
    sample_shape(&shape, lattice, (0.05, true), &mut |sample| {
        out.push(sample)
    })
    .expect("no file");
    assert!(
        out.iter()
            .all(|sample| (sample.normal.length() - 1.0).abs() < 1e-5)
    );
    out.into_iter().map(|sample| sample.position).collect()
}

#[test]
fn a_tank_is_a_closed_shell_half_a_spacing_outside_without_doubles() {
    let points = sampled(tank(false), Dimension::Three);
    // 6 × 5 × 4 lattice points less the 4 × 3 × 2 inner ones.
    assert_eq!(points.len(), 6 * 5 * 4 - 4 * 3 * 2);
    for (k, a) in points.iter().enumerate() {
        assert!(points[..k].iter().all(|b| a.distance(*b) > 0.099));
    }
    let low = points.iter().fold(Vec3::INFINITY, |low, x| low.min(*x));
    assert!(low.abs_diff_eq(Vec3::splat(-0.05), 1e-6));
}

#[test]
fn an_open_tank_has_no_lid() {
    let points = sampled(tank(true), Dimension::Three);
    assert!(points.iter().all(|x| x.y < 0.3));
    assert_eq!(points.len(), 6 * 5 * 4 - 4 * 3 * 2 - 6 * 4);
}

#[test]
fn normals_point_into_the_fluid() {
    let mut samples = Vec::new();
    let lattice = (Dimension::Three, 0.1, &Period::NONE);
    sample_shape(&tank(false), lattice, (0.05, true), &mut |sample| {
        samples.push(sample)
    })
    .expect("no file");
    let middle = Vec3::new(0.2, 0.15, 0.1);
    assert!(
        samples
            .iter()
            .all(|sample| sample.normal.dot(middle - sample.position) > 0.0)
    );
    samples.clear();
    let obstacle = BoundaryShape::Box {
        min: Vec3::ZERO,
        max: Vec3::new(0.4, 0.3, 0.2),
        rotation: glam::DVec3::ZERO,
        name: None,
        motion: None,
        slip: crate::scene::WallSlip::Free,
    };
    sample_shape(&obstacle, lattice, (0.05, true), &mut |sample| {
        samples.push(sample)
    })
    .expect("no file");
    assert!(
        samples
            .iter()
            .all(|sample| sample.normal.dot(middle - sample.position) < 0.0)
    );
}

#[test]
fn two_dimensions_lie_in_the_plane() {
    for shape in [
        tank(false),
        BoundaryShape::Sphere {
            center: Vec3::ONE,
            radius: 0.3,
            rotation: glam::DVec3::ZERO,
            name: None,
            motion: None,
            slip: crate::scene::WallSlip::Free,
        },
        BoundaryShape::Plane {
            center: Vec3::ZERO,
            normal: Vec3::new(1.0, 1.0, 0.0),
            half_size: 0.5,
            rotation: glam::DVec3::ZERO,
            name: None,
            motion: None,
            slip: crate::scene::WallSlip::Free,
        },
    ] {
        let points = sampled(shape.clone(), Dimension::Two);
        assert!(
            points.len() > 8 && points.iter().all(|x| x.z == 0.0),
            "{shape:?}"
        );
    }
}

#[test]
fn a_sphere_is_covered_evenly() {
    let center = Vec3::new(1.0, 2.0, 3.0);
    let points = sampled(
        BoundaryShape::Sphere {
            center,
            radius: 1.05,
            rotation: glam::DVec3::ZERO,
            name: None,
            motion: None,
            slip: crate::scene::WallSlip::Free,
        },
        Dimension::Three,
    );
    for (k, a) in points.iter().enumerate() {
        assert!((a.distance(center) - 1.0).abs() < 1e-4);
        let others = points[..k].iter().chain(&points[k + 1..]);
        let nearest = others.map(|b| a.distance(*b)).fold(f32::INFINITY, f32::min);
        assert!((0.05..0.15).contains(&nearest), "{nearest}");
    }
}
