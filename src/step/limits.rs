//! Limits of a scene's time step that are known before it runs, and a warning if the scene exceeds them.

use glam::Vec3;

use super::order::{limits_of, order_of};
use crate::{
    registry::Stages,
    scene::{Adaptive, Cfl, Scene, TimeStep},
    state::{Limit, Material},
    time_step::{self, adaptive},
};

/// Largest distance that a particle may move in a step \[support radii].
const FARTHEST: f32 = 0.5;

/// Speed of water that falls through the whole height of a box \[m/s].
pub(super) fn fall(scene: &Scene, low: Vec3, high: Vec3) -> f32 {
    let along = scene.gravity.normalize_or_zero();
    let height = along.abs().dot((high - low).max(Vec3::ZERO));
    let start = scene.max_initial_speed();
    (2.0 * scene.gravity.length() * height + start * start).sqrt()
}

/// Limits by name \[s], for the largest speed of this scene: free fall through its whole height.
pub(super) fn of(scene: &Scene, low: Vec3, high: Vec3) -> Vec<(String, f32)> {
    let gravity = scene.greatest_acceleration();
    let fall = fall(scene, low, high);
    let h = scene.support_radius();
    let motion = match scene.time_step {
        TimeStep::Cfl(cfl) => time_step::motion_limits(cfl.factor, h, fall, gravity),
        TimeStep::Fixed(_) => time_step::motion_limits(FARTHEST, h, fall, gravity),
        TimeStep::Adaptive(_) => adaptive::motion_limits(h, fall, gravity),
    };
    by_name(scene, motion, fall)
}

/// What drives the fluid as a whole.
fn forces(scene: &Scene) -> &'static str {
    if scene.body_forces.is_empty() {
        "gravity"
    } else {
        "gravity and body forces"
    }
}

fn by_name(scene: &Scene, [speed, force]: [Limit; 2], fall: f32) -> Vec<(String, f32)> {
    let mut limits = vec![
        (
            format!(
                "{} at {fall:.2} m/s, the fall through the fluid's height",
                speed.0
            ),
            speed.1,
        ),
        (format!("{} of {}", force.0, forces(scene)), force.1),
    ];
    // Pressure at the bottom of water at rest as deep as the fluid is high: p/ρ is half the square of that speed.
    let deep = scene.fluid.rest_density * 0.5 * fall * fall;
    let stages = Stages::default();
    let step = stages.step_limits(scene).pressure_step;
    let pressure = time_step::pressure_limit(step, &Material::new(scene), deep);
    limits.push(("pressure at the fluid's depth".to_owned(), pressure));
    let constant = stages.constant_limits(scene);
    limits.extend(constant.into_iter().map(|(name, dt)| (name.to_owned(), dt)));
    if scene.order.is_some()
        && let Ok(order) = order_of(scene, &stages)
    {
        let of_kernels = limits_of(&order.with_kernels(), scene).into_iter();
        limits.extend(
            of_kernels.map(|(name, dt)| (format!("{name} with the kernel of the order"), dt)),
        );
    }
    limits.retain(|limit| limit.1.is_finite());
    limits
}

/// A warning if a fixed time step, or the smallest one allowed, exceeds limits. It names each of them and a time step
/// that satisfies all.
pub(super) fn too_long(scene: &Scene, low: Vec3, high: Vec3) -> Option<String> {
    let (what, dt) = match scene.time_step {
        TimeStep::Fixed(dt) => ("the time step", dt),
        TimeStep::Cfl(Cfl { min, .. }) | TimeStep::Adaptive(Adaptive { min, .. }) => {
            ("the least time step", min)
        }
    };
    let fall = fall(scene, low, high);
    let motion = time_step::motion_limits(
        FARTHEST,
        scene.support_radius(),
        fall,
        scene.greatest_acceleration(),
    );
    let mut broken = by_name(scene, motion, fall);
    broken.retain(|limit| dt > limit.1);
    broken.sort_by(|a, b| a.1.total_cmp(&b.1));
    let least = broken.first()?.1;
    let limits: Vec<String> = broken
        .iter()
        .map(|(name, limit)| format!("{limit:.2e} s by {name}"))
        .collect();
    let remedy = match scene.time_step {
        TimeStep::Fixed(_) => format!("`time_step: Fixed({:.0e})`, or `Cfl()`", 0.5 * least),
        TimeStep::Cfl(_) | TimeStep::Adaptive(_) => format!("`min: {:.0e}` in it", 0.1 * least),
    };
    Some(format!(
        "{what} is {dt:e} s, longer than is stable: at most {}; write {remedy}",
        limits.join(", ")
    ))
}

/// Time step at the largest speed of free fall \[s].
pub(super) fn expected_step(scene: &Scene, limits: &[(String, f32)]) -> f32 {
    let least = limits
        .iter()
        .map(|limit| limit.1)
        .fold(f32::INFINITY, f32::min);
    match scene.time_step {
        TimeStep::Fixed(dt) => dt,
        TimeStep::Cfl(cfl) => least.clamp(cfl.min, cfl.max),
        TimeStep::Adaptive(scheme) => least.clamp(scheme.min, scheme.max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every limit that is exceeded is named, even if another is exceeded by more. The time step that the warning
    /// suggests satisfies all limits.
    #[test]
    fn every_limit_that_is_broken_is_named_with_what_would_do() {
        let (low, high) = (Vec3::ZERO, Vec3::new(0.4, 2.0, 0.4));
        let scene = |time_step: &str, pressure: &str, viscosity: f32| -> Scene {
            let text = format!(
                "(name: \"t\", spacing: 0.1, time_step: {time_step}, pressure: {pressure},
                fluid: (viscosity: Laminar(kinematic_viscosity: {viscosity})),
                bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 2, 0.4)), velocity: (0, 1, 0))])"
            );
            ron::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
        };
        let (mut told, mut quiet) = (0, 0);
        for pressure in [
            "Dfsph(())",
            "Sesph((equation: Gas(stiffness: 1e4)))",
            "Pcisph(())",
        ] {
            for viscosity in [0.0, 1e-3, 1.0, 1e3] {
                let limits = of(&scene("Fixed(1)", pressure, viscosity), low, high);
                for part in [0.5, 1.01, 3.0, 1e3] {
                    for (_, limit) in &limits {
                        let dt = part * limit;
                        for scheme in [format!("Fixed({dt:e})"), format!("Cfl((min: {dt:e}))")] {
                            let scene = scene(&scheme, pressure, viscosity);
                            let warning = too_long(&scene, low, high).unwrap_or_default();
                            for (name, limit) in &limits {
                                assert_eq!(
                                    dt > *limit,
                                    warning.contains(name),
                                    "{scheme}: {warning}"
                                );
                            }
                            let Some((_, remedy)) = warning.split_once("write `") else {
                                quiet += 1;
                                continue;
                            };
                            told += 1;
                            let number = remedy.split('`').next().unwrap_or_default();
                            let number = number.trim_start_matches("time_step: Fixed(");
                            let number = number.trim_start_matches("min: ").trim_end_matches(')');
                            let better: f32 = number.parse().expect("a number");
                            assert!(limits.iter().all(|limit| better <= limit.1), "{warning}");
                        }
                    }
                }
            }
        }
        assert!(told > 50 && quiet > 5, "{told} warnings, {quiet} without");
    }
}
