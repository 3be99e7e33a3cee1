//! Time steps that cannot be stable, or in which walls and forces would stand still: a least or a fixed one above the
//! limits that `check` itself prints.

use super::problem::{Checked, Problem};
use crate::registry::Stages;
use crate::scene::{Adaptive, Cfl, Dimension, Scene, TimeStep};
use crate::state::PART_OF_PERIOD;

/// A limit below asks for a thousand million steps a second: what causes it is the mistake \[s].
const SHORTEST: f32 = 1e-9;
/// A fixed step may be longer than its limit by as much as numbers are rounded.
const ROUNDING: f32 = 1.001;

/// The least time step must leave room for the limits that are certain: viscosity and sound, walls, gravity, and the
/// speed at the start.
pub(super) fn least_time_step(scene: &Scene) -> Checked {
    let min = match scene.time_step {
        TimeStep::Cfl(Cfl { min, .. }) | TimeStep::Adaptive(Adaptive { min, .. }) => min,
        // Whoever fixes the time step knows of its limits, and is warned.
        TimeStep::Fixed(dt) => return fixed(scene, dt),
    };
    let limits = Stages::default().certain_limits(scene);
    let Some((name, limit)) = limits.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(());
    };
    if min <= limit {
        return Ok(());
    }
    let is_absurd = limit < SHORTEST;
    let own = min == Cfl::default().min;
    // A scene that does not write `min` has its mistake elsewhere.
    let cause = cause(scene, name).filter(|_| is_absurd || own);
    let message = format!(
        "the least time step is {min:e} s, above the limit of {} s by {name} at this spacing; {}",
        if limit > 0.0 {
            format!("{limit:.2e}")
        } else {
            "0".to_owned()
        },
        match &cause {
            Some(cause) if is_absurd =>
                format!("{}: it must be in SI units, and smaller", cause.what),
            Some(cause) => format!(
                "{}: a smaller one, a larger spacing, or `min: {:.0e}` in `time_step`",
                cause.what,
                0.1 * limit
            ),
            None if is_absurd => "what causes it must be smaller, or the spacing larger".to_owned(),
            None => format!(
                "`min: {:.0e}` leaves room, or a larger spacing",
                0.1 * limit
            ),
        }
    );
    let path = cause.map_or("time_step.min".to_owned(), |cause| cause.path);
    Err(Problem::new(path, message))
}

/// The field that a limit comes from, and what it says.
struct Cause {
    path: String,
    what: String,
}

fn cause(scene: &Scene, name: &str) -> Option<Cause> {
    let in_plane = scene.dimension == Dimension::Two;
    let walls = || scene.boundaries.iter().enumerate();
    let of_wall = |index: usize, what: String| Cause {
        path: format!("boundaries.{index}.motion"),
        what,
    };
    Some(match name {
        "the speed of walls" => {
            let speeds =
                walls().filter_map(|(k, wall)| Some((k, wall.greatest_speed(in_plane, None)?)));
            let mesh = || walls().find(|wall| wall.1.motion().is_some());
            match speeds.max_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((index, speed)) => {
                    of_wall(index, format!("the wall moves with up to {speed:.3e} m/s"))
                }
                None => of_wall(mesh()?.0, "the mesh turns too fast".to_owned()),
            }
        }
        "the period of walls" => {
            let of = |(k, wall): (usize, &crate::scene::BoundaryShape)| {
                Some((k, wall.shortest_period(scene.spacing)?))
            };
            let shortest = walls().filter_map(of).min_by(|a, b| a.1.total_cmp(&b.1));
            let (index, period) = shortest?;
            of_wall(
                index,
                format!("the wall goes back and forth in {period:.3e} s"),
            )
        }
        "the period of body forces" => Cause {
            path: "body_forces".to_owned(),
            what: format!(
                "they oscillate in {:.3e} s",
                scene.shortest_period_of_forces()
            ),
        },
        "gravity and body forces" => Cause {
            path: "body_forces".to_owned(),
            what: match scene.greatest_acceleration() {
                most if most.is_finite() => format!("they are up to {most:.3e} m/s²"),
                _ => "they are beyond the largest number of single precision".to_owned(),
            },
        },
        "gravity" => Cause {
            path: "gravity".to_owned(),
            what: format!("gravity is {:.3e} m/s²", scene.gravity.as_dvec3().length()),
        },
        "the speed at the start" => {
            let bodies = scene.bodies.iter().map(|body| body.greatest_speed());
            let emitters = scene.emitters.iter().map(|emitter| emitter.speed);
            let fastest = |speeds: &mut dyn Iterator<Item = f32>| {
                speeds.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
            };
            match (fastest(&mut { bodies }), fastest(&mut { emitters })) {
                (body, Some((index, speed))) if body.is_none_or(|body| body.1 < speed) => Cause {
                    path: format!("emitters.{index}.speed"),
                    what: format!("the fluid enters at {speed:.3e} m/s"),
                },
                (body, _) => Cause {
                    path: format!("bodies.{}", body?.0),
                    what: format!("the body starts with up to {:.3e} m/s", body?.1),
                },
            }
        }
        "viscosity" => Cause {
            path: "fluid.viscosity".to_owned(),
            what: "the viscosity is a kinematic one in m²/s (water has 1e-6)".to_owned(),
        },
        _ => return None,
    })
}

/// A fixed step must show the movements of walls and forces: in a whole period nothing would move.
fn fixed(scene: &Scene, dt: f32) -> Checked {
    let refuse = |what: String, period: f32| {
        let limit = PART_OF_PERIOD * period;
        if dt <= ROUNDING * limit {
            return Ok(());
        }
        Err(Problem::new(
            "time_step",
            format!(
                "{what} in {period:.3e} s, and a step of {dt:e} s is more than a twentieth of it: too long to follow; \
                 `Fixed({:.0e})` would do, or `Cfl()`, or a slower movement",
                0.8 * limit
            ),
        ))
    };
    for (index, wall) in scene.boundaries.iter().enumerate() {
        if let Some(period) = wall.shortest_period(scene.spacing) {
            refuse(
                format!("the wall `boundaries.{index}` goes back and forth"),
                period,
            )?;
        }
    }
    match scene.shortest_period_of_forces() {
        period if period.is_finite() => refuse(
            "a force of `body_forces` goes back and forth".to_owned(),
            period,
        ),
        _ => Ok(()),
    }
}
