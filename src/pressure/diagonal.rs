//! Diagonal of the pressure system, `D_i = |Σ_j m ∇W_ij + Σ_b ρ0 V_b ∇W_ib|² + Σ_j |m ∇W_ij|²` (see
//! [`implicit`](super::implicit)), summed together with the density. It is IISPH's a_ii up to the factor −dt²/ρ², and
//! ρ/D is DFSPH's α. PCISPH uses it where it exceeds that of a full lattice.

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

/// `1/D` of every particle \[m⁸/kg²; m⁶/kg² in 2-D]; 0 if D is negligible.
#[derive(Resource, Debug, Default)]
pub struct InverseDiagonals(pub Vec<f32>);

/// `|Σ_j ∇W_ij|² + Σ_j |∇W_ij|²` of a particle in a full lattice.
pub(super) fn lattice_diagonal(material: &Material) -> f64 {
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

/// Densities and inverse diagonals (phase `Density`).
pub fn compute_density(
    mut columns: DensitiesAndDiagonals,
    mut slopes: Option<ResMut<PairSlopes>>,
    walls: Option<Res<WallSums>>,
    pairs: Pairs,
    material: Res<Material>,
) {
    let sums = DensitiesAndDiagonals::sums(&material, Walls::of(walls.as_deref()));
    let takers = columns.takers(pairs.positions().rows());
    pairs.sum_and_keep(&sums, slopes.as_deref_mut(), takers);
}

/// Densities and inverse diagonals, summed in one pass over the neighbours.
#[derive(SystemParam)]
pub struct DensitiesAndDiagonals<'w> {
    densities: ResMut<'w, Densities>,
    diagonals: ResMut<'w, InverseDiagonals>,
}

impl DensitiesAndDiagonals<'_> {
    /// The sums of both.
    pub(super) fn sums<'a>(
        material: &Material,
        walls: Walls<'a>,
    ) -> (DensitySum<'a, false>, DiagonalSum<'a>) {
        (
            DensitySum::new(material, walls),
            DiagonalSum::new(material, walls),
        )
    }

    /// Writers of both columns, for `rows` rows.
    pub(super) fn takers(
        &mut self,
        rows: usize,
    ) -> impl IndexedParallelIterator<Item = impl FnMut(usize, (f32, f32)) + Send> {
        self.densities.0.resize(rows, 0.0);
        self.diagonals.0.resize(rows, 0.0);
        both(
            putting(&mut self.densities.0),
            putting(&mut self.diagonals.0),
        )
    }
}

/// Sums `1/D`.
#[derive(Clone, Copy)]
pub struct DiagonalSum<'a> {
    walls: Walls<'a>,
    rest_density: f32,
    /// m and the kernel's factor.
    factor: f32,
    /// D below which the inverse is set to 0.
    least: f32,
}

/// Fraction of a full lattice's D below which pressure has no effect on a particle. The motion that removes an error
/// grows as 1/sqrt(D); two particles at the edge of each other's support have 4e-4.
const LEAST_DIAGONAL: f64 = 1e-3;

impl<'a> DiagonalSum<'a> {
    /// The sum for this fluid.
    pub fn new(material: &Material, walls: Walls<'a>) -> Self {
        let mass = f64::from(material.particle_mass);
        Self {
            walls,
            rest_density: material.rest_density,
            factor: material.particle_mass * material.kernel.slope_factor,
            least: (LEAST_DIAGONAL * mass * mass * lattice_diagonal(material)) as f32,
        }
    }
}

/// The sum of gradients and the sum of their squares.
pub struct GradientSums<S: Simd> {
    sum: [S::F; 3],
    squares: S::F,
    /// `Σ_b ρ0 V_b ∇W_ib` \[kg/m⁴].
    walls: Vec3,
}

impl PairSum for DiagonalSum<'_> {
    type Sums<S: Simd> = GradientSums<S>;
    type Output = f32;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, _: Vec4) -> GradientSums<S> {
        GradientSums {
            sum: [simd.splat(0.0); 3],
            squares: simd.splat(0.0),
            walls: self.rest_density * self.walls.gradient(i),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut GradientSums<S>) {
        accumulate(simd, &mut sums.sum, pair.slope, pair.x);
        let square = simd.mul(pair.slope, pair.slope);
        sums.squares = simd.mul_add(square, pair.distance, sums.squares);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: GradientSums<S>) -> f32 {
        let [x, y, z] = sums.sum;
        let sum = self.factor * Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z)) + sums.walls;
        let squares = self.factor * self.factor * simd.sum(sums.squares);
        let diagonal = sum.length_squared() + squares;
        if diagonal > self.least {
            1.0 / diagonal
        } else {
            0.0
        }
    }
}
