//! Curves of the study's gauges in a run.

use std::ops::ControlFlow;

use super::{FrontierPlan, GaugeColumn, Subject};
use crate::{
    Simulation,
    scene::Scene,
    validate::{Runner, Spent, Stopped},
};

/// Times \[s] and figures of a gauge.
pub(super) type Readings = Vec<(f64, f64)>;

/// The curves of the study's gauges in a run of a scene on `threads` threads.
pub(super) fn curves(
    plan: &FrontierPlan,
    scene: &Scene,
    threads: usize,
    tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> (Spent, Result<Vec<Readings>, Stopped>) {
    let Subject::Scene { gauges, .. } = &plan.subject else {
        return (Spent::default(), Ok(Vec::new()));
    };
    let simulation = match Simulation::with_threads(scene, threads) {
        Ok(simulation) => simulation,
        Err(error) => return (Spent::default(), Err(Stopped::Refused(error.to_string()))),
    };
    let mut runner = Runner::new(simulation, tell);
    let ended = runner.steps(scene.duration.into(), |_, _| {});
    let readings = || {
        let of_gauge = |of: &GaugeColumn| {
            let gauge = scene.gauges.iter().find(|gauge| gauge.name == of.gauge);
            let first = gauge.and_then(|gauge| gauge.columns().into_iter().next());
            let column = of.column.clone().or(first).unwrap_or_default();
            runner.readings(&of.gauge, &column)
        };
        gauges.iter().map(of_gauge).collect()
    };
    (runner.spent(), ended.map(|()| readings()))
}
