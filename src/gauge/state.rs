//! What gauges read of the world.

use bevy_ecs::{prelude::*, system::SystemParam};

use super::{account::EnergyAccount, free::FreeVelocities};
use crate::{
    boundary::{
        extrapolation::Continued, friction::WallFriction, moving::MovingWalls, owners::Owners,
        sums::BoundarySums,
    },
    index::{BoundarySamples, FluidIndex},
    integrate::Motion,
    pairs::Pairs,
    pressure::{delta_sph::Continuity, sesph::EquationOfState},
    state::{Clock, Densities, Execution, Material, PredictedPositions, Pressures, Velocities},
    time_step::AdaptiveTimeStep,
};

/// What gauges read of the world.
#[derive(SystemParam)]
pub(crate) struct State<'w> {
    pub(super) clock: Res<'w, Clock>,
    pub(super) material: Res<'w, Material>,
    pub(super) motion: Res<'w, Motion>,
    pub(super) places: Res<'w, PredictedPositions>,
    pub(super) velocities: Res<'w, Velocities>,
    pub(super) pressures: Res<'w, Pressures>,
    pub(super) densities: Res<'w, Densities>,
    pub(super) index: Res<'w, FluidIndex>,
    pub(super) pairs: Pairs<'w>,
    pub(super) execution: Res<'w, Execution>,
    pub(super) samples: Option<Res<'w, BoundarySamples>>,
    pub(super) owners: Option<Res<'w, Owners>>,
    pub(super) walls: Option<Res<'w, BoundarySums>>,
    pub(super) moving: Option<Res<'w, MovingWalls>>,
    pub(super) friction: Option<Res<'w, WallFriction>>,
    pub(super) continued: Option<Res<'w, Continued>>,
    equation: Option<Res<'w, EquationOfState>>,
    continuity: Option<Res<'w, Continuity>>,
    pub(super) free: Option<Res<'w, FreeVelocities>>,
    pub(super) energy: Option<Res<'w, EnergyAccount>>,
    pub(super) adaptive: Option<Res<'w, AdaptiveTimeStep>>,
}

impl State<'_> {
    /// Whether the pressure that acts in a step differs from the one that is reported.
    pub(super) fn acts_by_terms(&self) -> bool {
        self.equation.is_some() || self.continuity.is_some()
    }

    /// Number of fluid particles.
    pub(super) fn places_len(&self) -> usize {
        self.pairs.positions().rows()
    }
}
