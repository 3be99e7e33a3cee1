//! Pressure of walls that is continued linearly, `p_b = p_i + ρ0 g_i·(x_b − x_i)` at sample b for particle i (after
//! Adami, Hu & Adams 2012, eq. 27). The part with p_i is in the sum over the walls that every pressure force has
//! ([`sums`](super::sums)); the other is an acceleration like that of gravity, `Σ_b V_b (p_i − p_b)/ρ0 ∇W_ib`.
//!
//! With several layers g across the wall is a, the acceleration by gravity and body forces, but the pressure does not
//! fall below zero: a lid does not pull. Along it g is the part of a that the pressure of the fluid bears, from nothing
//! (fluid that slides freely) to all (fluid at rest). With one layer g is that part of all of a, no pressure falls
//! below zero, and samples push across the wall alone, times their push. Walls in motion are taken to move uniformly.

use bevy_ecs::prelude::*;
use glam::{Mat3, Vec3, Vec4};

use crate::{
    boundary::sums::{BoundarySums, Walls},
    index::BoundarySamples,
    kernel::Kernel,
    pairs::{Pair, PairSum, Pairs, accumulate},
    scene::Dimension,
    simd::Simd,
    state::{Accelerations, Material, Phase, Pressures, Product, Stage},
};

/// Hydrostatic part of the pressure of walls.
pub(crate) const STAGE: Stage = Stage {
    needs: &[
        Product::Columns,
        Product::Index,
        Product::Walls,
        Product::Neighbours,
        Product::Forces,
    ],
    wanted: |scene| scene.continues_pressure() && !scene.boundaries.is_empty(),
    bytes: |_, _| vec![("gradients that walls continue", 16.0 + 12.0)],
    ..Stage::new("wall_pressure", Phase::Forces, |_| {
        push_hydrostatically.into_configs()
    })
};

/// What walls of several layers continue, by row. In scenes that measure forces on walls.
#[derive(Resource, Debug, Default)]
pub(crate) struct Continued(Vec<Linear>);

impl Continued {
    /// What a sample with a volume at `−x` from a row adds to its acceleration \[m/s²].
    #[inline]
    pub(crate) fn by_sample(&self, row: usize, sample: (Vec3, f32), kernel: &Kernel) -> Vec3 {
        let linear = self.0.get(row).copied().unwrap_or_default();
        linear.push(sample, kernel)
    }
}

/// The pressure over ρ0 around a particle, without its own.
#[derive(Debug, Clone, Copy, Default)]
struct Linear {
    /// The gradient of the part that has a lower bound \[m/s²].
    bounded: Vec3,
    /// The bound, where the pressure is zero \[m²/s²].
    least: f32,
    /// The gradient of the rest \[m/s²].
    unbounded: Vec3,
    /// With one layer: the direction across the wall, and half of the push of the samples \[-].
    across: Option<(Vec3, f32)>,
}

impl Linear {
    /// The acceleration by a sample with a volume at `−x` \[m/s²].
    #[inline]
    fn push(self, (x, volume): (Vec3, f32), kernel: &Kernel) -> Vec3 {
        let difference = (-self.bounded.dot(x)).max(self.least) - self.unbounded.dot(x);
        let push = -volume * difference * kernel.gradient(x);
        match self.across {
            None => push,
            Some((inwards, factor)) => factor * push.dot(inwards) * inwards,
        }
    }
}

/// Where the determinant of the matrix is less, the fluid around a particle says nothing of a gradient \[-].
/// In the corner of a tank at the surface it is 0.002.
const LEAST_SHARE: f32 = 1e-4;

/// Fluid that bears no more of an acceleration is free \[-].
const FREE: f32 = 0.1;

/// Fluid that bears no less of it is at rest \[-].
const AT_REST: f32 = 0.5;

/// Sums over the fluid for the gradient of its pressure, corrected so that one of a linear pressure is exact:
/// `M G = Σ_j V (p_j − p_i)/ρ0 ∇W_ij` with `M = Σ_j V ∇W_ij ⊗ (x_j − x_i)`.
#[derive(Clone, Copy)]
struct Differences<'a> {
    /// Pressures over ρ0 as fourth entries \[m²/s²].
    table: &'a [Vec4],
    /// Volume of a particle times the scale of the gradient.
    factor: f32,
    dimension: Dimension,
}

/// Sums of a row: its own pressure, the vector, and the matrix's diagonal and other entries (yz, zx, xy).
struct DifferenceSums<S: Simd> {
    own: S::F,
    vector: [S::F; 3],
    diagonal: [S::F; 3],
    mixed: [S::F; 3],
}

impl PairSum for Differences<'_> {
    type Sums<S: Simd> = DifferenceSums<S>;
    /// G \[m/s²].
    type Output = Vec3;
    const BESIDE_BOUNDARY: bool = true;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, _: Vec4) -> DifferenceSums<S> {
        let zero = [simd.splat(0.0); 3];
        DifferenceSums {
            own: simd.splat(self.table[i].w),
            vector: zero,
            diagonal: zero,
            mixed: zero,
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut DifferenceSums<S>) {
        let [.., other] = simd.gather(self.table, j);
        let factor = simd.mul(pair.grad_factor, simd.sub(other, sums.own));
        accumulate(simd, &mut sums.vector, factor, pair.x_ij);
        let [x, y, z] = pair.x_ij;
        let minus = simd.sub(simd.splat(0.0), pair.grad_factor);
        let squares = [simd.mul(x, x), simd.mul(y, y), simd.mul(z, z)];
        accumulate(simd, &mut sums.diagonal, minus, squares);
        let products = [simd.mul(y, z), simd.mul(z, x), simd.mul(x, y)];
        accumulate(simd, &mut sums.mixed, minus, products);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: DifferenceSums<S>) -> Vec3 {
        let of = |lanes: [S::F; 3]| self.factor * Vec3::from(lanes.map(|lanes| simd.sum(lanes)));
        let (vector, mut diagonal, mixed) = (of(sums.vector), of(sums.diagonal), of(sums.mixed));
        if self.dimension == Dimension::Two {
            diagonal.z = 1.0;
        }
        let matrix = Mat3::from_cols(
            Vec3::new(diagonal.x, mixed.z, mixed.y),
            Vec3::new(mixed.z, diagonal.y, mixed.x),
            Vec3::new(mixed.y, mixed.x, diagonal.z),
        );
        if matrix.determinant() < LEAST_SHARE {
            return Vec3::ZERO;
        }
        matrix.inverse() * vector
    }
}

/// Room that is kept from step to step.
#[derive(Debug, Default)]
struct Buffers {
    /// Pressures over ρ0 as fourth entries, by row \[m²/s²].
    table: Vec<Vec4>,
    /// Gradients of the pressure over ρ0 \[m/s²], of the rows beside walls.
    borne: Vec<Vec3>,
}

/// Adds the push of walls that continue gravity and body forces (phase `Forces`, after these).
fn push_hydrostatically(
    mut accelerations: ResMut<Accelerations>,
    continued: Option<ResMut<Continued>>,
    boundary: Res<BoundarySamples>,
    (walls, pressures): (Option<Res<BoundarySums>>, Res<Pressures>),
    material: Res<Material>,
    pairs: Pairs,
    mut buffers: Local<Buffers>,
) {
    // The sums of one layer, times their push, take the pressure of the particle for the mean of both.
    let push_of_one = boundary
        .depths
        .is_empty()
        .then(|| 0.5 * walls.as_deref().map_or(1.0, BoundarySums::push));
    let walls = Walls::of(walls.as_deref());
    let rows = pairs.positions().rows();
    let positions = &pairs.positions().0;
    let per_density = material.rest_density.recip();
    let Buffers { table, borne } = &mut *buffers;
    let of_row = |pressure: &f32| Vec4::W * (per_density * pressure);
    table.clear();
    table.extend(pressures.0[..rows].iter().map(of_row));
    table.push(Vec4::ZERO);
    borne.resize(rows, Vec3::ZERO);
    let table = &*table;
    let differences = Differences {
        table,
        factor: per_density * material.particle_mass * material.kernel.gradient_scale,
        dimension: material.dimension,
    };
    pairs.sum_beside_boundary(&differences, borne);
    let push = |row: usize, samples: &[u32], acceleration: &mut Vec3| -> Linear {
        let (own, force) = (positions[row].truncate(), *acceleration);
        let inwards = walls.gradient(row).normalize_or_zero();
        let least = -table[row].w.max(0.0);
        let linear = if let Some(factor) = push_of_one {
            Linear {
                bounded: carried(borne[row], force),
                least,
                unbounded: Vec3::ZERO,
                across: Some((inwards, factor)),
            }
        } else {
            let bounded = force.dot(inwards) * inwards;
            Linear {
                bounded,
                least,
                unbounded: carried(borne[row], force - bounded),
                across: None,
            }
        };
        for &sample in samples {
            // A stale list may name samples that are gone: the sentinel has no volume.
            let Some(place) = boundary.packed.get(sample as usize) else {
                continue;
            };
            let x = material.period.nearest(own - place.truncate());
            *acceleration += linear.push((x, place.w), &material.kernel);
        }
        linear
    };
    let accelerations = &mut accelerations.0[..rows];
    let Some(mut continued) = continued else {
        // A vector of nothing takes no memory.
        let columns = (accelerations, &mut vec![(); rows][..]);
        return pairs.update_near_boundary(columns, |row, samples, acceleration, ()| {
            push(row, samples, acceleration);
        });
    };
    continued.0.clear();
    continued.0.resize(rows, Linear::default());
    let columns = (accelerations, &mut continued.0[..]);
    pairs.update_near_boundary(columns, |row, samples, acceleration, linear| {
        *linear = push(row, samples, acceleration);
    });
}

/// The part of an acceleration that the pressure of the fluid bears. Water that bears most of it counts as
/// at rest, and water that bears little as free: else the noise of its pressure would drive the rows beside walls.
fn carried(gradient: Vec3, acceleration: Vec3) -> Vec3 {
    let square = acceleration.length_squared();
    if square <= 0.0 {
        return Vec3::ZERO;
    }
    let part = gradient.dot(acceleration) / square;
    let t = ((part - FREE) / (AT_REST - FREE)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t) * acceleration
}
