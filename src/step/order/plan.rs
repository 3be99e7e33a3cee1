//! A checked order for one scene: the source of its schedule and of its descriptions.

use super::{
    check::{Read, check},
    condition::Due,
    error::OrderError,
    events::{Event, Kind, Misplaced},
    item::Order,
};
use crate::{
    pairs::choice::KernelChoice,
    registry::Stages,
    scene::Scene,
    state::{Limit, Phase, Product, Stage},
};

/// A checked order.
#[derive(Debug, Clone)]
pub(crate) struct PlannedOrder {
    events: Vec<Event>,
    /// What each stage reads, in the order of the stages.
    reads: Vec<Vec<Read>>,
}

/// A stage of a step, and how often it runs.
#[derive(Debug, Clone)]
pub(crate) struct PlannedStage {
    /// The stage.
    pub(crate) stage: Stage,
    /// When it is due.
    pub(crate) due: Due,
}

impl Order {
    /// Checks that every built-in stage that the scene asks for is in the order and finds its inputs.
    pub fn check(&self, scene: &Scene) -> Result<(), OrderError> {
        let planned = self.plan(scene, &Stages::default());
        planned.map(|_| ()).map_err(|(error, _)| error)
    }

    /// Checks the order for a scene. Fails if a stage is missing or lacks an input.
    pub(crate) fn plan(&self, scene: &Scene, stages: &Stages) -> Result<PlannedOrder, Misplaced> {
        let events = self.events(scene, stages)?;
        let reads = check(self, &events, scene, stages)?;
        Ok(PlannedOrder { events, reads })
    }
}

impl PlannedOrder {
    /// The stages, one after the other.
    pub(crate) fn stages(&self) -> impl Iterator<Item = PlannedStage> {
        self.events.iter().filter_map(|event| match event {
            Event::Run { stage, due, .. } => Some(PlannedStage {
                stage: *stage,
                due: *due,
            }),
            Event::Begin(_) | Event::End(_) => None,
        })
    }

    /// The events in a step.
    pub(in crate::step) fn events(&self) -> &[Event] {
        &self.events
    }

    /// Whether a stage reads what an earlier step left.
    pub(crate) fn reads_stale(&self) -> bool {
        self.reads.iter().flatten().any(|read| read.age > 0)
    }

    /// Stages with another kernel than the scene's, and that kernel.
    pub(crate) fn with_kernels(&self) -> Vec<(Stage, KernelChoice)> {
        let of = |event: &Event| match event {
            Event::Run { stage, kernel, .. } => kernel.map(|kernel| (*stage, kernel)),
            Event::Begin(_) | Event::End(_) => None,
        };
        self.events.iter().filter_map(of).collect()
    }

    /// Names of the stages with what decides when they run, for comparison with another order.
    pub(crate) fn names(&self) -> Vec<(String, u64)> {
        let mut open: Vec<Kind> = Vec::new();
        let mut names = Vec::new();
        for event in &self.events {
            match event {
                Event::Begin(kind) => open.push(*kind),
                Event::End(_) => drop(open.pop()),
                Event::Run { stage, due, .. } => {
                    let mut name = stage.name.to_owned();
                    if due.offset > 0 {
                        name.push_str(&format!(" from {}", due.offset));
                    }
                    for kind in &open {
                        match kind {
                            Kind::When(_, when) => name.push_str(&format!(" when {when}")),
                            Kind::SubSteps(times, _) => {
                                name.push_str(&format!(" in {times} sub-steps"));
                            }
                            Kind::InPressure => name.push_str(" in pressure"),
                            Kind::WithKernel(_) => name.push_str(&format!(" {}", label_of(kind))),
                            Kind::Every(..) | Kind::Repeat(..) => {}
                        }
                    }
                    names.push((name, due.every));
                }
            }
        }
        names
    }

    /// The stages in the order of their first run, without duplicates.
    pub(crate) fn installed(&self) -> Vec<Stage> {
        let mut installed: Vec<Stage> = Vec::new();
        for PlannedStage { stage, .. } in self.stages() {
            if installed.iter().all(|known| known.name != stage.name) {
                installed.push(stage);
            }
        }
        installed
    }

    /// Whether the stages run in the order of their phases.
    pub(crate) fn keeps_phases(&self) -> bool {
        self.stages().map(|planned| planned.stage.phase).is_sorted()
    }

    /// Whether stage `second` follows `first` in every step, both run once, and only stages that add forces run between
    /// them.
    pub(crate) fn follows(&self, second: &str, first: &str) -> bool {
        let mut depth = 0;
        let mut open = false;
        let mut found = [0, 0];
        let mut between = true;
        for event in &self.events {
            match event {
                Event::Begin(_) => {
                    depth += 1;
                    between &= !open;
                }
                Event::End(_) => depth -= 1,
                Event::Run { stage, .. } if stage.name == first => {
                    found[0] += 1;
                    open = true;
                    between &= depth == 0;
                }
                Event::Run { stage, .. } if stage.name == second => {
                    found[1] += 1;
                    between &= depth == 0 && open;
                    open = false;
                }
                Event::Run { stage, .. } if open => {
                    between &= !stage.invalidates
                        && stage.makes.iter().all(|made| *made == Product::Forces);
                }
                Event::Run { .. } => {}
            }
        }
        between && found == [1, 1]
    }

    /// Descriptions of the stages by phase. A group of one stage is written `every 2 steps: a`, a longer one `every 2
    /// steps { a` to `b }`, possibly across several phases.
    pub(crate) fn lines(&self) -> Vec<(Phase, Vec<String>)> {
        let mut lines = self.group(&mut 0);
        let mut out: Vec<(Phase, Vec<String>)> = Vec::new();
        for (phase, line) in lines.drain(..) {
            match out.last_mut() {
                Some((last, lines)) if *last == phase => lines.push(line),
                _ => out.push((phase, vec![line])),
            }
        }
        out
    }

    /// Lines of the events from index `at` to the end of their group.
    fn group(&self, at: &mut usize) -> Vec<(Phase, String)> {
        let mut lines = Vec::new();
        while let Some(event) = self.events.get(*at) {
            *at += 1;
            match event {
                Event::End(_) => break,
                Event::Run { stage, .. } => lines.push((stage.phase, stage.name.to_owned())),
                Event::Begin(kind) => {
                    let mut inner = self.group(at);
                    let label = match kind {
                        Kind::Every(every, 0) => format!("every {every} steps"),
                        Kind::Every(every, offset) => format!("every {every} steps from {offset}"),
                        Kind::When(_, when) => format!("when {when}"),
                        Kind::Repeat(times, 0) => format!("{times} times"),
                        Kind::SubSteps(times, 0) => format!("in {times} sub-steps"),
                        Kind::InPressure => "in every iteration".to_owned(),
                        Kind::WithKernel(_) => label_of(kind),
                        // Described at its first repetition.
                        Kind::Repeat(..) | Kind::SubSteps(..) => continue,
                    };
                    match inner.as_mut_slice() {
                        [] => {}
                        [(_, only)] => *only = format!("{label}: {only}"),
                        [(_, first), .., (_, last)] => {
                            *first = format!("{label} {{ {first}");
                            last.push_str(" }");
                        }
                    }
                    lines.append(&mut inner);
                }
            }
        }
        lines
    }

    /// The data flow: what every stage reads, how old that may be, and what it makes.
    pub(crate) fn flow(&self) -> Vec<Flow> {
        let of = |(planned, reads): (PlannedStage, &Vec<Read>)| Flow {
            stage: planned.stage.name,
            every: planned.due.every,
            reads: reads.iter().map(|read| (read.product, read.age)).collect(),
            writes: planned.stage.makes.to_vec(),
        };
        self.stages().zip(&self.reads).map(of).collect()
    }
}

/// A kernel in words.
fn label_of(kind: &Kind) -> String {
    match kind {
        Kind::WithKernel(KernelChoice { function, support }) => {
            format!("with {function:?} of {support} spacings")
        }
        _ => String::new(),
    }
}

/// Limits on the time step by stages with kernels of their own, which do not change in a run.
pub(in crate::step) fn limits_of(stages: &[(Stage, KernelChoice)], scene: &Scene) -> Vec<Limit> {
    let of = |(stage, kernel): &(Stage, KernelChoice)| (stage.limits)(&kernel.scene(scene));
    stages.iter().flat_map(of).collect()
}

/// What a stage reads and writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Flow {
    /// Name of the stage.
    pub stage: &'static str,
    /// Number of steps between two runs.
    pub every: u64,
    /// Products that it reads, each with its greatest age \[steps].
    pub reads: Vec<(Product, u64)>,
    /// Products that it writes.
    pub writes: Vec<Product>,
}
