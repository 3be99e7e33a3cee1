//! Runs the systems of a step with bevy's executors, protected against a host's threads and panics.

use bevy_ecs::{
    error::{BevyError, ErrorContext},
    prelude::*,
    schedule::{
        FixedBitSet, MultiThreadedExecutor, SingleThreadedExecutor, SystemExecutor, SystemSchedule,
    },
};

use crate::state::Execution;

/// Runs the systems one at a time, or in parallel where their data allow it.
///
/// A thread of the loops' pool must not wait for bevy's threads, because those wait for the pool, which may have no
/// other thread. So a parallel step that a host starts from within the pool runs its systems one at a time, with the
/// same results.
pub(super) struct StepExecutor {
    in_turn: SingleThreadedExecutor,
    parallel: Option<MultiThreadedExecutor>,
    applies_final_deferred: bool,
    /// Whether the last run was cut short: a system panicked, and the executor still counts the systems that ran before
    /// it as done.
    unfinished: bool,
}

impl StepExecutor {
    pub(super) fn new(parallel: bool) -> Self {
        Self {
            in_turn: SingleThreadedExecutor::new(),
            parallel: parallel.then(MultiThreadedExecutor::new),
            applies_final_deferred: true,
            unfinished: false,
        }
    }

    fn start_anew(&mut self, schedule: &SystemSchedule) {
        *self = Self {
            applies_final_deferred: self.applies_final_deferred,
            ..Self::new(self.parallel.is_some())
        };
        self.set_apply_final_deferred(self.applies_final_deferred);
        self.init(schedule);
    }
}

impl SystemExecutor for StepExecutor {
    fn init(&mut self, schedule: &SystemSchedule) {
        self.in_turn.init(schedule);
        if let Some(parallel) = &mut self.parallel {
            parallel.init(schedule);
        }
    }

    fn run(
        &mut self,
        schedule: &mut SystemSchedule,
        world: &mut World,
        skip_systems: Option<&FixedBitSet>,
        error_handler: fn(BevyError, ErrorContext),
    ) {
        if self.unfinished {
            self.start_anew(schedule);
        }
        self.unfinished = true;
        let is_inside = world
            .get_resource::<Execution>()
            .is_some_and(Execution::is_inside);
        match &mut self.parallel {
            Some(parallel) if !is_inside => {
                parallel.run(schedule, world, skip_systems, error_handler);
            }
            _ => {
                self.in_turn
                    .run(schedule, world, skip_systems, error_handler);
            }
        }
        self.unfinished = false;
    }

    fn set_apply_final_deferred(&mut self, value: bool) {
        self.applies_final_deferred = value;
        self.in_turn.set_apply_final_deferred(value);
        if let Some(parallel) = &mut self.parallel {
            parallel.set_apply_final_deferred(value);
        }
    }
}
