//! The boundary particles and their own index.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use super::structure::SpatialIndex;

/// Boundary particles in the form that loops over neighbours read.
#[derive(Resource)]
pub struct BoundarySamples {
    /// Position \[m] and volume \[m³; m² in 2-D] of every particle; a sentinel without volume ends them.
    pub(crate) packed: Vec<Vec4>,
    /// Unit vectors from the solid into the fluid.
    pub(crate) normals: Vec<Vec3>,
    /// Positions at the end of the step \[m] and volumes, with the sentinel; empty where no wall moves.
    pub(crate) ahead: Vec<Vec4>,
    /// Mean velocities of the step \[m/s], with one for the sentinel; empty where no wall moves.
    pub(crate) velocities: Vec<Vec4>,
    /// Depth of the nearest layer of samples behind the walls' faces \[m].
    pub(crate) layer_depth: f32,
    /// Depths of the particles \[m]; empty where all are in one layer.
    pub(crate) depths: Vec<f32>,
    /// Spatial index of the boundary particles.
    pub(crate) index: Box<dyn SpatialIndex>,
}

impl BoundarySamples {
    /// The particles without the sentinel.
    pub fn points(&self) -> &[Vec4] {
        &self.packed[..self.packed.len().saturating_sub(1)]
    }

    /// Depth of a particle behind the face of its wall \[m].
    #[inline]
    pub fn depth(&self, sample: usize) -> f32 {
        let depth = self.depths.get(sample);
        depth.copied().unwrap_or(self.layer_depth)
    }

    /// Where a particle is at the end of the step \[m].
    #[inline]
    pub fn place_ahead(&self, sample: usize) -> Vec3 {
        let ahead = self.ahead.get(sample);
        ahead.unwrap_or(&self.packed[sample]).truncate()
    }

    /// Its mean velocity in the step \[m/s].
    #[inline]
    pub fn velocity(&self, sample: usize) -> Vec3 {
        self.velocities
            .get(sample)
            .map_or(Vec3::ZERO, |velocity| velocity.truncate())
    }
}
