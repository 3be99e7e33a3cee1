//! Checks an order: walks through two steps, stage by stage, and tracks which products are current.
//!
//! All stages run in the first step. The second step follows a reordering of the rows: of the stages within `Every`,
//! only those run that are due in every such step.

use super::{
    condition::Due,
    error::OrderError,
    events::{Event, Kind, Misplaced},
    item::Order,
};
use crate::{
    registry::Stages,
    scene::{Scene, TimeStep},
    state::{Product, Stage},
};

/// A product that a stage reads, and how old it may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Read {
    /// The product.
    pub(crate) product: Product,
    /// Its greatest age \[steps]; 0 if it is made in the same step.
    pub(crate) age: u64,
}

/// Checks that every stage that the scene asks for is in the order and finds its inputs. Returns what each stage reads.
pub(crate) fn check(
    order: &Order,
    events: &[Event],
    scene: &Scene,
    stages: &Stages,
) -> Result<Vec<Vec<Read>>, Misplaced> {
    let mut checker = Checker {
        scene,
        stages,
        allow_stale: order.allow_stale,
        current: Vec::new(),
        made: Vec::new(),
        made_sometimes: Vec::new(),
        moved: Vec::new(),
        reorders: false,
        is_later: false,
        reads: Vec::new(),
        at: 0,
        makers: makers(events),
    };
    checker.step(events)?;
    let runs = |name: &str| {
        events
            .iter()
            .any(|event| matches!(event, Event::Run { stage, .. } if stage.name == name))
    };
    let nowhere = |error| (error, "stages".to_owned());
    if !runs("integrate") {
        return Err(nowhere(OrderError::NeverIntegrates));
    }
    for (index, name) in order.leave_out.iter().enumerate() {
        let path = || format!("leave_out.{index}");
        let Some(stage) = stages.find(name) else {
            let known = stages.iter().map(|stage| stage.name).collect();
            let name = name.clone();
            return Err((OrderError::UnknownStage { name, known }, path()));
        };
        if runs(stage.name) {
            return Err((OrderError::RunsAndLeavesOut { stage: stage.name }, path()));
        }
    }
    let is_missing = |stage: &&Stage| {
        let is_left_out = order.leave_out.iter().any(|name| name == stage.name);
        (stage.wanted)(scene) && !runs(stage.name) && !is_left_out
    };
    if let Some(stage) = stages.iter().find(is_missing) {
        return Err(nowhere(OrderError::LeavesOut { stage: stage.name }));
    }
    let reads = std::mem::take(&mut checker.reads);
    if checker.reorders {
        checker.is_later = true;
        checker.current.clear();
        checker.step(events)?;
    }
    Ok(reads)
}

/// Every product that a step makes for certain: the event that makes it, and how often \[steps].
fn makers(events: &[Event]) -> Vec<(usize, Product, u64)> {
    let mut makers = Vec::new();
    for (at, event) in events.iter().enumerate() {
        if let Event::Run { stage, due, .. } = event
            && !due.sometimes
        {
            makers.extend(stage.makes.iter().map(|product| (at, *product, due.every)));
        }
    }
    makers
}

/// Products made so far.
struct Checker<'a> {
    scene: &'a Scene,
    stages: &'a Stages,
    allow_stale: bool,
    current: Vec<Product>,
    /// Each with the number of steps between two runs of the stage that made it.
    made: Vec<(Product, u64)>,
    /// Products that are made under a condition.
    made_sometimes: Vec<Product>,
    /// Products made before rows were reordered.
    moved: Vec<Product>,
    reorders: bool,
    /// Whether the walk is in the second step.
    is_later: bool,
    reads: Vec<Vec<Read>>,
    /// The event that the walk is at.
    at: usize,
    makers: Vec<(usize, Product, u64)>,
}

impl Checker<'_> {
    fn step(&mut self, events: &[Event]) -> Result<(), Misplaced> {
        // For each open group: the products that were current before it, and whether its own are stale after its end.
        let mut groups: Vec<(Vec<Product>, bool)> = Vec::new();
        let mut skipped = 0;
        let mut outer = vec![1];
        for (at, event) in events.iter().enumerate() {
            self.at = at;
            match event {
                Event::Begin(kind) => {
                    let (count, offset) = match kind {
                        Kind::Every(count, offset) => (*count, *offset),
                        _ => (1, 0),
                    };
                    let total = outer.last().map_or(1, |outer| outer * count);
                    outer.push(total);
                    let interval = u64::from(self.scene.reorder_interval.max(1));
                    if let Kind::SubSteps(..) | Kind::InPressure = kind
                        && skipped == 0
                        && !self.current.contains(&Product::Forces)
                    {
                        let lacks = OrderError::Lacks {
                            stage: kind.name(),
                            product: Product::Forces,
                            maker: "clear_forces",
                            stale: false,
                        };
                        return Err((lacks, "stages".to_owned()));
                    }
                    let is_conditional = matches!(kind, Kind::When(..));
                    let may_skip = is_conditional || offset > 0 || !interval.is_multiple_of(total);
                    if skipped > 0 || self.is_later && may_skip {
                        skipped += 1;
                    }
                    groups.push((self.current.clone(), count > 1 || is_conditional));
                }
                Event::End(_) => {
                    outer.pop();
                    skipped = skipped.max(1) - 1;
                    if let Some((before, true)) = groups.pop() {
                        // In steps where the group does not run, what its stages made earlier is stale.
                        self.current.retain(|product| before.contains(product));
                    }
                }
                Event::Run { .. } if skipped > 0 => {}
                Event::Run {
                    stage, due, path, ..
                } => {
                    self.stage(stage, *due)
                        .map_err(|error| (error, path.clone()))?;
                }
            }
        }
        Ok(())
    }

    fn stage(&mut self, stage: &Stage, due: Due) -> Result<(), OrderError> {
        let Due {
            every, sometimes, ..
        } = due;
        if sometimes && (stage.invalidates || stage.name == "gather") {
            return Err(OrderError::UnderCondition { stage: stage.name });
        }
        if every > 1 && stage.name == "integrate" {
            return Err(OrderError::WaitsForItself { count: every });
        }
        if every > 1 && stage.name == "reorder" {
            return Err(OrderError::TwoIntervals { count: every });
        }
        if matches!(stage.name, "emit" | "outflow") && self.current.contains(&Product::Columns) {
            return Err(OrderError::WithinStep { stage: stage.name });
        }
        if every > 1 && stage.name == "emit" {
            return Err(OrderError::EntersLate { count: every });
        }
        let mut reads = Vec::new();
        for &product in stage.needs {
            reads.extend(self.need(stage, product)?);
        }
        self.reads.push(reads);
        if stage.invalidates {
            self.current.clear();
        }
        if stage.name == "reorder" {
            self.reorders = true;
            self.moved = self.made.iter().map(|made| made.0).collect();
        }
        self.current.extend(stage.makes);
        if sometimes {
            // What is made in every n-th step, too, is at most that old.
            self.made_sometimes.extend(stage.makes);
            return Ok(());
        }
        self.moved.retain(|product| !stage.makes.contains(product));
        self.made.retain(|made| !stage.makes.contains(&made.0));
        self.made
            .extend(stage.makes.iter().map(|product| (*product, every)));
        Ok(())
    }

    /// Finds a product that a stage needs; `None` if no stage makes it in this scene.
    fn need(&self, stage: &Stage, product: Product) -> Result<Option<Read>, OrderError> {
        // A stage does not lack a product that no stage makes in this scene (lists, if neighbours are recomputed).
        let makes = |stage: &&Stage| stage.makes.contains(&product) && (stage.wanted)(self.scene);
        let Some(maker) = self.stages.iter().find(makes) else {
            return Ok(None);
        };
        if self.current.contains(&product) {
            return Ok(Some(Read { product, age: 0 }));
        }
        let (stage, maker) = (stage.name, maker.name);
        let made = self.made.iter().find(|made| made.0 == product);
        if made.is_none() && self.made_sometimes.contains(&product) {
            return Err(OrderError::MadeSometimes {
                stage,
                product,
                maker,
            });
        }
        let Some(&(_, every)) = made.filter(|_| self.allow_stale && product != Product::Columns)
        else {
            return Err(OrderError::Lacks {
                stage,
                product,
                maker,
                stale: made.is_some(),
            });
        };
        if matches!(self.scene.time_step, TimeStep::Adaptive(_)) {
            return Err(OrderError::CannotGoBack { stage, product });
        }
        // The divergence solve changes velocities, which move with their particles when rows are reordered.
        if self.reorders && self.moved.contains(&product) && product != Product::Divergence {
            return Err(OrderError::RowsMove {
                stage,
                product,
                maker,
                period: u64::from(self.scene.reorder_interval.max(1)),
            });
        }
        // What is made later in the step is there since the step before, at the latest.
        let later = self.makers.iter().filter(|made| made.0 > self.at);
        let later = later.filter(|made| made.1 == product).map(|made| made.2);
        let age = later.fold(every.max(2) - 1, u64::min);
        Ok(Some(Read { product, age }))
    }
}
