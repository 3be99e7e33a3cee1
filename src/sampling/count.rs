//! Number of particles of a wall, computed without sampling it.

use std::f32::consts::TAU;

use glam::Vec3;

use crate::scene::{BoundaryShape, Dimension};

/// Number of particles of a boundary other than a mesh; an upper bound for a box.
pub(crate) fn count(shape: &BoundaryShape, dimension: Dimension, spacing: f32, depth: f32) -> f64 {
    let spacing = f64::from(spacing);
    let inset = Vec3::splat(depth);
    match *shape {
        BoundaryShape::Tank { min, max, .. } => {
            shell_count(max - min + 2.0 * inset, dimension, spacing)
        }
        BoundaryShape::Box { min, max, .. } => shell_count(
            (max - min - 2.0 * inset).max(Vec3::ZERO),
            dimension,
            spacing,
        ),
        BoundaryShape::Sphere { radius, .. } => {
            let radius = f64::from((radius - depth).max(0.5 * radius)) / spacing;
            let tau = f64::from(TAU);
            match dimension {
                Dimension::Two => (tau * radius).ceil().max(1.0),
                Dimension::Three => (2.0 * tau * radius * radius).ceil().max(1.0),
            }
        }
        BoundaryShape::Plane { half_size, .. } => {
            let line = (2.0 * f64::from(half_size) / spacing - 1e-3)
                .ceil()
                .max(1.0)
                + 1.0;
            match dimension {
                Dimension::Two => line,
                Dimension::Three => line * line,
            }
        }
        BoundaryShape::Mesh(_) | BoundaryShape::Revolution(_) | BoundaryShape::Terrain(_) => 0.0,
    }
}

/// Points of the surface of a box of `size` \[m], on a lattice no coarser than the spacing.
fn shell_count(size: Vec3, dimension: Dimension, spacing: f64) -> f64 {
    let axes = match dimension {
        Dimension::Two => 2,
        Dimension::Three => 3,
    };
    let size = size.as_dvec3().to_array();
    let steps = || {
        size[..axes]
            .iter()
            .map(|size| (size / spacing - 1e-3).ceil().max(0.0))
    };
    let all: f64 = steps().map(|last| last + 1.0).product();
    let inner: f64 = steps().map(|last| (last - 1.0).max(0.0)).product();
    let faces = if steps().any(|last| last == 0.0) {
        2.0
    } else {
        1.0
    };
    faces * (all - inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{sampling::sample, scene::Scene};

    #[test]
    fn shapes_are_counted_as_they_are_sampled() {
        let mut shapes: Vec<String> = ["false", "true"]
            .map(|open| format!("Tank(min: (0, 0, 0), max: (0.4, 0.3, 0.2), open: {open})"))
            .into();
        for size in [
            "(0.4, 0.55, 0.6)",
            "(0.01, 0.55, 0.6)",
            "(3.3, 0.001, 0.001)",
            "(0.01, 0.01, 0.01)",
        ] {
            shapes.push(format!("Box(min: (0, 0, 0), max: {size})"));
        }
        for radius in [0.01, 0.3, 0.77] {
            shapes.push(format!("Sphere(center: (0, 0, 0), radius: {radius})"));
            shapes.push(format!(
                "Plane(center: (0, 0, 0), normal: (0, 1, 0), half_size: {radius})"
            ));
        }
        for shape in shapes {
            for dimension in [2, 3] {
                let text = format!(
                    "(name: \"t\", dimension: {dimension}, spacing: 0.1, boundaries: [{shape}],
                    bodies: [(shape: Sphere(center: (0, 9, 0), radius: 0.2))])"
                );
                let scene: Scene = ron::from_str(&text).expect("a scene");
                let found = sample(&scene).expect("no file").len() as f64;
                let depth = crate::sampling::layer_depth(&scene);
                let counted = count(&scene.boundaries[0], scene.dimension, scene.spacing, depth);
                // An open tank has no lid.
                let most = if shape.contains("true") {
                    1.6 * found
                } else {
                    1.1 * found + 4.0
                };
                assert!(
                    (found..=most).contains(&counted),
                    "{shape}, {dimension}-D: {found} and {counted}"
                );
            }
        }
    }
}
