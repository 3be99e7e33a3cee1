//! Pressures beside walls with an equation of state, from what the pressure force does.
//!
//! A particle at a wall has a part `1 − γ` of its density from the wall, `γ_i = 1 − Σ_b V_b W_ib`, and a stretch of the
//! fluid does not thin that part out. So of the term t that acts in the force only γ works as pressure does in a fluid,
//! `t = p/(γ ρ²)`: that is Ferrand et al. 2013 (*Unified semi-analytical wall boundary conditions*, after Kulasegaram
//! et al. 2004), whose density `Σ_j m W_ij / γ_i` is at rest where ours is.
//!
//! The equation of state gives `ρ² t`, and [`weigh_pressures`] turns it into p. Methods that solve for the pressure
//! need none of it: their walls push as the fluid does ([`BesideWall`](crate::lattice::BesideWall)). Without it still
//! water had 1.43 times its pressure beside a wall in the plane (1.08 with it), and in a tank of 8 × 8 particles the
//! pressure rose 17 to 20 % too fast (1 to 4 %).

use bevy_ecs::prelude::*;

use crate::{
    boundary::sums::{WallSums, Walls},
    state::{Execution, Pressures},
};

/// Least share: a particle in a right-angled corner of three walls has 0.3, one that a wall has swallowed none.
const LEAST: f32 = 0.1;

/// γ of a row [-], at least [`LEAST`].
#[inline]
fn fluid_share(walls: Walls, row: usize) -> f32 {
    (1.0 - walls.share(row)).max(LEAST)
}

/// Makes pressures of what the method left, `p = γ ρ² t` (phase `Pressure`).
pub fn weigh_pressures(
    mut pressures: ResMut<Pressures>,
    walls: Option<Res<WallSums>>,
    execution: Res<Execution>,
) {
    let walls = Walls::of(walls.as_deref());
    execution.for_each_chunk(&mut pressures.0, |first, pressures| {
        for (row, pressure) in (first..).zip(pressures) {
            *pressure *= fluid_share(walls, row);
        }
    });
}
