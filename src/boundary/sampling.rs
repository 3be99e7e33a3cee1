//! Surfaces into particles: one layer at the spacing, half a spacing inside the solid, so that fluid which fills a tank
//! lies one spacing from the layer.

use std::f32::consts::{PI, TAU};

use glam::{IVec3, Vec3};

use crate::scene::{BoundaryShape, Dimension, Scene, shapes::wall_axes};

/// Boundary particles of a scene [m].
pub fn sample(scene: &Scene) -> Vec<Vec3> {
    let mut positions = Vec::new();
    for shape in &scene.boundaries {
        sample_shape(shape, scene.dimension, scene.spacing, &mut positions);
    }
    positions
}

fn sample_shape(shape: &BoundaryShape, dimension: Dimension, spacing: f32, out: &mut Vec<Vec3>) {
    let half = Vec3::splat(0.5 * spacing);
    match *shape {
        BoundaryShape::Tank { min, max, open } => {
            shell(min - half, max + half, open, dimension, spacing, out)
        }
        BoundaryShape::Box { min, max } => {
            // A plate thinner than the spacing keeps one layer, in its middle.
            let middle = 0.5 * (min + max);
            shell(
                (min + half).min(middle),
                (max - half).max(middle),
                false,
                dimension,
                spacing,
                out,
            );
        }
        BoundaryShape::Sphere { center, radius } => {
            let radius = (radius - half.x).max(half.x);
            match dimension {
                Dimension::Two => circle(center, radius, spacing, out),
                Dimension::Three => sphere(center, radius, spacing, out),
            }
        }
        BoundaryShape::Plane {
            center,
            normal,
            half_size,
        } => {
            let normal = normal.normalize_or(Vec3::Y);
            plane(
                center - half.x * normal,
                normal,
                half_size,
                dimension,
                spacing,
                out,
            );
        }
    }
}

/// The surface of the box `min`–`max` on a lattice no coarser than the spacing; edges and corners once.
fn shell(
    min: Vec3,
    max: Vec3,
    open_top: bool,
    dimension: Dimension,
    spacing: f32,
    out: &mut Vec<Vec3>,
) {
    let size = max - min;
    let mut last = ((size / spacing) - Vec3::splat(1e-3))
        .ceil()
        .max(Vec3::ZERO)
        .as_ivec3();
    let (mut min, mut size) = (min, size);
    if dimension == Dimension::Two {
        (last.z, min.z, size.z) = (0, 0.0, 0.0);
    }
    let step = size / last.max(IVec3::ONE).as_vec3();
    for z in 0..=last.z {
        for y in 0..=last.y {
            for x in 0..=last.x {
                let side = x == 0 || x == last.x;
                let front = dimension == Dimension::Three && (z == 0 || z == last.z);
                let level = y == 0 || y == last.y && !open_top;
                // An open tank's walls end at its rim.
                let above_rim = open_top && y == last.y && last.y > 0;
                if (side || front || level) && !above_rim {
                    out.push(min + step * IVec3::new(x, y, z).as_vec3());
                }
            }
        }
    }
}

fn circle(center: Vec3, radius: f32, spacing: f32, out: &mut Vec<Vec3>) {
    let count = (TAU * radius / spacing).ceil().max(1.0) as u32;
    out.extend((0..count).map(|k| {
        let (sin, cos) = (TAU * k as f32 / count as f32).sin_cos();
        (center + radius * Vec3::new(cos, sin, 0.0)).with_z(0.0)
    }));
}

/// A Fibonacci lattice with one particle for every square of the spacing.
fn sphere(center: Vec3, radius: f32, spacing: f32, out: &mut Vec<Vec3>) {
    let count = (4.0 * PI * (radius / spacing).powi(2)).ceil().max(1.0) as u32;
    let golden_angle = PI * (3.0 - 5f32.sqrt());
    out.extend((0..count).map(|k| {
        let height = 1.0 - (2.0 * k as f32 + 1.0) / count as f32;
        let ring = (1.0 - height * height).max(0.0).sqrt();
        let (sin, cos) = (golden_angle * k as f32).sin_cos();
        center + radius * Vec3::new(ring * cos, height, ring * sin)
    }));
}

fn plane(
    center: Vec3,
    normal: Vec3,
    half_size: f32,
    dimension: Dimension,
    spacing: f32,
    out: &mut Vec<Vec3>,
) {
    let (along, across) = wall_axes(normal, dimension);
    let count = (2.0 * half_size / spacing - 1e-3).ceil().max(1.0) as i32;
    let rows = if dimension == Dimension::Two {
        0..=0
    } else {
        0..=count
    };
    let place = |k: i32| half_size * (2.0 * k as f32 / count as f32 - 1.0);
    for row in rows {
        out.extend((0..=count).map(|k| center + place(k) * along + place(row) * across));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tank(open: bool) -> BoundaryShape {
        BoundaryShape::Tank {
            min: Vec3::ZERO,
            max: Vec3::new(0.4, 0.3, 0.2),
            open,
        }
    }

    fn sampled(shape: BoundaryShape, dimension: Dimension) -> Vec<Vec3> {
        let mut out = Vec::new();
        sample_shape(&shape, dimension, 0.1, &mut out);
        out
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
    fn two_dimensions_lie_in_the_plane() {
        for shape in [
            tank(false),
            BoundaryShape::Sphere {
                center: Vec3::ONE,
                radius: 0.3,
            },
            BoundaryShape::Plane {
                center: Vec3::ZERO,
                normal: Vec3::new(1.0, 1.0, 0.0),
                half_size: 0.5,
            },
        ] {
            let points = sampled(shape, Dimension::Two);
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
}
