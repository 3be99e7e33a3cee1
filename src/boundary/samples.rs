//! Boundary particles of a world, packed for the loops.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use super::friction::{SlipLength, WallFriction};
use super::moving::{MovingWalls, RestPose};
use super::owners::{NOBODY, Owners, SampleOf};
use super::volume::VolumeRule;
use crate::{
    index::{self, BoundarySamples},
    kernel::Kernel,
    sampling::{BoundarySample, layer_depth},
    scene::{BoundaryHandling, Scene},
    state::{
        DomainTooLarge, Execution, Material, SENTINEL, TOO_LARGE, in_order,
        particle::{Boundary, BoundaryDepth, BoundaryNormal, BoundaryVolume, Position},
        seal::reseal,
    },
};

/// Packs particles and calculates their volumes. Fails if the scene's spatial index cannot cover them.
pub fn pack(
    scene: &Scene,
    samples: &[BoundarySample],
    execution: &Execution,
) -> Result<BoundarySamples, DomainTooLarge> {
    let period = scene.period();
    let mut packed: Vec<Vec4> = samples
        .iter()
        .map(|sample| period.wrap(sample.position).extend(0.0))
        .collect();
    let mut index = index::build_for_walls(scene);
    index.rebuild(&packed, execution)?;
    packed.push(SENTINEL);
    let volumes = VolumeRule::new(scene).volumes(&*index, &packed, execution);
    for (particle, volume) in packed.iter_mut().zip(volumes) {
        particle.w = volume;
    }
    let normals = samples.iter().map(|sample| sample.normal).collect();
    let depths = match scene.boundary_handling() {
        BoundaryHandling::Layers => samples.iter().map(|sample| sample.depth).collect(),
        BoundaryHandling::Akinci
        | BoundaryHandling::Extrapolated
        | BoundaryHandling::DirectForcing(_) => Vec::new(),
    };
    Ok(BoundarySamples {
        packed,
        normals,
        ahead: Vec::new(),
        velocities: Vec::new(),
        layer_depth: layer_depth(scene),
        depths,
        index,
    })
}

/// Why walls that a host changed cannot be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoundaryError {
    /// No scene is installed.
    #[error("no scene is installed in this world; call `install` first")]
    NotInstalled,
    /// The scene is another than the one that is installed.
    #[error(
        "this scene is another than the one that is installed: its {differs} differs; pass the scene that was installed"
    )]
    OtherScene {
        /// What differs.
        differs: &'static str,
    },
    /// The scene was installed without boundaries.
    #[error(
        "the scene was installed without boundaries, so its step has no walls; give it one at least (a `Plane` \
         far from the fluid will do), and install it again"
    )]
    NoWalls,
    /// A particle lacks a component that every boundary particle has.
    #[error(
        "the boundary particle {particle} lacks the component `{component}`; insert it again, or remove `Boundary` \
         from what is no wall"
    )]
    LacksComponent {
        /// The particle.
        particle: Entity,
        /// Name of the component.
        component: &'static str,
    },
    /// A position or a normal is no use.
    #[error("the boundary particle {particle}: {quantity} is {value}; {wanted}")]
    Unusable {
        /// The particle.
        particle: Entity,
        /// Which quantity.
        quantity: &'static str,
        /// Its value.
        value: Vec3,
        /// What would be right.
        wanted: &'static str,
    },
    /// The scene's spatial index cannot cover the walls.
    #[error(transparent)]
    DomainTooLarge(#[from] DomainTooLarge),
}

/// How far the length of a normal may be from 1.
const UNIT: f32 = 1e-3;

/// Refuses boundary particles that would drop out, or spoil the volumes of all around them.
fn check(world: &mut World) -> Result<(), BoundaryError> {
    type Parts<'w> = (
        Entity,
        Option<&'w Position>,
        Option<&'w BoundaryNormal>,
        Has<BoundaryVolume>,
    );
    let mut walls = world.query_filtered::<Parts, With<Boundary>>();
    for (particle, position, normal, has_volume) in walls.iter(world) {
        let lacks = |component| BoundaryError::LacksComponent {
            particle,
            component,
        };
        let position = position.ok_or(lacks("Position"))?.0;
        let normal = normal.ok_or(lacks("BoundaryNormal"))?.0;
        if !has_volume {
            return Err(lacks("BoundaryVolume"));
        }
        let unusable = |quantity, value, wanted| BoundaryError::Unusable {
            particle,
            quantity,
            value,
            wanted,
        };
        if !position.abs().cmplt(Vec3::splat(TOO_LARGE)).all() {
            let wanted = "coordinates must be finite and below 1e17 m";
            return Err(unusable("the position", position, wanted));
        }
        // A length that is not a number is in no range.
        if !(1.0 - UNIT..=1.0 + UNIT).contains(&normal.length()) {
            let wanted = "it must be a unit vector from the solid into the fluid";
            return Err(unusable("the normal", normal, wanted));
        }
    }
    Ok(())
}

/// Refuses a scene that is not the one that is installed.
fn check_scene(scene: &Scene, material: &Material) -> Result<(), BoundaryError> {
    let differs = match material {
        _ if material.spacing != scene.spacing => "spacing",
        _ if material.dimension != scene.dimension => "dimension",
        _ if material.kernel != Kernel::of(scene) => "kernel",
        _ if material.period != scene.period() => "period",
        _ => return Ok(()),
    };
    Err(BoundaryError::OtherScene { differs })
}

/// What the tables say of all boundary particles, in one order.
#[derive(Default)]
struct Found {
    samples: Vec<BoundarySample>,
    owners: Vec<u32>,
    poses: Vec<Option<RestPose>>,
    slip: Vec<Option<f32>>,
}

impl Found {
    fn of(world: &mut World, scene: &Scene) -> Self {
        type Parts<'w> = (
            Entity,
            &'w Position,
            &'w BoundaryNormal,
            Option<&'w BoundaryDepth>,
            Option<&'w SampleOf>,
            Option<&'w RestPose>,
            Option<&'w SlipLength>,
        );
        let nearest = layer_depth(scene);
        let mut found = Self::default();
        let mut query = world.query_filtered::<Parts, With<Boundary>>();
        let tables = query.contiguous_iter(world).into_iter().flatten();
        for table in in_order(tables, |table| table.0) {
            let (_, positions, normals, depths, owners, poses, slip) = table;
            for row in 0..positions.len() {
                found.samples.push(BoundarySample {
                    position: positions[row].0,
                    normal: normals[row].0,
                    depth: depths.map_or(nearest, |depths| depths[row].0),
                });
                found.owners.push(owners.map_or(NOBODY, |of| of[row].0));
                found.poses.push(poses.map(|poses| poses[row]));
                found.slip.push(slip.map(|slip| slip[row].0));
            }
        }
        found
    }
}

/// Takes the boundary particles of a world over again, after a host has spawned, moved or despawned some. After an
/// error the walls stay as they were for the fluid.
pub fn refresh_boundary(world: &mut World, scene: &Scene) -> Result<(), BoundaryError> {
    let execution = world.get_resource::<Execution>().cloned();
    let material = world.get_resource::<Material>().copied();
    let (Some(execution), Some(material)) = (execution, material) else {
        return Err(BoundaryError::NotInstalled);
    };
    check_scene(scene, &material)?;
    if !world.contains_resource::<BoundarySamples>() {
        return Err(BoundaryError::NoWalls);
    }
    check(world)?;
    let Found {
        samples,
        owners,
        poses,
        slip,
    } = Found::of(world, scene);
    let samples = pack(scene, &samples, &execution)?;
    if let Some(mut walls) = world.get_resource_mut::<MovingWalls>() {
        let known = walls.courses.len();
        let known = |pose: &RestPose| (pose.course as usize) < known;
        let poses: Vec<_> = poses.into_iter().map(|pose| pose.filter(known)).collect();
        walls.take(scene, &poses, samples.points(), &execution)?;
    }
    if world.contains_resource::<Owners>() {
        world.insert_resource(Owners(owners));
    }
    if let Some(mut friction) = world.get_resource_mut::<WallFriction>() {
        friction.take(slip);
    }
    let mut packed = samples.points().iter();
    let mut volumes = world.query_filtered::<(Entity, &mut BoundaryVolume), With<Boundary>>();
    let tables = volumes.contiguous_iter_mut(world).into_iter().flatten();
    for (_, mut volumes) in in_order(tables, |table| table.0) {
        for (volume, sample) in volumes.iter_mut().zip(&mut packed) {
            volume.0 = sample.w;
        }
    }
    world.insert_resource(samples);
    reseal(world);
    Ok(())
}
