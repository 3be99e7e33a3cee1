//! SESPH (paper 5.1, Algorithm 1): pressure from an equation of state.
//!
//! Tait, `p = k ((ρ/ρ0)^7 − 1)` (eq. 4), or gas, `p = k (ρ − ρ0)` (eq. 5). Deviation: negative pressures, which arise
//! where a particle has few neighbours, are set to zero, because they would make a free surface clump.

use bevy_ecs::prelude::*;

use super::{
    force::pressure_force,
    solver::{PressureSolver, Requirement},
    wall_renormalisation,
};
use crate::{
    density,
    lattice::BesideWall,
    scene::{PressureMethod, Scene, Sesph, StateEquation},
    state::{
        Column, Corrected, Densities, Execution, Limit, Material, Positions, Pressures,
        SolverState, Systems,
    },
};

/// Maximum time step in units of the time that sound needs for the support radius \[-] (Becker & Teschner 2007, eq.
/// 18).
const SOUND_FACTOR: f32 = 0.4;

impl PressureSolver for Sesph {
    fn requirements(&self) -> Vec<Requirement> {
        let (stiffness, unit) = match self.equation {
            StateEquation::Tait { stiffness } => (stiffness, "Pa"),
            StateEquation::Gas { stiffness } => (stiffness, "m²/s²"),
        };
        vec![Requirement::Positive(
            "pressure.equation.stiffness",
            stiffness,
            unit,
        )]
    }

    fn limits(&self, scene: &Scene) -> Vec<Limit> {
        let sound_speed = EquationOfState(self.equation).sound_speed(scene.fluid.rest_density);
        vec![("sound", SOUND_FACTOR * scene.support_radius() / sound_speed)]
    }

    fn sound_speed(&self, scene: &Scene) -> Option<f32> {
        Some(EquationOfState(self.equation).sound_speed(scene.fluid.rest_density))
    }

    /// An equation of state stores energy in the density, and the force must be the gradient of this energy: the
    /// push of the samples stays uncorrected.
    fn beside_wall(&self, _: &Scene) -> BesideWall {
        BesideWall {
            push: 1.0,
            slide: 0.0,
        }
    }

    fn with_tolerances_of(&self, _: &PressureMethod) -> PressureMethod {
        PressureMethod::Sesph(*self)
    }

    fn energy_of_error(&self, scene: &Scene, error: f32) -> f64 {
        let rest_density = f64::from(scene.fluid.rest_density);
        let density = rest_density * (1.0 + f64::from(error));
        EquationOfState(self.equation).energy(density, rest_density)
    }

    fn columns(&self) -> &'static [Column] {
        &[]
    }

    fn install(&self, world: &mut World, _: &Scene) {
        world.insert_resource(EquationOfState(self.equation));
    }

    fn density(&self) -> Systems {
        density::compute_density.into_configs()
    }

    fn solve(&self, scene: &Scene) -> Systems {
        let method = (compute_pressure, pressure_force).chain();
        if scene.boundaries.is_empty() {
            method
        } else {
            (method, wall_renormalisation::weigh_pressures).chain()
        }
    }
}

/// The scene's equation of state.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct EquationOfState(pub(crate) StateEquation);

impl EquationOfState {
    /// Pressure \[Pa] at a density \[kg/m³], not below zero.
    #[inline]
    pub fn pressure(&self, density: f32, rest_density: f32) -> f32 {
        match self.0 {
            StateEquation::Tait { stiffness } => {
                let ratio = density / rest_density;
                let cube = ratio * ratio * ratio;
                stiffness * (cube * cube * ratio - 1.0)
            }
            StateEquation::Gas { stiffness } => stiffness * (density - rest_density),
        }
        .max(0.0)
    }

    /// Energy of compression from rest, `∫ p/ρ² dρ` \[J/kg], at a density \[kg/m³].
    pub fn energy(&self, density: f64, rest_density: f64) -> f64 {
        let ratio = density / rest_density;
        if ratio <= 1.0 {
            return 0.0;
        }
        match self.0 {
            StateEquation::Tait { stiffness } => {
                let work = ratio.powi(6) / 6.0 + 1.0 / ratio - 7.0 / 6.0;
                f64::from(stiffness) / rest_density * work
            }
            StateEquation::Gas { stiffness } => {
                f64::from(stiffness) * (ratio.ln() + 1.0 / ratio - 1.0)
            }
        }
    }

    /// Speed of sound at rest `sqrt(dp/dρ)` \[m/s].
    pub fn sound_speed(&self, rest_density: f32) -> f32 {
        match self.0 {
            StateEquation::Tait { stiffness } => (7.0 * stiffness / rest_density).sqrt(),
            StateEquation::Gas { stiffness } => stiffness.sqrt(),
        }
    }
}

/// Pressures and pressure terms from the densities (phase `Pressure`).
pub fn compute_pressure(
    mut pressures: ResMut<Pressures>,
    mut positions: ResMut<Positions>,
    mut solve: ResMut<SolverState>,
    densities: Res<Densities>,
    equation: Res<EquationOfState>,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    let rest_density = material.rest_density;
    solve.update(
        &mut positions.0,
        &mut pressures.0,
        &execution,
        |row, _, pressure| {
            let rho = densities.0[row];
            *pressure = equation.pressure(rho, rest_density);
            Corrected {
                term: *pressure / (rho * rho),
                error: rho / rest_density - 1.0,
                excess: rho / rest_density - 1.0,
                progress: 0.0,
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_is_the_integral_of_pressure() {
        for equation in [
            StateEquation::Tait { stiffness: 1000.0 },
            StateEquation::Gas { stiffness: 50.0 },
        ] {
            let equation = EquationOfState(equation);
            for end in [950.0, 1001.0, 1030.0, 1200.0_f64] {
                let steps = 4000;
                let d = (end - 1000.0).max(0.0) / f64::from(steps);
                let sum: f64 = (0..steps)
                    .map(|k| 1000.0 + (f64::from(k) + 0.5) * d)
                    .map(|rho| f64::from(equation.pressure(rho as f32, 1000.0)) / (rho * rho) * d)
                    .sum();
                let energy = equation.energy(end, 1000.0);
                assert!((energy - sum).abs() <= 2e-3 * sum, "{energy} {sum}");
            }
        }
    }

    #[test]
    fn equations_give_the_published_pressures() {
        let tait = EquationOfState(StateEquation::Tait { stiffness: 1000.0 });
        assert!(
            (tait.pressure(1010.0, 1000.0) / (1000.0 * (1.01f32.powi(7) - 1.0)) - 1.0).abs() < 1e-3
        );
        let gas = EquationOfState(StateEquation::Gas { stiffness: 50.0 });
        assert_eq!(gas.pressure(1010.0, 1000.0), 500.0);
        for equation in [tait, gas] {
            assert_eq!(equation.pressure(1000.0, 1000.0), 0.0);
            assert_eq!(equation.pressure(900.0, 1000.0), 0.0, "no tension");
        }
    }
}
