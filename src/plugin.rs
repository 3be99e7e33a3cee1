//! A scene in an `App` of bevy (feature `bevy_app`).

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
/// By default the fluid keeps up with `FixedUpdate`, which `bevy_time::TimePlugin` (one of bevy's `MinimalPlugins`) runs.
/// What became of it is in the resource [`FluidStatus`]; whatever goes wrong is triggered as [`FluidStopped`], and stops
/// the fluid but not the app.
///
/// Add it after what the scene needs: an [`Execution`](crate::Execution) in the world with the host's threads, or
/// [`Stages`](crate::step::Stages) of the host's own. A level restarts with [`uninstall`](crate::uninstall) and
/// [`install`].
pub struct FluidPlugin {
    scene: Scene,
    schedule: InternedScheduleLabel,
    pace: Pace,
}

/// How far a run of the schedule takes the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum Pace {
    /// As far as the [`Time`] of the schedule: in `FixedUpdate` its fixed step, in `Update` the last frame.
    #[default]
    Time,
    /// So far, whatever the clock says \[s].
    Seconds(f64),
    /// One step, whatever its length.
    Step,
}

/// How the fluid of a [`FluidPlugin`] is doing.
#[derive(Resource, Debug, Default)]
#[non_exhaustive]
pub enum FluidStatus {
    /// The schedule has not run yet, or found no scene.
    #[default]
    Waiting,
    /// What the last run did.
    Running(Advance),
    /// The scene was not installed.
    NotInstalled(InstallError),
    /// A step failed. The fluid stands still until a scene is installed anew, or the host puts another status here.
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
    /// Keeps up with `FixedUpdate`.
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

    /// Goes another way each time.
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

/// Takes the steps that are due. `stopped` is when the scene was installed that stopped last.
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
                let reason = "the world has no `Time`; add `bevy_time::TimePlugin` (one of `MinimalPlugins`), or give the \
                              `FluidPlugin` another `Pace`";
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
