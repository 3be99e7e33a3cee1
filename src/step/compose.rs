//! The systems of a step, from the events of an order.

use bevy_ecs::prelude::*;

use super::{
    constants::check_accelerations,
    order::{Compared, Condition, Decisions, Due, Event, Kind, PlannedOrder},
    timer::lap,
};
use crate::{
    force::inner::{self, InnerForces},
    pairs::choice::{self, OwnKernel},
    ranks,
    registry::Stages,
    scene::Scene,
    state::{
        Clock, Phase, Rows, Stage, Systems, agree,
        failure::healthy,
        seal::{check, is_whole, refuse, seal},
    },
};

/// Systems of the stages, one after the other.
pub(super) struct Composed {
    /// Of the step.
    pub(super) step: Vec<Systems>,
    /// Of the beginning of every iteration of the pressure solve.
    pub(super) iteration: Vec<Systems>,
}

/// The stages of an order, each followed by the system that records its time.
pub(super) fn compose(order: &PlannedOrder, scene: &Scene, on_ranks: bool) -> Composed {
    let mut composed = Composed {
        step: Vec::new(),
        iteration: Vec::new(),
    };
    for event in order.events() {
        if let Event::Begin(Kind::When(group, when)) = event {
            composed.step.push(decide(*group, *when).run_if(healthy));
        }
    }
    let mut is_inside = false;
    let own = Stages::default();
    let mut last: Option<(Phase, bool)> = None;
    for event in order.events() {
        if let (Event::Run { stage, .. }, false) = (event, is_inside) {
            let now = (stage.phase, own.find(stage.name).is_none());
            if last.is_none_or(|last| last != now || now.1) {
                composed.step.push(border(last.map(|last| last.0), now.0));
            }
            last = Some(now);
        }
        let systems = match event {
            Event::Begin(Kind::InPressure) => {
                is_inside = true;
                composed.step.push(inner::before_pressure().run_if(healthy));
                inner::begin_iteration()
            }
            Event::End(Kind::InPressure) => continue,
            Event::Run { stage, .. } if is_inside && stage.name == "pressure" => {
                composed.iteration.push(inner::end_iteration());
                is_inside = false;
                last = Some((stage.phase, false));
                run(event, scene)
            }
            Event::Run { stage, .. } if on_ranks => {
                composed.step.extend(run_on_ranks(stage, scene));
                continue;
            }
            Event::Run { .. } => run(event, scene),
            Event::Begin(Kind::SubSteps(_, 0)) => (inner::begin(), inner::start()).chain(),
            Event::Begin(Kind::SubSteps(..)) => inner::start(),
            Event::End(Kind::SubSteps(times, k)) if k + 1 == *times => {
                (inner::advance(*times), inner::end()).chain()
            }
            Event::End(Kind::SubSteps(times, _)) => inner::advance(*times),
            Event::Begin(Kind::WithKernel(kernel)) => kernel.begin(scene),
            Event::End(Kind::WithKernel(_)) => choice::end(),
            Event::Begin(_) | Event::End(_) => continue,
        };
        let list = if is_inside {
            &mut composed.iteration
        } else {
            &mut composed.step
        };
        list.push(systems.run_if(is_whole));
        if let (Event::Run { stage, .. }, false) = (event, is_inside) {
            list.push(lap(stage.phase).in_set(stage.phase));
        }
    }
    composed
        .step
        .push(border(last.map(|last| last.0), Phase::Observe));
    composed
}

/// Between two phases, where systems of a host may run: finds what they wrote.
pub(super) fn border(from: Option<Phase>, to: Phase) -> Systems {
    let looked = (check.ambiguous_with_all(), refuse).chain().in_set(to);
    match from {
        Some(from) => (seal.ambiguous_with_all().in_set(from), looked).chain(),
        None => looked,
    }
}

/// The systems of a stage and what ranks do before and after it. All ranks know whether one has failed, before the next
/// systems of which one may wait for others.
fn run_on_ranks(stage: &Stage, scene: &Scene) -> Vec<Systems> {
    let mut systems: Vec<Systems> = ranks::before(stage.name).into_iter().collect();
    if stage.name == "pressure" {
        systems.push(check_accelerations.into_configs());
    }
    systems.push(ranks::instead_of(stage.name).unwrap_or_else(|| (stage.systems)(scene)));
    systems.extend(ranks::after(stage.name, scene));
    let agreed = |systems: Systems| {
        let systems = systems.run_if(healthy);
        (systems, agree).chain().in_set(stage.phase)
    };
    let lap = lap(stage.phase).in_set(stage.phase);
    systems.into_iter().map(agreed).chain([lap]).collect()
}

/// The systems of a stage, when it is due.
fn run(event: &Event, scene: &Scene) -> Systems {
    let Event::Run {
        stage, due, groups, ..
    } = event
    else {
        return (|| {}).into_configs();
    };
    let (stage, due, groups): (&Stage, Due, Vec<usize>) = (stage, *due, groups.clone());
    let mut systems = (stage.systems)(scene).in_set(stage.phase);
    if stage.name == "pressure" {
        // Hosts add forces right before.
        let check = check_accelerations.in_set(stage.phase);
        systems = (check, systems.run_if(healthy)).chain();
    }
    if due.every > 1 {
        systems = systems
            .run_if(move |clock: Res<Clock>, rows: Res<Rows>| due.is_now(&clock, rows.changed));
    }
    if !groups.is_empty() {
        systems = systems.run_if(move |decisions: Res<Decisions>| {
            let holds = |group: &usize| decisions.0.get(*group).copied().unwrap_or_default();
            groups.iter().all(holds)
        });
    }
    systems
}

/// Decides whether a group runs in this step.
fn decide(group: usize, when: Condition) -> Systems {
    let decide = move |mut decisions: ResMut<Decisions>, compared: Compared| {
        if decisions.0.len() <= group {
            decisions.0.resize(group + 1, false);
        }
        decisions.0[group] = when.holds(&compared);
    };
    decide.into_configs()
}

/// Inserts what the groups of an order use.
pub(super) fn install(world: &mut World, order: &PlannedOrder) {
    for event in order.events() {
        match event {
            Event::Begin(Kind::When(..)) => world.init_resource::<Decisions>(),
            Event::Begin(Kind::SubSteps(..) | Kind::InPressure) => {
                world.init_resource::<InnerForces>()
            }
            Event::Begin(Kind::WithKernel(_)) => world.init_resource::<OwnKernel>(),
            _ => continue,
        };
    }
}
