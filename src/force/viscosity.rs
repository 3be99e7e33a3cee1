//! Viscosity, laminar or artificial. Neither acts between fluid and boundary: walls are free-slip, unless their `slip`
//! adds [`friction`](crate::boundary::friction).
//!
//! Laminar: `a_i = 2 (d + 2) ν Σ_j m/ρ_ij (v_ij · x_ij)/(|x_ij|² + 0.01 h²) ∇W_ij`, ν the kinematic viscosity \[m²/s]
//! (Monaghan 2005), with the mean density of the pair, `ρ_ij = (ρ_i + ρ_j)/2`: with ρ_j alone, as often published, a
//! free blob drifts. ν is divided by what a sheared lattice shows of it, 0.7 with the default kernels, so that flows
//! between plates have the nominal one. With it acts [`NumericalViscosity`].
//!
//! Artificial: `a_i = −Σ_j m Π_ij ∇W_ij`, `Π_ij = −2 α h c/(ρ_i + ρ_j) · (v_ij · x_ij)/(|x_ij|² + 0.01 h²)` if the
//! particles approach, 0 otherwise (Becker & Teschner 2007, eq. 10, with h the support radius as there).

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::{
    boundary::friction,
    kernel::Kernel,
    lattice::Lattice,
    pairs::{Pair, PairSum, accumulate, broadcast, difference, dot},
    pressure::{
        first_force::{self, FirstForce, WithFirstForce},
        warm_start::{self, WarmStart},
    },
    scene::{Scene, Viscosity},
    simd::Simd,
    state::{
        Accelerations, Densities, Execution, Limit, Material, MeanPressures, Phase, Positions,
        Pressures, Product, Stage, Systems, Velocities,
    },
};

/// Part of h²/ν that a step may take \[-]: 1/8 of the square of the smoothing length h/2 (Morris et al. 1997, eq. 23).
const LIMIT_FACTOR: f32 = 1.0 / 32.0;

/// Part of the longest step in which a lattice is stable under its viscosity \[-]: disorder raises what it needs.
/// Kernels that are narrow within their support, as Wendland's C4, would not be stable at the limit above.
const LATTICE_LIMIT_FACTOR: f32 = 0.8;

/// Viscosity.
pub(crate) const STAGE: Stage = Stage {
    needs: &[
        Product::Columns,
        Product::Index,
        Product::Neighbours,
        Product::Density,
        Product::Divergence,
        Product::Forces,
    ],
    has_own_kernel: true,
    wanted: |scene| scene.fluid.viscosity != Viscosity::None,
    install,
    limits,
    ..Stage::new("viscosity", Phase::Forces, systems)
};

/// Inserts the parameters of a scene's viscosity.
pub(crate) fn install(world: &mut World, scene: &Scene) {
    match scene.fluid.viscosity {
        Viscosity::None => {}
        Viscosity::Laminar {
            kinematic_viscosity,
            ..
        } => {
            let lattice = Lattice::of(scene).shear_viscosity() as f32;
            world.insert_resource(LaminarViscosity(kinematic_viscosity / lattice));
            let numerical = scene.numerical_viscosity();
            if numerical > 0.0 {
                world.insert_resource(NumericalViscosity(numerical));
            }
        }
        Viscosity::Artificial { alpha, sound_speed } => {
            world.insert_resource(ArtificialViscosity { alpha, sound_speed });
        }
    }
}

fn systems(scene: &Scene) -> Systems {
    let viscosity = match scene.fluid.viscosity {
        Viscosity::Artificial { .. } => apply_artificial_viscosity.into_configs(),
        Viscosity::Laminar { .. } if scene.numerical_viscosity() > 0.0 => {
            let terms = put_pressure_terms
                .run_if(not(resource_exists::<FirstForce>))
                .ambiguous_with_all();
            (terms, apply_laminar_viscosity).chain()
        }
        Viscosity::Laminar { .. } | Viscosity::None => apply_laminar_viscosity.into_configs(),
    };
    let viscosity = if first_force::is_possible(scene) {
        (first_force::start(), viscosity).chain()
    } else {
        viscosity
    };
    if friction::is_wanted(scene) {
        (viscosity, friction::apply_wall_friction).chain()
    } else {
        viscosity
    }
}

fn limits(scene: &Scene) -> Vec<Limit> {
    let h = scene.support_radius();
    let viscosity = match scene.fluid.viscosity {
        Viscosity::None => 0.0,
        Viscosity::Laminar {
            kinematic_viscosity,
            ..
        } => kinematic_viscosity,
        // The kinematic viscosity that it amounts to in 3-D (Monaghan 2005, eq. 8.8), with its smoothing length h.
        Viscosity::Artificial { alpha, sound_speed } => alpha * h * sound_speed / 10.0,
    };
    let limit = (viscosity > 0.0).then(|| {
        let lattice = Lattice::of(scene);
        let part = match scene.fluid.viscosity {
            Viscosity::Laminar { .. } => lattice.shear_viscosity(),
            Viscosity::None | Viscosity::Artificial { .. } => 1.0,
        };
        let of_lattice = LATTICE_LIMIT_FACTOR * (part * lattice.viscous_step()) as f32;
        let longest = (LIMIT_FACTOR * h * h).min(of_lattice * scene.spacing * scene.spacing);
        ("viscosity", longest / viscosity)
    });
    limit.into_iter().collect()
}

/// Kinematic viscosity ν of the scene, over the part of it that a sheared lattice shows
/// ([`Lattice::shear_viscosity`]) \[m²/s].
#[derive(Resource, Debug, Clone, Copy)]
pub struct LaminarViscosity(pub(crate) f32);

/// Parameters of the artificial viscosity.
#[derive(Resource, Debug, Clone, Copy)]
pub struct ArtificialViscosity {
    /// α \[-].
    pub(crate) alpha: f32,
    /// Speed of sound c \[m/s].
    pub(crate) sound_speed: f32,
}

/// α of the numerical viscosity \[-], which acts beside the laminar one; in scenes that have it.
///
/// It is an artificial viscosity of every pair with `c = sqrt(p/ρ)`, p the mean of the two pressures of the last step.
/// Waves of a lattice under pressure have that speed, and with it a square lattice melts into a denser one. Since the
/// speed follows pressure, both are damped in the same number of steps at every depth and spacing.
#[derive(Resource, Debug, Clone, Copy)]
pub struct NumericalViscosity(pub(crate) f32);

/// Puts the pressure terms from which the solve will start beside the positions, where the first pressure force has not
/// (phase `Forces`): the sums are the same to the bit, whether that force is summed beside viscosity or not.
pub fn put_pressure_terms(
    mut positions: ResMut<Positions>,
    densities: Res<Densities>,
    pressures: Res<Pressures>,
    means: Option<Res<MeanPressures>>,
    start: Option<Res<WarmStart>>,
    execution: Res<Execution>,
) {
    let start = start.as_deref();
    let means = means.filter(|_| start.is_some_and(|start| start.share > 0.0));
    warm_start::put_terms(
        &mut positions,
        warm_start::share_of_terms(start),
        (&densities, &pressures),
        means.as_deref(),
        &execution,
    );
}

/// Adds laminar and numerical viscosity (phase `Forces`).
pub fn apply_laminar_viscosity(
    mut accelerations: ResMut<Accelerations>,
    mut velocities: ResMut<Velocities>,
    densities: Res<Densities>,
    viscosity: Res<LaminarViscosity>,
    numerical: Option<Res<NumericalViscosity>>,
    material: Res<Material>,
    mut sums: WithFirstForce,
) {
    let d = f32::from(u8::from(material.dimension));
    let strength = 4.0 * (d + 2.0) * viscosity.0 * sums.pairs.viscosity_share();
    let columns = (&mut *accelerations, &mut *velocities, &*densities);
    match numerical {
        None => apply_friction::<false, false>(columns, &material, &mut sums, (strength, 0.0)),
        Some(alpha) => {
            let h = sums.pairs.kernel().support_radius;
            // c² is ρ0/2 times the sum of two terms p/ρ².
            let half = 0.5 * material.rest_density / sums.share_of_terms();
            let strengths = (strength, 2.0 * alpha.0 * h * half.sqrt());
            apply_friction::<false, true>(columns, &material, &mut sums, strengths);
        }
    }
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
    let h = sums.pairs.kernel().support_radius;
    let strength = 2.0 * alpha * h * sound_speed;
    let columns = (&mut *accelerations, &mut *velocities, &*densities);
    apply_friction::<true, false>(columns, &material, &mut sums, (strength, 0.0));
}

/// Adds `s Σ_j m/(ρ_i + ρ_j) (v_ij · x_ij)/(|x_ij|² + 0.01 h²) ∇W_ij`. The first strength is s in m²/s, with
/// `APPROACHING` only of pairs that approach; with `NUMERICAL` the second times the root of a pair's two terms comes to
/// it.
fn apply_friction<const APPROACHING: bool, const NUMERICAL: bool>(
    (accelerations, velocities, densities): (&mut Accelerations, &mut Velocities, &Densities),
    material: &Material,
    sums: &mut WithFirstForce,
    (strength, numerical): (f32, f32),
) {
    let rows = densities.0.len();
    sums.pairs
        .execution
        .for_each_chunk(&mut velocities.0[..rows], |first, velocities| {
            for (velocity, rho) in velocities.iter_mut().zip(&densities.0[first..]) {
                velocity.w = *rho;
            }
        });
    let kernel = *sums.pairs.kernel();
    let pass = Friction::<APPROACHING, NUMERICAL> {
        kernel: &kernel,
        particle_mass: material.particle_mass,
        velocities: &velocities.0,
        strength,
        numerical,
    };
    sums.add(pass, &mut accelerations.0);
}

/// The sum of both models. The fourth entry of a velocity is the density.
#[derive(Clone, Copy)]
struct Friction<'a, const APPROACHING: bool, const NUMERICAL: bool> {
    kernel: &'a Kernel,
    particle_mass: f32,
    velocities: &'a [Vec4],
    strength: f32,
    numerical: f32,
}

struct FrictionSums<S: Simd> {
    velocity: [S::F; 3],
    density: S::F,
    term: S::F,
    sum: [S::F; 3],
}

impl<const APPROACHING: bool, const NUMERICAL: bool> PairSum
    for Friction<'_, APPROACHING, NUMERICAL>
{
    type Sums<S: Simd> = FrictionSums<S>;
    type Output = Vec3;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, own: Vec4) -> FrictionSums<S> {
        FrictionSums {
            velocity: broadcast(simd, self.velocities[i]),
            density: simd.splat(self.velocities[i].w),
            term: simd.splat(own.w),
            sum: [simd.splat(0.0); 3],
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut FrictionSums<S>) {
        let h = self.kernel.support_radius;
        let Pair {
            x_ij,
            r2,
            grad_factor,
            ..
        } = *pair;
        let (v, density) = difference(simd, sums.velocity, self.velocities, j);
        let mut approach = dot(simd, v, x_ij);
        if APPROACHING {
            approach = simd.min(approach, simd.splat(0.0));
        }
        let mut strength = simd.splat(self.strength);
        if NUMERICAL {
            let terms = simd.add(sums.term, pair.packed_j);
            let speed = simd.sqrt(simd.max(terms, simd.splat(0.0)));
            strength = simd.mul_add(simd.splat(self.numerical), speed, strength);
        }
        let approach = simd.mul(strength, approach);
        let damped = simd.add(r2, simd.splat(0.01 * h * h));
        let densities = simd.add(sums.density, density);
        let factor = simd.div(simd.mul(approach, grad_factor), simd.mul(damped, densities));
        accumulate(simd, &mut sums.sum, factor, x_ij);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: FrictionSums<S>) -> Vec3 {
        let [x, y, z] = sums.sum;
        let factor = self.particle_mass * self.kernel.gradient_scale;
        factor * Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z))
    }
}
