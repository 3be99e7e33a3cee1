//! Solid boundaries as particles (Akinci et al. 2012): sampled once, with the volume that each stands for.
//!
//! A wall adds `ρ0 V_b W` to the density of the fluid near it, which makes pressure push the fluid away. The particles
//! are entities; loops read a packed copy, and an index of their own that is built once, since they do not move. What they
//! add to the sums of the fluid is found once a step ([`sums`]).

pub mod contact;
pub mod direct_forcing;
mod front;
mod mesh;
mod sampling;
pub mod sums;
mod volume;

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

pub use sampling::{BoundarySample, layer_depth, sample};
pub use volume::volumes;

use crate::{
    column::SENTINEL,
    execution::Execution,
    index::{self, DomainTooLarge, SpatialIndex},
    particle::{Boundary, BoundaryNormal, BoundaryVolume, Position},
    scene::Scene,
};

/// The boundary particles as loops read them.
#[derive(Resource)]
pub struct BoundarySamples {
    /// Position [m] and volume [m³; m² in 2-D] of every particle; a sentinel without volume ends them.
    pub packed: Vec<Vec4>,
    /// Unit vectors from the solid into the fluid.
    pub normals: Vec<Vec3>,
    /// Depth of the layer of samples behind the walls' faces [m].
    pub layer_depth: f32,
    /// Who is where.
    pub index: Box<dyn SpatialIndex>,
}

impl BoundarySamples {
    /// The particles without the sentinel.
    pub fn points(&self) -> &[Vec4] {
        &self.packed[..self.packed.len() - 1]
    }

    /// Packs particles and calculates their volumes. Fails if the scene's spatial index cannot cover them.
    pub fn new(
        scene: &Scene,
        samples: &[BoundarySample],
        execution: &Execution,
    ) -> Result<Self, DomainTooLarge> {
        let mut packed: Vec<Vec4> = samples
            .iter()
            .map(|sample| sample.position.extend(0.0))
            .collect();
        let mut index = index::build(scene);
        index.rebuild(&packed, execution)?;
        packed.push(SENTINEL);
        let volumes = volumes(scene, &*index, &packed, execution);
        for (particle, volume) in packed.iter_mut().zip(volumes) {
            particle.w = volume;
        }
        let normals = samples.iter().map(|sample| sample.normal).collect();
        Ok(Self {
            packed,
            normals,
            layer_depth: layer_depth(scene),
            index,
        })
    }
}

/// Takes the boundary particles of a world over again, after a host has spawned, moved or despawned some. If the
/// scene's spatial index cannot cover them, the walls stay as they were for the fluid.
pub fn refresh_boundary(world: &mut World, scene: &Scene) -> Result<(), DomainTooLarge> {
    let execution = world.resource::<Execution>().clone();
    let mut query =
        world.query_filtered::<(&Position, &BoundaryNormal, &mut BoundaryVolume), With<Boundary>>();
    let samples: Vec<BoundarySample> = query
        .iter(world)
        .map(|(x, normal, _)| BoundarySample {
            position: x.0,
            normal: normal.0,
        })
        .collect();
    let samples = BoundarySamples::new(scene, &samples, &execution)?;
    for ((_, _, mut volume), sample) in query.iter_mut(world).zip(samples.points()) {
        volume.0 = sample.w;
    }
    world.insert_resource(samples);
    Ok(())
}
