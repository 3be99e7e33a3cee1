//! One run of a point: its errors, its cost, and how it ended.

use std::ops::ControlFlow;
use std::time::Instant;

use super::{FrontierPlan, Reference, Subject, curves::curves};
use crate::{
    measure::{distance, range},
    scene::{Scene, unknown_name},
    study::stability::{Class, End},
    validate::{Findings, Spent, Stopped},
};

/// Why a run has no errors.
pub(super) enum Ended {
    /// How it ended, and why.
    Failed(Class, String),
    /// The case has no figure of a name, which no run would mend: what is wrong, and what would be right.
    NoFigure(String),
}

/// A finished run.
pub(super) struct Measured {
    /// Errors by figure.
    pub(super) errors: Result<Vec<f64>, Ended>,
    /// What it took.
    pub(super) spent: Spent,
}

/// Runs a scene and measures it. `None` if `stop` says so in between.
pub(super) fn measure(
    plan: &FrontierPlan,
    scene: &Scene,
    reference: &Reference,
    stop: &dyn Fn() -> bool,
) -> Option<Measured> {
    let started = Instant::now();
    let mut late = false;
    let mut tell = |_: f64| {
        late = started.elapsed().as_secs_f64() > plan.study.seconds;
        if late || stop() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let (spent, ended) = run(plan, scene, reference, &mut tell);
    let errors = match ended {
        Ok(Ok(errors)) if errors.iter().all(|error| error.is_finite()) => Ok(errors),
        Ok(Ok(_)) => Err(Ended::Failed(
            Class::Refused,
            "the run has nothing to compare: one of its figures is no number".to_owned(),
        )),
        Ok(Err(unknown)) => Err(Ended::NoFigure(unknown)),
        Err(Stopped::Asked) if late => {
            Err(Ended::Failed(Class::OutOfTime, End::OutOfTime.reason()))
        }
        Err(Stopped::Asked) => return None,
        Err(Stopped::Failed { error, .. }) => Err(match End::of(&error.cause) {
            End::Failed(class, _) => Ended::Failed(class, error.to_string()),
            end => Ended::Failed(Class::Refused, end.reason()),
        }),
        Err(Stopped::Refused(reason)) => Err(Ended::Failed(Class::Refused, reason)),
    };
    Some(Measured { errors, spent })
}

/// Errors by figure, or what is wrong with the name of one.
type Errors = Result<Vec<f64>, String>;

fn run(
    plan: &FrontierPlan,
    scene: &Scene,
    reference: &Reference,
    tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> (Spent, Result<Errors, Stopped>) {
    match &plan.subject {
        Subject::Case(case) => {
            let (spent, findings) = case.run_scene(scene, 1, tell);
            let figures = plan.study.measures();
            (spent, findings.map(|found| errors_of(&found, &figures)))
        }
        Subject::Scene { .. } => {
            let (spent, curves) = curves(plan, scene, 1, tell);
            let errors = curves.map(|curves| {
                let pairs = curves.iter().zip(&reference.curves);
                Ok(pairs
                    .map(|(found, known)| distance(found, known) / range(known))
                    .collect())
            });
            (spent, errors)
        }
    }
}

/// Errors of figures by name.
fn errors_of(found: &Findings, figures: &[String]) -> Errors {
    let known: Vec<&str> = found
        .figures
        .iter()
        .map(|figure| figure.quantity.as_str())
        .collect();
    let error = |name: &String| {
        let figure = found.figures.iter().find(|figure| figure.quantity == *name);
        let figure = figure.ok_or_else(|| unknown_name("figure", name, None, &known))?;
        Ok(figure.error().abs())
    };
    figures.iter().map(error).collect()
}
