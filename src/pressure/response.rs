//! What a particle answers to its own pressure, `D_i = |Σ_j m ∇W_ij + Σ_b ρ0 V_b ∇W_ib|² + Σ_j |m ∇W_ij|²` (see
//! [`implicit`](super::implicit)), summed along with its density. IISPH and DFSPH divide by it, and PCISPH where it is more than
//! a full lattice's.

use bevy_ecs::{prelude::*, system::SystemParam};
use glam::{Vec3, Vec4};
use rayon::iter::IndexedParallelIterator;

use crate::{
    boundary::sums::{WallSums, Walls},
    density::DensitySum,
    pairs::{Pair, PairSlopes, PairSum, Pairs, accumulate, both, putting},
    simd::Simd,
    state::{Densities, Material},
};

/// `1/D` of every particle [m⁸/kg²; m⁶/kg² in 2-D]; 0 where nothing answers.
#[derive(Resource, Debug, Default)]
pub struct Responses(pub Vec<f32>);

/// `|Σ_j ∇W_ij|² + Σ_j |∇W_ij|²` of a particle in a full lattice.
pub(super) fn lattice_response(material: &Material) -> f64 {
    let gradients = || {
        let lattice = material
            .kernel
            .lattice(material.dimension, material.spacing);
        lattice.map(|x| material.kernel.gradient(x).as_dvec3())
    };
    let sum: glam::DVec3 = gradients().sum();
    let squares: f64 = gradients().map(|gradient| gradient.length_squared()).sum();
    sum.length_squared() + squares
}

/// Densities, and what the particles answer to their pressure (phase `Density`).
pub fn compute_density(
    mut columns: AnsweringDensities,
    mut slopes: Option<ResMut<PairSlopes>>,
    walls: Option<Res<WallSums>>,
    pairs: Pairs,
    material: Res<Material>,
) {
    let sums = AnsweringDensities::sums(&material, Walls::of(walls.as_deref()));
    let takers = columns.takers(pairs.positions().rows());
    pairs.sum_and_keep(&sums, slopes.as_deref_mut(), takers);
}

/// Densities and responses, which one pass over the neighbours sums.
#[derive(SystemParam)]
pub struct AnsweringDensities<'w> {
    densities: ResMut<'w, Densities>,
    responses: ResMut<'w, Responses>,
}

impl AnsweringDensities<'_> {
    /// The sums of both.
    pub(super) fn sums<'a>(
        material: &Material,
        walls: Walls<'a>,
    ) -> (DensitySum<'a, false>, Response<'a>) {
        (
            DensitySum::new(material, walls),
            Response::new(material, walls),
        )
    }

    /// What takes them, for so many rows.
    pub(super) fn takers(
        &mut self,
        rows: usize,
    ) -> impl IndexedParallelIterator<Item = impl FnMut(usize, (f32, f32)) + Send> {
        self.densities.0.resize(rows, 0.0);
        self.responses.0.resize(rows, 0.0);
        both(
            putting(&mut self.densities.0),
            putting(&mut self.responses.0),
        )
    }
}

/// Sums `1/D`.
#[derive(Clone, Copy)]
pub struct Response<'a> {
    walls: Walls<'a>,
    rest_density: f32,
    /// m and the kernel's factor.
    factor: f32,
    /// D below which nothing answers.
    least: f32,
}

/// Part of a full lattice's D below which a particle is taken to answer no pressure. The motion that removes an error
/// grows as 1/sqrt(D); two particles on the edge of each other's support have 4e-4.
const LEAST_RESPONSE: f64 = 1e-3;

impl<'a> Response<'a> {
    /// The sum for this fluid.
    pub fn new(material: &Material, walls: Walls<'a>) -> Self {
        let mass = f64::from(material.particle_mass);
        Self {
            walls,
            rest_density: material.rest_density,
            factor: material.particle_mass * material.kernel.slope_factor,
            least: (LEAST_RESPONSE * mass * mass * lattice_response(material)) as f32,
        }
    }
}

/// The sum of gradients and that of their squares.
pub struct ResponseSums<S: Simd> {
    sum: [S::F; 3],
    squares: S::F,
    /// `Σ_b ρ0 V_b ∇W_ib` [kg/m⁴].
    walls: Vec3,
}

impl PairSum for Response<'_> {
    type Sums<S: Simd> = ResponseSums<S>;
    type Output = f32;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, _: Vec4) -> ResponseSums<S> {
        ResponseSums {
            sum: [simd.splat(0.0); 3],
            squares: simd.splat(0.0),
            walls: self.rest_density * self.walls.gradient(i),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut ResponseSums<S>) {
        accumulate(simd, &mut sums.sum, pair.slope, pair.x);
        let square = simd.mul(pair.slope, pair.slope);
        sums.squares = simd.mul_add(square, pair.distance, sums.squares);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: ResponseSums<S>) -> f32 {
        let [x, y, z] = sums.sum;
        let sum = self.factor * Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z)) + sums.walls;
        let squares = self.factor * self.factor * simd.sum(sums.squares);
        let response = sum.length_squared() + squares;
        if response > self.least {
            1.0 / response
        } else {
            0.0
        }
    }
}
