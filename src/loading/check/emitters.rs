//! Emitters, boxes that remove, and what is outside the domain.

use super::problem::{Checked, Problem, ensure};
use super::proper::{axes, box_is_proper, is_flat, radius_is_proper};
use crate::scene::shapes::{Inlet, rectangle_axes};
use crate::scene::{Dimension, Emitter, EmitterShape, Outside, PressureMethod, Scene, TimeStep};

/// Most particles of a layer: a larger number is a slip in the units.
const LARGEST_LAYER: f64 = 1e7;

/// Each field of the emitters, and boxes that remove.
pub(super) fn fields(scene: &Scene) -> Checked {
    let is_fed =
        !scene.emitters.is_empty() && matches!(scene.pressure, PressureMethod::DeltaSph(_));
    ensure(!is_fed, "emitters", || {
        "fluid cannot enter with δ-SPH, whose jets lose speed and fill a quarter too much; take `pressure: Dfsph()`"
            .to_owned()
    })?;
    for (index, emitter) in scene.emitters.iter().enumerate() {
        of_one(scene, emitter, &format!("emitters.{index}"))?;
    }
    for (index, bounds) in scene.outflow.iter().enumerate() {
        let path = format!("outflow.{index}");
        box_is_proper(&path, bounds.min, bounds.max, scene.dimension)?;
    }
    let has_domain = scene.outside == Outside::Stop || scene.domain.is_some();
    ensure(has_domain, "outside", || {
        "nothing is outside of a scene without a `domain`; write `domain: (min: …, max: …)`, or leave `outside` out"
            .to_owned()
    })
}

fn of_one(scene: &Scene, emitter: &Emitter, path: &str) -> Checked {
    let field = |name: &str| format!("{path}.{name}");
    face(scene, &emitter.shape, &field("shape"))?;
    let &Emitter {
        speed, start, end, ..
    } = emitter;
    ensure(speed > 0.0, field("speed"), || {
        format!("the speed is {speed} m/s; it must be above 0 (the normal says where to)")
    })?;
    ensure(start >= 0.0, field("start"), || {
        format!("the fluid enters from {start} s on; it must not be before 0")
    })?;
    ensure(end.is_none_or(|end| end > start), field("end"), || {
        format!(
            "the last of the fluid enters at {} s and the first at {start} s; `end` must be above `start`",
            end.unwrap_or_default()
        )
    })?;
    ensure(emitter.limit != Some(0), field("limit"), || {
        "at most 0 particles enter; the least is 1 (left out, there is no limit)".to_owned()
    })?;
    let amplitude = emitter.jitter.map_or(0.0, |jitter| jitter.amplitude);
    ensure(
        (0.0..0.5).contains(&amplitude),
        field("jitter.amplitude"),
        || {
            format!(
                "the amplitude of the jitter is {amplitude} spacings; it must be from 0 to below 0.5, where \
                 particles could meet"
            )
        },
    )?;
    let limit = 0.5 * scene.support_radius();
    if let TimeStep::Fixed(dt) = scene.time_step {
        ensure(speed * dt <= limit, "time_step", || {
            format!(
                "the fluid of `{path}` enters at {speed} m/s, {:.3e} m in a step of {dt:e} s; it may move half the \
                 support radius, {limit:.3e} m: `Fixed({:.0e})` would do, or `Cfl()`",
                speed * dt,
                0.8 * limit / speed
            )
        })?;
    }
    let inlet = Inlet::new(emitter, scene);
    ensure(!inlet.points.is_empty(), field("shape"), || {
        format!(
            "the face is too small for a particle: it must be at least half a spacing, {} m, wide; make it larger or \
             the spacing smaller",
            0.5 * scene.spacing
        )
    })?;
    ensure(inlet.particles(emitter, f64::MAX) > 0, field("end"), || {
        format!(
            "not one layer of {:.3e} m enters from {start} to {} s at {speed} m/s; `end` must be later",
            inlet.pitch,
            end.unwrap_or_default()
        )
    })
}

fn face(scene: &Scene, shape: &EmitterShape, path: &str) -> Checked {
    let field = |name: &str| format!("{path}.{name}");
    let dimension = scene.dimension;
    is_flat(field("center"), shape.center(), dimension)?;
    is_flat(field("normal"), shape.normal(), dimension)?;
    // The square of a length that is too small, or too large, is none.
    ensure(
        shape.normal().try_normalize().is_some(),
        field("normal"),
        || {
            "the normal is zero, or its square is; it must point where the fluid enters to"
                .to_owned()
        },
    )?;
    let spacing = f64::from(scene.spacing);
    let cells = match *shape {
        EmitterShape::Disc { radius, .. } => {
            radius_is_proper(path, radius)?;
            std::f64::consts::PI * (f64::from(radius) / spacing).powi(axes(dimension) as i32 - 1)
        }
        EmitterShape::Rectangle {
            width, height, up, ..
        } => {
            rectangle(dimension, (width, height), path)?;
            let normal = shape.normal().as_dvec3().normalize_or_zero();
            let flat = dimension == Dimension::Two;
            ensure(!flat || up.is_none(), field("up"), || {
                "in 2-D the face is a segment across the normal; leave `up` out".to_owned()
            })?;
            ensure(
                flat || rectangle_axes(normal, up).is_some(),
                field("up"),
                || {
                    "it is zero or along the normal; it must point across it, along the height"
                        .to_owned()
                },
            )?;
            let size = f64::from(width) * height.map_or(spacing, f64::from);
            size / (spacing * spacing)
        }
    };
    ensure(cells <= LARGEST_LAYER, path, || {
        format!(
            "a layer holds {cells:.1e} particles; at most {LARGEST_LAYER:.0e} are possible: make the face smaller or \
             the spacing larger"
        )
    })
}

/// A rectangle has a width, and in 3-D a height.
fn rectangle(dimension: Dimension, (width, height): (f32, Option<f32>), path: &str) -> Checked {
    ensure(width > 0.0, format!("{path}.width"), || {
        format!("the width is {width} m; it must be above 0")
    })?;
    match (dimension, height) {
        (Dimension::Two, None) => Ok(()),
        (Dimension::Two, Some(_)) => Err(Problem::new(
            format!("{path}.height"),
            "in 2-D the face is a segment, of which `width` is the length; leave `height` out",
        )),
        (Dimension::Three, None) => Err(Problem::new(
            path,
            "a rectangle in 3-D has a height, too: write `height: …` (m), and `up: (x, y, z)` for its direction",
        )),
        (Dimension::Three, Some(height)) => ensure(height > 0.0, format!("{path}.height"), || {
            format!("the height is {height} m; it must be above 0")
        }),
    }
}

/// Particles that emitters add until the end of a scene, at most. A domain that removes holds no more than fills it.
pub(super) fn expected(scene: &Scene, fluid: f64) -> f64 {
    let end = f64::from(scene.duration);
    let of = |emitter: &Emitter| Inlet::new(emitter, scene).particles(emitter, end) as f64;
    let all: f64 = scene.emitters.iter().map(of).sum();
    let leaves = scene.outside == Outside::Remove || !scene.outflow.is_empty();
    let Some(domain) = scene.domain.filter(|_| leaves) else {
        return all;
    };
    let counts = (domain.max - domain.min).as_dvec3() / f64::from(scene.spacing);
    let room = counts.to_array()[..axes(scene.dimension)]
        .iter()
        .product::<f64>();
    all.min((room - fluid).max(0.0))
}
