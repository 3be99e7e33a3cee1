//! δ-SPH: weakly compressible, with a density from the continuity equation and its diffusion (Antuono, Colagrossi,
//! Marrone & Molteni 2010, *Comput. Phys. Commun.* 181, 532).
//!
//! `Dρ_i/Dt = Σ_j m (v_i − v_j)·∇W_ij + δ h c D_i`, `p = c² (ρ − ρ0)`. The state carries p, which the equation of state
//! makes equivalent: `Dp/Dt = c² Dρ/Dt`. D_i is the sum of the [`stabilisation`] with κ dt = δ h/c, h half the support
//! radius: it takes from the difference of two densities the part that the pressure accelerations of both explain, as
//! the renormalised gradient of the paper does. Water at rest is left alone, also at walls and at a free surface.
//!
//! The step is the semi-implicit Euler scheme for v, x and p: p changes by the velocities at the end of the step. The
//! summed density (paper eq. 1) has no influence on the pressure; reports show its error.

use bevy_ecs::{prelude::*, schedule::InternedScheduleLabel};

use super::{
    density_rate::{DensityRates, PredictedVelocities, sum_rates},
    diagonal,
    force::pressure_force,
    implicit, initial,
    solver::{PressureSolver, Requirement},
    stabilisation::{Stabilisation, Stabilised},
};
use crate::{
    boundary::sums::BoundarySums,
    density,
    pairs::PairsWithGradients,
    scene::{DeltaSph, Scene},
    state::{
        Accelerations, Clock, Column, Corrected, Densities, Execution, Limit, Material, Positions,
        PressureAccelerations, Pressures, SolverState, Systems, Velocities,
    },
};

/// As in [`sesph`](super::sesph).
const SOUND_FACTOR: f32 = 0.4;

/// Relaxation and stabilisation of the solve for the initial pressure.
const RELAXATION: f32 = 0.4;
const INITIAL_STABILISATION: Stabilisation = Stabilisation(0.1);

static TEN: std::sync::LazyLock<u32> = std::sync::LazyLock::new(|| std::env::var("TEN").map_or(1, |m| m.parse().unwrap()));
/// Summed density below which fluid is spray, as a part of the rest density \[-]: at a flat surface there is 0.7 to
/// 0.8. Nothing would change the pressure that a particle in free flight carries, and it would push what it meets.
const SPRAY: f32 = 0.5;

/// Least density that a pressure corresponds to, as a part of the rest density \[-].
const LEAST_DENSITY: f32 = 0.5;

impl PressureSolver for DeltaSph {
    fn requirements(&self) -> Vec<Requirement> {
        vec![
            Requirement::Positive("pressure.sound_speed", self.sound_speed, "m/s"),
            Requirement::Diffusion(self.diffusion),
        ]
    }

    fn limits(&self, scene: &Scene) -> Vec<Limit> {
        let h = scene.support_radius();
        vec![("sound", SOUND_FACTOR * h / self.sound_speed)]
    }

    fn columns(&self) -> &'static [Column] {
        const {
            let [a, b, c, d] = *implicit::COLUMNS;
            &[a, b, c, d]
        }
    }

    fn install(&self, world: &mut World) {
        world.insert_resource(Continuity {
            sound_speed: self.sound_speed,
            diffusion: self.diffusion,
        });
        // Of the solve for the initial pressure.
        implicit::install(world, RELAXATION, true, 0, INITIAL_STABILISATION);
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

    fn solve(&self, _: &Scene) -> Systems {
        (put_terms, pressure_force, predict_rates, advance_pressures).chain()
    }

    fn schedules(&self, _: &Scene) -> Vec<(InternedScheduleLabel, Systems)> {
        Vec::new()
    }
}

/// The parameters in a step.
#[derive(Resource, Debug, Clone, Copy)]
pub struct Continuity {
    /// c \[m/s].
    sound_speed: f32,
    /// δ \[-].
    diffusion: f32,
}

impl Continuity {
    /// ρ at a pressure \[kg/m³].
    fn density(&self, pressure: f32, rest_density: f32) -> f32 {
        let change = pressure / (self.sound_speed * self.sound_speed);
        (rest_density + change).max(LEAST_DENSITY * rest_density)
    }

    /// Energy of compression or tension, `∫ p/ρ² dρ` \[J/kg], at a pressure \[Pa].
    pub(crate) fn energy(&self, pressure: f64, rest_density: f64) -> f64 {
        let square = f64::from(self.sound_speed).powi(2);
        let ratio = (1.0 + pressure / (square * rest_density)).max(LEAST_DENSITY.into());
        square * (ratio.ln() + 1.0 / ratio - 1.0)
    }

    /// δ h/c \[s].
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
    continuity: Res<Continuity>,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    let rest_density = material.rest_density;
    let (positions, pressures) = (&mut positions.0, &mut pressures.0);
    solve.begin(false, false);
    solve.update(positions, pressures, &execution, |row, _, pressure| {
        let rho = continuity.density(*pressure, rest_density);
        let error = densities.0[row] / rest_density - 1.0;
        Corrected {
            term: *pressure / (rho * rho),
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
    let accelerations = &accelerations.0;
    predicted.write(
        &velocities,
        &pressure_accelerations,
        &execution,
        |row, a_p| dt * accelerations[row] + (dt - time) * a_p,
    );
    let diffusion = Stabilised::over(time, &pressure_accelerations);
    sum_rates(rates, &predicted, walls, &pairs, &material, Some(diffusion));
}

/// Pressures at the end of the step.
fn advance_pressures(
    mut pressures: ResMut<Pressures>,
    rates: Res<DensityRates>,
    densities: Res<Densities>,
    continuity: Res<Continuity>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let factor = clock.dt * continuity.sound_speed * continuity.sound_speed;
    let spray = SPRAY * material.rest_density;
    execution.for_each_chunk(&mut pressures.0, |first, pressures| {
        let columns = rates.0[first..].iter().zip(&densities.0[first..]);
        for (pressure, (rate, rho)) in pressures.iter_mut().zip(columns) {
            let next = *pressure + factor * rate;
            *pressure = match *TEN {
                _ if *rho < spray => 0.0,
                0 => next.max(0.0),
                1 if *rho > material.rest_density => next.max(0.0),
                3 if *rho > 1.02 * material.rest_density => next.max(0.0),
                _ => next,
            };
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_is_the_integral_of_pressure() {
        let continuity = Continuity {
            sound_speed: 20.0,
            diffusion: 0.1,
        };
        for end in [950.0, 999.0, 1030.0, 1200.0_f64] {
            let steps = 4000;
            let d = (end - 1000.0) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|k| 1000.0 + (f64::from(k) + 0.5) * d)
                .map(|rho| 400.0 * (rho - 1000.0) / (rho * rho) * d)
                .sum();
            let pressure = 400.0 * (end - 1000.0);
            let energy = continuity.energy(pressure, 1000.0);
            assert!((energy - sum).abs() <= 1e-4 * sum, "{energy} {sum}");
            let density = f64::from(continuity.density(pressure as f32, 1000.0));
            assert!((density - end).abs() < 1e-3, "{density} {end}");
        }
    }
}
