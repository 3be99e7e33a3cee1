//! Renormalisation of pressures beside walls, for equations of state.
//!
//! The fraction `1 − γ` of the density of a particle at a wall comes from the wall, `γ_i = 1 − Σ_b V_b W_ib`, and an
//! expansion of the fluid does not reduce it. Hence the term t of the force corresponds to the pressure `p = γ ρ² t`
//! (Ferrand et al. 2013, *Unified semi-analytical wall boundary conditions*, after Kulasegaram et al. 2004).
//!
//! The equation of state gives `ρ² t`, and [`weigh_pressures`] turns it into p. Without it, still water in 2-D has
//! 1.43 times its pressure beside a wall (1.08 with it). Methods that solve for the pressure do not need it: their
//! walls push as the fluid does ([`BesideWall`](crate::lattice::BesideWall)).

use bevy_ecs::prelude::*;

use crate::{
    boundary::sums::{BoundarySums, Walls},
    state::{Execution, Pressures},
};

/// Lower bound of γ: a particle in a right-angled corner of three walls has 0.3, a particle inside a wall has 0.
const LEAST: f32 = 0.1;

/// γ of a row \[-], at least [`LEAST`].
#[inline]
fn wall_renormalisation(walls: Walls, row: usize) -> f32 {
    (1.0 - walls.share(row)).max(LEAST)
}

/// Converts the method's `ρ² t` to pressures, `p = γ ρ² t` (phase `Pressure`).
pub fn weigh_pressures(
    mut pressures: ResMut<Pressures>,
    walls: Option<Res<BoundarySums>>,
    execution: Res<Execution>,
) {
    let walls = Walls::of(walls.as_deref());
    execution.for_each_chunk(&mut pressures.0, |first, pressures| {
        for (row, pressure) in (first..).zip(pressures) {
            *pressure *= wall_renormalisation(walls, row);
        }
    });
}
