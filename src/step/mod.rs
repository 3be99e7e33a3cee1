//! The step: its order, its schedule, and the ways to run it.

mod advance;
mod apply;
mod compose;
mod constants;
mod error;
mod executor;
mod install;
mod installed;
mod limits;
pub(crate) mod memory;
mod mend;
mod numbers;
mod order;
mod plan;
mod report;
mod schedule;
mod sealed;
mod simulation;
mod start;
mod start_density;
mod start_errors;
mod start_slabs;
mod take;
mod timer;
mod uninstall;
mod warnings;
mod warnings_of_cuts;
mod warnings_of_flow;
mod warnings_of_forces;
mod warnings_of_gauges;
mod warnings_of_layers;
mod warnings_of_pace;
mod warnings_of_tolerances;
mod warnings_of_units;

pub use advance::{Advance, advance};
pub use apply::{ApplyError, apply};
pub use error::{Burst, Crowd, InstallError, StartDensity};
pub use install::{install, install_on_rank};
pub(crate) use installed::{Installed, NamedFile};
pub use memory::warnings_beside;
pub(crate) use order::check_order;
pub use order::{Condition, Flow, Order, OrderError, OrderItem, Range};
pub use plan::{Plan, PlannedEmitter, plan, plan_beside};
pub use report::{StepOutcome, StepReport};
pub use schedule::Step;
pub use simulation::Simulation;
pub use take::take_step;
pub use timer::PhaseTimer;
pub(crate) use uninstall::between_steps;
pub use uninstall::{NotBetweenSteps, UninstallError, uninstall};
pub use warnings::warnings;

pub use crate::{
    registry::{StageError, Stages},
    state::{
        Accelerations, Clock, Densities, Execution, Failure, FailureCause, Material, Phase,
        Positions, Pressures, Product, Rows, Stage, StepError, Systems, Velocities,
    },
};
