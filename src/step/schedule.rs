//! Builds the schedule of a step from an order.

use bevy_ecs::{
    prelude::*,
    schedule::{
        InternedScheduleLabel, LogLevel, ScheduleBuildSettings, ScheduleLabel,
        SingleThreadedExecutor,
    },
};

use super::{
    compose::compose,
    constants::check_constants,
    error::InstallError,
    executor::StepExecutor,
    mend::mend,
    order::PlannedOrder,
    report::finish,
    timer::{lap, start_timer},
};
use crate::{
    boundary::{moving, room},
    gauge,
    pressure::{first_force, iterate::PressureIteration},
    registry::Stages,
    scene::{Executor, Scene, TimeStep},
    state::{
        Execution, Phase, Stage, Systems, agree, chain, clock,
        failure::{self, healthy},
        of_step,
        seal::{is_whole, seal_at_end},
        start_task_threads,
    },
    time_step::roll_back,
};

/// The schedule of one step. A host may run it, and may add systems before, after and between its [`Phase`]s.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Step;

/// Present if the step's systems run one at a time.
#[derive(Resource, Debug)]
pub(super) struct SingleThreadedStep;

/// Number of the engine's systems in a step; none if stages of a host are among them.
#[derive(Resource, Debug)]
pub(super) struct OwnSystems(pub(super) Option<usize>);

/// Schedules of a scene that are built but not yet added to the world.
pub(super) struct Built {
    schedules: Vec<Schedule>,
    single_threaded: bool,
    sums_first_force: bool,
    own: Option<usize>,
}

/// Labels of the schedules that a step needs. A panic inside one of them can remove it from the world.
#[derive(Resource, Debug)]
pub(super) struct Labels(pub(super) Vec<InternedScheduleLabel>);

impl Built {
    /// Adds the schedules and their resources to the world.
    pub(super) fn add(self, world: &mut World) {
        if self.single_threaded {
            world.insert_resource(SingleThreadedStep);
        }
        if self.sums_first_force {
            first_force::install(world);
        }
        world.insert_resource(OwnSystems(self.own));
        world.insert_resource(Labels(self.schedules.iter().map(Schedule::label).collect()));
        self.schedules
            .into_iter()
            .for_each(|schedule| world.add_schedule(schedule));
    }
}

fn is_on_ranks(world: &World) -> bool {
    let execution = world.get_resource::<Execution>();
    execution.is_some_and(|execution| execution.team().is_some())
}

/// Builds the schedules of `order` for `scene`. The world registers their components and receives no data.
pub(super) fn build_schedules(
    world: &mut World,
    scene: &Scene,
    order: &PlannedOrder,
    threads: usize,
) -> Result<Built, InstallError> {
    let mut step = Schedule::new(Step);
    let parallel = scene.executor == Executor::Parallel;
    if parallel {
        start_task_threads(threads).map_err(InstallError::TaskThreads)?;
    }
    step.set_executor(StepExecutor::new(parallel));
    let on_ranks = is_on_ranks(world);
    let mut configs = vec![
        (
            clock::begin,
            mend.ambiguous_with_all(),
            check_constants.run_if(healthy),
            of_step::note,
            start_timer,
        )
            .chain(),
    ];
    if on_ranks {
        configs.push(agree.into_configs());
    }
    if gauge::measures_energy(scene) {
        configs.push(gauge::note_start.run_if(healthy));
    }
    let mut composed = compose(order, scene, on_ranks);
    configs.extend(composed.step);
    let has_gauges = !scene.gauges.is_empty();
    if gauge::measures_energy(scene) {
        configs.push(gauge::book.in_set(Phase::Observe).run_if(is_whole));
    }
    if has_gauges {
        configs.push(gauge::read_gauges.in_set(Phase::Observe).run_if(is_whole));
    }
    if moving::is_wanted(scene) {
        configs.push(room::explain_no_room.in_set(Phase::Observe));
    }
    let located = (of_step::explain, failure::locate_failure).chain();
    configs.push(located.in_set(Phase::Observe));
    if matches!(scene.time_step, TimeStep::Adaptive(_)) {
        configs.push(roll_back::roll_back.in_set(Phase::Observe));
        if has_gauges {
            configs.push(gauge::go_back.in_set(Phase::Observe));
        }
    }
    let finished = (
        lap(Phase::Observe),
        finish,
        seal_at_end.ambiguous_with_all(),
    )
        .chain();
    configs.push(finished.in_set(Phase::Observe));
    step.set_build_settings(strict());
    // Chains the phases, also those without a stage in this scene, because a host orders its systems against them. An
    // order that returns to an earlier phase cannot have this chain.
    if order.keeps_phases() {
        let [a, b, c, d, e, f, g, h] = Phase::ALL;
        step.configure_sets((a, b, c, d, e, f, g, h).chain());
    }
    step.add_systems(chain(configs));
    step.initialize(world)
        .map_err(|error| InstallError::Schedule(error.to_string(step.graph(), world)))?;
    let known = Stages::default();
    let is_own = |stage: &Stage| known.find(stage.name).is_some();
    let all_own = order.installed().iter().all(is_own);
    let own = all_own.then(|| step.systems_len());
    let mut schedules = vec![step];
    for stage in order.installed() {
        for (label, systems) in (stage.schedules)(scene) {
            let systems = if label == PressureIteration.intern() && !composed.iteration.is_empty() {
                (chain(std::mem::take(&mut composed.iteration)), systems).chain()
            } else {
                systems
            };
            schedules.push(iteration(world, label, systems)?);
        }
    }
    Ok(Built {
        own,
        schedules,
        single_threaded: !parallel,
        sums_first_force: first_force::is_possible(scene) && order.follows("pressure", "viscosity"),
    })
}

/// A schedule that a stage runs, such as an iteration of a pressure method.
fn iteration(
    world: &mut World,
    label: InternedScheduleLabel,
    systems: Systems,
) -> Result<Schedule, InstallError> {
    let mut iteration = Schedule::new(label);
    iteration
        .set_executor(SingleThreadedExecutor::new())
        .set_build_settings(strict())
        .add_systems(systems);
    iteration
        .initialize(world)
        .map_err(|error| InstallError::Schedule(error.to_string(iteration.graph(), world)))?;
    Ok(iteration)
}

/// Two systems with conflicting access and no order between them are an error.
fn strict() -> ScheduleBuildSettings {
    ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..Default::default()
    }
}
