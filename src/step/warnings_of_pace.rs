//! Warnings for speeds that no method follows, for runs without an end in sight, and for steps in which single
//! precision loses what moves.

use super::limits::{self, expected_step};
use super::numbers::short;
use crate::{
    loading::Size,
    scene::{Dimension, Scene, TimeStep},
};

/// 0.3 times the speed of sound in water, above which it cannot be treated as incompressible \[m/s].
const FASTEST: f32 = 0.3 * 1480.0;

/// More steps take weeks with few particles.
const MOST_STEPS: f64 = 1e8;

/// Least way in a step, in distances between neighbouring numbers: less is off by more than 5 %.
const LEAST_WAY: f64 = 10.0;

pub(super) fn of(scene: &Scene, size: &Size) -> Vec<String> {
    let (low, high) = (size.fluid_box.0.as_vec3(), size.fluid_box.1.as_vec3());
    let limits = limits::of(scene, low, high);
    let dt = f64::from(expected_step(scene, &limits));
    // Steps that end at every frame are no longer than the time between two.
    let rate = f64::from(scene.output.frames_per_second);
    let dt = if scene.output.exact_times && rate > 0.0 {
        dt.min(1.0 / rate)
    } else {
        dt
    };
    let fall = limits::fall(scene, low, high);
    let mut warnings = Vec::new();
    warnings.extend(too_fast(scene, fall));
    warnings.extend(endless(scene, dt));
    warnings.extend(lost(size, dt, fall.into()));
    warnings
}

fn too_fast(scene: &Scene, fall: f32) -> Option<String> {
    let start = scene.max_initial_speed();
    let in_plane = scene.dimension == Dimension::Two;
    let walls = scene
        .boundaries
        .iter()
        .filter_map(|wall| wall.greatest_speed(in_plane, None));
    let wall = walls.fold(0.0, f32::max);
    let (what, speed) = if start > FASTEST {
        ("fluid starts", start)
    } else if wall > FASTEST {
        ("a wall moves", wall)
    } else if fall > FASTEST {
        ("fluid that falls through its own height arrives", fall)
    } else {
        return None;
    };
    Some(format!(
        "{what} at {} m/s; all methods take the fluid for incompressible, which water is up to {FASTEST:.0} m/s, three \
         tenths of its speed of sound",
        short(speed.into())
    ))
}

fn endless(scene: &Scene, dt: f64) -> Option<String> {
    let duration = f64::from(scene.duration);
    let steps = duration / dt;
    let remedy = match scene.time_step {
        _ if scene.output.exact_times && dt * f64::from(scene.output.frames_per_second) > 0.99 => {
            "write fewer `frames_per_second`, or frames without `exact_times`, or a shorter `duration`"
        }
        TimeStep::Fixed(_) => "write a longer step, or `time_step: Cfl()`, or a shorter `duration`",
        _ => "write a shorter `duration`, or longer steps (`max` in `time_step`, a larger spacing)",
    };
    (steps > MOST_STEPS).then(|| {
        format!(
            "the run takes about {steps:.1e} steps of {dt:.1e} s to its end at {} s, which are years; {remedy}",
            scene.duration
        )
    })
}

/// Where coordinates are large and steps short, positions stay what they were, or move by too much.
fn lost(size: &Size, dt: f64, speed: f64) -> Option<String> {
    let (low, high) = size.fluid_box;
    let farthest = low.abs().max(high.abs()).max_element();
    let single = farthest as f32;
    let apart = f64::from(single.next_up()) - f64::from(single);
    let way = speed * dt;
    if way == 0.0 || way >= LEAST_WAY * apart {
        return None;
    }
    let loss = if way < 0.5 * apart {
        "nothing moves".to_owned()
    } else {
        format!(
            "ways are off by up to {:.0} %",
            (50.0 * apart / way).min(100.0)
        )
    };
    Some(format!(
        "fluid at {} m/s moves {way:.1e} m in a step of {dt:.1e} s, and at {} m coordinates in single precision are \
         {apart:.1e} m apart: {loss}; write longer steps, or move the scene to the origin",
        short(speed),
        short(farthest)
    ))
}

#[cfg(test)]
mod tests {
    use super::super::warnings;
    use crate::scene::Scene;

    fn of(x: f32, rest: &str) -> String {
        let far = x + 0.5;
        let text = format!(
            "(name: \"t\", dimension: 2, spacing: 0.1, duration: 2,
            bodies: [(shape: Box(min: ({x}, 0, 0), max: ({far}, 0.5, 0)), velocity: (1, 0, 0))], {rest})"
        );
        let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        warnings(&scene).expect("a scene").join("\n")
    }

    /// The warning comes wherever a float of the coordinate loses more than 5.5 % of the way.
    #[test]
    fn ways_that_single_precision_loses_are_told() {
        let (mut told, mut quiet) = (0, 0);
        for exponent in 2..9 {
            for x in [0.0_f32, 1.0, 30.0, 1000.0] {
                let dt = 10.0_f32.powi(-exponent);
                let text = of(x, &format!("gravity: (0, 0, 0), time_step: Fixed({dt:e})"));
                let end = x + 0.45;
                let moved = f64::from(end + dt) - f64::from(end);
                let error = (moved / f64::from(dt) - 1.0).abs();
                let is_told = text.contains("single precision");
                assert!(is_told || error <= 0.055, "{x} m, {dt:e} s: {error}");
                assert!(
                    !text.contains("nothing moves") || moved == 0.0,
                    "{x} m, {dt:e} s"
                );
                *(if is_told { &mut told } else { &mut quiet }) += 1;
            }
        }
        assert!(told > 5 && quiet > 5, "{told} told, {quiet} not");
    }

    #[test]
    fn runs_of_years_are_told() {
        for (rest, years) in [
            ("time_step: Fixed(1e-9)", true),
            ("time_step: Fixed(1e-30)", true),
            ("time_step: Cfl(max: 1e-9, min: 1e-10)", true),
            ("time_step: Fixed(1e-3)", false),
            ("time_step: Cfl(max: 1e-6)", false),
            ("output: (frames_per_second: 1e9, exact_times: true)", true),
            ("output: (frames_per_second: 1e9)", false),
        ] {
            assert_eq!(of(0.0, rest).contains("which are years"), years, "{rest}");
        }
    }

    /// Whatever brings fluid to the speed of sound is named.
    #[test]
    fn speeds_of_sound_are_told() {
        let wall = |speed: f32| {
            format!(
                "boundaries: [Box(min: (5, 0, 0), max: (6, 1, 0), motion: Velocity(velocity: ({speed}, 0, 0)))]"
            )
        };
        for (rest, part) in [
            (wall(2000.0), "a wall moves at 2000 m/s"),
            (wall(100.0), ""),
            ("gravity: (0, -1e6, 0)".to_owned(), "fluid that falls"),
            (
                "emitters: [(shape: Disc(center: (9, 9, 0), normal: (0, 1, 0), radius: 1), speed: 500)]"
                    .to_owned(),
                "fluid starts at 500 m/s",
            ),
        ] {
            let told = of(0.0, &rest);
            assert!(told.contains(part) && told.contains("incompressible") != part.is_empty(), "{rest}: {told}");
        }
    }
}
