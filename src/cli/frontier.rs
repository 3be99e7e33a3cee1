//! `overfall study` with a frontier study: speed against error, as CSV and a chart.

use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use overfall::frontier::{
    FrontierEvent, FrontierPlan, Reference, Run, Runs, Subject, pareto_front, run_frontier, text_of,
};
use overfall::output::{OutputError, Provenance, write_atomically};
use overfall::scene::{Scene, SceneError};
use overfall::study::StudyError;
use overfall::study::chart::{FrontierPanel, FrontierPicture, FrontierPoint, draw_frontier};
use serde_json::json;

use super::claims::Claims;
use super::exit::{Exit, Failure, cannot_write};
use super::folder::{self, SUMMARY};
use super::kinds::{Kind, with_kind};
use super::stability::source;
use super::stages::Display;
use super::waiting::waiting;
use super::writer::Writer;
use super::{COMMIT, beside, caret, console, interrupt, options, report};

/// Names in the folder, in addition to the summary's.
const RUNS: &str = "runs.csv";
const CHART: &str = "chart.svg";
const REFERENCE: &str = "reference.csv";

/// Time between two versions of the results while points are run.
const WRITE_INTERVAL: Duration = Duration::from_secs(2);

/// Runs a frontier study and writes its results.
pub(super) fn study(options: &options::Study) -> Result<Exit, Failure> {
    let quiet = options.reporting.quiet;
    let plan = load(options)?;
    let root = folder::root(options.out.as_deref(), &plan.study.name);
    let (known, reference) = older(&root, options.fresh);
    let writer = Writer {
        kind: "study",
        name: &plan.study.name,
        force: options.force,
        inputs: inputs(&options.study, &plan),
    };
    let planned = [RUNS, CHART, REFERENCE, SUMMARY].map(str::to_owned);
    let (claims, aside) = Claims::start(&root, &writer, &planned)?;
    if let Some(aside) = aside.filter(|_| !quiet) {
        console::note(&format!("the older results are in {} now", aside.display()));
    }
    let provenance = Provenance::of_this_process(COMMIT);
    let sink = Sink {
        plan: &plan,
        known: &known,
        path: claims.claim(RUNS).map_err(cannot_write)?,
        remarks: remarks(&options.study, &plan, &provenance),
    };
    // What an older run has is in the new folder at once: a program that is stopped early loses nothing.
    sink.write(&Runs::default(), false).map_err(cannot_write)?;
    let mut display = Display::start(quiet);
    interrupt::listen(display.announcer())?;
    let threads = options.threads.count();
    let Some(reference) = fine_run(&plan, reference, threads, &mut display)? else {
        display.finish();
        return Ok(Exit::Interrupted);
    };
    let mut written = vec![sink.path.clone()];
    if matches!(plan.subject, Subject::Scene { .. }) {
        let path = claims.claim(REFERENCE).map_err(cannot_write)?;
        let text = reference
            .csv()
            .map_err(|error| cannot_write(io_error(&path, error)))?;
        write_atomically(&path, |out| out.write_all(&text)).map_err(cannot_write)?;
        written.push(path);
    }
    let (runs, reused) = run(&sink, &reference, threads, &mut display)?;
    // The runs of variants that --only leaves out are kept.
    let is_whole = options.only.is_empty() && !interrupt::asked();
    sink.write(&runs, is_whole).map_err(cannot_write)?;
    if reused > 0 && !quiet {
        console::note(&format!(
            "{reused} runs are those of an older one; --fresh makes them again"
        ));
    }
    match draw_frontier(&picture(&plan, &runs, source(&provenance, threads))) {
        Ok(svg) => {
            let path = claims.claim(CHART).map_err(cannot_write)?;
            write_atomically(&path, |out| out.write_all(svg.as_bytes())).map_err(cannot_write)?;
            written.push(path);
        }
        Err(error) => console::note(&format!("no chart: {error}")),
    }
    let summary = report::pretty(&summary(&plan, &runs, (threads, reused), &provenance))?;
    let path = claims.claim(SUMMARY).map_err(cannot_write)?;
    write_atomically(&path, |out| out.write_all(summary.as_bytes())).map_err(cannot_write)?;
    written.push(path);
    if !interrupt::asked() {
        claims.complete()?;
    }
    let mut text = text_of(&plan, &runs);
    text.push('\n');
    for file in written {
        text.push_str(&format!("  {}\n", claims.place(&file).display()));
    }
    console::print(if options.reporting.json {
        &summary
    } else {
        &text
    })?;
    Ok(if interrupt::asked() {
        Exit::Interrupted
    } else {
        Exit::Done
    })
}

/// What an older run in the folder found, read before that is moved aside.
fn older(root: &Path, fresh: bool) -> (Runs, Option<Reference>) {
    if fresh {
        return (Runs::default(), None);
    }
    (
        Runs::read(&beside::newest(root, RUNS).join(RUNS)).unwrap_or_default(),
        Reference::read(&beside::newest(root, REFERENCE).join(REFERENCE)).ok(),
    )
}

fn io_error(path: &Path, source: std::io::Error) -> OutputError {
    OutputError::Io {
        path: path.to_owned(),
        source,
    }
}

fn version() -> String {
    format!(
        "{} {}",
        env!("CARGO_PKG_VERSION"),
        COMMIT.unwrap_or_default()
    )
}

fn go_on() -> ControlFlow<()> {
    if interrupt::asked() {
        ControlFlow::Break(())
    } else {
        ControlFlow::Continue(())
    }
}

/// The fine run, if the study has one; `None` if it was interrupted.
fn fine_run(
    plan: &FrontierPlan,
    older: Option<Reference>,
    threads: usize,
    display: &mut Display,
) -> Result<Option<Reference>, Failure> {
    let found = Reference::of(plan, older, (threads, &version()), &mut |fraction| {
        display.step("the fine run", "", fraction);
        go_on()
    });
    match found {
        Ok(reference) => Ok(Some(reference)),
        Err(_) if interrupt::asked() => Ok(None),
        Err(error) => Err(Failure::Failed(error)),
    }
}

fn load(options: &options::Study) -> Result<FrontierPlan, Failure> {
    let overrides = (options.set.parse()).map_err(|error| Failure::Refused(error.to_string()))?;
    let plan = waiting(
        "reading the study and its scenes",
        options.reporting.quiet,
        || FrontierPlan::load(&options.study, &overrides),
    );
    let mut plan = plan.map_err(|error| {
        let refusal = caret::of_study(&error);
        Failure::Refused(match error {
            StudyError::Scene(SceneError::Syntax { .. }) => {
                with_kind(refusal, &options.study, Kind::Study)
            }
            _ => refusal,
        })
    })?;
    if !options.only.is_empty() {
        plan.only(&options.only).map_err(Failure::Refused)?;
    }
    Ok(plan)
}

/// Runs the points, with progress; also returns the number of runs that an older one had.
fn run(
    sink: &Sink,
    reference: &Reference,
    threads: usize,
    display: &mut Display,
) -> Result<(Runs, usize), Failure> {
    let (mut wrote, mut looked, mut reused) = (Ok(()), Instant::now(), 0);
    let mut of = String::new();
    let runs = run_frontier(
        sink.plan,
        reference,
        sink.known,
        (threads, &version()),
        &mut |event| {
            match event {
                FrontierEvent::Waiting { fraction } => display.step("measuring", &of, fraction),
                FrontierEvent::Done {
                    lines,
                    all,
                    known,
                    fraction,
                } => {
                    reused += usize::from(known);
                    of = lines.first().map_or_else(String::new, said);
                    display.step("measuring", &of, fraction);
                    // A program that is killed loses the runs of the last moments.
                    if looked.elapsed() >= WRITE_INTERVAL {
                        wrote = sink.write(all, false);
                        looked = Instant::now();
                    }
                }
            }
            if wrote.is_err() {
                ControlFlow::Break(())
            } else {
                go_on()
            }
        },
    );
    display.finish();
    wrote.map_err(cannot_write)?;
    Ok((runs.map_err(Failure::Refused)?, reused))
}

/// A finished run in words.
fn said(run: &Run) -> String {
    let end = match run.error {
        Some(error) => format!("error {error:.2e}"),
        None => run.class.name().to_owned(),
    };
    format!("{} {}: {end}", run.variant, run.settings)
}

/// Where the runs are written.
struct Sink<'a> {
    plan: &'a FrontierPlan,
    known: &'a Runs,
    path: PathBuf,
    remarks: Vec<String>,
}

impl Sink<'_> {
    /// Writes runs, and while the study is not finished those of an older one beside them.
    fn write(&self, runs: &Runs, is_finished: bool) -> Result<(), OutputError> {
        let mut runs = runs.clone();
        if !is_finished {
            let more = self.known.beside(&runs);
            runs.0.extend(more);
        }
        runs.sort(self.plan);
        let text = runs
            .csv(&self.remarks)
            .map_err(|error| io_error(&self.path, error))?;
        write_atomically(&self.path, |out| out.write_all(&text))
    }
}

fn remarks(path: &Path, plan: &FrontierPlan, provenance: &Provenance) -> Vec<String> {
    vec![
        format!("study {}: {}", path.display(), plan.study.title()),
        serde_json::to_string(provenance).unwrap_or_default(),
    ]
}

fn picture(plan: &FrontierPlan, runs: &Runs, source: String) -> FrontierPicture {
    let mut series: Vec<String> = Vec::new();
    for point in &plan.points {
        if !series.contains(&point.variant) {
            series.push(point.variant.clone());
        }
    }
    let number = |name: &str| series.iter().position(|of| of == name).unwrap_or(0);
    let panel = |figure: String| {
        let (points, failed) = runs.points(&figure);
        FrontierPanel {
            figure,
            front: pareto_front(&points),
            points: points
                .into_iter()
                .map(|point| FrontierPoint {
                    series: number(&point.variant),
                    label: if point.settings.is_empty() {
                        point.variant
                    } else {
                        point.settings
                    },
                    cost: point.cost,
                    error: point.error,
                })
                .collect(),
            failed: failed
                .iter()
                .map(|of| (number(&of.variant), of.cost, of.class))
                .collect(),
        }
    };
    let truth = match &plan.subject {
        Subject::Case(case) => format!("the known values of {}", case.name),
        Subject::Scene { fine, .. } => format!("a fine run, {}", fine.join(", ")),
    };
    FrontierPicture {
        title: plan.study.title().to_owned(),
        panels: plan.study.measures().into_iter().map(panel).collect(),
        series,
        source: format!("against {truth}; {source}"),
    }
}

/// The files that a study reads.
fn inputs(study: &Path, plan: &FrontierPlan) -> Vec<PathBuf> {
    let mut inputs = vec![study.to_owned()];
    if let Subject::Scene { file, .. } = &plan.subject {
        inputs.push(file.clone());
        inputs.extend(Scene::fragments(file));
    }
    inputs
}

fn summary(
    plan: &FrontierPlan,
    runs: &Runs,
    (threads, reused): (usize, usize),
    provenance: &Provenance,
) -> serde_json::Value {
    let figure = |name: String| {
        let (points, failed) = runs.points(&name);
        let front: Vec<_> = pareto_front(&points)
            .into_iter()
            .map(|k| &points[k])
            .map(|of| {
                json!({
                    "variant": of.variant,
                    "settings": of.settings,
                    "error": of.error,
                    "cost": of.cost[0],
                })
            })
            .collect();
        json!({"figure": name, "points": points.len(), "failed": failed.len(), "front": front})
    };
    let figures: Vec<_> = plan.study.measures().into_iter().map(figure).collect();
    json!({
        "study": plan.study.name,
        "status": if interrupt::asked() { "interrupted" } else { "done" },
        "threads": threads,
        "reused": reused,
        "provenance": provenance,
        "figures": figures,
    })
}
