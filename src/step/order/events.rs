//! An order as the list of what happens in a step: the only walk through its items.

use super::{
    error::{MOST_STAGES, OrderError},
    item::{Order, OrderItem},
};
use crate::{
    registry::Stages,
    scene::Scene,
    state::{Clock, Stage},
};

/// What happens in a step.
#[derive(Debug, Clone)]
pub(crate) enum Event {
    /// A stage runs that the scene asks for.
    Run {
        /// The stage.
        stage: Stage,
        /// Steps between two runs.
        every: u64,
        /// Path of its item in the file.
        path: String,
    },
    /// A group begins.
    Begin {
        /// Steps between two runs of the group, if it is an `Every`; else it is a `Repeat`.
        every: Option<u64>,
        /// How often it is run in a step, and which time this is.
        times: (u32, u32),
    },
    /// It ends.
    End,
}

/// A refusal, with the path of the item that it is about.
pub(crate) type Misplaced = (OrderError, String);

impl Order {
    /// What happens in a step of a scene, unchecked but for names and counts.
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

/// Stages that items run in a step at most.
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
                // Both are u32 at most.
                let every = every * u64::from(*count);
                if every > u64::from(u32::MAX) {
                    return Err((OrderError::TooRare { count: every }, path));
                }
                self.group(items, every, (Some(u64::from(*count)), (1, 0)), &path)
            }
            OrderItem::Repeat(times, items) => {
                // Without a stage in it it is gone through once, for its names.
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

/// Whether stages that run in every `every`-th step are due.
pub(crate) fn is_due(every: u64, clock: &Clock, rows_changed: bool) -> bool {
    clock.step.is_multiple_of(every) || rows_changed
}
