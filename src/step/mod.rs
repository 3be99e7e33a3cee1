//! The step: its phases, its order, and the ways to run it.

mod executor;
mod install;
pub(crate) mod memory;
mod order;
mod order_check;
mod plan;
mod report;
mod schedule;
mod stage;
mod start;
mod start_density;
mod timer;
mod warnings;

pub(crate) use install::check_order;
pub use install::{InstallError, Simulation, install, take_step};
pub use order::{Order, OrderError, OrderItem};
pub use plan::{Plan, plan};
pub use report::{StepOutcome, StepReport};
pub use schedule::Step;
pub use stage::{Datum, Stage};
pub use start_density::StartDensity;
pub use timer::PhaseTimer;
pub use warnings::warnings;

pub use crate::state::{Clock, Failure, FailureCause, Phase, StepError};
