//! State of a run besides the columns.

use crate::{
    flow::{Changes, Emitters, Turnover},
    gauge::{EnergyAccount, Gauges},
    integrate::Motion,
    neighbours,
    pressure::implicit::Jacobi,
    reorder::ReorderState,
    state::{Clock, Remembered, SolverState, particle::NextParticleId},
    time_step::{AdaptiveTimeStep, RecoveryTime, roll_back::KeptState},
};

/// The state of the reordering.
pub(crate) const REORDERING: &str = "reordering";

/// Resources that a step reads before it writes them.
pub(crate) const REMEMBERED: &[Remembered] = &[
    Remembered::new::<Clock>("clock"),
    Remembered::new::<NextParticleId>("next particle"),
    Remembered::new::<Motion>("motion"),
    Remembered::new::<SolverState>("pressure solve"),
    Remembered::new::<Jacobi>("relaxation"),
    Remembered::new::<RecoveryTime>("recovery"),
    Remembered::new::<AdaptiveTimeStep>("adaptive time step"),
    Remembered::new::<KeptState>("state to go back to"),
    Remembered::new::<ReorderState>(REORDERING),
    Remembered::new::<Emitters>("emitters"),
    Remembered::new::<Turnover>("turnover"),
    Remembered::new::<Changes>("changes since the state to go back to"),
    Remembered::new::<Gauges>("gauges"),
    Remembered::new::<EnergyAccount>("energy account"),
    neighbours::REMEMBERED,
];
