//! Periodic axes: long enough, and everything that reaches across a seam fits to its own image.

use glam::{DVec3, Vec3};

use super::problem::{Checked, ensure};
use super::proper::{AXIS_NAMES, axes};
use crate::scene::shapes::wall_axes;
use crate::scene::{BodyForce, BoundaryShape, Dimension, GaugeKind, Scene, WallMotion};

/// Least length of a period \[support radii; search radii where lists are kept]. A pair within one may be two apart at
/// predicted positions; another image of the neighbour must still be further than one away.
const LEAST: f32 = 3.0;

/// What rows of a lattice may miss at a seam \[spacings].
const TOLERANCE: f64 = 1e-3;

pub(super) fn axes_and_walls(scene: &Scene) -> Checked {
    for (axis, faces) in scene.periodic.axes().into_iter().enumerate() {
        let Some([low, high]) = faces else { continue };
        let name = AXIS_NAMES[axis];
        let path = format!("periodic.{name}");
        ensure(axis < axes(scene.dimension), &path, || {
            "a 2-D scene is the plane z = 0; only x and y can be periodic".to_owned()
        })?;
        ensure(low < high, &path, || {
            format!(
                "the period starts at {low} m and ends at {high} m; the second must be above the first"
            )
        })?;
        let (length, support) = (high - low, scene.search_radius());
        let radii = match scene.skin() {
            Some(_) => "search radii",
            None => "support radii",
        };
        ensure(length >= LEAST * support, &path, || {
            format!(
                "the period is {length:.4} m long, {:.2} {radii} of {support:.4} m; it must be at least \
                 {LEAST:.0}, {:.4} m, so that no particle meets two images of another",
                length / support,
                LEAST * support
            )
        })?;
        domain(scene, axis, &path, [low, high])?;
        forces_and_gauges(scene, axis)?;
    }
    if scene.period().is_any() {
        for (index, wall) in scene.boundaries.iter().enumerate() {
            of_wall(scene, wall, &format!("boundaries.{index}"))?;
        }
    }
    Ok(())
}

fn domain(scene: &Scene, axis: usize, path: &str, [low, high]: [f32; 2]) -> Checked {
    let Some(domain) = scene.domain else {
        return Ok(());
    };
    let rounding = 1e-3 * scene.spacing;
    let holds = domain.min[axis] <= low + rounding && domain.max[axis] >= high - rounding;
    ensure(holds, path, || {
        format!(
            "the period reaches from {low} to {high} m and `domain` from {} to {} m; particles go round the whole \
             period, so widen `domain` along it",
            domain.min[axis], domain.max[axis]
        )
    })
}

fn forces_and_gauges(scene: &Scene, axis: usize) -> Checked {
    let name = AXIS_NAMES[axis];
    for (index, force) in scene.body_forces.iter().enumerate() {
        let is_central = matches!(force, BodyForce::Central(_));
        ensure(!is_central, format!("body_forces.{index}"), || {
            format!(
                "a central force does not repeat along {name}, which is periodic; use gravity or a `Table`"
            )
        })?;
    }
    for (index, gauge) in scene.gauges.iter().enumerate() {
        let along = match gauge.kind {
            GaugeKind::Front { direction, .. } => direction[axis],
            _ => 0.0,
        };
        ensure(
            along == 0.0,
            format!("gauges.{index}.kind.direction"),
            || {
                format!(
                    "{name} is periodic, and fluid has no front along it; measure along another axis"
                )
            },
        )?;
    }
    Ok(())
}

/// What goes round an axis is straight along it, and does not turn.
fn of_wall(scene: &Scene, wall: &BoundaryShape, path: &str) -> Checked {
    let period = scene.period();
    let (low, high) = match *wall {
        BoundaryShape::Tank { min, max, .. } | BoundaryShape::Box { min, max, .. } => (min, max),
        BoundaryShape::Sphere { center, radius, .. } => {
            let (low, high) = (center - radius, center + radius);
            let round = period.goes_round(low, high);
            let fits = !(0..axes(scene.dimension)).any(|axis| round.test(axis));
            return ensure(fits, format!("{path}.radius"), || {
                format!(
                    "the sphere of radius {radius} m meets its own image; it must be smaller than the period"
                )
            });
        }
        BoundaryShape::Plane {
            center,
            normal,
            half_size,
            ..
        } => return of_plane(scene, (center, normal, half_size), path),
        BoundaryShape::Mesh(_) => return Ok(()),
    };
    let round = period.goes_round(low, high);
    let round = (0..axes(scene.dimension)).any(|axis| round.test(axis));
    let turns = matches!(wall.motion(), Some(WallMotion::Rotation { .. }));
    ensure(!(round && turns), format!("{path}.motion"), || {
        "the wall goes round a periodic axis and cannot turn; move it along, or make it shorter than the period"
            .to_owned()
    })
}

fn of_plane(scene: &Scene, (center, normal, half_size): (Vec3, Vec3, f32), path: &str) -> Checked {
    let period = scene.period();
    let (along, across) = wall_axes(normal, scene.dimension);
    let directions = match scene.dimension {
        Dimension::Two => vec![along],
        Dimension::Three => vec![along, across],
    };
    for direction in directions {
        let reach = half_size * direction.abs();
        let round = period.goes_round(center - reach, center + reach);
        let round = (0..3).any(|axis| round.test(axis));
        let straight = direction.abs().max_element() > 1.0 - 1e-6;
        ensure(!round || straight, format!("{path}.normal"), || {
            "the plane goes round a periodic axis and must lie along it; turn its normal, or make it smaller".to_owned()
        })?;
    }
    Ok(())
}

/// A body of fluid, by the box around its particles \[m], that reaches across a seam fills the period with rows.
pub(super) fn meets_itself(scene: &Scene, path: &str, (min, max): (DVec3, DVec3)) -> Checked {
    let spacing = f64::from(scene.spacing);
    for (axis, name) in AXIS_NAMES.iter().enumerate().take(axes(scene.dimension)) {
        let Some([low, high]) = scene.period().faces(axis) else {
            continue;
        };
        let length = f64::from(high) - f64::from(low);
        let gap = (length - (max[axis] - min[axis])) / spacing;
        let fits = (gap - 1.0).abs() <= TOLERANCE || gap >= 2.0 - TOLERANCE;
        ensure(fits, path, || {
            let rows = (length / spacing).round().max(1.0);
            format!(
                "the body meets its own image along {name}: its last row is {gap:.3} spacings before the image of its \
                 first, and must be 1 (or 2 and more) before it; the period of {length:.6} m holds {rows} rows of a \
                 spacing of {:.6} m, and a body as long as the period has them",
                length / rows
            )
        })?;
    }
    Ok(())
}

/// The scene with walls that go round as long as its bodies can see; none without periodic axes.
pub(super) fn unrolled(scene: &Scene) -> Option<Scene> {
    let period = scene.period();
    period.is_any().then(|| Scene {
        boundaries: scene
            .boundaries
            .iter()
            .map(|wall| period.unrolled(wall))
            .collect(),
        ..scene.clone()
    })
}
