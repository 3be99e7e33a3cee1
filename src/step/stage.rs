//! The stages of a step: one line each with its name, what it needs, what it makes, and its systems.

use bevy_ecs::{prelude::*, schedule::ScheduleConfigs, system::ScheduleSystem};

use super::order::OrderError;
use crate::{
    boundary::{contact, direct_forcing, sums},
    density, force, gauge, index, integrate, neighbours,
    pressure::{self, first_force, initial, recovery, warm_start},
    reorder,
    scene::{Neighbours, PressureMethod, Scene, SurfaceTension, TimeStep, Viscosity},
    state::transfer,
    state::{Phase, clock, failure::healthy},
    time_step::{self, adaptive, roll_back},
};

/// Something that a stage makes and others need.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Datum {
    /// Columns and spatial index.
    Index,
    /// Neighbour lists.
    Neighbours,
    /// Densities.
    Density,
    /// Velocities without compression.
    Divergence,
    /// Accelerations by all forces but pressure.
    Forces,
    /// Accelerations by pressure.
    Pressure,
}

/// A stage that an order may name.
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// The phase that its time is booked to.
    pub phase: Phase,
    /// What must be current before it.
    pub needs: &'static [Datum],
    /// What is current after it.
    pub makes: &'static [Datum],
    /// Whether it moves particles or rows, so that nothing made before is current.
    pub spoils_all: bool,
    /// Whether a scene has a use for it.
    pub wanted: fn(&Scene) -> bool,
    /// Its systems.
    pub systems: fn(&Scene) -> ScheduleConfigs<ScheduleSystem>,
}

use Datum::{Density, Divergence, Forces, Index, Neighbours as Lists, Pressure};

impl Stage {
    /// Every stage.
    pub const ALL: &[Self] = &[
        Self {
            name: "rebuild_index",
            phase: Phase::RebuildIndex,
            needs: &[],
            makes: &[Index],
            spoils_all: false,
            wanted: |_| true,
            systems: |scene| {
                let gather = (transfer::check_components, transfer::gather_columns).chain();
                let gather = if warm_start::starts_from_means(scene) {
                    (gather, warm_start::gather_mean_pressures).chain()
                } else {
                    gather
                };
                (gather, index::update_index).chain()
            },
        },
        Self {
            name: "find_neighbours",
            phase: Phase::FindNeighbours,
            needs: &[Index],
            makes: &[Lists],
            spoils_all: false,
            wanted: |scene| scene.neighbours == Neighbours::Stored,
            systems: |scene| {
                if scene.boundaries.is_empty() {
                    neighbours::find_fluid_neighbours.into_configs()
                } else {
                    (
                        neighbours::find_fluid_neighbours,
                        neighbours::find_boundary_neighbours,
                    )
                        .chain()
                }
            },
        },
        Self {
            name: "density",
            phase: Phase::Density,
            needs: &[Index, Lists],
            makes: &[Density],
            spoils_all: false,
            wanted: |_| true,
            systems: |scene| {
                let density = match scene.pressure {
                    PressureMethod::Sesph(_) => density::compute_density.into_configs(),
                    PressureMethod::Pcisph(_) | PressureMethod::Iisph(_) => {
                        pressure::response::compute_density.into_configs()
                    }
                    PressureMethod::Dfsph(_) => pressure::dfsph::compute_density.into_configs(),
                };
                if scene.boundaries.is_empty() {
                    density
                } else {
                    (sums::sum_walls, density).chain()
                }
            },
        },
        Self {
            name: "divergence",
            phase: Phase::Forces,
            needs: &[Index, Lists, Density],
            makes: &[Divergence],
            spoils_all: false,
            wanted: |scene| matches!(scene.pressure, PressureMethod::Dfsph(_)),
            systems: |_| pressure::dfsph::solve_divergence.into_configs(),
        },
        Self {
            name: "gravity",
            phase: Phase::Forces,
            needs: &[Index],
            makes: &[Forces],
            spoils_all: false,
            wanted: |_| true,
            systems: |_| force::apply_gravity.into_configs(),
        },
        Self {
            name: "viscosity",
            phase: Phase::Forces,
            needs: &[Index, Lists, Density, Divergence, Forces],
            makes: &[],
            spoils_all: false,
            wanted: |scene| scene.fluid.viscosity != Viscosity::None,
            systems: |scene| {
                let viscosity = match scene.fluid.viscosity {
                    Viscosity::Artificial { .. } => {
                        force::apply_artificial_viscosity.into_configs()
                    }
                    Viscosity::Laminar { .. } | Viscosity::None => {
                        force::apply_laminar_viscosity.into_configs()
                    }
                };
                let numerical = matches!(
                    scene.fluid.viscosity,
                    Viscosity::Laminar { numerical, .. } if numerical > 0.0
                );
                let viscosity = if numerical {
                    let terms = force::put_pressure_terms
                        .run_if(not(resource_exists::<first_force::FirstForce>))
                        .ambiguous_with_all();
                    (terms, viscosity).chain()
                } else {
                    viscosity
                };
                if first_force::is_possible(scene) {
                    (first_force::start(), viscosity).chain()
                } else {
                    viscosity
                }
            },
        },
        Self {
            name: "surface_tension",
            phase: Phase::Forces,
            needs: &[Index, Lists, Forces],
            makes: &[],
            spoils_all: false,
            wanted: |scene| scene.fluid.surface_tension != SurfaceTension::None,
            systems: |_| force::apply_surface_tension.into_configs(),
        },
        Self {
            name: "pressure",
            phase: Phase::Pressure,
            needs: &[Index, Lists, Density, Divergence, Forces],
            makes: &[Pressure],
            spoils_all: false,
            wanted: |_| true,
            systems: |scene| {
                let method = match scene.pressure {
                    PressureMethod::Sesph(_) => {
                        let method = (
                            pressure::state_equation::compute_pressure,
                            pressure::pressure_force,
                        )
                            .chain();
                        if scene.boundaries.is_empty() {
                            method
                        } else {
                            (method, pressure::fluid_share::weigh_pressures).chain()
                        }
                    }
                    PressureMethod::Pcisph(_) => (
                        pressure::solve::solve_pressure,
                        pressure::implicit::take_pressures,
                    )
                        .chain(),
                    PressureMethod::Iisph(_) => (
                        pressure::solve::solve_pressure,
                        pressure::implicit::take_pressures,
                    )
                        .chain(),
                    PressureMethod::Dfsph(_) => (
                        pressure::solve::solve_pressure,
                        pressure::implicit::take_pressures,
                        pressure::dfsph::add_divergence_pressure,
                    )
                        .chain(),
                };
                let method = if initial::is_solved_for(scene) {
                    let first = initial::solve_initial_pressure.run_if(initial::is_first_step);
                    (first, method).chain()
                } else {
                    method
                };
                if warm_start::starts_from_means(scene) {
                    (method, warm_start::average_pressures).chain()
                } else {
                    method
                }
            },
        },
        Self {
            name: "integrate",
            phase: Phase::Integrate,
            needs: &[Index, Lists, Density, Forces, Pressure],
            makes: &[],
            spoils_all: true,
            wanted: |_| true,
            systems: |scene| {
                let guard = (transfer::check_rows, integrate::guard).chain();
                let scatter = transfer::scatter_columns.into_configs();
                let scatter = if warm_start::starts_from_means(scene) {
                    (scatter, warm_start::scatter_mean_pressures).chain()
                } else {
                    scatter
                };
                let accept = (scatter, clock::advance_clock).chain();
                let recovers = recovery::share(&scene.pressure).is_some_and(|share| share < 1.0);
                let accept = if recovers {
                    (accept, recovery::choose_recovery_time).chain()
                } else {
                    accept
                };
                let (guard, accept) = match scene.time_step {
                    TimeStep::Fixed(_) => (guard, accept),
                    TimeStep::Cfl(_) => (guard, (accept, time_step::choose_time_step).chain()),
                    TimeStep::Adaptive(_) => (
                        (guard, adaptive::detect_shock.run_if(healthy)).chain(),
                        (
                            roll_back::keep_state,
                            accept,
                            adaptive::choose_adaptive_time_step,
                        )
                            .chain(),
                    ),
                };
                let guard = (guard, accept.run_if(healthy)).chain();
                let integrated = if gauge::measures_forces(scene) {
                    (integrate::integrate, gauge::keep_velocities).chain()
                } else {
                    integrate::integrate.into_configs()
                };
                let moved = if scene.boundaries.is_empty() {
                    integrated
                } else if scene.forces_directly() {
                    let corrected = (direct_forcing::correct_motion, contact::keep_outside);
                    (integrated, corrected.chain()).chain()
                } else {
                    (integrated, contact::keep_outside).chain()
                };
                (moved, integrate::measure, guard).chain()
            },
        },
        Self {
            name: "reorder",
            phase: Phase::Reorder,
            needs: &[],
            makes: &[],
            spoils_all: true,
            wanted: |scene| scene.reorder_interval > 0,
            systems: |_| reorder::reorder.run_if(reorder::reorder_is_due),
        },
    ];

    /// The stage of a name.
    pub fn find(name: &str) -> Result<&'static Self, OrderError> {
        Self::ALL
            .iter()
            .find(|stage| stage.name == name)
            .ok_or_else(|| OrderError::UnknownStage {
                name: name.to_owned(),
            })
    }
}
