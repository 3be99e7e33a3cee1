//! Warnings: settings that are allowed but probably mistakes. They are given before the run, with a value that would be
//! right.

use std::path::Path;

use glam::{DVec3, Vec3};

use super::{
    limits, numbers::short, warnings_of_cuts, warnings_of_flow, warnings_of_forces,
    warnings_of_gauges, warnings_of_layers, warnings_of_pace, warnings_of_tolerances,
    warnings_of_units,
};
use crate::{
    loading::Size,
    scene::{
        AccelerationTable, BodyForce, BoundaryShape, Gauge, GaugeKind, LEAST_WAY, MotionTable,
        Rate, Scene, SceneError, TimeStep, WallCourse, WallMotion,
    },
};

/// Times at which a wall is looked at, evenly over the run. A prime: an oscillation is not met at its zeros.
const LOOKS: u32 = 97;

/// Settings of a scene that are probably mistakes. Fails as [`Scene::check`] does.
pub fn warnings(scene: &Scene) -> Result<Vec<String>, SceneError> {
    Ok(of_size(scene, &scene.checked_size()?))
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

/// A warning for a level without gravity, against which it is measured.
fn without_up(scene: &Scene, gauge: &Gauge) -> Option<String> {
    let is_level = matches!(gauge.kind, GaugeKind::Height { .. });
    (is_level && scene.gravity == Vec3::ZERO).then(|| {
        format!(
            "the gauge `{}` measures a level, and the scene has no gravity to say where up is: it takes +y; \
             `kind: Front(direction: …)` measures along any direction",
            gauge.name
        )
    })
}

/// A warning for a wall that hardly moves while the scene lasts.
fn stands(scene: &Scene, (index, wall): (usize, &BoundaryShape), size: &Size) -> Option<String> {
    let course = WallCourse::new(wall.motion()?).ok()?;
    let (low, high) = size.whole_box;
    let end = f64::from(scene.duration);
    let moved = |time: f64| {
        let pose = course.pose(time);
        let corners = [low, high, DVec3::new(low.x, high.y, low.z)];
        let of = |x: DVec3| pose.place(x.as_vec3()).distance(x.as_vec3().as_dvec3());
        corners.map(of).into_iter().fold(0.0, f64::max)
    };
    let times = (1..=LOOKS).map(|k| end * f64::from(k) / f64::from(LOOKS));
    let most = times.map(moved).fold(0.0, f64::max);
    (most < f64::from(LEAST_WAY * scene.spacing)).then(|| {
        format!(
            "the wall `boundaries.{index}` has a `motion`, and moves {} m at most in the {} s of the scene: it \
             stands; see its times and its speed, or leave `motion` out",
            short(most),
            scene.duration
        )
    })
}

/// A warning for tables whose rows are closer than a step: the fluid notices their mean alone.
fn dense_tables(scene: &Scene) -> Option<String> {
    let forces = scene.body_forces.iter().filter_map(|force| match force {
        BodyForce::Table(table) => {
            let read = AccelerationTable::load(Path::new(&table.file)).ok()?;
            Some((read.shortest_interval(), &table.file))
        }
        BodyForce::Central(_) | BodyForce::Wave(_) => None,
    });
    let walls = scene
        .boundaries
        .iter()
        .filter_map(|wall| match wall.motion()? {
            WallMotion::Table { file, .. } => {
                let read = MotionTable::load(Path::new(file)).ok()?;
                Some((read.shortest_interval(), file))
            }
            _ => None,
        });
    let (interval, file) = forces.chain(walls).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let TimeStep::Fixed(dt) = scene.time_step else {
        return None;
    };
    (interval < f64::from(dt) * (1.0 - 1e-3)).then(|| {
        format!(
            "rows of `{file}` are {interval:e} s apart, and a step is {dt:e} s: what is between the ends of a step \
             acts by its mean; `time_step: Fixed({interval:.0e})` would show every row"
        )
    })
}

pub(super) fn of_size(scene: &Scene, size: &Size) -> Vec<String> {
    let mut warnings = Vec::new();
    warnings.extend(warnings_of_units::of(scene, size));
    warnings.extend(warnings_of_pace::of(scene, size));
    warnings.extend(
        scene
            .gauges
            .iter()
            .filter_map(|gauge| idle(scene, size, gauge)),
    );
    let gauges = scene.gauges.iter();
    warnings.extend(gauges.filter_map(|gauge| without_up(scene, gauge)));
    let gauges = scene.gauges.iter();
    warnings.extend(gauges.flat_map(|gauge| warnings_of_gauges::of(scene, gauge)));
    let walls = scene.boundaries.iter().enumerate();
    warnings.extend(walls.filter_map(|wall| stands(scene, wall, size)));
    warnings.extend(dense_tables(scene));
    warnings.extend(warnings_of_tolerances::of(scene));
    warnings.extend(warnings_of_flow::of(scene));
    warnings.extend(warnings_of_forces::of(scene));
    warnings.extend(warnings_of_layers::of(scene));
    warnings.extend(warnings_of_cuts::of(scene, size));
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
    fn walls_that_stand_and_levels_without_gravity_are_told() {
        let scene = |motion: &str, gravity: &str| {
            let text = format!(
                "(name: \"t\", dimension: 2, spacing: 0.1, duration: 2, gravity: {gravity},
                gauges: [(name: \"mine\", kind: Height(at: (1, 0, 0)))],
                bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0)))],
                boundaries: [Tank(min: (0, 0, 0), max: (2, 1, 0)),
                    Box(min: (1.5, 0, 0), max: (1.7, 1, 0), motion: {motion})])"
            );
            let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
            warnings(&scene).expect("a scene").join("\n")
        };
        let down = "(0, -9.81, 0)";
        for stands in [
            "Velocity(velocity: (0, 1, 0), start: 2)",
            "Velocity(velocity: (0, 1e-20, 0))",
            "Oscillation(amplitude: (0, 1e-6, 0), frequency: 1)",
        ] {
            let told = scene(stands, down);
            assert!(
                told.contains("`boundaries.1` has a `motion`"),
                "{stands}: {told}"
            );
        }
        for moves in [
            "Velocity(velocity: (0, 1, 0), start: 1.9)",
            "Oscillation(amplitude: (0, 0.01, 0), frequency: 10)",
            "Rotation(center: (1.6, 0.5, 0), angular_velocity: (0, 0, 0.1))",
        ] {
            assert_eq!(scene(moves, down), "", "{moves}");
        }
        let told = scene("Velocity(velocity: (0, 1, 0))", "(0, 0, 0)");
        assert!(
            told.contains("takes +y") && told.contains("`kind: Front"),
            "{told}"
        );
    }
}
