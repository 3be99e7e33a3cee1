//! Viscosity between walls and fluid, for walls that do not let it slip.
//!
//! A sample takes part in the laminar viscosity with a velocity of its own: that which the fluid before it would have
//! there, if it went on behind the face with the same shear (Adami et al. 2012, eq. 23, there `2 v_wall − ṽ`). ṽ is the
//! mean of the fluid around the sample, weighted by the kernel, at the mean height ȳ over the face. With the depth L of
//! the layer and the slip length b (Navier; 0 without slip) the shear is `(ṽ − v_wall)/(ȳ + b)`, and the sample has
//! `v_wall + (b − L) shear`: exact for a linear profile, wherever the particles are.
//!
//! The force on a particle is `2 (d + 2) ν ρ0/ρ_i g Σ_b V_b (x_ib·∇W_ib)/(|x_ib|² + 0.01 h²) (v_i − v_b)`, along the
//! face alone. One layer stands for all that the wall's side of the kernel lacks: g makes it hold a lattice in a linear
//! shear as a lattice that goes on would. The wall takes the opposite of it.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::{
    index::{BoundarySamples, FluidIndex},
    kernel::Kernel,
    lattice::Lattice,
    neighbours::{Recomputed, Search},
    pairs::Pairs,
    sampling,
    scene::{Scene, Viscosity},
    simd::{Simd, Vectorised},
    state::{Accelerations, CHUNK, Densities, Execution, Material, Velocities},
};

/// Slip length of a boundary particle \[m], 0 without slip; those that let the fluid slip freely have none.
#[derive(Component, Debug, Clone, Copy, PartialEq)]
pub struct SlipLength(pub f32);

/// Least mean height of the fluid over a face, in spacings: nearer particles would be held too hard.
const LEAST_HEIGHT: f32 = 0.25;

/// Friction of the walls. In scenes whose walls do not let the fluid slip freely.
#[derive(Resource, Debug, Clone, Default)]
pub struct WallFriction {
    /// Slip length of each sample \[m]; none for free slip.
    slip: Vec<Option<f32>>,
    /// Rows of the samples that hold the fluid.
    rough: Vec<u32>,
    /// Velocities with which samples take part \[m/s], by row.
    velocities: Vec<Vec3>,
    /// Velocities of the fluid that friction was calculated with, and densities.
    fluid: Vec<Vec4>,
    /// `2 (d + 2) ν ρ0 g`.
    strength: f32,
}

/// Whether a wall of the scene holds the fluid.
pub(crate) fn is_wanted(scene: &Scene) -> bool {
    let mut walls = scene.boundaries.iter();
    walls.any(|wall| wall.slip().length().is_some())
}

impl WallFriction {
    /// For the samples with these slip lengths, by row.
    pub fn new(scene: &Scene, slip: Vec<Option<f32>>) -> Self {
        let mut friction = Self::default();
        friction.set_viscosity(scene);
        friction.take(slip);
        friction
    }

    /// Takes the viscosity of a scene.
    pub(crate) fn set_viscosity(&mut self, scene: &Scene) {
        let viscosity = match scene.fluid.viscosity {
            Viscosity::Laminar {
                kinematic_viscosity,
                ..
            } => kinematic_viscosity / Lattice::of(scene).shear_viscosity() as f32,
            Viscosity::None | Viscosity::Artificial { .. } => 0.0,
        };
        let d = f32::from(u8::from(scene.dimension));
        let grip = sampling::grip_of_wall(scene);
        self.strength = 2.0 * (d + 2.0) * viscosity * scene.fluid.rest_density * grip;
    }

    /// Takes the slip lengths of all samples over again.
    pub(crate) fn take(&mut self, slip: Vec<Option<f32>>) {
        let rows = (0..).zip(&slip).filter(|(_, slip)| slip.is_some());
        self.rough = rows.map(|(row, _)| row).collect();
        self.velocities = vec![Vec3::ZERO; slip.len()];
        self.slip = slip;
    }

    /// Acceleration of a particle, by its row, by a sample at `−x` from it with a volume and a normal \[m/s²].
    #[inline]
    pub(crate) fn acceleration(
        &self,
        row: usize,
        sample: usize,
        (x, volume, normal): (Vec3, f32, Vec3),
        kernel: &Kernel,
    ) -> Vec3 {
        let h = kernel.support_radius;
        let (Some(Some(_)), Some(own)) = (self.slip.get(sample), self.fluid.get(row)) else {
            return Vec3::ZERO;
        };
        let square = x.length_squared();
        if square >= h * h {
            return Vec3::ZERO;
        }
        let slope = kernel.gradient(x).dot(x) / (square + 0.01 * h * h);
        let v = own.truncate() - self.velocities[sample];
        let along = v - v.dot(normal) * normal;
        self.strength / own.w * volume * slope * along
    }

    /// Finds the velocities with which samples take part.
    fn find_velocities(
        &mut self,
        boundary: &BoundarySamples,
        (index, positions): (&FluidIndex, &[Vec4]),
        material: &Material,
        execution: &Execution,
    ) {
        let search = Search {
            of: &*boundary.index,
            points: boundary.points(),
            among: &*index.structure,
            among_points: positions,
            same: false,
        };
        let mut found = vec![Vec3::ZERO; self.rough.len()];
        let friction = &*self;
        execution.install(|| {
            let rows = friction.rough.par_chunks(CHUNK);
            found
                .par_chunks_mut(CHUNK)
                .zip(rows)
                .for_each(|(found, rows)| {
                    execution.instruction_set.dispatch(RoughRows {
                        friction,
                        boundary,
                        search,
                        material,
                        rows,
                        found,
                    });
                });
        });
        for (&row, velocity) in self.rough.iter().zip(found) {
            self.velocities[row as usize] = velocity;
        }
    }
}

/// Samples whose velocities are found one after the other.
struct RoughRows<'a> {
    friction: &'a WallFriction,
    boundary: &'a BoundarySamples,
    search: Search<'a>,
    material: &'a Material,
    rows: &'a [u32],
    found: &'a mut [Vec3],
}

impl Vectorised for RoughRows<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Material {
            kernel,
            spacing,
            period,
            ..
        } = self.material;
        let points = self.search.among_points;
        let mut near = Recomputed::new(self.search);
        for (&row, found) in self.rows.iter().zip(self.found) {
            let sample = row as usize;
            let place = self.boundary.packed[sample].truncate();
            let normal = self.boundary.normals[sample];
            let of_wall = self.boundary.velocity(sample);
            let slip = self.friction.slip[sample].unwrap_or_default();
            let depth = self.boundary.depth(sample);
            let (mut weights, mut velocity, mut height) = (0.0, Vec3::ZERO, 0.0);
            for &other in near.of(simd, sample) {
                let arm = period.nearest(points[other as usize].truncate() - place);
                let over = arm.dot(normal) - depth;
                // What is behind the face is on the other side of a thin wall.
                if over > -0.5 * spacing {
                    let weight = kernel.value(arm.length());
                    weights += weight;
                    height += weight * over;
                    velocity += weight * self.friction.fluid[other as usize].truncate();
                }
            }
            *found = if weights > 0.0 {
                let height = (height / weights).max(LEAST_HEIGHT * spacing);
                let shear = (velocity / weights - of_wall) / (height + slip);
                of_wall + (slip - depth) * shear
            } else {
                of_wall
            };
        }
    }
}

/// Adds the friction of walls (phase `Forces`, after the fluid's own viscosity).
pub fn apply_wall_friction(
    mut friction: ResMut<WallFriction>,
    mut accelerations: ResMut<Accelerations>,
    (velocities, densities): (Res<Velocities>, Res<Densities>),
    boundary: Res<BoundarySamples>,
    index: Res<FluidIndex>,
    material: Res<Material>,
    pairs: Pairs,
) {
    let rows = pairs.positions().rows();
    let friction = &mut *friction;
    friction.fluid.clear();
    let columns = velocities.0[..rows].iter().zip(&densities.0);
    let with_density = columns.map(|(v, density)| v.truncate().extend(*density));
    friction.fluid.extend(with_density);
    let fluid = (&*index, pairs.positions().points());
    friction.find_velocities(&boundary, fluid, &material, &pairs.execution);
    let friction = &*friction;
    let positions = &pairs.positions().0;
    let columns = (&mut accelerations.0[..rows], &mut vec![(); rows][..]);
    pairs.update_near_boundary(columns, |row, samples, acceleration: &mut Vec3, ()| {
        let own = positions[row].truncate();
        for &sample in samples {
            // A stale list may name samples that are gone.
            let Some(&normal) = boundary.normals.get(sample as usize) else {
                continue;
            };
            let place = boundary.packed[sample as usize];
            let x = material.period.nearest(own - place.truncate());
            *acceleration +=
                friction.acceleration(row, sample as usize, (x, place.w, normal), &material.kernel);
        }
    });
}
