//! Warnings for walls of several layers: solids that are thinner than their layers, and tanks whose layers meet.

use glam::Vec3;

use super::numbers::short;
use crate::sampling;
use crate::scene::{BoundaryHandling, BoundaryShape, Dimension, Scene};

/// How thick walls must be for all of their layers \[m].
fn reach(scene: &Scene) -> f32 {
    sampling::layer_depths(scene).count() as f32 * scene.spacing
}

pub(super) fn of(scene: &Scene) -> Vec<String> {
    if scene.boundary_handling() != BoundaryHandling::Layers {
        return Vec::new();
    }
    let numbered = scene.boundaries.iter().enumerate();
    let thin = numbered.filter_map(|(index, wall)| thin(scene, index, wall));
    thin.chain(tanks_that_meet(scene)).collect()
}

/// A solid without room for all layers: it does not push as a wall does, and water passes it.
fn thin(scene: &Scene, index: usize, wall: &BoundaryShape) -> Option<String> {
    let thickness = match *wall {
        BoundaryShape::Box { min, max, .. } => match scene.dimension {
            Dimension::Two => (max - min).truncate().min_element(),
            Dimension::Three => (max - min).min_element(),
        },
        BoundaryShape::Sphere { radius, .. } => 2.0 * radius,
        _ => return None,
    };
    let needed = reach(scene);
    (thickness < 0.999 * needed).then(|| {
        format!(
            "`boundaries.{index}` is {} m thick, and its layers need {} m: water beside it is not at rest and may pass \
             it; make it thicker, or write `boundary_handling: Akinci`",
            short(thickness.into()),
            short(needed.into())
        )
    })
}

/// Tanks side by side whose layers reach into the other one.
fn tanks_that_meet(scene: &Scene) -> Vec<String> {
    let reach = reach(scene);
    let tanks: Vec<(usize, Vec3, Vec3)> = (scene.boundaries.iter().enumerate())
        .filter_map(|(index, wall)| match *wall {
            BoundaryShape::Tank { min, max, .. } if !wall.frame().is_turned() => {
                Some((index, min, max))
            }
            _ => None,
        })
        .collect();
    let in_plane = scene.dimension == Dimension::Two;
    let meet = |a: &(usize, Vec3, Vec3), b: &(usize, Vec3, Vec3)| {
        let gap = (a.1 - b.2).max(b.1 - a.2);
        let gap = if in_plane {
            gap.truncate().max_element()
        } else {
            gap.max_element()
        };
        // Below zero one is in the other, which is refused where fluid is.
        (0.0..0.999 * reach).contains(&gap).then(|| {
            format!(
                "the tanks `boundaries.{}` and `boundaries.{}` are {} m apart, and their layers reach {} m: those of \
                 the one push the water of the other; move them apart, or write `boundary_handling: Akinci`",
                a.0,
                b.0,
                short(gap.into()),
                short(reach.into())
            )
        })
    };
    let pairs = (0..tanks.len()).flat_map(|a| (0..a).map(move |b| (b, a)));
    pairs
        .filter_map(|(a, b)| meet(&tanks[a], &tanks[b]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::warnings;
    use crate::scene::Scene;

    fn told(boundaries: &str, handling: &str) -> String {
        let text = format!(
            "(name: \"t\", dimension: 2, spacing: 0.1, boundary_handling: {handling}, kernel: WendlandC2, support: 4,
            bodies: [(shape: Box(min: (0, 1, 0), max: (1, 2, 0)))], boundaries: [{boundaries}])"
        );
        let scene = Scene::parse(&text, "t.ron", &[]).expect("a scene");
        warnings(&scene).expect("a scene").join("\n")
    }

    #[test]
    fn thin_solids_and_near_tanks_are_told_with_layers_alone() {
        let boxes = |thickness: f32| format!("Box(min: (0, {}, 0), max: (1, 0, 0))", -thickness);
        assert!(told(&boxes(0.2), "Layers").contains("`boundaries.0` is 0.2 m thick"));
        for (boundaries, handling) in [(boxes(0.4), "Layers"), (boxes(0.2), "Akinci")] {
            assert!(!told(&boundaries, handling).contains("thick"));
        }
        let tanks = |gap: f32| {
            format!(
                "Tank(min: (0, 0, 0), max: (2, 3, 0)), Tank(min: ({}, 0, 0), max: (6, 3, 0))",
                2.0 + gap
            )
        };
        assert!(told(&tanks(0.3), "Layers").contains("`boundaries.0` and `boundaries.1`"));
        assert!(!told(&tanks(0.5), "Layers").contains("push the water"));
        assert!(!told(&tanks(0.3), "Akinci").contains("push the water"));
    }
}
