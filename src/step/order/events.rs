//! An order as the list of events in a step: the only code that walks through its items.

use super::{
    error::{MOST_STAGES, OrderError},
    item::{Order, OrderItem},
};
use crate::{
    registry::Stages,
    scene::Scene,
    state::{Clock, Stage},
};

/// An event in a step.
#[derive(Debug, Clone)]
pub(crate) enum Event {
    /// A stage of this scene runs.
    Run {
        /// The stage.
        stage: Stage,
        /// Number of steps between two runs.
        every: u64,
        /// Path of its item in the file.
        path: String,
    },
    /// A group begins.
    Begin {
        /// Number of steps between two runs of the group if it is an `Every`; `None` for a `Repeat`.
        every: Option<u64>,
        /// How many times it runs in a step, and the index of this repetition.
        times: (u32, u32),
    },
    /// The group ends.
    End,
}

/// An error, with the path of the item that caused it.
pub(crate) type Misplaced = (OrderError, String);

impl Order {
    /// The events in a step of a scene. Only names and counts are checked here.
    pub(crate) fn events(&self, scene: &Scene, stages: &Stages) -> Result<Vec<Event>, Misplaced> {
        let count = count(&self.stages);
        if count > MOST_STAGES {
            return Err((OrderError::TooManyStages { count }, "stages".to_owned()));
        }
        let mut walk = Walk {
            scene,
            stages,
            events: Vec::new(),
        };
        walk.items(&self.stages, 1, "stages")?;
        Ok(walk.events)
    }
}

/// Upper bound of the number of stages that the items run in a step.
fn count(items: &[OrderItem]) -> u64 {
    let of_item = |item: &OrderItem| match item {
        OrderItem::Run(_) => 1,
        OrderItem::Every(_, items) => count(items),
        OrderItem::Repeat(times, items) => u64::from(*times).saturating_mul(count(items)),
    };
    items.iter().map(of_item).fold(0, u64::saturating_add)
}

struct Walk<'a> {
    scene: &'a Scene,
    stages: &'a Stages,
    events: Vec<Event>,
}

impl Walk<'_> {
    fn items(&mut self, items: &[OrderItem], every: u64, path: &str) -> Result<(), Misplaced> {
        for (index, item) in items.iter().enumerate() {
            self.item(item, every, format!("{path}.{index}"))?;
        }
        Ok(())
    }

    fn item(&mut self, item: &OrderItem, every: u64, path: String) -> Result<(), Misplaced> {
        match item {
            OrderItem::Run(name) => self.run(name, every, path),
            OrderItem::Every(0, _) => Err((OrderError::ZeroCount { item: "Every" }, path)),
            OrderItem::Repeat(0, _) => Err((OrderError::ZeroCount { item: "Repeat" }, path)),
            OrderItem::Every(count, items) => {
                // Both factors are at most u32::MAX.
                let every = every * u64::from(*count);
                if every > u64::from(u32::MAX) {
                    return Err((OrderError::TooRare { count: every }, path));
                }
                self.group(items, every, (Some(u64::from(*count)), (1, 0)), &path)
            }
            OrderItem::Repeat(times, items) => {
                // A group without stages is walked through once, to check its names.
                let runs = if count(items) == 0 { 1 } else { *times };
                let mut runs = 0..runs;
                runs.try_for_each(|k| self.group(items, every, (None, (*times, k)), &path))
            }
        }
    }

    fn group(
        &mut self,
        items: &[OrderItem],
        every: u64,
        (count, times): (Option<u64>, (u32, u32)),
        path: &str,
    ) -> Result<(), Misplaced> {
        self.events.push(Event::Begin {
            every: count,
            times,
        });
        self.items(items, every, &format!("{path}.1"))?;
        self.events.push(Event::End);
        Ok(())
    }

    fn run(&mut self, name: &str, every: u64, path: String) -> Result<(), Misplaced> {
        let Some(stage) = self.stages.find(name) else {
            let known = self.stages.iter().map(|stage| stage.name).collect();
            let name = name.to_owned();
            return Err((OrderError::UnknownStage { name, known }, path));
        };
        if (stage.wanted)(self.scene) {
            let stage = *stage;
            self.events.push(Event::Run { stage, every, path });
        }
        Ok(())
    }
}

/// Whether a stage that runs every `every` steps is due.
pub(crate) fn is_due(every: u64, clock: &Clock, rows_changed: bool) -> bool {
    clock.step.is_multiple_of(every) || rows_changed
}
