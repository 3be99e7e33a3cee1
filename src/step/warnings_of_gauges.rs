//! Warnings for gauges in solids, and for figures that no reading is compared with.

use glam::Vec3;

use super::numbers::short;
use crate::scene::{BoundaryShape, Dimension, Gauge, GaugeKind, Scene};

pub(super) fn of(scene: &Scene, gauge: &Gauge) -> Vec<String> {
    let all = [
        in_a_solid(scene, gauge),
        beside(scene, gauge),
        long_window(scene, gauge),
    ];
    all.into_iter().flatten().collect()
}

/// A point within a solid that stands, where no fluid gets.
fn in_a_solid(scene: &Scene, gauge: &Gauge) -> Option<String> {
    let (at, radius) = match gauge.kind {
        GaugeKind::Pressure { at, radius } | GaugeKind::Velocity { at, radius } => {
            (at, radius.unwrap_or(scene.support_radius()))
        }
        _ => return None,
    };
    let flat = scene.dimension == Dimension::Two;
    let depth = |wall: &BoundaryShape| match *wall {
        BoundaryShape::Box { min, max, .. } => {
            let mut depth = (at - min).min(max - at);
            if flat {
                depth.z = f32::INFINITY;
            }
            depth.min_element()
        }
        BoundaryShape::Sphere { center, radius, .. } => radius - at.distance(center),
        _ => f32::NEG_INFINITY,
    };
    let walls = scene
        .boundaries
        .iter()
        .enumerate()
        .filter(|(_, wall)| wall.motion().is_none());
    let (index, depth) = walls
        .map(|(index, wall)| (index, depth(wall)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let Vec3 { x, y, z } = at;
    // Fluid outside of the solid may still be within the radius.
    (depth > radius).then(|| {
        format!(
            "the gauge `{}` at ({x}, {y}, {z}) m is {} m deep in the solid `boundaries.{index}`, and reads within \
             {radius} m: it shows nothing",
            gauge.name,
            short(depth.into())
        )
    })
}

/// Figures of other times than the scene has.
fn beside(scene: &Scene, gauge: &Gauge) -> Option<String> {
    let reference = gauge.reference.as_ref()?;
    let curve = reference.load().ok()?;
    let (first, last) = (curve.points.first()?.0, curve.points.last()?.0);
    let end = f64::from(scene.duration);
    (first > end || last < 0.0).then(|| {
        format!(
            "the figures of `{}` are from {} to {} s, and the scene is from 0 to {} s: no reading of the gauge `{}` \
             is compared with them; `scale` and `offset` convert times",
            reference.file,
            short(first),
            short(last),
            scene.duration,
            gauge.name
        )
    })
}

/// A window that is never full.
fn long_window(scene: &Scene, gauge: &Gauge) -> Option<String> {
    (gauge.window > scene.duration).then(|| {
        format!(
            "the gauge `{}` has a window of {} s, and the scene ends at {} s: its means are over less",
            gauge.name, gauge.window, scene.duration
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::warnings;
    use crate::scene::Scene;

    fn of(gauge: &str) -> String {
        let text = format!(
            "(name: \"t\", dimension: 2, spacing: 0.1, duration: 2, gauges: [(name: \"mine\", {gauge})],
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0)))],
            boundaries: [Tank(min: (0, 0, 0), max: (4, 4, 0)), Box(min: (1, 1, 0), max: (2, 2, 0)),
                Sphere(center: (3, 3, 0), radius: 0.5)])"
        );
        let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        warnings(&scene).expect("a scene").join("\n")
    }

    #[test]
    fn gauges_in_solids_are_told() {
        for (x, y, deep) in [
            (1.5, 1.5, true),
            (1.3, 1.7, true),
            (1.1, 1.5, false),
            (0.8, 1.5, false),
            (3.0, 3.0, true),
            (3.4, 3.0, false),
        ] {
            for kind in ["Pressure", "Velocity"] {
                let told = of(&format!("kind: {kind}(at: ({x}, {y}, 0))"));
                assert_eq!(
                    told.contains("deep in the solid"),
                    deep,
                    "{kind} at {x}, {y}: {told}"
                );
            }
        }
        assert_eq!(of("kind: Pressure(at: (1.5, 1.5, 0), radius: 0.7)"), "");
    }

    #[test]
    fn figures_of_other_times_and_windows_that_are_never_full_are_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("r.csv");
        for (first, last, beside) in [
            (5.0, 9.0, true),
            (-3.0, -1.0, true),
            (1.0, 9.0, false),
            (-1.0, 0.5, false),
        ] {
            std::fs::write(&file, format!("t,p\n{first},1\n{last},2\n")).expect("a file");
            let told = of(&format!(
                "kind: Pressure(at: (0.1, 0.1, 0)), reference: (file: {:?})",
                file.display().to_string()
            ));
            assert_eq!(
                told.contains("no reading of the gauge `mine`"),
                beside,
                "{first}: {told}"
            );
        }
        for (window, long) in [(3.0, true), (2.0, false), (0.0, false)] {
            let told = of(&format!(
                "kind: Energy, window: {window}, every: Seconds(0.1)"
            ));
            assert_eq!(told.contains("a window of"), long, "{window}: {told}");
        }
    }
}
