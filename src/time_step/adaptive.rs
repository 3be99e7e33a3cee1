//! The adaptive time step of Ihmsen, Akinci, Gissler & Teschner 2010 (*Boundary Handling and Adaptive Time-stepping
//! for PCISPH*): it changes by 0.2 % per step, and the run is rolled back after a shock.
//!
//! - It grows if 0.19 sqrt(h/a_max) > dt, 0.39 h/v_max > dt, e_max < 4.5 η and e_mean < 0.9 η.
//! - It shrinks if 0.2 sqrt(h/a_max) < dt, 0.4 h/v_max ≤ dt, e_max > 5.5 η or e_mean > η.
//! - It rolls back two steps ([`roll_back`](super::roll_back)) if e_max rose by 8 η or exceeds the scene's limit, or
//!   if 0.45 h/v_max < dt, and continues with min(0.2 sqrt(h/a_max), 0.08 h/v_max). e: density errors at the end of a
//!   step.
//!
//! Deviations. η is the scene's `density_error` and not the limit of the pressure method. With an equation of state
//! the error has no influence on dt. A failed step is treated as a shock. The new dt is at most half of the old; at
//! the least dt, or after [`MOST_IN_A_ROW`] roll-backs without progress, the step fails.

use bevy_ecs::prelude::*;

use super::{
    cfl::ITERATIONS,
    limits::{StepLimits, pressure_limit},
};
use crate::{
    integrate::Motion,
    scene::{self, Scene},
    state::{
        Clock, DensityError, Failure, FailureCause, Limit, Material, Remembers, Shock, SolverState,
        TakenBack,
    },
};

const GROWTH: f32 = 1.002;
const SHRINKAGE: f32 = 0.998;

/// Maximum number of consecutive roll-backs before a step fails.
pub const MOST_IN_A_ROW: u32 = 12;

/// The scheme and its state.
#[derive(Resource, Debug, Clone, PartialEq)]
pub struct AdaptiveTimeStep {
    scheme: scene::Adaptive,
    /// Limit by viscosity and sound \[s].
    constant_limit: f32,
    /// Number of spacings that `sqrt(p/ρ)` covers in the longest step that pressure allows \[-].
    pressure_step: f32,
    /// Whether the density error depends on the time step.
    error_counts: bool,
    /// Largest density error of the last step \[-]; infinite before the first.
    pub(super) largest_error: f32,
    /// Number of roll-backs since the run last passed `place`.
    in_a_row: u32,
    /// Simulated time at the end of the step that failed last \[s].
    place: f64,
    /// What the last run of the schedule rolled back.
    pub(crate) taken_back: Option<TakenBack>,
}

/// The first time step \[s] of a scene and the scheme.
pub(super) fn start(
    scheme: scene::Adaptive,
    scene: &Scene,
    limits: &StepLimits,
) -> (f32, AdaptiveTimeStep) {
    let adaptive = AdaptiveTimeStep {
        scheme,
        constant_limit: limits.constant,
        pressure_step: limits.pressure_step,
        error_counts: limits.momentum.is_some(),
        largest_error: f32::INFINITY,
        in_a_row: 0,
        place: 0.0,
        taken_back: None,
    };
    let gentle = gentle(
        scene.support_radius(),
        scene.max_initial_speed(),
        scene.greatest_acceleration(),
    );
    let dt = adaptive.bounded(scheme.initial.unwrap_or(gentle));
    (dt, adaptive)
}

/// The time step after a shock \[s], and the first one.
fn gentle(h: f32, max_speed: f32, max_acceleration: f32) -> f32 {
    (0.2 * (h / max_acceleration).sqrt()).min(0.08 * h / max_speed)
}

/// Limits by motion above which the time step shrinks.
pub fn motion_limits(h: f32, max_speed: f32, max_acceleration: f32) -> [Limit; 2] {
    [
        ("speed", 0.4 * h / max_speed),
        ("force", 0.2 * (h / max_acceleration).sqrt()),
    ]
}

impl Remembers for AdaptiveTimeStep {
    type State = (f32, u32, f64);

    fn state(&self, _: &[Entity]) -> Self::State {
        (self.largest_error, self.in_a_row, self.place)
    }

    fn set_state(&mut self, state: Self::State, _: &[Entity]) -> Result<(), &'static str> {
        (self.largest_error, self.in_a_row, self.place) = state;
        self.taken_back = None;
        Ok(())
    }
}

impl AdaptiveTimeStep {
    fn bounded(&self, dt: f32) -> f32 {
        let scene::Adaptive { min, max, .. } = self.scheme;
        dt.min(self.constant_limit).clamp(min, max)
    }

    /// Longest step \[s] under a pressure \[Pa], not below the scene's shortest.
    pub(super) fn longest_under(&self, material: &Material, pressure: f32) -> f32 {
        pressure_limit(self.pressure_step, material, pressure).max(self.scheme.min)
    }

    /// Takes the parameters of a scheme in the middle of a run, whose next step would be `next_dt` \[s], and returns
    /// that step within the new limits \[s].
    pub(crate) fn set_scheme(
        &mut self,
        scheme: scene::Adaptive,
        limits: &StepLimits,
        next_dt: f32,
    ) -> f32 {
        self.scheme = scheme;
        self.constant_limit = limits.constant;
        self.pressure_step = limits.pressure_step;
        self.bounded(next_dt)
    }

    /// Whether a failed step of this length \[s] may be repeated with a shorter one.
    pub fn may_go_back(&self, dt: f32) -> bool {
        dt > self.scheme.min && self.in_a_row < MOST_IN_A_ROW
    }

    /// The time step \[s] after a successful one of `dt`.
    fn next(&self, dt: f32, limits: [Limit; 2], error: DensityError, iterations: u32) -> f32 {
        let eta = self.scheme.density_error;
        let [(_, speed), (_, force)] = limits;
        let errors_are_large = self.error_counts && (error.largest > 5.5 * eta || error.mean > eta);
        let errors_are_small =
            !self.error_counts || error.largest < 4.5 * eta && error.mean < 0.9 * eta;
        let shrinks = force < dt || speed <= dt || errors_are_large || iterations > ITERATIONS;
        let change = if shrinks {
            SHRINKAGE
        } else if 0.19 / 0.2 * force > dt && 0.39 / 0.4 * speed > dt && errors_are_small {
            GROWTH
        } else {
            1.0
        };
        self.bounded(change * dt)
    }

    /// Records a roll-back of the step after `clock`, and returns the next time step \[s].
    pub(super) fn go_back(
        &mut self,
        clock: &Clock,
        h: f32,
        max_speed: f32,
        max_acceleration: f32,
    ) -> f32 {
        self.in_a_row += 1;
        self.place = self.place.max(clock.time + f64::from(clock.dt));
        // The motion of a step that is not finite says nothing, and a time step of zero is useless.
        let gentle = gentle(h, max_speed, max_acceleration);
        let half = 0.5 * clock.dt;
        self.bounded(if gentle > 0.0 { half.min(gentle) } else { half })
    }
}

/// Rejects a step with a shock (phase `Integrate`).
pub fn detect_shock(
    mut failure: ResMut<Failure>,
    adaptive: Res<AdaptiveTimeStep>,
    motion: Res<Motion>,
    solve: Res<SolverState>,
    material: Res<Material>,
    clock: Res<Clock>,
) {
    let (error, before) = (solve.error.largest, adaptive.largest_error);
    let mut shock = |shock, row| failure.record(FailureCause::Shock(shock), Some(row));
    let limit = 0.45 * material.kernel.support_radius;
    let displacement = clock.dt * motion.max_speed;
    if displacement > limit {
        let cause = Shock::TooFast {
            displacement,
            limit,
        };
        return shock(cause, motion.fastest_row());
    }
    let limit = adaptive.scheme.max_density_error;
    if error > limit {
        return shock(Shock::ErrorTooLarge { error, limit }, solve.error.row);
    }
    let limit = 8.0 * adaptive.scheme.density_error;
    if error - before > limit {
        let cause = Shock::ErrorJumped {
            before,
            error,
            limit,
        };
        shock(cause, solve.error.row);
    }
}

/// Chooses the length of the next step (phase `Integrate`, if the step succeeded).
pub fn choose_adaptive_time_step(
    mut clock: ResMut<Clock>,
    mut adaptive: ResMut<AdaptiveTimeStep>,
    motion: Res<Motion>,
    solve: Res<SolverState>,
    material: Res<Material>,
) {
    adaptive.largest_error = solve.error.largest;
    if clock.time >= adaptive.place {
        adaptive.in_a_row = 0;
    }
    let h = material.kernel.support_radius;
    let limits = motion_limits(h, motion.max_speed, motion.max_acceleration);
    let next = adaptive.next(clock.full_dt(), limits, solve.error, solve.iterations);
    clock.next_dt = next.min(adaptive.longest_under(&material, motion.max_pressure));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::TimeStep;

    fn scheme(momentum: Option<bool>) -> AdaptiveTimeStep {
        let text = "(name: \"t\", spacing: 0.1, time_step: Adaptive((density_error: 0.01)),
              bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)), velocity: (0, -8, 0))])";
        let scene = ron::from_str::<Scene>(text).expect("a scene");
        let limits = StepLimits {
            constant: f32::INFINITY,
            pressure_step: f32::INFINITY,
            momentum,
        };
        let TimeStep::Adaptive(adaptive) = scene.time_step else {
            panic!("an adaptive scene");
        };
        let (dt, adaptive) = start(adaptive, &scene, &limits);
        // 0.08 h/v, less than 0.2 sqrt(h/g) = 0.0286 s.
        assert!((dt - 0.002).abs() < 1e-9, "{dt}");
        adaptive
    }

    /// The change of a time step of 1 ms with h = 0.1 m.
    fn change(
        adaptive: &AdaptiveTimeStep,
        speed: f32,
        acceleration: f32,
        largest: f32,
        mean: f32,
    ) -> f32 {
        let error = DensityError {
            largest,
            mean,
            row: 0,
        };
        1e3 * adaptive.next(1e-3, motion_limits(0.1, speed, acceleration), error, 10) - 1.0
    }

    #[test]
    fn changes_by_the_published_conditions() {
        let pcisph = scheme(Some(false));
        let (up, down, same) = (0.002, -0.002, 0.0);
        // The limits of speed are 39 and 40 m/s, those of the acceleration 3610 and 4000 m/s².
        for (speed, acceleration, largest, mean, expected) in [
            (38.0, 3500.0, 0.044, 0.0089, up),
            (39.5, 3500.0, 0.044, 0.0089, same),
            (40.1, 3500.0, 0.044, 0.0089, down),
            (38.0, 3700.0, 0.044, 0.0089, same),
            (38.0, 4100.0, 0.044, 0.0089, down),
            (38.0, 3500.0, 0.050, 0.0089, same),
            (38.0, 3500.0, 0.056, 0.0089, down),
            (38.0, 3500.0, 0.044, 0.0095, same),
            (38.0, 3500.0, 0.044, 0.0101, down),
        ] {
            let found = change(&pcisph, speed, acceleration, largest, mean);
            assert!(
                (found - expected).abs() < 1e-5,
                "{found} for {speed} m/s, {acceleration} m/s², errors {largest} and {mean}"
            );
        }
        let error = DensityError::default();
        let change_by_iterations =
            1e3 * pcisph.next(1e-3, motion_limits(0.1, 1.0, 1.0), error, 11) - 1.0;
        assert!((change_by_iterations - down).abs() < 1e-5);
        let sesph = scheme(None);
        assert!((change(&sesph, 38.0, 3500.0, 0.056, 0.0101) - up).abs() < 1e-5);
    }

    #[test]
    fn goes_back_to_the_published_time_step_or_half() {
        let mut adaptive = scheme(Some(false));
        let mut back = |dt, max_speed, max_acceleration| {
            let clock = Clock {
                dt,
                ..Clock::default()
            };
            adaptive.go_back(&clock, 0.1, max_speed, max_acceleration)
        };
        assert!((back(4e-3, 8.0, 10.0) - 1e-3).abs() < 1e-9);
        assert!((back(4e-3, 1.0, 1e5) - 2e-4).abs() < 1e-9);
        assert!((back(4e-3, 1.0, 10.0) - 2e-3).abs() < 1e-9);
        for nonsense in [f32::NAN, f32::INFINITY] {
            assert!((back(4e-3, nonsense, nonsense) - 2e-3).abs() < 1e-9);
        }
        // The least time step is a millionth of a second.
        assert_eq!(back(1.5e-6, 1.0, 10.0), 1e-6);
        assert!(!adaptive.may_go_back(1e-6) && adaptive.may_go_back(2e-6));
    }
}
