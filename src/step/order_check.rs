//! The check of an order: two steps are walked through, stage by stage, with what is current at each.
//!
//! The first is one in which all stages run. The second is one after a reordering of the rows: of the stages within
//! `Every` only those run that surely do then.

use super::{
    order::{MOST_STAGES, Order, OrderError, OrderItem, stages},
    stage::{Datum, Stage},
};
use crate::scene::{Scene, TimeStep};

pub(super) fn check(order: &Order, scene: &Scene) -> Result<(), OrderError> {
    let count = stages(&order.stages);
    if count > MOST_STAGES {
        return Err(OrderError::TooManyStages { count });
    }
    let mut checker = Checker {
        scene,
        allow_stale: order.allow_stale,
        current: Vec::new(),
        made: Vec::new(),
        moved: Vec::new(),
        reorder_period: None,
        ran: Vec::new(),
        is_later: false,
    };
    checker.items(&order.stages, 1)?;
    if !checker.ran.contains(&"integrate") {
        return Err(OrderError::NeverIntegrates);
    }
    all_are_there(order, scene, &checker.ran)?;
    if checker.reorder_period.is_some() {
        checker.is_later = true;
        checker.current.clear();
        checker.items(&order.stages, 1)?;
    }
    Ok(())
}

/// Every stage that the scene wants runs, or the order says that it shall not.
fn all_are_there(order: &Order, scene: &Scene, ran: &[&str]) -> Result<(), OrderError> {
    let mut left_out = Vec::new();
    for name in &order.leave_out {
        let stage = Stage::find(name)?.name;
        if ran.contains(&stage) {
            return Err(OrderError::RunsAndLeavesOut { stage });
        }
        left_out.push(stage);
    }
    let missing = Stage::ALL.iter().find(|stage| {
        (stage.wanted)(scene) && !ran.contains(&stage.name) && !left_out.contains(&stage.name)
    });
    missing.map_or(Ok(()), |stage| {
        Err(OrderError::LeavesOut { stage: stage.name })
    })
}

/// What a step has made so far.
struct Checker<'a> {
    scene: &'a Scene,
    allow_stale: bool,
    current: Vec<Datum>,
    made: Vec<Datum>,
    /// What was made before the rows moved.
    moved: Vec<Datum>,
    /// Steps between two reorderings, if there are any.
    reorder_period: Option<u64>,
    ran: Vec<&'static str>,
    /// Whether this is the second step.
    is_later: bool,
}

impl Checker<'_> {
    /// Walks through items that run in every `every`th step.
    fn items(&mut self, items: &[OrderItem], every: u64) -> Result<(), OrderError> {
        for item in items {
            match item {
                OrderItem::Run(name) => self.stage(Stage::find(name)?, every)?,
                OrderItem::Every(0, _) => return Err(OrderError::ZeroCount { item: "Every" }),
                OrderItem::Repeat(0, _) => return Err(OrderError::ZeroCount { item: "Repeat" }),
                // There is no stage in it, however often it is repeated.
                OrderItem::Repeat(_, items) if stages(items) == 0 => self.items(items, every)?,
                OrderItem::Repeat(count, items) => {
                    (0..*count).try_for_each(|_| self.items(items, every))?;
                }
                OrderItem::Every(count, items) => self.every(*count, items, every)?,
            }
        }
        Ok(())
    }

    fn every(&mut self, count: u32, items: &[OrderItem], outer: u64) -> Result<(), OrderError> {
        // Both are u32 at most.
        let every = outer * u64::from(count);
        if every > u64::from(u32::MAX) {
            return Err(OrderError::TooRare { count: every });
        }
        let runs = self
            .reorder_period
            .is_some_and(|period| period.is_multiple_of(every));
        if self.is_later && !runs {
            return Ok(());
        }
        let before = self.current.clone();
        self.items(items, every)?;
        if count > 1 {
            // In the steps between, what these stages make is left over.
            self.current.retain(|datum| before.contains(datum));
        }
        Ok(())
    }

    fn stage(&mut self, stage: &'static Stage, every: u64) -> Result<(), OrderError> {
        if !(stage.wanted)(self.scene) {
            return Ok(());
        }
        if stage.name == "integrate" && every > 1 {
            return Err(OrderError::WaitsForItself { count: every });
        }
        for &datum in stage.needs {
            self.need(stage, datum)?;
        }
        if stage.spoils_all {
            self.current.clear();
        }
        if stage.name == "reorder" {
            let interval = u64::from(self.scene.reorder_interval.max(1));
            self.reorder_period = Some(least_common_multiple(every, interval));
            self.moved.clone_from(&self.made);
        }
        self.moved.retain(|datum| !stage.makes.contains(datum));
        self.current.extend(stage.makes);
        self.made.extend(stage.makes);
        self.ran.push(stage.name);
        Ok(())
    }

    fn need(&self, stage: &'static Stage, datum: Datum) -> Result<(), OrderError> {
        // What no stage makes in this scene (lists, where neighbours are recomputed) nobody lacks.
        let makes = |s: &&Stage| s.makes.contains(&datum) && (s.wanted)(self.scene);
        let Some(maker) = Stage::ALL.iter().find(makes) else {
            return Ok(());
        };
        if self.current.contains(&datum) {
            return Ok(());
        }
        let (stage, maker) = (stage.name, maker.name);
        let stale = self.made.contains(&datum);
        if !(stale && self.allow_stale) {
            return Err(OrderError::Lacks {
                stage,
                datum,
                maker,
                stale,
            });
        }
        if matches!(self.scene.time_step, TimeStep::Adaptive(_)) {
            return Err(OrderError::CannotGoBack { stage, datum });
        }
        if let Some(period) = self.reorder_period
            && self.moved.contains(&datum)
            // What a divergence solve leaves are velocities, which go with their particles.
            && datum != Datum::Divergence
        {
            return Err(OrderError::RowsMove {
                stage,
                datum,
                maker,
                period,
            });
        }
        Ok(())
    }
}

/// Both are u32 at most, so their product is a u64.
fn least_common_multiple(a: u64, b: u64) -> u64 {
    let (mut divisor, mut rest) = (a, b);
    while rest > 0 {
        (divisor, rest) = (rest, divisor % rest);
    }
    a / divisor * b
}
