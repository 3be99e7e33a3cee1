//! Runs a study: the variants of a case take turns, block by block.
//!
//! Other programs start and stop on a machine, and its clock rate changes with them. Variants measured one after the
//! other would each find different conditions. In turns (A B C A B C …) they find the same conditions, and the spread
//! over the blocks shows how steady these were.

use std::ops::ControlFlow;

use bevy_ecs::prelude::*;

use super::{
    Block, Measure, Pause, Plan, PlannedCase, PlannedVariant, Span, StudyError, Table,
    measure::LastStep, pause::Progress, readings, start::State,
};
use crate::{
    Step, StepOutcome,
    index::FluidIndex,
    install,
    measure::Curve,
    neighbours::{FluidNeighbours, Search, tested_pairs},
    scene::Scene,
    state::{Clock, Execution, Positions, StepError},
    step::StepReport,
};

/// Progress of a study.
pub enum Event<'a> {
    /// A step was taken.
    Step {
        /// The current stage: a start, or the measurement of a case.
        stage: &'a str,
        /// The variant that took the step.
        of: &'a str,
        /// Completed fraction of the stage, 0 to 1.
        fraction: f64,
    },
    /// Every variant of a case has finished a block. The table holds the results so far, and the study can go on from
    /// here, unless a variant cannot be saved at this step.
    Turn(&'a Table, Option<Pause>),
}

/// Runs a study with `threads` threads; 0 uses all cores. `tell` is called after every step and may stop the study.
///
/// If a variant fails, its row shows the reason and the others continue. The table contains all blocks that were
/// finished.
pub fn run(
    plan: &Plan,
    threads: usize,
    tell: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Table, StudyError> {
    resume(plan, threads, None, tell)
}

/// As [`run()`], from where an earlier study stopped. What it had finished is not repeated.
pub fn resume(
    plan: &Plan,
    threads: usize,
    from: Option<&Pause>,
    tell: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Table, StudyError> {
    let execution = Execution::new(threads).map_err(StudyError::Threads)?;
    let mut table = Table::new(plan);
    let done = from.map(|from| from.resume(plan, &mut table)).transpose()?;
    let first = done.as_ref().map_or(0, |done| done.case);
    let wants = |what: fn(&Measure) -> bool| {
        let mut columns = plan.study.columns.iter();
        columns.any(|column| what(&column.measure))
    };
    for (number, case) in plan.cases.iter().enumerate().skip(first) {
        let done = done.as_ref();
        let from = from.zip(done.filter(|done| done.case == number && done.turns > 0));
        let mut turns = Turns {
            plan,
            case,
            execution: &execution,
            wants_pairs: wants(Measure::counts_pairs),
            wants_distance: wants(Measure::compares_variants),
            from,
            tell,
        };
        if turns.run(number, &mut table)?.is_break() {
            break;
        }
    }
    Ok(table)
}

/// A variant's world.
struct Runner {
    world: World,
    /// Reference curves of its gauges.
    references: Vec<Option<Curve>>,
    failed: bool,
    last: LastStep,
}

struct Turns<'a, 'b> {
    plan: &'a Plan,
    case: &'a PlannedCase,
    execution: &'a Execution,
    wants_pairs: bool,
    wants_distance: bool,
    /// Where an earlier study stopped in this case.
    from: Option<(&'a Pause, &'a Progress)>,
    tell: &'a mut (dyn FnMut(Event) -> ControlFlow<()> + 'b),
}

/// Why a span ended early.
enum Broken {
    /// The caller stopped it.
    Asked,
    /// A step failed.
    Failed(StepError),
}

impl Turns<'_, '_> {
    fn run(&mut self, number: usize, table: &mut Table) -> Result<ControlFlow<()>, StudyError> {
        let state = match self.from {
            Some(_) => None,
            None => match self.start()? {
                ControlFlow::Continue(state) => state,
                ControlFlow::Break(()) => return Ok(ControlFlow::Break(())),
            },
        };
        let stage = self.label("measuring");
        let mut runners = Vec::new();
        if self.begin(&stage).is_break() {
            return Ok(ControlFlow::Break(()));
        }
        for (k, variant) in self.case.variants.iter().enumerate() {
            runners.push(self.runner((k, variant), state.as_ref())?);
        }
        let turns = self.plan.study.blocks + 1;
        let first = self.from.map_or(0, |(_, done)| done.turns);
        for turn in first..turns {
            for (k, runner) in runners.iter_mut().enumerate() {
                if runner.failed {
                    continue;
                }
                let of = &self.case.variants[k].name;
                let span = if turn == 0 {
                    self.plan.study.warm_up
                } else {
                    self.case.block
                };
                let (before, count) = (
                    turn as usize * self.case.variants.len() + k,
                    turns as usize * self.case.variants.len(),
                );
                let place = |part: f64| (before as f64 + part) / count as f64;
                let row = &mut table.rows[number * self.case.variants.len() + k];
                match advance(&mut runner.world, span, &mut runner.last, |part| {
                    (self.tell)(Event::Step {
                        stage: &stage,
                        of,
                        fraction: place(part),
                    })
                }) {
                    Ok(mut block) => {
                        let columns = &self.plan.study.columns;
                        readings::tally(&mut runner.world, columns, &runner.references, &mut block);
                        if turn == 0 {
                            continue;
                        }
                        if self.wants_pairs {
                            count_pairs(&runner.world, &mut block);
                        }
                        row.blocks.push(block);
                    }
                    Err(Broken::Asked) => return Ok(ControlFlow::Break(())),
                    Err(Broken::Failed(error)) => {
                        runner.failed = true;
                        row.failure = Some(error.to_string());
                    }
                }
            }
            if self.wants_distance && turn > 0 {
                self.compare(&mut runners, number, table);
            }
            let pause = self.pause(table, (number, turn), &mut runners);
            if (self.tell)(Event::Turn(table, pause)).is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// What to go on from after a turn of a case.
    fn pause(
        &self,
        table: &Table,
        (number, turn): (usize, u32),
        runners: &mut [Runner],
    ) -> Option<Pause> {
        let is_last = turn == self.plan.study.blocks;
        let done = if is_last {
            (number + 1, 0)
        } else {
            (number, turn + 1)
        };
        let variants = runners.iter_mut().filter(|_| !is_last);
        let variants = variants.map(|runner| {
            let last = (!runner.failed).then_some(runner.last);
            (&mut runner.world, last)
        });
        Pause::of(self.plan, table, done, variants)
    }

    /// Notes how far the particles of every variant are from those of the baseline.
    fn compare(&self, runners: &mut [Runner], number: usize, table: &mut Table) {
        let variants = &self.case.variants;
        let baseline = |variant: &PlannedVariant| variant.name == table.baseline();
        let Some(baseline) = variants.iter().position(baseline) else {
            return;
        };
        if runners[baseline].failed {
            return;
        }
        let known = State::of(&mut runners[baseline].world);
        for (k, runner) in runners.iter_mut().enumerate() {
            let row = &mut table.rows[number * variants.len() + k];
            let scene = &variants[k].scene;
            if let (false, Some(block)) = (runner.failed, row.blocks.last_mut()) {
                let distance = State::of(&mut runner.world).distance(&known, &scene.period());
                block.distance = distance.map(|distance| distance / f64::from(scene.spacing));
            }
        }
    }

    /// Reports the beginning of a stage, before its worlds are created.
    fn begin(&mut self, stage: &str) -> ControlFlow<()> {
        (self.tell)(Event::Step {
            stage,
            of: "setting up",
            fraction: 0.0,
        })
    }

    fn label(&self, what: &str) -> String {
        match self.case.name.as_str() {
            "" => what.to_owned(),
            name => format!("{name}, {what}"),
        }
    }

    /// Simulates the start, if the case has one.
    fn start(&mut self) -> Result<ControlFlow<(), Option<State>>, StudyError> {
        let Some((scene, time)) = &self.case.start else {
            return Ok(ControlFlow::Continue(None));
        };
        let stage = self.label("start");
        if self.begin(&stage).is_break() {
            return Ok(ControlFlow::Break(()));
        }
        let mut world = self.world(scene, &stage, self.execution.clone())?;
        // The state is taken exactly at this time, whatever the length of a step.
        world.resource_mut::<Clock>().until = Some((*time).into());
        let mut last = LastStep::default();
        match advance(&mut world, Span::Time(*time), &mut last, |fraction| {
            (self.tell)(Event::Step {
                stage: &stage,
                of: "",
                fraction,
            })
        }) {
            Ok(_) => Ok(ControlFlow::Continue(Some(State::of(&mut world)))),
            Err(Broken::Asked) => Ok(ControlFlow::Break(())),
            Err(Broken::Failed(error)) => Err(StudyError::Start {
                case: match self.case.name.as_str() {
                    "" => self.plan.study.name.clone(),
                    name => name.to_owned(),
                },
                error: Box::new(error),
            }),
        }
    }

    fn world(&self, scene: &Scene, of: &str, execution: Execution) -> Result<World, StudyError> {
        let mut world = World::new();
        world.insert_resource(execution);
        install(&mut world, scene).map_err(|error| StudyError::Install {
            variant: of.to_owned(),
            error: Box::new(error),
        })?;
        Ok(world)
    }

    fn runner(
        &self,
        (number, variant): (usize, &PlannedVariant),
        state: Option<&State>,
    ) -> Result<Runner, StudyError> {
        let execution = match variant.threads {
            Some(threads) => Execution::new(threads as usize).map_err(StudyError::Threads)?,
            None => self.execution.clone(),
        };
        let mut world = self.world(&variant.scene, &self.label(&variant.name), execution)?;
        let mut last = Some(LastStep::default());
        match (self.from, state) {
            (Some((from, done)), _) => {
                last = done.last.get(number).copied().flatten();
                if last.is_some() {
                    from.restore(number, &mut world)?;
                }
            }
            (None, Some(state)) => state.hand_over(&mut world, variant.rows),
            (None, None) => State::of(&mut world).hand_over(&mut world, variant.rows),
        }
        Ok(Runner {
            world,
            references: readings::references(&variant.scene),
            failed: last.is_none(),
            last: last.unwrap_or_default(),
        })
    }
}

/// Runs steps to the end of the span; `tell` gets the completed fraction.
fn advance(
    world: &mut World,
    span: Span,
    last: &mut LastStep,
    mut tell: impl FnMut(f64) -> ControlFlow<()>,
) -> Result<Block, Broken> {
    let mut block = Block::default();
    loop {
        let part = match span {
            Span::Steps(steps) => block.steps as f64 / steps as f64,
            // Time is a sum of many steps: a step that misses the end only by rounding has reached it.
            Span::Time(time) => block.time / f64::from(time) + 1e-6,
        };
        // A span without steps is 0/0.
        if part >= 1.0 || part.is_nan() {
            return Ok(block);
        }
        world.run_schedule(Step);
        let outcome: Result<StepReport, StepError> = world.resource::<StepOutcome>().0.clone();
        block.add(&outcome.map_err(Broken::Failed)?, last);
        if tell(part.max(0.0)).is_break() {
            return Err(Broken::Asked);
        }
    }
}

/// Counts the pairs of the last step's search.
fn count_pairs(world: &World, block: &mut Block) {
    let (index, positions) = (
        world.resource::<FluidIndex>(),
        world.resource::<Positions>(),
    );
    let of = &*index.structure;
    let points = positions.points();
    block.counts += 1.0;
    block.pairs = world
        .get_resource::<FluidNeighbours>()
        .map(|found| found.lists.pairs() as f64);
    block.tested_pairs += tested_pairs(&Search {
        of,
        points,
        among: of,
        among_points: points,
        same: true,
    }) as f64;
}
