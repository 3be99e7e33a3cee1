//! An order as the list of events in a step: the only code that walks through its items.

use super::{
    condition::{Condition, Due},
    error::{MOST_STAGES, OrderError},
    item::{Order, OrderItem},
};
use crate::{
    boundary::friction,
    pairs::choice::KernelChoice,
    registry::Stages,
    scene::{KernelFunction, Scene, TimeStep},
    state::{Phase, Product, Stage},
};

/// Least support of a stage's kernel in spacings, as that of a scene.
const LEAST_SUPPORT: f32 = 1.2;

/// An event in a step.
#[derive(Debug, Clone)]
pub(crate) enum Event {
    /// A stage of this scene runs.
    Run {
        /// The stage.
        stage: Stage,
        /// When it is due.
        due: Due,
        /// Numbers of the groups with conditions around it.
        groups: Vec<usize>,
        /// The kernel of its sums, if it is not the scene's.
        kernel: Option<KernelChoice>,
        /// Path of its item in the file.
        path: String,
    },
    /// A group begins.
    Begin(Kind),
    /// The group ends.
    End(Kind),
}

/// A group of stages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// Every n-th step, from one of them on.
    Every(u64, u64),
    /// Under a condition: the number of the group, and the condition.
    When(usize, Condition),
    /// How many times it runs in a step, and the index of this repetition.
    Repeat(u32, u32),
    /// Likewise, each for a part of the step.
    SubSteps(u32, u32),
    /// Forces with another kernel.
    WithKernel(KernelChoice),
    /// Stages within the iterations of `pressure`, which is the last of them.
    InPressure,
}

impl Kind {
    /// Its name in an order.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Every(..) => "Every",
            Self::When(..) => "Group",
            Self::Repeat(..) => "Repeat",
            Self::SubSteps(..) => "SubSteps",
            Self::WithKernel(_) => "WithKernel",
            Self::InPressure => "InPressure",
        }
    }
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
            conditions: 0,
        };
        let around = Around {
            due: Due::ALWAYS,
            groups: Vec::new(),
            forces: None,
            kernel: None,
        };
        walk.items(&self.stages, &around, "stages")?;
        Ok(walk.events)
    }
}

/// Upper bound of the number of stages that the items run in a step.
fn count(items: &[OrderItem]) -> u64 {
    let of_item = |item: &OrderItem| match item {
        OrderItem::Run(_) => 1,
        OrderItem::Every(_, items)
        | OrderItem::Group { stages: items, .. }
        | OrderItem::WithKernel { stages: items, .. } => count(items),
        OrderItem::Repeat(times, items) | OrderItem::SubSteps(times, items) => {
            u64::from(*times).saturating_mul(count(items))
        }
        OrderItem::InPressure(items) => count(items).saturating_add(1),
    };
    items.iter().map(of_item).fold(0, u64::saturating_add)
}

/// The groups around an item.
#[derive(Clone)]
struct Around {
    due: Due,
    groups: Vec<usize>,
    /// Name of the group that only forces may be in.
    forces: Option<&'static str>,
    kernel: Option<KernelChoice>,
}

struct Walk<'a> {
    scene: &'a Scene,
    stages: &'a Stages,
    events: Vec<Event>,
    /// Number of groups with conditions so far.
    conditions: usize,
}

impl Walk<'_> {
    fn items(&mut self, items: &[OrderItem], around: &Around, path: &str) -> Result<(), Misplaced> {
        for (index, item) in items.iter().enumerate() {
            self.item(item, around, format!("{path}.{index}"))?;
        }
        Ok(())
    }

    fn item(&mut self, item: &OrderItem, around: &Around, path: String) -> Result<(), Misplaced> {
        let zero = |item| Err((OrderError::ZeroCount { item }, path.clone()));
        let times_of = |times: u32, items: &[OrderItem]| {
            // A group without stages is walked through once, to check its names.
            if count(items) == 0 { 1 } else { times }
        };
        match item {
            OrderItem::Run(name) => self.run(name, around, path),
            OrderItem::Every(0, _) => zero("Every"),
            OrderItem::Repeat(0, _) => zero("Repeat"),
            OrderItem::Group { every: 0, .. } => zero("Group"),
            OrderItem::SubSteps(0, _) => zero("SubSteps"),
            OrderItem::Every(count, items) => {
                self.every((*count, 0), items, around, (&path, &format!("{path}.1")))
            }
            OrderItem::Repeat(times, items) => {
                for k in 0..times_of(*times, items) {
                    let kind = Kind::Repeat(*times, k);
                    self.group(kind, items, around, &format!("{path}.1"))?;
                }
                Ok(())
            }
            OrderItem::Group {
                every,
                offset,
                when,
                stages,
            } => {
                if offset >= every {
                    let (offset, every) = (*offset, *every);
                    return Err((OrderError::Offset { offset, every }, path));
                }
                let mut inner = around.clone();
                let open = when.map(|when| self.condition(when, &mut inner, &path));
                let open = open.transpose()?;
                let places = (&*path, &*format!("{path}.stages"));
                if *every > 1 {
                    self.every((*every, *offset), stages, &inner, places)?;
                } else {
                    self.items(stages, &inner, places.1)?;
                }
                self.events.extend(open.map(Event::End));
                Ok(())
            }
            OrderItem::WithKernel {
                kernel,
                support,
                stages,
            } => {
                let (choice, inner) = self.choose((*kernel, *support), around, &path)?;
                let kind = Kind::WithKernel(choice);
                self.group(kind, stages, &inner, &format!("{path}.stages"))
            }
            OrderItem::SubSteps(times, items) => {
                let inner = self.forces_only("SubSteps", around, &path)?;
                let times = times_of(*times, items);
                for k in 0..times {
                    let kind = Kind::SubSteps(times, k);
                    self.group(kind, items, &inner, &format!("{path}.1"))?;
                }
                Ok(())
            }
            OrderItem::InPressure(items) => {
                let inner = self.forces_only("InPressure", around, &path)?;
                if self.scene.pressure.iterations().is_none() {
                    return Err((OrderError::NoIterations, path));
                }
                self.events.push(Event::Begin(Kind::InPressure));
                self.items(items, &inner, &format!("{path}.0"))?;
                self.run("pressure", around, path)?;
                self.events.push(Event::End(Kind::InPressure));
                Ok(())
            }
        }
    }

    /// Opens a group with a condition.
    fn condition(
        &mut self,
        when: Condition,
        inner: &mut Around,
        path: &str,
    ) -> Result<Kind, Misplaced> {
        if !when.is_sensible() {
            let condition = when.to_string();
            return Err((OrderError::Condition { condition }, format!("{path}.when")));
        }
        let kind = Kind::When(self.conditions, when);
        self.conditions += 1;
        inner.groups.extend([self.conditions - 1]);
        inner.due.sometimes = true;
        self.events.push(Event::Begin(kind));
        Ok(kind)
    }

    /// A group for forces with another kernel.
    fn choose(
        &self,
        (kernel, support): (Option<KernelFunction>, Option<f32>),
        around: &Around,
        path: &str,
    ) -> Result<(KernelChoice, Around), Misplaced> {
        if around.kernel.is_some() {
            let stage = "WithKernel";
            return Err((OrderError::NoKernelOfItsOwn { stage }, path.to_owned()));
        }
        let most = self.scene.support();
        let choice = KernelChoice {
            function: kernel.unwrap_or(self.scene.kernel()),
            support: support.unwrap_or(most),
        };
        if !(LEAST_SUPPORT..=most).contains(&choice.support) {
            let error = OrderError::Support {
                support: choice.support,
                least: LEAST_SUPPORT,
                most,
            };
            return Err((error, format!("{path}.support")));
        }
        let kernel = Some(choice);
        let inner = around.clone();
        Ok((choice, Around { kernel, ..inner }))
    }

    /// Whether a stage may have a kernel.
    fn may_have(&self, stage: &Stage, choice: KernelChoice) -> Result<(), OrderError> {
        let name = stage.name;
        if matches!(name, "density" | "divergence" | "pressure") {
            return Err(OrderError::KernelOfDensity { stage: name });
        }
        if !stage.has_own_kernel {
            return Err(OrderError::NoKernelOfItsOwn { stage: name });
        }
        if name == "viscosity" && friction::is_wanted(self.scene) {
            return Err(OrderError::KernelOfWalls);
        }
        let limits = (stage.limits)(&choice.scene(self.scene)).into_iter();
        let limit = limits.map(|limit| limit.1).fold(f32::INFINITY, f32::min);
        match self.scene.time_step {
            TimeStep::Cfl(cfl) if cfl.min > limit => Some(cfl.min),
            TimeStep::Adaptive(scheme) if scheme.min > limit => Some(scheme.min),
            _ => None,
        }
        .map_or(Ok(()), |min| {
            let stage = name;
            Err(OrderError::KernelNeedsShortSteps { stage, limit, min })
        })
    }

    /// A group for forces.
    fn forces_only(
        &self,
        group: &'static str,
        around: &Around,
        path: &str,
    ) -> Result<Around, Misplaced> {
        if let Some(outer) = around.forces {
            let (stage, group) = (group, outer);
            return Err((OrderError::NoForce { stage, group }, path.to_owned()));
        }
        Ok(Around {
            forces: Some(group),
            ..around.clone()
        })
    }

    fn every(
        &mut self,
        (count, offset): (u32, u32),
        items: &[OrderItem],
        around: &Around,
        (path, inner_path): (&str, &str),
    ) -> Result<(), Misplaced> {
        let outer = around.due;
        // Both factors are at most u32::MAX.
        let every = outer.every * u64::from(count);
        if every > u64::from(u32::MAX) {
            return Err((OrderError::TooRare { count: every }, path.to_owned()));
        }
        let mut inner = around.clone();
        inner.due = Due {
            every,
            offset: outer.offset + outer.every * u64::from(offset),
            ..outer
        };
        let kind = Kind::Every(count.into(), offset.into());
        self.group(kind, items, &inner, inner_path)
    }

    fn group(
        &mut self,
        kind: Kind,
        items: &[OrderItem],
        around: &Around,
        path: &str,
    ) -> Result<(), Misplaced> {
        self.events.push(Event::Begin(kind));
        self.items(items, around, path)?;
        self.events.push(Event::End(kind));
        Ok(())
    }

    fn run(&mut self, name: &str, around: &Around, path: String) -> Result<(), Misplaced> {
        let Some(stage) = self.stages.find(name) else {
            let known = self.stages.iter().map(|stage| stage.name).collect();
            let name = name.to_owned();
            return Err((OrderError::UnknownStage { name, known }, path));
        };
        let adds_force = stage.phase == Phase::Forces
            && !stage.invalidates
            && stage.makes.iter().all(|made| *made == Product::Forces)
            && stage.name != "clear_forces";
        if let Some(group) = around.forces.filter(|_| !adds_force) {
            let stage = stage.name;
            return Err((OrderError::NoForce { stage, group }, path));
        }
        if (stage.wanted)(self.scene) {
            let stage = *stage;
            let choice = around.kernel;
            if let Err(error) = choice.map_or(Ok(()), |choice| self.may_have(&stage, choice)) {
                return Err((error, path));
            }
            let Around {
                due,
                groups,
                kernel,
                ..
            } = around.clone();
            self.events.push(Event::Run {
                stage,
                due,
                groups,
                kernel,
                path,
            });
        }
        Ok(())
    }
}
