//! A scene in a bevy `App` (feature `bevy_app`).

use bevy_app::{App, FixedUpdate, Plugin};
use bevy_ecs::{
    change_detection::Tick,
    prelude::*,
    schedule::{InternedScheduleLabel, ScheduleLabel},
};
use bevy_time::Time;

use crate::{
    scene::Scene,
    state::{Clock, StepError},
    step::{Advance, InstallError, advance, install, take_step},
};

/// Installs a scene in the world of an `App`, and runs its steps in one of the schedules.
///
/// By default the fluid follows `FixedUpdate`, which `bevy_time::TimePlugin` (one of bevy's `MinimalPlugins`) runs. The
/// resource [`FluidStatus`] holds the result. Any failure triggers [`FluidStopped`] and stops the fluid but not the
/// app.
///
/// Add it after the resources that the scene uses: an [`Execution`](crate::Execution) in the world with the host's
/// threads, or [`Stages`](crate::step::Stages) of the host. A level is restarted with [`uninstall`](crate::uninstall)
/// and [`install`].
pub struct FluidPlugin {
    scene: Scene,
    schedule: InternedScheduleLabel,
    pace: Pace,
}

/// Simulated time per run of the schedule.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum Pace {
    /// The [`Time`] of the schedule: in `FixedUpdate` its fixed step, in `Update` the last frame.
    #[default]
    Time,
    /// This duration, whatever the clock says \[s].
    Seconds(f64),
    /// One step, whatever its length.
    Step,
}

/// State of the fluid of a [`FluidPlugin`].
#[derive(Resource, Debug, Default)]
#[non_exhaustive]
pub enum FluidStatus {
    /// The schedule has not run yet, or there was no scene.
    #[default]
    Waiting,
    /// Result of the last run.
    Running(Advance),
    /// The scene could not be installed.
    NotInstalled(InstallError),
    /// A step failed. The fluid is stopped until a scene is installed again or the host sets another status here.
    Stopped(StepError),
    /// With [`Pace::Time`], the world has no [`Time`].
    NoTime,
}

/// The fluid stopped, for the reason that [`FluidStatus`] gives.
#[derive(Event, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FluidStopped {
    /// The reason in words.
    pub reason: String,
}

impl FluidPlugin {
    /// Follows `FixedUpdate`.
    pub fn new(scene: Scene) -> Self {
        Self {
            scene,
            schedule: FixedUpdate.intern(),
            pace: Pace::default(),
        }
    }

    /// Runs in another schedule.
    #[must_use]
    pub fn in_schedule(mut self, schedule: impl ScheduleLabel) -> Self {
        self.schedule = schedule.intern();
        self
    }

    /// Uses another pace.
    #[must_use]
    pub fn at_pace(mut self, pace: Pace) -> Self {
        self.pace = pace;
        self
    }
}

impl Plugin for FluidPlugin {
    fn build(&self, app: &mut App) {
        #[cfg(feature = "bevy_reflect")]
        crate::state::particle::register_types(
            &mut app
                .world_mut()
                .get_resource_or_init::<AppTypeRegistry>()
                .write(),
        );
        let world = app.world_mut();
        let installed = install(world, &self.scene);
        world.insert_resource(FluidStatus::Waiting);
        if let Err(error) = installed {
            stop(world, error.to_string(), FluidStatus::NotInstalled(error));
        }
        let pace = self.pace;
        let mut stopped = None;
        app.add_systems(self.schedule, move |world: &mut World| {
            run(world, pace, &mut stopped);
        });
    }
}

/// Takes the steps that are due. `stopped` is the time of installation of the last scene that stopped.
fn run(world: &mut World, pace: Pace, stopped: &mut Option<Tick>) {
    let installed = world.get_resource_change_ticks::<Clock>();
    let Some(installed) = installed.map(|ticks| ticks.added) else {
        if let Some(mut status) = world.get_resource_mut::<FluidStatus>()
            && !matches!(*status, FluidStatus::NotInstalled(_))
        {
            *status = FluidStatus::Waiting;
        }
        return;
    };
    let has_stopped = matches!(
        world.get_resource(),
        Some(FluidStatus::Stopped(_) | FluidStatus::NoTime)
    );
    if has_stopped && *stopped == Some(installed) {
        return;
    }
    *stopped = Some(installed);
    let taken = match pace {
        Pace::Step => take_step(world).map(|report| Advance {
            steps: 1,
            rest: 0.0,
            report: Some(report),
        }),
        Pace::Seconds(seconds) => advance(world, seconds),
        Pace::Time => match world.get_resource::<Time>() {
            Some(time) => advance(world, time.delta_secs_f64()),
            None => {
                let reason = "the world has no `Time`; add `bevy_time::TimePlugin` (one of `MinimalPlugins`), or give \
                              the `FluidPlugin` another `Pace`";
                return stop(world, reason.to_owned(), FluidStatus::NoTime);
            }
        },
    };
    match taken {
        Ok(advance) => world.insert_resource(FluidStatus::Running(advance)),
        Err(error) => stop(world, error.to_string(), FluidStatus::Stopped(error)),
    }
}

fn stop(world: &mut World, reason: String, status: FluidStatus) {
    world.insert_resource(status);
    world.trigger(FluidStopped { reason });
}
