//! Recovery: the time over which compression found at the start of a step is removed.
//!
//! A solve that removes all compression within its step moves particles with a velocity of error/dt, and that velocity
//! remains. Here a step removes the compression that it would add, and the part dt/τ of what it finds. τ is the time
//! step that speeds and forces allow, divided by the scene's `recovery`. It does not follow a shorter time step and
//! falls slowly: otherwise a single fast particle would raise the speed of all.
//!
//! No wave grows if the warm start share and `recovery` together are at most 1 (eigenvalues of the recurrence in
//! pressure, divergence and density error; `docs/decisions/still_water.md`).

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use super::limits::motion_limits;
use crate::{
    integrate::Motion,
    scene::Scene,
    state::{Clock, Material, Remembers},
};

/// Decrease of τ per time that passes \[-].
const SLOWING: f32 = 0.1;

/// Maximum compression that is left for later steps \[-].
const MOST_LEFT: f32 = 0.2;

/// Maximum density that is missing and left missing by a step \[-]: what rows beside walls and rounding lack. Rows at a
/// free surface lack more, which the fluid may fill at once. `docs/decisions/still_water.md` has the measurements.
pub(crate) const MOST_MISSING: f32 = 0.01;

/// Minimum factor on τ per step, and on the longest step that motion allows \[-], so that a large τ of fluid at rest
/// ends.
const LEAST_LEFT: f32 = 0.97;

/// Speed factor λ of the time step that motion allows \[-], that of `Cfl` by default.
const SPEED_FACTOR: f32 = 0.2;

/// Longest τ \[s], for fluid at rest.
const LONGEST: f32 = 1e6;

/// The time over which compression is removed. Present in scenes that do not remove it at once.
#[derive(Resource, Debug, Clone, Copy, Serialize, Deserialize)]
pub struct RecoveryTime {
    /// Part of the compression found that a step of the length that motion allows removes \[-].
    share: f32,
    /// Maximum compression that is left, and maximum density that is missing and left missing \[-].
    most_left: f32,
    most_missing: f32,
    /// Longest step \[s] that the scene takes, and that its forces allow on fluid at rest.
    rest_step: f32,
    /// τ \[s].
    time: f32,
    /// Longest step \[s] that the motion allows, at most `rest_step`.
    motion_step: f32,
    /// Minimum factor on it per step \[-]: accelerations of an impact would else make every step as long as the motion
    /// allows. PCISPH predicts what an impact compresses; its columns gain 1 % of their energy with it, and it has
    /// none.
    least_left: f32,
}

impl Remembers for RecoveryTime {
    type State = [f32; 2];

    fn state(&self, _: &[Entity]) -> [f32; 2] {
        [self.time, self.motion_step]
    }

    fn set_state(&mut self, state: [f32; 2], _: &[Entity]) -> Result<(), &'static str> {
        [self.time, self.motion_step] = state;
        Ok(())
    }
}

impl RecoveryTime {
    /// Leaves the density as it is found, if the fluid `keeps_gaps`. Else it leaves compression as any step does, and
    /// the fluid may fill gaps at once.
    pub(crate) fn never(keeps_gaps: bool) -> Self {
        Self {
            share: 0.0,
            most_left: if keeps_gaps { f32::INFINITY } else { MOST_LEFT },
            most_missing: if keeps_gaps { f32::INFINITY } else { 0.0 },
            rest_step: 0.0,
            time: LONGEST,
            motion_step: 0.0,
            least_left: 0.0,
        }
    }

    /// Initial value for a scene whose steps remove at most `share` of the compression found; none if they remove all.
    pub(crate) fn new(share: f32, fills_slowly: bool, scene: &Scene) -> Option<Self> {
        if share >= 1.0 {
            return None;
        }
        let h = scene.support_radius();
        let [speed, force] = motion_limits(
            SPEED_FACTOR,
            h,
            scene.max_initial_speed(),
            scene.greatest_acceleration(),
        );
        let rest_step = force.1.min(scene.time_step.longest());
        Some(Self {
            share,
            most_left: MOST_LEFT,
            most_missing: if fills_slowly { MOST_MISSING } else { 0.0 },
            rest_step,
            time: speed.1.min(force.1).min(LONGEST) / share,
            motion_step: speed.1.min(rest_step),
            least_left: if fills_slowly { LEAST_LEFT } else { 0.0 },
        })
    }

    /// Length of a step \[s] relative to the longest that the motion allows, at most 1 \[-].
    #[inline]
    fn length(&self, dt: f32) -> f32 {
        (dt / self.motion_step).min(1.0)
    }

    /// Part of the compression found \[-] that a step of `dt` \[s] removes. At most [`MOST_LEFT`] is left for later:
    /// the compression of an impact could fill a wall.
    ///
    /// A step that is shorter than the motion allows leaves more. If a step of any length removed this part, the
    /// pressure would grow with 1/dt², and a step that this pressure allows would be shorter without end. With the root
    /// of the length, it has a lower bound, and water of 160 rows is compressed by 0.5 instead of 0.65 %.
    ///
    /// Density that is missing may be filled within a step of the length that motion allows, and within a shorter one
    /// in proportion; what exceeds [`MOST_MISSING`] at once. If any step could fill all, water at rest in short steps
    /// would carry no pressure until it has fallen by what rounding lacks.
    #[inline]
    pub(crate) fn removed(&self, dt: f32, found: f32) -> f32 {
        let part = (dt / self.time).min(self.share);
        if found > 0.0 {
            let excess = self.length(dt).sqrt() * found / self.most_left;
            found - (1.0 - part) * found / (1.0 + excess)
        } else {
            let filled = if self.share > 0.0 {
                part / self.share
            } else {
                0.0
            };
            found - (1.0 - filled) * found.max(-self.most_missing)
        }
    }
}

/// Chooses τ for the next step (phase `Integrate`, if the step succeeded).
pub fn choose_recovery_time(
    mut recovery: ResMut<RecoveryTime>,
    motion: Res<Motion>,
    material: Res<Material>,
    clock: Res<Clock>,
) {
    let h = material.kernel.support_radius;
    let [speed, force] = motion_limits(SPEED_FACTOR, h, motion.max_speed, motion.max_acceleration);
    let allowed = speed.1.min(force.1).max(clock.dt);
    let is_first = clock.step <= 1;
    let slower = if is_first {
        0.0
    } else {
        recovery.least_left * recovery.motion_step
    };
    recovery.motion_step = allowed.min(recovery.rest_step).max(slower);
    let wanted = allowed.min(LONGEST) / recovery.share;
    // A host may have set the fluid in motion before the first step.
    recovery.time = if is_first {
        wanted
    } else {
        let slower = (recovery.time - SLOWING * clock.dt).min(LEAST_LEFT * recovery.time);
        wanted.max(slower)
    };
}
