//! Viscosity, laminar or artificial.
//!
//! Laminar: `a_i = 2 (d + 2) ν Σ_j m/ρ_ij (v_ij · x_ij)/(|x_ij|² + 0.01 h²) ∇W_ij`, ν the kinematic viscosity [m²/s]
//! (Monaghan 2005), with the mean density of the two, `ρ_ij = (ρ_i + ρ_j)/2`: with ρ_j alone, as often written, a free
//! blob drifts.
//!
//! Artificial: `a_i = −Σ_j m Π_ij ∇W_ij`, `Π_ij = −2 α h c/(ρ_i + ρ_j) · (v_ij · x_ij)/(|x_ij|² + 0.01 h²)` where the
//! particles approach, 0 elsewhere (Becker & Teschner 2007, eq. 10, with h the support radius as there).
//!
//! Neither acts between fluid and boundary: walls are free-slip.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::{
    column::{Accelerations, Densities, Velocities},
    material::Material,
    pairs::{Pair, PairSum, accumulate, broadcast, difference, dot},
    pressure::first_force::WithFirstForce,
    simd::Simd,
};

/// Kinematic viscosity ν [m²/s] of the scene.
#[derive(Resource, Debug, Clone, Copy)]
pub struct LaminarViscosity(pub f32);

/// Parameters of the artificial viscosity.
#[derive(Resource, Debug, Clone, Copy)]
pub struct ArtificialViscosity {
    /// α [-].
    pub alpha: f32,
    /// Speed of sound c [m/s].
    pub sound_speed: f32,
}

/// Adds laminar viscosity (phase `Forces`).
pub fn apply_laminar_viscosity(
    mut accelerations: ResMut<Accelerations>,
    mut velocities: ResMut<Velocities>,
    densities: Res<Densities>,
    viscosity: Res<LaminarViscosity>,
    material: Res<Material>,
    mut sums: WithFirstForce,
) {
    let d = f32::from(u8::from(material.dimension));
    let strength = 4.0 * (d + 2.0) * viscosity.0;
    apply_friction::<false>(
        &mut accelerations,
        &mut velocities,
        &densities,
        &material,
        &mut sums,
        strength,
    );
}

/// Adds artificial viscosity (phase `Forces`).
pub fn apply_artificial_viscosity(
    mut accelerations: ResMut<Accelerations>,
    mut velocities: ResMut<Velocities>,
    densities: Res<Densities>,
    viscosity: Res<ArtificialViscosity>,
    material: Res<Material>,
    mut sums: WithFirstForce,
) {
    let ArtificialViscosity { alpha, sound_speed } = *viscosity;
    let h = material.kernel.support_radius;
    let strength = 2.0 * alpha * h * sound_speed;
    apply_friction::<true>(
        &mut accelerations,
        &mut velocities,
        &densities,
        &material,
        &mut sums,
        strength,
    );
}

/// Adds `strength Σ_j m/(ρ_i + ρ_j) (v_ij · x_ij)/(|x_ij|² + 0.01 h²) ∇W_ij`, `strength` in m²/s; with `APPROACHING`
/// only of pairs that approach.
fn apply_friction<const APPROACHING: bool>(
    accelerations: &mut Accelerations,
    velocities: &mut Velocities,
    densities: &Densities,
    material: &Material,
    sums: &mut WithFirstForce,
    strength: f32,
) {
    let rows = densities.0.len();
    sums.pairs
        .execution
        .for_each_chunk(&mut velocities.0[..rows], |first, velocities| {
            for (velocity, rho) in velocities.iter_mut().zip(&densities.0[first..]) {
                velocity.w = *rho;
            }
        });
    let pass = Friction::<APPROACHING> {
        material,
        velocities: &velocities.0,
        factor: strength * material.particle_mass * material.kernel.slope_factor,
    };
    sums.add(pass, &mut accelerations.0);
}

/// The sum of both models. The fourth entry of a velocity is the density.
#[derive(Clone, Copy)]
struct Friction<'a, const APPROACHING: bool> {
    material: &'a Material,
    velocities: &'a [Vec4],
    factor: f32,
}

struct FrictionSums<S: Simd> {
    velocity: [S::F; 3],
    density: S::F,
    sum: [S::F; 3],
}

impl<const APPROACHING: bool> PairSum for Friction<'_, APPROACHING> {
    type Sums<S: Simd> = FrictionSums<S>;
    type Output = Vec3;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, _: Vec4) -> FrictionSums<S> {
        FrictionSums {
            velocity: broadcast(simd, self.velocities[i]),
            density: simd.splat(self.velocities[i].w),
            sum: [simd.splat(0.0); 3],
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut FrictionSums<S>) {
        let h = self.material.kernel.support_radius;
        let Pair {
            x, distance, slope, ..
        } = *pair;
        let (v, density) = difference(simd, sums.velocity, self.velocities, j);
        let mut approach = dot(simd, v, x);
        if APPROACHING {
            approach = simd.min(approach, simd.splat(0.0));
        }
        let damped = simd.add(distance, simd.splat(0.01 * h * h));
        let densities = simd.add(sums.density, density);
        let factor = simd.div(simd.mul(approach, slope), simd.mul(damped, densities));
        accumulate(simd, &mut sums.sum, factor, x);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: FrictionSums<S>) -> Vec3 {
        let [x, y, z] = sums.sum;
        self.factor * Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z))
    }
}
