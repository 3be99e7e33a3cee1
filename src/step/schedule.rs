//! The schedule of a step, built from an order.

use bevy_ecs::{
    prelude::*,
    schedule::{
        Chain, InternedScheduleLabel, LogLevel, ScheduleBuildSettings, ScheduleConfigs,
        ScheduleLabel, SingleThreadedExecutor,
    },
    system::ScheduleSystem,
};

use super::{
    executor::StepExecutor,
    install::InstallError,
    order::{Order, OrderItem, stages},
    report::finish,
    stage::{Datum, Stage},
    timer::{start_timer, stop_watch},
};
use crate::{
    gauge,
    pressure::{
        dfsph::{self, DivergenceIteration},
        first_force, iisph,
        initial::{self, InitialIteration},
        pcisph, pressure_force,
        solve::{LastCorrection, PressureIteration},
    },
    scene::{Executor, PressureMethod, Scene, TimeStep},
    state::{Clock, Phase, clock, failure, failure::healthy},
    state::{Rows, start_task_threads},
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
/// The parallel executor overlaps a host's own systems beside ours; ours are one chain, and the loops inside them are
/// parallel either way. It runs systems on threads of its own, so that every loop has to wake the pool: a step of
/// PCISPH takes 2.3 times as long so as in the pool with 1 000 particles, 1.25 times with 8 000, 1.025 times with 130
/// 000.
const PARALLEL_FROM: usize = 30_000;

/// The schedules of a scene, built and not yet in the world.
pub(super) struct Built {
    schedules: Vec<Schedule>,
    in_turn: bool,
    sums_first_force: bool,
}

/// The labels of the schedules that a step needs. A panic within one of them can lose it.
#[derive(Resource, Debug)]
pub(super) struct Labels(pub(super) Vec<InternedScheduleLabel>);

impl Built {
    /// Adds the schedules, and what they need, to the world.
    pub(super) fn add(self, world: &mut World) {
        if self.in_turn {
            world.insert_resource(InTurn);
        }
        if self.sums_first_force {
            first_force::install(world);
        }
        world.insert_resource(Labels(self.schedules.iter().map(Schedule::label).collect()));
        self.schedules
            .into_iter()
            .for_each(|schedule| world.add_schedule(schedule));
    }
}

/// Builds the schedules of `order` for `scene`. The world learns of their components and holds nothing new.
pub(super) fn build_schedules(
    world: &mut World,
    scene: &Scene,
    order: &Order,
    particles: usize,
    threads: usize,
) -> Result<Built, InstallError> {
    let mut step = Schedule::new(Step);
    let parallel = match scene.executor {
        Executor::Auto => particles >= PARALLEL_FROM,
        Executor::Parallel => true,
        Executor::SingleThreaded => false,
    };
    if parallel {
        start_task_threads(threads).map_err(InstallError::TaskThreads)?;
    }
    step.set_executor(StepExecutor::new(parallel));
    let mut configs = vec![(clock::begin, start_timer).chain()];
    if gauge::measures_energy(scene) {
        configs.push(gauge::note_start.run_if(healthy));
    }
    add_stages(&order.stages, scene, None, &mut configs);
    let has_gauges = !scene.gauges.is_empty();
    if gauge::measures_energy(scene) {
        configs.push(gauge::book.in_set(Phase::Observe).run_if(healthy));
    }
    if has_gauges {
        configs.push(gauge::read_gauges.in_set(Phase::Observe).run_if(healthy));
    }
    configs.push(failure::name_the_particle.in_set(Phase::Observe));
    if matches!(scene.time_step, TimeStep::Adaptive(_)) {
        configs.push(roll_back::roll_back.in_set(Phase::Observe));
        if has_gauges {
            configs.push(gauge::go_back.in_set(Phase::Observe));
        }
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
    let mut schedules = vec![step];
    let mut add = |schedule: Result<Schedule, InstallError>| -> Result<(), InstallError> {
        schedules.push(schedule?);
        Ok(())
    };
    if initial::is_solved_for(scene) {
        add(iteration(world, InitialIteration, iisph::iteration()))?;
    }
    match scene.pressure {
        PressureMethod::Sesph(_) => {}
        PressureMethod::Pcisph(parameters) => {
            add(iteration(
                world,
                PressureIteration,
                pcisph::iteration(scene),
            ))?;
            if parameters.last_correction {
                add(iteration(
                    world,
                    LastCorrection,
                    pressure_force.into_configs(),
                ))?;
            }
        }
        PressureMethod::Iisph(_) => add(iteration(world, PressureIteration, iisph::iteration()))?,
        PressureMethod::Dfsph(_) => {
            let divergence = dfsph::divergence_iteration();
            add(iteration(world, DivergenceIteration, divergence))?;
            add(iteration(world, PressureIteration, dfsph::iteration()))?;
        }
    }
    Ok(Built {
        schedules,
        in_turn: !parallel,
        sums_first_force: first_force::is_possible(scene)
            && follows_viscosity(&order.stages, scene),
    })
}

/// The schedule of one iteration of a pressure method.
fn iteration(
    world: &mut World,
    label: impl ScheduleLabel,
    systems: ScheduleConfigs<ScheduleSystem>,
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
                    systems = systems.run_if(move |clock: Res<Clock>, rows: Res<Rows>| {
                        clock.step.is_multiple_of(count) || rows.changed
                    });
                }
                configs.push(systems);
                configs.push(stop_watch(stage.phase).in_set(stage.phase));
            }
            OrderItem::Every(count, items) => {
                let count = u64::from(*count);
                add_stages(
                    items,
                    scene,
                    Some(every.map_or(count, |outer| outer.saturating_mul(count))),
                    configs,
                );
            }
            OrderItem::Repeat(_, items) if stages(items) == 0 => {}
            OrderItem::Repeat(count, items) => {
                (0..*count).for_each(|_| add_stages(items, scene, every, configs))
            }
        }
    }
}

/// Whether the pressure solve follows viscosity in every step, both run once, and no more than forces are made between
/// them.
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
            OrderItem::Repeat(_, items) if stages(items) == 0 => {}
            OrderItem::Repeat(count, items) => {
                (0..(*count).min(2)).for_each(|_| visited(items, scene, phases));
            }
        }
    }
}

/// The stages of `order` that `scene` wants, by phase, in the order in which they run. A group of one stage is written
/// `every 2 steps: a`, a longer one `every 2 steps { a` to `b }`, over as many phases as it goes through.
pub(super) fn planned(order: &Order, scene: &Scene) -> Vec<(Phase, Vec<String>)> {
    let mut lines = Vec::new();
    for item in &order.stages {
        lines.append(&mut lines_of(item, scene));
    }
    let mut out: Vec<(Phase, Vec<String>)> = Vec::new();
    for (phase, line) in lines {
        match out.last_mut() {
            Some((last, lines)) if *last == phase => lines.push(line),
            _ => out.push((phase, vec![line])),
        }
    }
    out
}

fn lines_of(item: &OrderItem, scene: &Scene) -> Vec<(Phase, String)> {
    let (group, items) = match item {
        OrderItem::Run(name) => {
            let stage = Stage::ALL.iter().find(|stage| stage.name == name);
            let wanted = stage.filter(|stage| (stage.wanted)(scene));
            return wanted
                .map(|stage| (stage.phase, name.clone()))
                .into_iter()
                .collect();
        }
        OrderItem::Every(count, items) => (format!("every {count} steps"), items),
        OrderItem::Repeat(count, items) => (format!("{count} times"), items),
    };
    let mut lines: Vec<_> = items
        .iter()
        .flat_map(|item| lines_of(item, scene))
        .collect();
    match lines.as_mut_slice() {
        [] => {}
        [(_, only)] => *only = format!("{group}: {only}"),
        [(_, first), .., (_, last)] => {
            *first = format!("{group} {{ {first}");
            last.push_str(" }");
        }
    }
    lines
}
