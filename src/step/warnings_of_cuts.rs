//! A warning for bodies that solids cut: the fluid falls into the gaps between their lattice and the solid.
//!
//! Measured, 2-D, DFSPH, at spacings of 10, 20 and 40 mm under 0.3 and 0.9 m of water, beside sheets, balls, ramps and
//! ground that is half a spacing high: 0.19 to 0.45 times the speed below whatever the spacing is, then at rest after
//! two to three times `sqrt(spacing/g)`. The density at the start is right: there is too much room, not too little.

use glam::DVec3;

use super::numbers::short;
use crate::{
    loading::Size,
    scene::{BoundaryShape, Dimension, Scene, Shape},
};

/// Part of a spacing by which a face may lie beside a plane of the lattice.
const OFF: f64 = 0.1;

/// Speed over `sqrt(2 g H)` at most.
const PART: f64 = 0.5;

/// Times `sqrt(spacing/g)` after which the fluid is at rest.
const LASTS: f64 = 3.0;

pub(super) fn of(scene: &Scene, size: &Size) -> Option<String> {
    let gravity = scene.gravity.as_dvec3().length();
    let body = scene.bodies.iter().position(|body| body.cut)?;
    let solids = scene.boundaries.iter().enumerate();
    let solid = solids
        .filter(|(_, solid)| !matches!(solid, BoundaryShape::Tank { .. }))
        .find(|(_, solid)| !fits(scene, solid))?;
    let (low, high) = size.fluid_box;
    let depth = scene
        .gravity
        .as_dvec3()
        .normalize_or_zero()
        .abs()
        .dot(high - low);
    let speed = PART * (2.0 * gravity * depth).sqrt();
    (speed > 0.0).then(|| {
        format!(
            "`bodies.{body}` is cut, and between its lattice and `boundaries.{}` there are gaps of up to a spacing: \
             the fluid falls into them and settles with up to about {:.1} m/s in the first {} s; look at what follows, \
             or give the solid faces that are multiples of the spacing from the body's",
            solid.0,
            speed,
            short((LASTS * (f64::from(scene.spacing) / gravity).sqrt() * 100.0).round() / 100.0)
        )
    })
}

/// Whether a solid leaves no gap: it is beside all bodies that are cut, or has its faces in the planes of their
/// lattices.
fn fits(scene: &Scene, solid: &BoundaryShape) -> bool {
    let cut = || scene.bodies.iter().filter(|body| body.cut);
    let axes = match scene.dimension {
        Dimension::Two => 2,
        Dimension::Three => 3,
    };
    match *solid {
        BoundaryShape::Sphere { center, radius, .. } => cut().all(|body| {
            let away = body
                .frame()
                .place(body.shape.center())
                .distance(center.as_dvec3());
            away > f64::from(body.shape.reach() + radius)
        }),
        BoundaryShape::Box {
            min, max, rotation, ..
        } if rotation == DVec3::ZERO => {
            let solid = [min.as_dvec3(), max.as_dvec3()];
            cut().all(|body| match body.shape {
                Shape::Box { min, max } if body.rotation == DVec3::ZERO => {
                    let body = [min.as_dvec3(), max.as_dvec3()];
                    in_lattice(solid, body, axes, scene.spacing.into())
                }
                _ => false,
            })
        }
        BoundaryShape::Box { .. } => false,
        // Not measured: of ground, meshes and planes only parts may touch the body.
        _ => true,
    }
}

/// Whether the faces of a solid that lie within a body are in planes of its lattice, and far enough apart.
fn in_lattice([from, to]: [DVec3; 2], [min, max]: [DVec3; 2], axes: usize, spacing: f64) -> bool {
    let is_beside = (0..axes).any(|axis| from[axis] >= max[axis] || to[axis] <= min[axis]);
    let is_plane = |face: f64, axis: usize| {
        let at = (face - min[axis]) / spacing;
        face <= min[axis] || face >= max[axis] || (at - at.round()).abs() <= OFF
    };
    let fits = |axis: usize| {
        to[axis] - from[axis] >= 2.0 * spacing
            && is_plane(from[axis], axis)
            && is_plane(to[axis], axis)
    };
    is_beside || (0..axes).all(fits)
}

#[cfg(test)]
mod tests {
    use crate::{scene::Scene, step::warnings};

    #[test]
    fn gaps_beside_what_cuts_a_body_are_told_and_faces_in_the_lattice_are_not() {
        let told = |solid: &str, cut: bool| {
            let text = format!(
                "(name: \"t\", dimension: 2, spacing: 0.02,
                bodies: [(shape: Box(min: (0, 0, 0), max: (0.6, 0.3, 0)), cut: {cut})],
                boundaries: [Tank(min: (0, 0, 0), max: (0.6, 0.6, 0)), {solid}])"
            );
            let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
            warnings(&scene).expect("a scene").join("\n")
        };
        for solid in [
            "Sphere(center: (0.3, 0, 0), radius: 0.113)",
            "Box(min: (0, 0, 0), max: (0.6, 0.053, 0))",
            "Box(min: (0.2, 0, 0), max: (0.205, 0.25, 0))",
            "Box(min: (0.2, 0.1, 0), max: (0.3, 0.2, 0), rotation: (0, 0, 30))",
        ] {
            let told = told(solid, true);
            // Half of sqrt(2 g H) is 1.21 m/s; the fastest of these had 1.09.
            assert!(
                told.contains("up to about 1.2 m/s in the first 0.14 s"),
                "{solid}: {told}"
            );
        }
        for solid in [
            "Box(min: (0, 0, 0), max: (0.6, 0.06, 0))",
            "Box(min: (0.2, 0, 0), max: (0.4, 0.1, 0))",
            "Box(min: (0.2, 0.4, 0), max: (0.413, 0.5, 0))",
            "Sphere(center: (0.3, 9, 0), radius: 0.1)",
        ] {
            assert_eq!(told(solid, true), "", "{solid}");
        }
        assert_eq!(
            told("Sphere(center: (0.3, 0.5, 0), radius: 0.1)", false),
            ""
        );
    }
}
