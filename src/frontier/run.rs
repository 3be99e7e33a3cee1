//! Runs the points of a frontier study, several at a time with one thread each.

use std::ops::ControlFlow;

use super::{
    FrontierPlan, PlannedPoint, Reference, Run, Runs,
    measure::{Ended, Measured, measure},
};
use crate::study::{
    command,
    pool::{Desk, Word, each},
    stability::{Class, key_of, scene_text},
};
use crate::validate::Spent;

/// Progress of a frontier study.
pub enum FrontierEvent<'a> {
    /// Points are being run.
    Waiting {
        /// Completed fraction of all runs, 0 to 1.
        fraction: f64,
    },
    /// A run is finished.
    Done {
        /// Its lines.
        lines: &'a [Run],
        /// The lines of all runs so far, in no order.
        all: &'a Runs,
        /// Whether it is one of an older run of the study.
        known: bool,
        /// Completed fraction of all runs, 0 to 1.
        fraction: f64,
    },
}

/// Runs the points of `plan` on `threads` threads, except those runs that `known` has. `version` is that of the
/// program: a run of another one is made again. `tell` is called for every run, and ten times a second; it may stop the
/// study.
/// Returns the lines of all finished runs, in the order of the study. Fails if a figure of the study is none of the
/// case's.
pub fn run_frontier(
    plan: &FrontierPlan,
    reference: &Reference,
    known: &Runs,
    (threads, version): (usize, &str),
    tell: &mut dyn FnMut(FrontierEvent) -> ControlFlow<()>,
) -> Result<Runs, String> {
    // Every point once, then again: after an interruption there is a point of each setting first.
    let repeats = plan.study.repeats as usize;
    let total = plan.points.len() * repeats;
    let mut all = Runs::default();
    let mut done = 0;
    let mut wrong = None;
    let work = |number: usize, desk: &Desk<Done>| {
        let (repeat, point) = (number / plan.points.len(), number % plan.points.len());
        let worker = Worker {
            plan,
            reference,
            known,
            version,
            desk,
        };
        if let Some(found) = worker.run(&plan.points[point], repeat as u32 + 1) {
            desk.put(found);
        }
    };
    each(total, threads, work, &mut |word| {
        let fraction = |done: usize| done as f64 / total.max(1) as f64;
        match word {
            Word::Waiting => tell(FrontierEvent::Waiting {
                fraction: fraction(done),
            }),
            Word::Part(Err(unknown)) => {
                wrong = Some(unknown);
                ControlFlow::Break(())
            }
            Word::Part(Ok((lines, known))) => {
                done += 1;
                all.0.extend(lines.iter().cloned());
                tell(FrontierEvent::Done {
                    lines: &lines,
                    all: &all,
                    known,
                    fraction: fraction(done),
                })
            }
        }
    });
    all.sort(plan);
    wrong.map_or(Ok(all), Err)
}

/// The lines of a run, and whether an older run of the study had them; or what is wrong with a figure's name.
type Done = Result<(Vec<Run>, bool), String>;

struct Worker<'a, 'b> {
    plan: &'a FrontierPlan,
    reference: &'a Reference,
    known: &'a Runs,
    version: &'a str,
    desk: &'a Desk<'b, Done>,
}

impl Worker<'_, '_> {
    /// `None` if the study stops.
    fn run(&self, point: &PlannedPoint, repeat: u32) -> Option<Done> {
        let figures = self.plan.study.measures();
        let scene = self.plan.scene(&point.set);
        let what = match &scene {
            Ok(scene) => scene_text(scene),
            Err(error) => error.to_string(),
        };
        let seconds = self.plan.study.seconds.to_string();
        let key = key_of(&[self.version, &what, &self.reference.key, &seconds]);
        let name = (point.variant.as_str(), point.settings.as_str());
        if let Some(lines) = self.known.of(name, repeat, &key, &figures) {
            return Some(Ok((lines, true)));
        }
        let measured = match &scene {
            Ok(scene) => measure(self.plan, scene, self.reference, &|| self.desk.stops())?,
            Err(error) => Measured {
                errors: Err(Ended::Failed(Class::Refused, error.to_string())),
                spent: Spent::default(),
            },
        };
        Some(match &measured.errors {
            Err(Ended::NoFigure(unknown)) => Err(unknown.clone()),
            _ => Ok((self.lines(point, repeat, &key, &measured), false)),
        })
    }

    fn lines(&self, point: &PlannedPoint, repeat: u32, key: &str, of: &Measured) -> Vec<Run> {
        let figures = self.plan.study.measures();
        let Measured { errors, spent } = of;
        let steps = spent.steps.max(1) as f64;
        let command = command::of_run(&self.plan.subject.file(), &self.plan.set(&point.set), None);
        let (class, reason) = match errors {
            Ok(_) => (Class::Stable, String::new()),
            Err(Ended::Failed(class, reason)) => (*class, reason.clone()),
            Err(Ended::NoFigure(unknown)) => (Class::Refused, unknown.clone()),
        };
        (figures.into_iter().enumerate())
            .map(|(k, figure)| Run {
                variant: point.variant.clone(),
                settings: point.settings.clone(),
                repeat,
                figure,
                error: errors
                    .as_ref()
                    .ok()
                    .and_then(|errors| errors.get(k).copied()),
                class,
                steps: spent.steps,
                time_s: spent.time,
                wall_s: spent.wall,
                cost: (spent.time > 0.0).then(|| spent.wall / spent.time),
                mean_density_error: spent.mean_density_errors / steps,
                largest_density_error: spent.largest_density_error,
                iterations: spent.iterations as f64 / steps,
                reason: reason.clone(),
                command: command.clone(),
                key: key.to_owned(),
            })
            .collect()
    }
}
