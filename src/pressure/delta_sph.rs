//! δ-SPH: weakly compressible, with a pressure that follows from the motion and is diffused (Antuono et al. 2010,
//! *Comput. Phys. Commun.* 181, 532), on particles that are [shifted](super::shifting).
//!
//! `Dp_i/Dt = c² (Σ_j m (v_i − v_j)·∇W_ij + δ h/2 c D_i)`: the continuity equation with `p = c² (ρ − ρ0)`. D_i is the
//! sum of the [stabilisation](super::stabilisation) with κ Δt = δ h/2c, for the support radius h, which leaves water at
//! rest alone, also at walls and at a free surface. Away from the surface p returns slowly to that of the summed
//! density (paper eq. 1), so that the volume lasts.
//!
//! Deviation: every particle stands for the volume m/ρ0, as in a liquid; with m/ρ a lattice at rest under its weight
//! has a slope that is off by `2 g H/c²`. The step is the semi-implicit Euler scheme for v, x and p: p changes by the
//! velocities at the end of the step. `docs/decisions/delta_sph.md` has the figures.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{
    density_rate::{DensityRates, PredictedVelocities, sum_rates},
    diagonal,
    force::pressure_force,
    implicit, initial,
    shifting::{self, Shifting},
    solver::{PressureSolver, Requirement},
    stabilisation::{Stabilisation, Stabilised},
};
use crate::{
    boundary::sums::{BoundarySums, Walls},
    density,
    pairs::PairsWithGradients,
    scene::{DeltaSph, PressureMethod, Scene},
    state::{
        Accelerations, Clock, Column, Corrected, Densities, Displacements, Execution, Limit,
        Material, Positions, PressureAccelerations, Pressures, SolverState, Systems, Velocities,
    },
};

/// As in [`sesph`](super::sesph).
const SOUND_FACTOR: f32 = 0.4;

/// Relaxation and stabilisation of the solve for the initial pressure.
const RELAXATION: f32 = 0.4;
const INITIAL_STABILISATION: Stabilisation = Stabilisation(0.1);

/// Part of the difference between the pressure and that of the summed density that goes in the time that sound needs
/// for the support radius \[-].
///
/// Shifting spreads particles into what splashes enclose, and the continuity equation does not see it: after 3 s of a
/// dam break water stood half as high again. With it the volume is that of the implicit methods within 1 %, and the
/// noise of the summed density stays where diffusion smooths it.
const RETURN: f32 = 0.02;

/// Cosine of the angle to the vertical of a wall that water hangs from \[-].
const HANGING: f32 = 0.3;

impl PressureSolver for DeltaSph {
    fn requirements(&self) -> Vec<Requirement> {
        let speed = self.sound_speed;
        let speed = speed.map(|c| Requirement::Positive("pressure.sound_speed", c, "m/s"));
        let factors = [
            Requirement::Factor("pressure.diffusion", self.diffusion, 0.3),
            Requirement::Factor("pressure.shifting", self.shifting, 100.0),
            Requirement::Factor("pressure.tension", self.tension, 0.1),
        ];
        speed.into_iter().chain(factors).collect()
    }

    /// Between 2 and 2.6 spacings still water moves with up to 0.85 sqrt(g H), with less it is compressed by half.
    fn least_support(&self) -> f32 {
        2.6
    }

    fn limits(&self, scene: &Scene) -> Vec<Limit> {
        let h = scene.support_radius();
        vec![("sound", SOUND_FACTOR * h / self.sound_speed_in(scene))]
    }

    fn sound_speed(&self, scene: &Scene) -> Option<f32> {
        Some(self.sound_speed_in(scene))
    }

    fn with_tolerances_of(&self, _: &PressureMethod) -> PressureMethod {
        PressureMethod::DeltaSph(*self)
    }

    /// The initial pressure is solved for. Of the errors of the summed density that remain, pressures take up a part
    /// only, as diffusion smooths them within the time that sound needs for the support radius.
    fn energy_of_error(&self, scene: &Scene, error: f32) -> f64 {
        let speed = f64::from(RETURN * self.sound_speed_in(scene) * error);
        0.5 * speed * speed
    }

    fn columns(&self) -> &'static [Column] {
        const {
            let [a, b, c, d] = *implicit::COLUMNS;
            &[
                a,
                b,
                c,
                d,
                Column::derived("surroundings", "-", "gradients and normals", 60),
                Column::derived("displacement", "m", "by shifting", 12),
            ]
        }
    }

    fn install(&self, world: &mut World, scene: &Scene) {
        let continuity = Continuity {
            sound_speed: self.sound_speed_in(scene),
            diffusion: self.diffusion,
            tension: self.tension,
        };
        world.insert_resource(continuity);
        world.insert_resource(Shifting::new(self.shifting, scene));
        world.insert_resource(Displacements::empty());
        // Of the solve for the initial pressure.
        implicit::install(world, RELAXATION, true, 0, INITIAL_STABILISATION);
        let rest_density = scene.fluid.rest_density;
        let tension = self.tension * continuity.stiffness(rest_density);
        world.resource_mut::<implicit::Jacobi>().least = -tension / (rest_density * rest_density);
    }

    fn density(&self) -> Systems {
        (
            diagonal::compute_density.run_if(initial::is_first_step),
            density::compute_density.run_if(not(initial::is_first_step)),
        )
            .chain()
    }

    fn solves_initial_pressure(&self) -> bool {
        true
    }

    fn solve(&self, scene: &Scene) -> Systems {
        let shift = if scene.boundaries.is_empty() {
            shifting::shift.into_configs()
        } else {
            (shifting::shift, shifting::keep_off_walls).chain()
        };
        (
            put_terms,
            pressure_force,
            shifting::look_around,
            shifting::ease_tension,
            shift,
            predict_rates,
            advance_pressures,
        )
            .chain()
    }
}

/// The parameters in a step.
#[derive(Resource, Debug, Clone, Copy)]
pub struct Continuity {
    /// c \[m/s].
    sound_speed: f32,
    /// δ \[-].
    diffusion: f32,
    /// Largest tension over ρ0 c² \[-].
    tension: f32,
}

impl Continuity {
    /// ρ0 c² \[Pa].
    fn stiffness(&self, rest_density: f32) -> f32 {
        rest_density * self.sound_speed * self.sound_speed
    }

    /// Energy of compression or tension, `p²/(2 ρ0² c²)` \[J/kg], at a pressure \[Pa].
    pub(crate) fn energy(&self, pressure: f64, rest_density: f64) -> f64 {
        let speed = pressure / (rest_density * f64::from(self.sound_speed));
        0.5 * speed * speed
    }

    /// δ h/2c \[s].
    fn diffusion_time(&self, material: &Material) -> f32 {
        self.diffusion * 0.5 * material.kernel.support_radius / self.sound_speed
    }
}

/// The pressure terms of the pressures that the last step left, and the errors of the summed densities.
fn put_terms(
    mut positions: ResMut<Positions>,
    mut pressures: ResMut<Pressures>,
    mut solve: ResMut<SolverState>,
    densities: Res<Densities>,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    let rest_density = material.rest_density;
    let (positions, pressures) = (&mut positions.0, &mut pressures.0);
    solve.begin(false, false);
    solve.update(positions, pressures, &execution, |row, _, pressure| {
        let error = densities.0[row] / rest_density - 1.0;
        Corrected {
            term: *pressure / (rest_density * rest_density),
            error,
            excess: error,
            progress: 0.0,
        }
    });
}

/// Dρ/Dt of the velocities at the end of the step, with diffusion.
fn predict_rates(
    rates: ResMut<DensityRates>,
    mut predicted: ResMut<PredictedVelocities>,
    velocities: Res<Velocities>,
    (accelerations, pressure_accelerations): (Res<Accelerations>, Res<PressureAccelerations>),
    walls: Option<Res<BoundarySums>>,
    pairs: PairsWithGradients,
    continuity: Res<Continuity>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (dt, time) = (clock.dt, continuity.diffusion_time(&material));
    let change = |row: usize, a_p: Vec3| dt * accelerations.0[row] + (dt - time) * a_p;
    predicted.write(&velocities, &pressure_accelerations, &execution, change);
    let diffusion = Stabilised::over(time, &pressure_accelerations);
    sum_rates(rates, &predicted, walls, &pairs, &material, Some(diffusion));
}

/// Pressures at the end of the step. Those of spray would push what it meets, and nothing would change them. Particles
/// that are crowded do not pull: tension would crowd them more. Neither do those under a lid: water falls from it.
fn advance_pressures(
    mut pressures: ResMut<Pressures>,
    (rates, densities): (Res<DensityRates>, Res<Densities>),
    (shifting, walls): (Res<Shifting>, Option<Res<BoundarySums>>),
    continuity: Res<Continuity>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let walls = Walls::of(walls.as_deref());
    let hangs = |row: usize| {
        let inwards = walls.gradient(row);
        inwards.dot(material.gravity) < -HANGING * inwards.length() * material.gravity.length()
    };
    let rest_density = material.rest_density;
    let square = continuity.sound_speed * continuity.sound_speed;
    let per_second = RETURN * continuity.sound_speed / material.kernel.support_radius;
    let least = -continuity.tension * continuity.stiffness(rest_density);
    execution.for_each_chunk(&mut pressures.0, |first, pressures| {
        for (row, pressure) in (first..).zip(pressures) {
            let rho = densities.0[row];
            if rho < shifting::SPRAY * rest_density {
                *pressure = 0.0;
                continue;
            }
            let mut rate = rates.0[row];
            if shifting.is_inside(row) {
                rate += per_second * (rho - rest_density - *pressure / square);
            }
            let least = if rho > rest_density || hangs(row) {
                0.0
            } else {
                least
            };
            *pressure = (*pressure + clock.dt * square * rate).max(least);
        }
    });
}
