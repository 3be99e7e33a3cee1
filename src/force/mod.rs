//! All forces but pressure, each a file and a system that is in the schedule only if the scene asks.
//!
//! They add to [`Accelerations`], which gravity starts.

mod gravity;
mod surface_tension;
mod viscosity;

pub use gravity::apply_gravity;
pub use surface_tension::{Cohesion, apply_surface_tension};
pub use viscosity::{
    ArtificialViscosity, LaminarViscosity, apply_artificial_viscosity, apply_laminar_viscosity,
};

use bevy_ecs::prelude::*;
use glam::Vec3;

use crate::column::Accelerations;

/// Accelerations of one force, before they are added to the others [m/s²].
#[derive(Resource, Debug, Default)]
pub struct ForceScratch(Vec<Vec3>);

impl ForceScratch {
    /// One entry a row.
    fn rows(&mut self, rows: usize) -> &mut [Vec3] {
        self.0.resize(rows, Vec3::ZERO);
        &mut self.0
    }

    fn add_to(&self, accelerations: &mut Accelerations) {
        for (sum, force) in accelerations.0.iter_mut().zip(&self.0) {
            *sum += *force;
        }
    }
}
