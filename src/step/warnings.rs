//! Warnings: settings that are allowed but probably mistakes. They are given before the run, with a value that would be
//! right.

use glam::Vec3;

use super::limits;
use crate::{
    loading::Size,
    scene::{Gauge, GaugeKind, Rate, Scene, SceneError},
};

/// Above these lengths a scene was probably written in millimetres: spacing and extent \[m].
const LARGE_SPACING: f32 = 1.0;
const LARGE_EXTENT: f64 = 500.0;

/// 0.3 times the speed of sound in water, above which it cannot be treated as incompressible \[m/s].
const FASTEST: f32 = 0.3 * 1480.0;

/// Settings of a scene that are probably mistakes. Fails as [`Scene::check`] does.
pub fn warnings(scene: &Scene) -> Result<Vec<String>, SceneError> {
    Ok(of_size(scene, &scene.checked_size()?))
}

/// A number with four digits that count, as people write it.
fn short(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// A warning for a gauge that may never show anything: read after the end, or where nothing is at the start.
fn idle(scene: &Scene, size: &Size, gauge: &Gauge) -> Option<String> {
    let name = &gauge.name;
    if let Rate::Seconds(every) = gauge.every
        && every > scene.duration
    {
        return Some(format!(
            "the gauge `{name}` is read every {every} s, and the scene ends at {} s: it shows nothing",
            scene.duration
        ));
    }
    let (at, radius, upright) = match gauge.kind {
        GaugeKind::Pressure { at, radius }
        | GaugeKind::Velocity { at, radius }
        | GaugeKind::WallPressure { at, radius, .. } => {
            (at, radius.unwrap_or(scene.support_radius()), None)
        }
        // Where on its axis the point is does not matter.
        GaugeKind::Height { at, radius } => {
            let up = (-scene.gravity).try_normalize().unwrap_or(Vec3::Y);
            (at, radius.unwrap_or(scene.spacing), Some(up.as_dvec3()))
        }
        _ => return None,
    };
    let (low, high) = size.whole_box;
    let place = at.as_dvec3();
    let away = place - place.clamp(low, high);
    // Along a periodic axis every place has an image in the box.
    let mut away = scene.period().open_part(away.as_vec3()).as_dvec3();
    if let Some(up) = upright {
        away -= away.dot(up) * up;
    }
    (away.length() > f64::from(radius)).then(|| {
        format!(
            "the gauge `{name}` at ({}, {}, {}) m is {} m outside the box around all fluid and walls, from {} to {}: \
             it may never show anything",
            at.x,
            at.y,
            at.z,
            short(away.length()),
            low.as_vec3(),
            high.as_vec3()
        )
    })
}

pub(super) fn of_size(scene: &Scene, size: &Size) -> Vec<String> {
    let mut warnings = Vec::new();
    let extent = (size.whole_box.1 - size.whole_box.0).max_element();
    if scene.spacing >= LARGE_SPACING || extent >= LARGE_EXTENT {
        let spacing = f64::from(scene.spacing);
        warnings.push(format!(
            "the scene is {} m long at a spacing of {} m; lengths are in metres, so if these are millimetres, write \
             {} and {}",
            short(extent),
            short(spacing),
            short(1e-3 * extent),
            short(1e-3 * spacing),
        ));
    }
    let start = scene.max_initial_speed();
    if start > FASTEST {
        warnings.push(format!(
            "a body starts at {start} m/s; all methods take the fluid for incompressible, which water is up to \
             {FASTEST:.0} m/s, three tenths of its speed of sound"
        ));
    }
    warnings.extend(
        scene
            .gauges
            .iter()
            .filter_map(|gauge| idle(scene, size, gauge)),
    );
    let (low, high) = size.fluid_box;
    warnings.extend(limits::too_long(scene, low.as_vec3(), high.as_vec3()));
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(gauges: &str) -> String {
        let text = format!(
            "(name: \"t\", dimension: 2, spacing: 0.1, duration: 2, gauges: [{gauges}],
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0)))],
            boundaries: [Tank(min: (0, 0, 0), max: (2, 1, 0))])"
        );
        let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        warnings(&scene).expect("a scene").join("\n")
    }

    #[test]
    fn gauges_that_can_show_nothing_are_told() {
        for (gauge, part) in [
            ("kind: Height(at: (3, 0, 0))", "outside the box"),
            ("kind: Velocity(at: (1, 5, 0))", "outside the box"),
            ("kind: Pressure(at: (-1e30, 0, 0))", "outside the box"),
            ("kind: Energy, every: Seconds(2.5)", "it shows nothing"),
        ] {
            let told = of(&format!("(name: \"mine\", {gauge})"));
            assert!(
                told.contains(part) && told.contains("`mine`"),
                "{gauge}: {told}"
            );
        }
        for gauge in [
            "kind: Height(at: (1.9, 70, 0))",
            "kind: Height(at: (2.9, 0, 0), radius: 1)",
            "kind: Velocity(at: (1, 0.9, 0)), every: Seconds(2)",
            "kind: WallPressure(at: (2, 0.1, 0), normal: (-1, 0, 0))",
        ] {
            assert_eq!(of(&format!("(name: \"mine\", {gauge})")), "", "{gauge}");
        }
    }

    #[test]
    fn lengths_that_look_like_millimetres_are_told_in_few_digits() {
        let text = "(name: \"t\", dimension: 2, spacing: 10, gravity: (0, 0, 0),
            bodies: [(shape: Box(min: (0, 0, 0), max: (700.2, 500, 0)))])";
        let scene = Scene::parse(text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        let told = warnings(&scene).expect("a scene").join("\n");
        assert!(
            told.contains("700.2 m long") && told.contains("write 0.7002 and 0.01"),
            "{told}"
        );
    }
}
