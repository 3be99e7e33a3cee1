//! Time steps that cannot be stable: a least one above what `check` itself says is the most.

use super::problem::{Checked, ensure};
use crate::registry::Stages;
use crate::scene::{Adaptive, Cfl, Scene, TimeStep};

/// The least time step must leave room for the limits that are certain: viscosity and sound, gravity, and the speed at
/// the start.
pub(super) fn least_time_step(scene: &Scene) -> Checked {
    let min = match scene.time_step {
        TimeStep::Cfl(Cfl { min, .. }) | TimeStep::Adaptive(Adaptive { min, .. }) => min,
        // Whoever fixes the time step knows of its limits, and is warned.
        TimeStep::Fixed(_) => return Ok(()),
    };
    let limits = Stages::default().certain_limits(scene);
    let Some((name, limit)) = limits.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(());
    };
    ensure(min <= limit, "time_step.min", || {
        format!(
            "the least time step is {min:e} s, above the {limit:.2e} s that {name} allows at this spacing; `min: \
             {:.0e}` leaves room, or a larger spacing",
            0.1 * limit
        )
    })
}
