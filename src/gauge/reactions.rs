//! Effects of walls on each particle in a step.

use glam::Vec3;

use super::state::State;
use crate::{boundary::sums::Walls, pressure::force::PressureForce};

/// Effects of walls on each row in the step.
pub(super) struct Reactions {
    /// Pressure term of all solves, `p/ρ²`.
    pub(super) terms: Vec<f32>,
    /// Acceleration along the wall that completes the fluid's own force \[m/s²].
    pub(super) added: Vec<Vec3>,
    /// Rows that contact changed.
    pub(super) touched: Vec<u32>,
}

impl Reactions {
    pub(super) fn new(state: &State) -> Self {
        let rows = state.places_len();
        let positions = &state.pairs.positions().0;
        let terms: Vec<f32> = if state.acts_by_terms() {
            // The pressure that acts in the step differs from the pressure that is reported.
            positions[..rows].iter().map(|x| x.w).collect()
        } else {
            let pressures = state.pressures.0.iter().zip(&state.densities.0);
            pressures.map(|(p, rho)| p / (rho * rho)).collect()
        };
        let walls = Walls::of(state.walls.as_deref());
        let mut carried = positions.clone();
        for (x, term) in carried.iter_mut().zip(&terms) {
            x.w = *term;
        }
        let mut added = vec![Vec3::ZERO; rows];
        let pass = PressureForce::new(&state.material, walls);
        state.pairs.sum_at(&carried, &pass, &mut added);
        state.execution.for_each_chunk(&mut added, |first, added| {
            for (row, acceleration) in (first..).zip(added) {
                *acceleration = walls.added(row, *acceleration);
            }
        });
        let free = state.free.as_ref().map_or(&[][..], |free| &free.0);
        let changed = free.iter().zip(&state.velocities.0);
        let touched = (0..)
            .zip(changed)
            .filter(|(_, (before, after))| before.truncate() != after.truncate())
            .map(|(row, _)| row)
            .collect();
        Self {
            terms,
            added,
            touched,
        }
    }
}
