//! Gauges: names, places, rates, and what they are compared with.

use std::path::Path;

use glam::Vec3;

use super::problem::{Checked, Problem, ensure};
use super::proper::{axes, box_is_proper, is_flat};
use crate::input::no_file;
use crate::scene::{
    Dimension, Gauge, GaugeKind, GaugeReference, Rate, Scene, TimeStep, unknown_name,
};

/// Longest name \[bytes]: it names a file.
const LONGEST_NAME: usize = 100;

pub(super) fn gauges(scene: &Scene) -> Checked {
    for (index, gauge) in scene.gauges.iter().enumerate() {
        let path = format!("gauges.{index}");
        name(scene, index, &path)?;
        rate(scene, gauge, &path)?;
        kind(scene, &gauge.kind, &format!("{path}.kind"))?;
        if let Some(reference) = &gauge.reference {
            compared(gauge, reference, &format!("{path}.reference"))?;
        }
    }
    for (index, boundary) in scene.boundaries.iter().enumerate() {
        let is_empty = boundary.name().is_some_and(|name| name.trim().is_empty());
        ensure(!is_empty, format!("boundaries.{index}.name"), || {
            "the name is empty; write a word, or leave it out".to_owned()
        })?;
    }
    Ok(())
}

fn name(scene: &Scene, index: usize, path: &str) -> Checked {
    let name = &scene.gauges[index].name;
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let names_a_file = !name.is_empty() && name.len() <= LONGEST_NAME && name.chars().all(is_plain);
    ensure(names_a_file, format!("{path}.name"), || {
        format!(
            "the name {name:?} cannot name the gauge's file; write at most {LONGEST_NAME} letters (a to z), digits, \
             `-` and `_`"
        )
    })?;
    // Some file systems do not tell capitals from small letters.
    let same = |other: &&Gauge| other.name.eq_ignore_ascii_case(name);
    let twice = scene.gauges[..index].iter().find(same);
    ensure(twice.is_none(), format!("{path}.name"), || {
        format!("the name {name:?} is given twice; files and readings go by it")
    })
}

fn rate(scene: &Scene, gauge: &Gauge, path: &str) -> Checked {
    // Not finite was refused before.
    let (interval, unit) = match gauge.every {
        Rate::Seconds(seconds) => {
            ensure(seconds > 0.0, format!("{path}.every"), || {
                format!("the gauge is read every {seconds} s; it must be above 0")
            })?;
            (Some(seconds), "s".to_owned())
        }
        Rate::Steps(steps) => {
            ensure(steps > 0, format!("{path}.every"), || {
                "the gauge is read every 0 steps; the least is 1".to_owned()
            })?;
            let fixed = match scene.time_step {
                TimeStep::Fixed(dt) => Some(dt * steps as f32),
                TimeStep::Cfl(_) | TimeStep::Adaptive(_) => None,
            };
            (fixed, format!("s ({steps} steps)"))
        }
    };
    let window = gauge.window;
    ensure(window >= 0.0, format!("{path}.window"), || {
        format!("the window is {window} s; it must not be below 0 (0 for no means)")
    })?;
    let is_long =
        interval.is_none_or(|interval| window == 0.0 || window >= interval * (1.0 - 1e-5));
    ensure(is_long, format!("{path}.window"), || {
        let interval = interval.unwrap_or_default();
        format!(
            "the window of {window} s is shorter than the time between readings, {interval} {unit}: what lies between \
             would be in no mean; it must be as long at least, or read the gauge more often (`every`)"
        )
    })
}

/// Radii of gauges \[spacings]: within less there is no particle, and of more the kernel is lost in single precision.
const RADII: std::ops::RangeInclusive<f32> = 0.5..=1e5;

/// A radius that is given.
fn radius(scene: &Scene, path: &str, radius: Option<f32>) -> Checked {
    let spacing = scene.spacing;
    let is_proper = radius.is_none_or(|radius| RADII.contains(&(radius / spacing)));
    ensure(is_proper, format!("{path}.radius"), || {
        format!(
            "the radius is {} m; it must be from {} m, half a spacing, below which there is no particle, to {:e} m \
             (left out, it is chosen)",
            radius.unwrap_or_default(),
            RADII.start() * spacing,
            RADII.end() * spacing
        )
    })
}

/// A point that particles can reach.
fn point(scene: &Scene, path: String, at: Vec3) -> Checked {
    is_flat(&path, at, scene.dimension)?;
    let Some(domain) = scene.domain else {
        return Ok(());
    };
    let outside = |axis: &usize| at[*axis] < domain.min[*axis] || at[*axis] > domain.max[*axis];
    let is_inside = !(0..axes(scene.dimension)).any(|axis| outside(&axis));
    ensure(is_inside, path, || {
        format!(
            "({}, {}, {}) m is outside the domain, from ({}, {}, {}) to ({}, {}, {}) m, where no fluid gets",
            at.x,
            at.y,
            at.z,
            domain.min.x,
            domain.min.y,
            domain.min.z,
            domain.max.x,
            domain.max.y,
            domain.max.z
        )
    })
}

fn direction(scene: &Scene, path: String, what: &str, direction: Vec3) -> Checked {
    is_flat(&path, direction, scene.dimension)?;
    // The square of a length that is too small, or too large, is none.
    let is_proper = direction.try_normalize().is_some();
    ensure(is_proper, path, || {
        let [x, y, z] = direction.to_array();
        match direction == Vec3::ZERO {
            true => format!("the {what}"),
            false => {
                format!(
                    "the square of ({x:e}, {y:e}, {z:e}) is beyond single precision; write a length nearer to 1"
                )
            }
        }
    })
}

fn kind(scene: &Scene, kind: &GaugeKind, path: &str) -> Checked {
    match *kind {
        GaugeKind::Height { at, radius: of } => {
            radius(scene, path, of)?;
            is_flat(format!("{path}.at"), at, scene.dimension)?;
            // Where on its axis the point is does not matter.
            let up = (-scene.gravity).try_normalize().unwrap_or(Vec3::Y);
            let middle = scene
                .domain
                .map_or(at, |domain| 0.5 * (domain.min + domain.max));
            let level = at + up * (middle - at).dot(up);
            point(scene, format!("{path}.at"), level).map_err(|problem| {
                let message = format!(
                    "the column about ({}, {}, {}) m is outside the domain, where no fluid gets",
                    at.x, at.y, at.z
                );
                Problem::new(problem.path, message)
            })
        }
        GaugeKind::Pressure { at, radius: of } | GaugeKind::Velocity { at, radius: of } => {
            radius(scene, path, of)?;
            point(scene, format!("{path}.at"), at)
        }
        GaugeKind::WallPressure {
            at,
            normal,
            radius: of,
            ref boundary,
        } => {
            radius(scene, path, of)?;
            if let Some(boundary) = boundary {
                is_named(scene, path, boundary)?;
            }
            point(scene, format!("{path}.at"), at)?;
            let what = "normal is zero; it must point from the wall into the fluid";
            direction(scene, format!("{path}.normal"), what, normal)
        }
        GaugeKind::Front {
            from,
            direction: along,
            within,
        } => {
            is_flat(format!("{path}.from"), from, scene.dimension)?;
            let what = "direction is zero; it must point along the way of the front";
            direction(scene, format!("{path}.direction"), what, along)?;
            match within {
                Some(bounds) => box_is_proper(
                    &format!("{path}.within"),
                    bounds.min,
                    bounds.max,
                    scene.dimension,
                ),
                None => Ok(()),
            }
        }
        GaugeKind::Force {
            ref boundary,
            about,
        } => {
            is_flat(format!("{path}.about"), about, scene.dimension)?;
            is_named(scene, path, boundary)
        }
        GaugeKind::Flux {
            corner,
            along,
            across,
        } => surface(scene, path, corner, [along, across]),
        GaugeKind::Energy => Ok(()),
    }
}

/// A boundary of the scene has this name.
fn is_named(scene: &Scene, path: &str, boundary: &str) -> Checked {
    let mut names: Vec<&str> = scene.boundaries.iter().filter_map(|b| b.name()).collect();
    names.dedup();
    ensure(
        names.contains(&boundary),
        format!("{path}.boundary"),
        || match names.as_slice() {
            [] => format!(
                "no boundary is called `{boundary}`, since none has a name; give it one, `Tank(name: \
                 {boundary:?}, …)`"
            ),
            names => unknown_name("boundary name", boundary, None, names),
        },
    )
}

/// A corner and two edges that span a surface; in 2-D an end and one edge.
fn surface(scene: &Scene, path: &str, corner: Vec3, [along, across]: [Vec3; 2]) -> Checked {
    is_flat(format!("{path}.corner"), corner, scene.dimension)?;
    let what = "edge is zero; it must lead to the next corner (in 2-D to the other end)";
    direction(scene, format!("{path}.along"), what, along)?;
    match scene.dimension {
        Dimension::Two => ensure(across == Vec3::ZERO, format!("{path}.across"), || {
            "a 2-D scene has no second edge; leave `across` out".to_owned()
        }),
        Dimension::Three => {
            let area = along.as_dvec3().cross(across.as_dvec3()).length();
            let lengths = along.as_dvec3().length() * across.as_dvec3().length();
            ensure(area > 1e-3 * lengths, format!("{path}.across"), || {
                format!(
                    "the edge ({}, {}, {}) m is zero or along the other one; the two must span a surface",
                    across.x, across.y, across.z
                )
            })
        }
    }?;
    // It may stick out.
    let corners = [Vec3::ZERO, along, across, along + across].map(|edge| corner + edge);
    let within = scene.domain.is_none_or(|domain| {
        let all = |beyond: &dyn Fn(Vec3) -> bool| corners.iter().all(|corner| beyond(*corner));
        !(0..axes(scene.dimension)).any(|axis| {
            all(&|x| x[axis] < domain.min[axis]) || all(&|x| x[axis] > domain.max[axis])
        })
    });
    ensure(within, format!("{path}.corner"), || {
        "the surface is outside the domain, where no fluid gets".to_owned()
    })
}

fn compared(gauge: &Gauge, reference: &GaugeReference, path: &str) -> Checked {
    let columns = gauge.columns();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    if let Some(quantity) = &reference.quantity {
        ensure(
            columns.contains(&quantity.as_str()),
            format!("{path}.quantity"),
            || unknown_name("column", quantity, None, &columns),
        )?;
    }
    for (axis, scale) in ["0", "1"].iter().zip(reference.scale.to_array()) {
        ensure(scale != 0.0, format!("{path}.scale.{axis}"), || {
            "the scale is 0; it must be what the file's figures are multiplied by (1 for SI units)"
                .to_owned()
        })?;
    }
    if let Some(reason) = no_file(Path::new(&reference.file)) {
        return Err(Problem::new(format!("{path}.file"), reason));
    }
    let loaded = reference.load();
    loaded.map(|_| ()).map_err(|error| {
        let field = error.field();
        Problem::new(format!("{path}.{field}"), error.to_string())
    })
}
