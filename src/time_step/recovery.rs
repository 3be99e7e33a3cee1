//! Recovery: over how much time compression that a step finds at its start is pushed out.
//!
//! A solve that removes within its step what it finds moves particles with a speed of error/dt and leaves that speed in
//! the state. Here a step removes what it would add, and of what it finds the part dt/τ. τ is the time step that speeds
//! and forces allow, over the scene's `recovery`; it does not follow a time step that is shorter, and falls slowly: a
//! single fast particle that shortened both would raise the speed of all.
//!
//! Of a wave whose error the iterations leave by the part R, a step that starts from the share w of the last pressures
//! leaves no growing remainder for any R up to 1 if w and `recovery` are together at most 1 (eigenvalues of the
//! recurrence in pressure, divergence and density error; `docs/decisions/still_water.md`).

use bevy_ecs::prelude::*;

use super::limits::motion_limits;
use crate::{
    integrate::Motion,
    scene::Scene,
    state::{Clock, Material},
};

/// Decrease of τ over the time that passes [-].
const SLOWING: f32 = 0.1;

/// Compression that is left for later at most [-].
const MOST_LEFT: f32 = 0.2;

/// Part of τ that the next step keeps at least [-], so that a τ of fluid which nothing moved ends.
const LEAST_LEFT: f32 = 0.97;

/// Speed factor λ of the time step that motion allows [-], that of `Cfl` by default.
const SPEED_FACTOR: f32 = 0.2;

/// Longest τ [s], of fluid that nothing moves.
const LONGEST: f32 = 1e6;

/// Time over which compression that a step finds is pushed out. In scenes that do not push it out at once.
#[derive(Resource, Debug, Clone, Copy)]
pub struct RecoveryTime {
    /// Part of the compression found that a step as long as motion allows removes [-].
    share: f32,
    /// τ [s].
    time: f32,
}

impl RecoveryTime {
    /// Compression that is found stays.
    pub(crate) const NEVER: Self = Self {
        share: 0.0,
        time: LONGEST,
    };

    /// What a scene starts with whose steps remove at most this share of what they find; none if they remove all.
    pub(crate) fn new(share: f32, scene: &Scene) -> Option<Self> {
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
        Some(Self {
            share,
            time: speed.1.min(force.1).min(LONGEST) / share,
        })
    }

    /// Compression [-] that a step of `dt` [s] leaves for later of what it finds. More than [`MOST_LEFT`] is never
    /// left: what an impact drives together would fill a wall.
    #[inline]
    pub(crate) fn left_for_later(&self, dt: f32, found: f32) -> f32 {
        let found = found.max(0.0);
        let left = 1.0 - (dt / self.time).min(self.share);
        left * found / (1.0 + found / MOST_LEFT)
    }
}

/// Chooses τ for the next step (phase `Integrate`, when the step is good).
pub fn choose_recovery_time(
    mut recovery: ResMut<RecoveryTime>,
    motion: Res<Motion>,
    material: Res<Material>,
    clock: Res<Clock>,
) {
    let h = material.kernel.support_radius;
    let [speed, force] = motion_limits(SPEED_FACTOR, h, motion.max_speed, motion.max_acceleration);
    let allowed = speed.1.min(force.1).max(clock.dt);
    let wanted = allowed.min(LONGEST) / recovery.share;
    // A host may have set the fluid in motion before the first step.
    recovery.time = if clock.step <= 1 {
        wanted
    } else {
        let slower = (recovery.time - SLOWING * clock.dt).min(LEAST_LEFT * recovery.time);
        wanted.max(slower)
    };
}
