//! The forces on a scene's fluid beside gravity, with their tables read.

use std::path::Path;

use bevy_ecs::prelude::*;
use glam::Vec3;

use crate::{
    measure::CurveError,
    scene::{AccelerationTable, BodyForce, CentralForce, ForceWave, Scene},
};

/// Forces beside gravity. In scenes that have some.
#[derive(Resource, Debug, Clone, Default, PartialEq)]
pub struct BodyForces {
    /// Those towards a point.
    pub(crate) central: Vec<CentralForce>,
    /// Those over time.
    pub(crate) tables: Vec<AccelerationTable>,
    /// Those that are waves.
    pub(crate) waves: Vec<ForceWave>,
}

impl BodyForces {
    /// Those of a scene. Fails if the file of a table is gone or has become unusable.
    pub fn new(scene: &Scene) -> Result<Self, CurveError> {
        let mut forces = Self::default();
        for force in &scene.body_forces {
            match force {
                BodyForce::Central(central) => forces.central.push(*central),
                BodyForce::Table(table) => forces
                    .tables
                    .push(AccelerationTable::load(Path::new(&table.file))?),
                BodyForce::Wave(wave) => forces.waves.push(*wave),
            }
        }
        Ok(forces)
    }

    /// Every figure that they depend on and that is not in the scene.
    pub(crate) fn figures(&self) -> impl Iterator<Item = f64> {
        self.tables.iter().flat_map(AccelerationTable::figures)
    }

    /// Potential energy of a mass of 1 in the central forces, zero at their centres \[m²/s²].
    #[inline]
    pub fn potential(&self, point: Vec3) -> f32 {
        self.central
            .iter()
            .map(|force| force.potential(point))
            .sum()
    }
}
