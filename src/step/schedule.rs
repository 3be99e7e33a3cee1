//! The schedule of a step, built from an order.

use bevy_ecs::{
    prelude::*,
    schedule::{
        Chain, LogLevel, MultiThreadedExecutor, ScheduleBuildSettings, ScheduleConfigs,
        ScheduleLabel, SingleThreadedExecutor,
    },
    system::ScheduleSystem,
};

use super::{
    clock::{self, Clock, healthy},
    install::InstallError,
    order::{Order, OrderItem},
    phase::Phase,
    report::finish,
    stage::{Datum, Stage},
    timer::{start_timer, stop_watch},
};
use crate::{
    execution::{Execution, start_task_threads},
    pressure::{
        dfsph::{self, DivergenceIteration},
        first_force, iisph, pcisph, pressure_force,
        solve::{LastCorrection, PressureIteration},
    },
    scene::{Executor, PressureMethod, Scene, TimeStep},
    time_step::roll_back,
};

/// The schedule of one step. A host runs it, and may add systems before, after and between its [`Phase`]s.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Step;

/// There where a step runs its systems one after the other.
#[derive(Resource, Debug)]
pub(super) struct InTurn;

/// Fluid particles below which the step's own executor is single-threaded, unless the scene says which.
///
/// The parallel executor overlaps a host's own systems beside ours; ours are one chain, and the loops inside them are parallel
/// either way. It runs systems on threads of its own, so that every loop has to wake the pool: a step of PCISPH takes 2.3
/// times as long so as in the pool with 1 000 particles, 1.25 times with 8 000, 1.025 times with 130 000.
const PARALLEL_FROM: usize = 30_000;

/// Adds the schedules of `order` for `scene` to the world.
pub(super) fn add_schedules(
    world: &mut World,
    scene: &Scene,
    order: &Order,
    particles: usize,
) -> Result<(), InstallError> {
    let mut step = Schedule::new(Step);
    let parallel = match scene.executor {
        Executor::Auto => particles >= PARALLEL_FROM,
        Executor::Parallel => true,
        Executor::SingleThreaded => false,
    };
    if parallel {
        let threads = world.resource::<Execution>().threads();
        start_task_threads(threads).map_err(InstallError::TaskThreads)?;
        step.set_executor(MultiThreadedExecutor::new());
    } else {
        step.set_executor(SingleThreadedExecutor::new());
        world.insert_resource(InTurn);
    }
    if first_force::is_possible(scene) && follows_viscosity(&order.stages, scene) {
        first_force::install(world);
    }
    let mut configs = vec![(clock::begin, start_timer).chain()];
    add_stages(&order.stages, scene, None, &mut configs);
    configs.push(clock::name_the_particle.in_set(Phase::Observe));
    if matches!(scene.time_step, TimeStep::Adaptive(_)) {
        configs.push(roll_back::roll_back.in_set(Phase::Observe));
    }
    configs.push(
        (stop_watch(Phase::Observe), finish)
            .chain()
            .in_set(Phase::Observe),
    );
    step.set_build_settings(strict());
    // A host orders its systems against phases, also against one that has no stage in this scene. An order that goes
    // back to an earlier phase has no such chain.
    let mut phases = Vec::new();
    visited(&order.stages, scene, &mut phases);
    if phases.is_sorted() {
        let [a, b, c, d, e, f, g, h] = Phase::ALL;
        step.configure_sets((a, b, c, d, e, f, g, h).chain());
    }
    step.add_systems(chain(configs));
    step.initialize(world)
        .map_err(|error| InstallError::Schedule(error.to_string(step.graph(), world)))?;
    world.add_schedule(step);

    match scene.pressure {
        PressureMethod::Sesph(_) => {}
        PressureMethod::Pcisph(parameters) => {
            add_iteration(world, PressureIteration, pcisph::iteration(scene))?;
            if parameters.last_correction {
                add_iteration(world, LastCorrection, pressure_force.into_configs())?;
            }
        }
        PressureMethod::Iisph(_) => add_iteration(world, PressureIteration, iisph::iteration())?,
        PressureMethod::Dfsph(_) => {
            add_iteration(world, DivergenceIteration, dfsph::divergence_iteration())?;
            add_iteration(world, PressureIteration, dfsph::iteration())?;
        }
    }
    Ok(())
}

/// Adds the schedule of one iteration of a pressure method.
fn add_iteration(
    world: &mut World,
    label: impl ScheduleLabel,
    systems: ScheduleConfigs<ScheduleSystem>,
) -> Result<(), InstallError> {
    let mut iteration = Schedule::new(label);
    iteration
        .set_executor(SingleThreadedExecutor::new())
        .set_build_settings(strict())
        .add_systems(systems);
    iteration
        .initialize(world)
        .map_err(|error| InstallError::Schedule(error.to_string(iteration.graph(), world)))?;
    world.add_schedule(iteration);
    Ok(())
}

/// Two systems that want the same data without an order between them are an error.
fn strict() -> ScheduleBuildSettings {
    ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..Default::default()
    }
}

fn chain(configs: Vec<ScheduleConfigs<ScheduleSystem>>) -> ScheduleConfigs<ScheduleSystem> {
    ScheduleConfigs::Configs {
        configs,
        collective_conditions: Vec::new(),
        metadata: Chain::Unchained,
    }
    .chain()
}

/// Appends the stages that the scene wants, each followed by its stop watch.
fn add_stages(
    items: &[OrderItem],
    scene: &Scene,
    every: Option<u64>,
    configs: &mut Vec<ScheduleConfigs<ScheduleSystem>>,
) {
    for item in items {
        match item {
            OrderItem::Run(name) => {
                // Names were checked with the order.
                let Some(stage) = Stage::ALL.iter().find(|stage| stage.name == name) else {
                    continue;
                };
                if !(stage.wanted)(scene) {
                    continue;
                }
                let mut systems = (stage.systems)(scene).in_set(stage.phase).run_if(healthy);
                if let Some(count) = every {
                    systems =
                        systems.run_if(move |clock: Res<Clock>| clock.step.is_multiple_of(count));
                }
                configs.push(systems);
                configs.push(stop_watch(stage.phase).in_set(stage.phase));
            }
            OrderItem::Every(count, items) => {
                let count = u64::from(*count);
                add_stages(
                    items,
                    scene,
                    Some(every.map_or(count, |outer| outer * count)),
                    configs,
                );
            }
            OrderItem::Repeat(count, items) => {
                (0..*count).for_each(|_| add_stages(items, scene, every, configs))
            }
        }
    }
}

/// Whether the pressure solve follows viscosity in every step, both run once, and no more than forces are made between them.
fn follows_viscosity(items: &[OrderItem], scene: &Scene) -> bool {
    fn count(items: &[OrderItem], searched: &str) -> usize {
        let of_item = |item: &OrderItem| match item {
            OrderItem::Run(name) => usize::from(name == searched),
            OrderItem::Every(_, items) | OrderItem::Repeat(_, items) => count(items, searched),
        };
        items.iter().map(of_item).sum()
    }
    let runs = |searched: &'static str| move |item: &OrderItem| matches!(item, OrderItem::Run(name) if name == searched);
    let leaves_all = |item: &OrderItem| match item {
        OrderItem::Run(name) => Stage::find(name).is_ok_and(|stage| {
            !(stage.wanted)(scene)
                || !stage.spoils_all && stage.makes.iter().all(|made| *made == Datum::Forces)
        }),
        OrderItem::Every(..) | OrderItem::Repeat(..) => false,
    };
    let mut after = items
        .iter()
        .skip_while(|item| !runs("viscosity")(item))
        .skip(1);
    let next = after.find(|item| runs("pressure")(item) || !leaves_all(item));
    next.is_some_and(runs("pressure"))
        && ["viscosity", "pressure"]
            .iter()
            .all(|name| count(items, name) == 1)
}

/// The phases that `items` go through, in their order; of repetitions the first two, which show whether it goes back.
fn visited(items: &[OrderItem], scene: &Scene, phases: &mut Vec<Phase>) {
    for item in items {
        match item {
            OrderItem::Run(name) => {
                let stage = Stage::ALL.iter().find(|stage| stage.name == name);
                phases.extend(
                    stage
                        .filter(|stage| (stage.wanted)(scene))
                        .map(|stage| stage.phase),
                );
            }
            OrderItem::Every(_, items) => visited(items, scene, phases),
            OrderItem::Repeat(count, items) => {
                (0..(*count).min(2)).for_each(|_| visited(items, scene, phases));
            }
        }
    }
}

/// The stages of `order` that `scene` wants, by phase.
pub(super) fn planned(order: &Order, scene: &Scene) -> Vec<(Phase, Vec<String>)> {
    fn walk(items: &[OrderItem], scene: &Scene, prefix: &str, out: &mut Vec<(Phase, Vec<String>)>) {
        for item in items {
            match item {
                OrderItem::Run(name) => {
                    let Some(stage) = Stage::ALL.iter().find(|stage| stage.name == name) else {
                        continue;
                    };
                    if !(stage.wanted)(scene) {
                        continue;
                    }
                    let line = format!("{prefix}{name}");
                    match out.last_mut() {
                        Some((phase, names)) if *phase == stage.phase => names.push(line),
                        _ => out.push((stage.phase, vec![line])),
                    }
                }
                OrderItem::Every(count, items) => {
                    walk(items, scene, &format!("{prefix}every {count} steps: "), out);
                }
                OrderItem::Repeat(count, items) => {
                    walk(items, scene, &format!("{prefix}{count} times: "), out)
                }
            }
        }
    }
    let mut out = Vec::new();
    walk(&order.stages, scene, "", &mut out);
    out
}
