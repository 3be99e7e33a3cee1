//! The step: its phases, its order, and the ways to run it.

mod clock;
mod executor;
mod install;
mod limits;
pub(crate) mod memory;
mod order;
mod order_check;
mod phase;
mod plan;
mod report;
mod schedule;
mod stage;
mod start;
mod start_density;
mod start_slabs;
mod timer;
mod warnings;

pub use clock::{Clock, Failure};
pub(crate) use install::check_order;
pub use install::{InstallError, Simulation, install, take_step};
pub use order::{Order, OrderError, OrderItem};
pub use phase::Phase;
pub use plan::{Plan, plan};
pub use report::{FailureCause, StepError, StepOutcome, StepReport};
pub use schedule::Step;
pub use stage::{Datum, Stage};
pub use start_density::StartDensity;
pub use timer::PhaseTimer;
pub use warnings::warnings;
