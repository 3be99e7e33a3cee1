//! Diagonal of the pressure system, `D_i = |Σ_j m ∇W_ij + Σ_b ρ0 V_b ∇W_ib|² + Σ_j |m ∇W_ij|²` (see
//! [`implicit`](super::implicit)), summed together with the density. With a [`Stabilisation`] κ the second sum counts
//! 1 − κ, and `2 κ ρ0 Σ_j m |W′_ij/r|` comes to it. It is IISPH's a_ii up to the factor −dt²/ρ², and
//! ρ/D is DFSPH's α. PCISPH uses it where it exceeds that of a full lattice.

use bevy_ecs::{prelude::*, system::SystemParam};
use glam::{Vec3, Vec4};
use rayon::iter::IndexedParallelIterator;

use super::stabilisation::Stabilisation;
use crate::{
    boundary::sums::{BoundarySums, Walls},
    density::DensitySum,
    pairs::{KernelGradients, Pair, PairSum, Pairs, accumulate, store, zip},
    simd::Simd,
    state::{Densities, Material},
};

/// `1/D` of every particle \[m⁸/kg²; m⁶/kg² in 2-D]; 0 if D is negligible.
#[derive(Resource, Debug, Default)]
pub struct InverseDiagonals(pub(crate) Vec<f32>);

/// `|Σ_j ∇W_ij|² + Σ_j |∇W_ij|²` of a particle in a full lattice, with a stabilisation κ that of its system.
pub(super) fn lattice_diagonal(material: &Material, stabilisation: Stabilisation) -> f64 {
    let kernel = &material.kernel;
    let lattice = || kernel.lattice(material.dimension, material.spacing);
    let gradients = || lattice().map(|x| kernel.gradient(x).as_dvec3());
    let sum: glam::DVec3 = gradients().sum();
    let squares: f64 = gradients().map(|gradient| gradient.length_squared()).sum();
    // ∇W = x W′/r.
    let slopes = gradients().zip(lattice()).map(|(gradient, x)| {
        let x = x.as_dvec3();
        match x.length_squared() {
            0.0 => 0.0,
            square => -gradient.dot(x) / square,
        }
    });
    let kappa = f64::from(stabilisation.0);
    let volume = f64::from(material.particle_mass / material.rest_density);
    sum.length_squared() + (1.0 - kappa) * squares + 2.0 * kappa / volume * slopes.sum::<f64>()
}

/// Densities and inverse diagonals (phase `Density`).
pub fn compute_density(
    mut columns: DensitiesAndDiagonals,
    mut grad_factors: Option<ResMut<KernelGradients>>,
    walls: Option<Res<BoundarySums>>,
    pairs: Pairs,
    material: Res<Material>,
    stabilisation: Res<Stabilisation>,
) {
    let walls = Walls::of(walls.as_deref());
    let sums = DensitiesAndDiagonals::sums(&material, walls, *stabilisation);
    let sinks = columns.sinks(pairs.positions().rows());
    pairs.sum_and_keep(&sums, grad_factors.as_deref_mut(), sinks);
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
        stabilisation: Stabilisation,
    ) -> (DensitySum<'a, false>, DiagonalSum<'a>) {
        (
            DensitySum::new(material, walls),
            DiagonalSum::new(material, walls, stabilisation),
        )
    }

    /// Writers of both columns, for `rows` rows.
    pub(super) fn sinks(
        &mut self,
        rows: usize,
    ) -> impl IndexedParallelIterator<Item = impl FnMut(usize, (f32, f32)) + Send> {
        self.densities.0.resize(rows, 0.0);
        self.diagonals.0.resize(rows, 0.0);
        zip(store(&mut self.densities.0), store(&mut self.diagonals.0))
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
    /// Factors of the sums of squares and of slopes.
    squares: f32,
    slopes: f32,
}

/// Fraction of a full lattice's D below which pressure has no effect on a particle. The motion that removes an error
/// grows as 1/sqrt(D); two particles at the edge of each other's support have 4e-4.
const LEAST_DIAGONAL: f64 = 1e-3;

impl<'a> DiagonalSum<'a> {
    /// The sum for this fluid.
    pub fn new(material: &Material, walls: Walls<'a>, stabilisation: Stabilisation) -> Self {
        let mass = f64::from(material.particle_mass);
        let diagonal = lattice_diagonal(material, stabilisation);
        let (factor, Stabilisation(kappa)) = (
            material.particle_mass * material.kernel.gradient_scale,
            stabilisation,
        );
        Self {
            walls,
            rest_density: material.rest_density,
            factor,
            least: (LEAST_DIAGONAL * mass * mass * diagonal) as f32,
            squares: (1.0 - kappa) * factor * factor,
            slopes: 2.0 * kappa * material.rest_density * factor,
        }
    }
}

/// The sum of gradients and the sum of their squares.
pub struct GradientSums<S: Simd> {
    sum: [S::F; 3],
    squares: S::F,
    slopes: S::F,
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
            slopes: simd.splat(0.0),
            walls: self.rest_density * self.walls.gradient(i),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut GradientSums<S>) {
        accumulate(simd, &mut sums.sum, pair.grad_factor, pair.x_ij);
        let square = simd.mul(pair.grad_factor, pair.grad_factor);
        sums.squares = simd.mul_add(square, pair.r2, sums.squares);
        sums.slopes = simd.sub(sums.slopes, pair.grad_factor);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: GradientSums<S>) -> f32 {
        let [x, y, z] = sums.sum;
        let sum = self.factor * Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z)) + sums.walls;
        let squares = self.squares * simd.sum(sums.squares);
        let diagonal = sum.length_squared() + squares + self.slopes * simd.sum(sums.slopes);
        if diagonal > self.least {
            1.0 / diagonal
        } else {
            0.0
        }
    }
}
