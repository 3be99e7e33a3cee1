//! Creates the particles of a scene. Everything that can fail happens before the first one is spawned.

use bevy_ecs::prelude::*;

use super::error::InstallError;
use crate::{
    boundary::{
        self,
        direct_forcing::DirectForcing,
        extrapolation::Continued,
        friction::{self, SlipLength, WallFriction},
        moving::{MovingWalls, RestPose},
        owners::{Owners, SampleOf},
        sums::BoundarySums,
    },
    filling, gauge,
    index::{self, BoundarySamples, z_curve},
    neighbours::BoundaryNeighbours,
    ranks, sampling,
    sampling::BoundarySample,
    scene::{BoundaryHandling, Neighbours, Scene, shapes::ParticleSeed},
    state::{
        Execution, Material,
        particle::{
            self, Boundary, BoundaryDepth, BoundaryNormal, BoundaryVolume, Density, Position,
            Velocity,
        },
    },
};

/// The fluid's particles, in Z-curve order if the scene reorders its rows.
pub(super) struct FluidStart {
    pub(super) seeds: Vec<ParticleSeed>,
    order: Vec<z_curve::Handle>,
}

impl FluidStart {
    pub(super) fn new(scene: &Scene, execution: &Execution) -> Result<Self, InstallError> {
        for field in scene
            .bodies
            .iter()
            .filter_map(|body| body.velocity_field.as_ref())
        {
            field.read()?;
        }
        let seeds = execution.pool().install(|| filling::fluid_particles(scene));
        let mut order: Vec<z_curve::Handle> = (0..seeds.len() as u32).map(|row| (0, row)).collect();
        let points: Vec<_> = seeds.iter().map(|seed| seed.position.extend(0.0)).collect();
        // Refuses now what the first step could not index.
        index::build(scene)
            .rebuild(&points, execution)
            .map_err(InstallError::Fluid)?;
        if scene.reorder_interval > 0 {
            // Numbers of particles do not depend on how long lists are kept.
            let every_step = Scene {
                neighbours: Neighbours::Stored,
                ..scene.clone()
            };
            let index = index::build(&every_step);
            z_curve::sort_handles(
                &points,
                (index.grid(), scene.reorder_by),
                execution,
                &mut order,
            );
        }
        Ok(Self { seeds, order })
    }

    pub(super) fn spawn(self, world: &mut World, material: &Material) {
        let Self { seeds, order } = self;
        let density = Density(material.rest_density);
        ranks::spawn_own(world, order.len(), |world, own| {
            world.spawn_batch(order[own].iter().map(|(_, row)| {
                let seed = &seeds[*row as usize];
                (
                    particle::Fluid,
                    Position(seed.position),
                    Velocity(seed.velocity),
                    density,
                    particle::Pressure(0.0),
                )
            }));
        });
    }
}

/// The boundary particles, and their data for the loops.
pub(super) struct Walls {
    pub(super) sampled: Vec<BoundarySample>,
    /// The boundary of each sample, by number, if a gauge needs it.
    owners: Option<Vec<u32>>,
    pub(super) samples: BoundarySamples,
    /// Those that move, and the poses of all samples.
    moving: Option<(MovingWalls, Vec<Option<RestPose>>)>,
    /// Slip lengths of all samples, where walls hold the fluid.
    slip: Option<Vec<Option<f32>>>,
}

impl Walls {
    /// `None` for a scene without boundaries.
    pub(super) fn new(scene: &Scene, execution: &Execution) -> Result<Option<Self>, InstallError> {
        if scene.boundaries.is_empty() {
            return Ok(None);
        }
        let (mut sampled, mut owners) = (Vec::new(), Vec::new());
        let mut put = |owner, sample| {
            sampled.push(sample);
            owners.push(owner);
        };
        let pool = execution.pool();
        pool.install(|| sampling::for_each_sample_of(scene, &mut put))?;
        let samples = boundary::pack(scene, &sampled, execution).map_err(InstallError::Boundary)?;
        let mut moving = MovingWalls::new(scene)?.map(|walls| {
            let samples = sampled.iter().zip(&owners);
            let poses: Vec<_> = samples
                .map(|(sample, &owner)| walls.pose_of(owner, sample))
                .collect();
            (walls, poses)
        });
        if let Some((walls, poses)) = &mut moving {
            let taken = walls.take(scene, poses, samples.points(), execution);
            taken.map_err(InstallError::Boundary)?;
        }
        let slip = friction::is_wanted(scene).then(|| {
            let of = |&owner: &u32| scene.boundaries[owner as usize].slip().length();
            owners.iter().map(of).collect()
        });
        Ok(Some(Self {
            slip,
            sampled,
            owners: gauge::measures_forces(scene).then_some(owners),
            samples,
            moving,
        }))
    }

    /// Spawns the particles, calls `then`, and inserts the resources of walls.
    pub(super) fn spawn(self, world: &mut World, scene: &Scene, then: impl FnOnce(&mut World)) {
        let Self {
            sampled,
            owners,
            samples,
            moving,
            slip,
        } = self;
        let packed = samples.points().to_vec();
        let depths: Vec<f32> = sampled.iter().map(|sample| sample.depth).collect();
        let spawned = world.spawn_batch(sampled.into_iter().zip(packed).map(|(sample, packed)| {
            (
                Boundary,
                Position(packed.truncate()),
                BoundaryNormal(sample.normal),
                BoundaryVolume(packed.w),
            )
        }));
        let particles: Vec<Entity> = spawned.collect();
        if scene.boundary_handling() == BoundaryHandling::Layers {
            let depths = depths.into_iter().map(BoundaryDepth);
            world.insert_batch(particles.iter().copied().zip(depths).collect::<Vec<_>>());
        }
        then(world);
        if let Some((walls, poses)) = moving {
            let moved = particles.iter().zip(poses);
            let moved = moved.filter_map(|(&particle, pose)| Some((particle, pose?)));
            world.insert_batch(moved.collect::<Vec<_>>());
            world.insert_resource(walls);
        }
        if let Some(slip) = slip {
            let rough = particles.iter().zip(&slip);
            let rough =
                rough.filter_map(|(&particle, slip)| Some((particle, SlipLength((*slip)?))));
            world.insert_batch(rough.collect::<Vec<_>>());
            world.insert_resource(WallFriction::new(scene, slip));
        }
        if let Some(owners) = owners {
            let of = owners.iter().map(|&owner| SampleOf(owner));
            world.insert_batch(particles.into_iter().zip(of));
            world.insert_resource(Owners(owners));
            if scene.continues_pressure() {
                world.init_resource::<Continued>();
            }
        }
        world.insert_resource(samples);
        world.insert_resource(BoundarySums::new(
            scene.pressure.solver().beside_wall(scene),
        ));
        if let BoundaryHandling::DirectForcing(parameters) = scene.boundary_handling() {
            let direct = DirectForcing::new(parameters, world.resource::<Material>());
            world.insert_resource(direct);
        }
        if scene.stores_neighbours() {
            world.init_resource::<BoundaryNeighbours>();
        }
    }
}
