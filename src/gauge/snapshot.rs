//! What a host asks of the fluid between steps: who is near a point, and pressure, density and velocity there.
//!
//! A snapshot reads the tables, so it holds what the host spawned, moved or removed since the last step, and is right
//! before the first step and after one that failed. It costs about as much as the index of a step: ask it for many
//! points.

use bevy_ecs::prelude::*;
use bytemuck::TransparentWrapper;
use glam::{DVec3, Vec3, Vec4};

use super::{
    near::{Crowd, Near},
    point::Around,
};
use crate::{
    index::{self, SpatialIndex},
    scene::Scene,
    state::{
        DomainTooLarge, Execution, Material, in_order,
        particle::{Density, Fluid, Position, Pressure, Velocity},
    },
};

/// The fluid as stored in the tables.
pub struct Snapshot {
    entities: Vec<Entity>,
    places: Vec<Vec4>,
    velocities: Vec<Vec3>,
    densities: Vec<f32>,
    pressures: Vec<f32>,
    index: Box<dyn SpatialIndex>,
    material: Material,
    execution: Execution,
}

/// Why the fluid cannot be queried.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The world has no scene.
    #[error("no scene is installed in this world; call `install` first")]
    NotInstalled,
    /// The particles cannot be indexed.
    #[error(transparent)]
    Index(#[from] DomainTooLarge),
    /// The queried entity has no position.
    #[error("{entity} has no finite `Position`, so nothing is near it")]
    NoPlace {
        /// The entity.
        entity: Entity,
    },
}

/// A point, or the position of an entity.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Target {
    /// A point \[m].
    Point(Vec3),
    /// An entity with a [`Position`], of the fluid or not. It is not its own neighbour.
    Entity(Entity),
}

impl From<Vec3> for Target {
    fn from(point: Vec3) -> Self {
        Self::Point(point)
    }
}

impl From<Entity> for Target {
    fn from(entity: Entity) -> Self {
        Self::Entity(entity)
    }
}

/// A fluid particle near a point.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Neighbour {
    /// The particle.
    pub particle: Entity,
    /// Its distance \[m], less than h.
    pub distance: f32,
}

/// A quantity at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Interpolated<T> {
    /// The mean over the surrounding particles, weighted by the kernel (Shepard 1968); `None` without fluid.
    pub value: Option<T>,
    /// Number of particles that contribute.
    pub neighbours: u32,
}

/// A component that can be interpolated: [`Pressure`], [`Density`], [`Velocity`].
pub trait Field: private::Column {}

mod private {
    use super::{DVec3, Snapshot};

    pub trait Column: Sized + Send {
        fn of(snapshot: &Snapshot, row: usize) -> DVec3;
        fn from_mean(mean: DVec3) -> Self;
    }
}

impl Field for Pressure {}
impl private::Column for Pressure {
    fn of(snapshot: &Snapshot, row: usize) -> DVec3 {
        DVec3::splat(snapshot.pressures[row].into())
    }

    fn from_mean(mean: DVec3) -> Self {
        Self(mean.x as f32)
    }
}

impl Field for Density {}
impl private::Column for Density {
    fn of(snapshot: &Snapshot, row: usize) -> DVec3 {
        DVec3::splat(snapshot.densities[row].into())
    }

    fn from_mean(mean: DVec3) -> Self {
        Self(mean.x as f32)
    }
}

impl Field for Velocity {}
impl private::Column for Velocity {
    fn of(snapshot: &Snapshot, row: usize) -> DVec3 {
        snapshot.velocities[row].as_dvec3()
    }

    fn from_mean(mean: DVec3) -> Self {
        Self(mean.as_vec3())
    }
}

impl Snapshot {
    /// The fluid of a world, between steps. Particles that lack a component, or are nowhere, are left out.
    pub fn of(world: &World) -> Result<Self, SnapshotError> {
        let material = world.get_resource::<Material>().copied();
        let execution = world.get_resource::<Execution>().cloned();
        let (Some(material), Some(execution)) = (material, execution) else {
            return Err(SnapshotError::NotInstalled);
        };
        // Cells as large as the kernel's support, in a structure that covers fluid however far it has flown.
        let h = material.kernel.support_radius;
        let index = index::build(&Scene {
            dimension: material.dimension,
            support: Some(h / material.spacing),
            periodic: material.period.to_scene(),
            ..Scene::new("", material.spacing)
        });
        let mut snapshot = Self {
            entities: Vec::new(),
            places: Vec::new(),
            velocities: Vec::new(),
            densities: Vec::new(),
            pressures: Vec::new(),
            index,
            material,
            execution,
        };
        snapshot.gather(world);
        snapshot
            .index
            .rebuild(&snapshot.places, &snapshot.execution)?;
        Ok(snapshot)
    }

    fn gather(&mut self, world: &World) {
        type Columns = (
            Entity,
            &'static Position,
            &'static Velocity,
            &'static Density,
            &'static Pressure,
        );
        // `None` if the world does not know any such component.
        let Some(mut fluid) = world.try_query_filtered::<Columns, With<Fluid>>() else {
            return;
        };
        let tables = fluid.contiguous_iter(world).into_iter().flatten();
        for (entities, x, v, rho, p) in in_order(tables, |table| table.0) {
            let (x, v) = (Position::peel_slice(x), Velocity::peel_slice(v));
            let (rho, p) = (Density::peel_slice(rho), Pressure::peel_slice(p));
            for row in (0..x.len()).filter(|&row| x[row].is_finite()) {
                self.entities.push(entities[row]);
                let place = self.material.period.wrap(x[row]);
                self.places.push(place.extend(0.0));
                self.velocities.push(v[row]);
                self.densities.push(rho[row]);
                self.pressures.push(p[row]);
            }
        }
    }

    fn crowd(&self) -> Crowd<'_> {
        Crowd {
            near: Near {
                index: &*self.index,
                points: &self.places,
                slack: 0.0,
            },
            places: &self.places,
            dimension: self.material.dimension,
            spacing: self.material.spacing,
            period: self.material.period,
        }
    }

    fn distance(&self, row: usize, point: Vec3) -> f32 {
        let offset = self.places[row].truncate() - point;
        self.material.period.nearest(offset).length()
    }

    /// Fluid particles.
    pub fn particles(&self) -> &[Entity] {
        &self.entities
    }

    /// Fluid particles nearer to a point \[m] than h, the nearest first.
    pub fn neighbours_of(&self, point: Vec3) -> Vec<Neighbour> {
        let mut rows = Vec::new();
        let h = self.material.kernel.support_radius;
        let reach = self.crowd().reach(h);
        (self.crowd().near).rows_in(point - reach, point + reach, &mut rows);
        let neighbours = rows.into_iter().map(|row| Neighbour {
            particle: self.entities[row as usize],
            distance: self.distance(row as usize, point),
        });
        let mut neighbours: Vec<Neighbour> =
            neighbours.filter(|found| found.distance < h).collect();
        // A stable sort: particles at the same distance stay in the order of their rows.
        neighbours.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        neighbours
    }

    /// A quantity at points \[m], each a mean over the particles nearer than h: exact for a constant field; beside
    /// walls and surfaces, where all particles are on one side, of first order in h.
    pub fn interpolate<F: Field>(&self, points: &[Vec3]) -> Vec<Interpolated<F>> {
        let mut found: Vec<(u32, Option<DVec3>)> = vec![(0, None); points.len()];
        self.execution.for_each_chunk(&mut found, |first, found| {
            let mut rows = Vec::new();
            for (found, &at) in found.iter_mut().zip(&points[first..]) {
                let around = Around {
                    at,
                    side: None,
                    kernel: self.material.kernel,
                };
                let value = |row: usize| <F as private::Column>::of(self, row);
                *found = around.mean(self.crowd(), &mut rows, value);
            }
        });
        let interpolated = found.into_iter().map(|(neighbours, mean)| Interpolated {
            value: mean.map(F::from_mean),
            neighbours,
        });
        interpolated.collect()
    }
}

/// Fluid particles nearer than h to a point \[m] or to an entity, the nearest first.
pub fn neighbours_of(world: &World, of: Target) -> Result<Vec<Neighbour>, SnapshotError> {
    let snapshot = Snapshot::of(world)?;
    let entity = match of {
        Target::Point(point) => return Ok(snapshot.neighbours_of(point)),
        Target::Entity(entity) => entity,
    };
    let place = world.get::<Position>(entity).map(|x| x.0);
    let Some(place) = place.filter(|x| x.is_finite()) else {
        return Err(SnapshotError::NoPlace { entity });
    };
    let mut found = snapshot.neighbours_of(place);
    found.retain(|neighbour| neighbour.particle != entity);
    Ok(found)
}
