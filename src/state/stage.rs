//! What a stage of a step is: its name, what it needs and makes, its systems, and what a scene needs for it.

use std::fmt;

use bevy_ecs::{
    prelude::*,
    schedule::{Chain, InternedScheduleLabel, ScheduleConfigs},
    system::ScheduleSystem,
};

use super::phase::Phase;
use crate::scene::Scene;

/// Systems of a schedule, with their order.
pub type Systems = ScheduleConfigs<ScheduleSystem>;

/// A limit on the time step by its name \[s].
pub type Limit = (&'static str, f32);

/// Part of the period of a wall or a force that a step may last \[-]: a sine in 20 straight pieces is 1.2 % off at
/// most.
pub(crate) const PART_OF_PERIOD: f32 = 0.05;

/// Something that a stage makes and others need.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Product {
    /// Columns of the particles' state.
    Columns,
    /// The spatial index.
    Index,
    /// Walls in motion where they are.
    Walls,
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

impl fmt::Display for Product {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Columns => "the columns",
            Self::Index => "the spatial index",
            Self::Walls => "walls in motion",
            Self::Neighbours => "neighbours",
            Self::Density => "densities",
            Self::Divergence => "velocities without divergence",
            Self::Forces => "accelerations without pressure",
            Self::Pressure => "pressure forces",
        })
    }
}

/// A stage that an order may name. It is declared beside the code that it runs.
#[derive(Debug, Clone, Copy)]
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// The phase that its time counts for.
    pub phase: Phase,
    /// What must be current before it.
    pub needs: &'static [Product],
    /// What is current after it.
    pub makes: &'static [Product],
    /// Whether it moves particles or rows, so that nothing made before is current.
    pub invalidates: bool,
    /// Whether its sums over pairs may have another kernel than the scene's (`WithKernel` in an order). It is so for
    /// forces that are opposite for both particles of a pair, and that take the kernel from the pairs.
    pub has_own_kernel: bool,
    /// Whether a scene asks for it.
    pub wanted: fn(&Scene) -> bool,
    /// Inserts the resources that its systems use.
    pub install: fn(&mut World, &Scene),
    /// Its systems.
    pub systems: fn(&Scene) -> Systems,
    /// Schedules that its systems run, such as the iterations of a solver.
    pub schedules: fn(&Scene) -> Vec<(InternedScheduleLabel, Systems)>,
    /// Memory besides columns, by what holds it \[bytes per fluid particle], for so many neighbours of a particle.
    pub bytes: fn(&Scene, f32) -> Vec<(&'static str, f64)>,
    /// Limits on the time step that do not change in a run.
    pub limits: fn(&Scene) -> Vec<Limit>,
}

impl Stage {
    /// A stage without needs, which every scene wants; the rest is given with `..Stage::new(…)`.
    pub const fn new(name: &'static str, phase: Phase, systems: fn(&Scene) -> Systems) -> Self {
        Self {
            name,
            phase,
            needs: &[],
            makes: &[],
            invalidates: false,
            has_own_kernel: false,
            wanted: |_| true,
            install: |_, _| {},
            systems,
            schedules: |_| Vec::new(),
            bytes: |_, _| Vec::new(),
            limits: |_| Vec::new(),
        }
    }
}

/// Systems one after the other.
pub(crate) fn chain(configs: Vec<Systems>) -> Systems {
    let configs = ScheduleConfigs::Configs {
        configs,
        collective_conditions: Vec::new(),
        metadata: Chain::Unchained,
    };
    configs.chain()
}
