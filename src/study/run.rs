//! Runs a study: the variants of a case take turns, block by block.
//!
//! Other programs start and stop on a machine, and its clock rate changes with them. Variants measured one after the
//! other would each find different conditions. In turns (A B C A B C …) they find the same conditions, and the spread
//! over the blocks shows how steady these were.

use std::ops::ControlFlow;

use bevy_ecs::prelude::*;

use super::{
    Block, Plan, PlannedCase, PlannedVariant, Span, StudyError, Table, measure::LastStep, readings,
    start::State,
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
    /// Every variant of a case has finished a block; the table holds the results so far.
    Turn(&'a Table),
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
    let execution = Execution::new(threads)?;
    let mut table = Table::new(plan);
    let wants_pairs = (plan.study.columns.iter()).any(|column| column.measure.counts_pairs());
    for (number, case) in plan.cases.iter().enumerate() {
        let mut turns = Turns {
            plan,
            case,
            execution: &execution,
            wants_pairs,
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
        let state = match self.start()? {
            ControlFlow::Continue(state) => state,
            ControlFlow::Break(()) => return Ok(ControlFlow::Break(())),
        };
        let stage = self.label("measuring");
        let mut runners = Vec::new();
        if self.begin(&stage).is_break() {
            return Ok(ControlFlow::Break(()));
        }
        for variant in &self.case.variants {
            runners.push(self.runner(variant, state.as_ref())?);
        }
        let turns = self.plan.study.blocks + 1;
        for turn in 0..turns {
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
            if (self.tell)(Event::Turn(table)).is_break() {
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(()))
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
        variant: &PlannedVariant,
        state: Option<&State>,
    ) -> Result<Runner, StudyError> {
        let execution = match variant.threads {
            Some(threads) => Execution::new(threads as usize)?,
            None => self.execution.clone(),
        };
        let mut world = self.world(&variant.scene, &self.label(&variant.name), execution)?;
        match state {
            Some(state) => state.hand_over(&mut world, variant.rows),
            None => State::of(&mut world).hand_over(&mut world, variant.rows),
        }
        Ok(Runner {
            world,
            references: readings::references(&variant.scene),
            failed: false,
            last: LastStep::default(),
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
