//! `overfall validate`: runs cases with known answers; writes a table and a page with charts.

use std::fmt::Write as _;
use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::PathBuf;

use overfall::output::{OutputError, Provenance, write_atomically};
use overfall::study::chart::{ErrorPanel, draw_orders, draw_runs_beside_known};
use overfall::validate::{
    CASES, Case, Convergence, Event, Figure, Job, METHODS, Method, Outcome, convergence, csv, page,
    run_all, table,
};

use serde_json::{Value, json};

use super::claims::Claims;
use super::exit::{Exit, Failure, cannot_write};
use super::folder::SUMMARY;
use super::stages::Display;
use super::writer::Writer;
use super::{COMMIT, console, folder, interrupt, options, report};

/// Name of the default folder in `out/`.
const NAME: &str = "validation";
/// Names in the folder.
const PAGE: &str = "page.md";
const FIGURES: &str = "figures.csv";

/// Runs cases and writes the results.
pub(super) fn validate(options: &options::Validate) -> Result<Exit, Failure> {
    if options.list {
        let known = if options.reporting.json {
            report::pretty(&list_json())?
        } else {
            list()
        };
        console::print(&known)?;
        return Ok(Exit::Done);
    }
    let jobs = jobs(options)?;
    let quiet = options.reporting.quiet;
    let root = folder::root(options.out.as_deref(), NAME);
    let writer = Writer {
        kind: "validation",
        name: NAME,
        force: options.force,
        inputs: Vec::new(),
    };
    let planned = [PAGE, FIGURES, SUMMARY].map(str::to_owned);
    let (claims, aside) = Claims::start(&root, &writer, &planned)?;
    if let Some(aside) = aside.filter(|_| !quiet) {
        console::note(&format!("the older page is in {} now", aside.display()));
    }
    let mut display = Display::start(quiet);
    let announce = display.announcer();
    interrupt::listen(display.announcer())?;
    let mut wrote = Ok(());
    let outcomes = run_all(&jobs, options.threads.count(), &mut |event| {
        match event {
            Event::Step { job, fraction } => {
                let of = format!("{}, {}", job.case.name, job.method.name);
                display.step("validating", &of, fraction);
            }
            // Written after every job, so that results are kept however the program ends.
            Event::Done { number, outcomes } => {
                if let Some(outcome) = outcomes[number].as_ref().filter(|_| !quiet) {
                    announce(&said(outcome));
                }
                wrote = write_figures(&claims, outcomes);
            }
        }
        if interrupt::asked() || wrote.is_err() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    display.finish();
    wrote.map_err(cannot_write)?;
    let outcomes: Vec<Outcome> = outcomes.into_iter().flatten().collect();
    let page = write_page(&claims, &outcomes).map_err(cannot_write)?;
    let left = jobs.len() - outcomes.len();
    let summary = report::pretty(&summary(&outcomes, left, options.threads.count()))?;
    write(&claims, SUMMARY, &summary).map_err(cannot_write)?;
    if !interrupt::asked() {
        claims.complete()?;
    }
    let mut text = table(&outcomes);
    if interrupt::asked() {
        let _ = writeln!(
            text,
            "interrupted: {left} of {} runs are missing",
            jobs.len()
        );
    }
    let _ = writeln!(text, "\n  {}", claims.place(&page).display());
    console::print(if options.reporting.json {
        &summary
    } else {
        &text
    })?;
    if interrupt::asked() {
        return Ok(Exit::Interrupted);
    }
    all_done(&outcomes, jobs.len())
}

/// Fails if a run has failed.
fn all_done(outcomes: &[Outcome], jobs: usize) -> Result<Exit, Failure> {
    let failed = outcomes.iter().filter(|outcome| outcome.result.is_err());
    match failed.count() {
        0 => Ok(Exit::Done),
        count => Err(Failure::Failed(format!("{count} of {jobs} runs failed"))),
    }
}

/// The result of a finished job, in words.
fn said(outcome: &Outcome) -> String {
    let job = &outcome.job;
    let end = match &outcome.result {
        Ok(_) => "done".to_owned(),
        Err(error) => error.to_string(),
    };
    let (case, method, seconds) = (job.case.name, job.method.name, outcome.seconds);
    format!(
        "{case}, {method}, {}: {end}, {seconds:.1} s",
        job.resolution
    )
}

fn list() -> String {
    let mut text = "cases\n".to_owned();
    for case in CASES {
        let (name, title, n, across) = (case.name, case.title, case.resolution, case.across);
        let _ = writeln!(text, "  {name:24} {title}; {n} particles over the {across}");
    }
    text.push_str("methods\n");
    for method in &METHODS {
        let _ = writeln!(text, "  {:24} {}", method.key, method.name);
    }
    text
}

/// The same for programs.
fn list_json() -> Value {
    let cases = CASES.iter().map(|case| {
        json!({"case": case.name, "title": case.title, "resolution": case.resolution, "across": case.across})
    });
    let methods = METHODS
        .iter()
        .map(|method| json!({"method": method.key, "name": method.name}));
    json!({
        "cases": cases.collect::<Vec<_>>(),
        "methods": methods.collect::<Vec<_>>(),
    })
}

/// All results, and where they come from. What is no number is `null`.
fn summary(outcomes: &[Outcome], left: usize, threads: usize) -> Value {
    let figure = |figure: &Figure| {
        json!({
            "quantity": figure.quantity,
            "measured": figure.measured,
            "known": figure.known,
            "error": figure.error(),
        })
    };
    let of = |outcome: &Outcome| {
        let (figures, failure) = match &outcome.result {
            Ok(findings) => (findings.figures.iter().map(figure).collect(), None),
            Err(error) => (Vec::new(), Some(error.to_string())),
        };
        json!({
            "case": outcome.job.case.name,
            "method": outcome.job.method.key,
            "resolution": outcome.job.resolution,
            "wall_s": outcome.seconds,
            "failure": failure,
            "figures": figures,
        })
    };
    json!({
        "status": if left == 0 { "done" } else { "interrupted" },
        "threads": threads,
        "provenance": Provenance::of_this_process(COMMIT),
        "runs": outcomes.iter().map(of).collect::<Vec<_>>(),
    })
}

/// The requested runs, case by case.
fn jobs(options: &options::Validate) -> Result<Vec<Job>, Failure> {
    for asked in &options.cases {
        if CASES
            .iter()
            .any(|case| case.name.starts_with(asked.as_str()))
        {
            continue;
        }
        return Err(Failure::Refused(format!(
            "there is no case `{asked}`; the cases are {}",
            CASES.map(|case| case.name).join(", ")
        )));
    }
    let is_asked = |case: &&&Case| {
        let mut asked = options.cases.iter();
        options.cases.is_empty() || asked.any(|asked| case.name.starts_with(asked.as_str()))
    };
    let methods: Vec<&'static Method> = match &options.methods[..] {
        [] => METHODS.iter().collect(),
        asked => (METHODS.iter())
            .filter(|method| asked.iter().any(|asked| asked.key == method.key))
            .collect(),
    };
    let mut jobs = Vec::new();
    for case in CASES.iter().filter(is_asked).copied() {
        let resolutions = match options.resolution {
            _ if options.convergence => case.resolutions.to_vec(),
            asked => vec![asked.unwrap_or(case.resolution)],
        };
        for &method in &methods {
            let job = |&resolution: &u32| Job {
                case,
                method,
                resolution,
            };
            jobs.extend(resolutions.iter().map(job));
        }
    }
    Ok(jobs)
}

fn write(claims: &Claims, name: &str, text: &str) -> Result<PathBuf, OutputError> {
    let path = claims.claim(name)?;
    write_atomically(&path, |out| out.write_all(text.as_bytes()))?;
    Ok(path)
}

fn write_figures(claims: &Claims, outcomes: &[Option<Outcome>]) -> Result<(), OutputError> {
    write(claims, FIGURES, &csv(outcomes.iter().flatten())).map(|_| ())
}

/// Writes the page and the charts that it shows.
fn write_page(claims: &Claims, outcomes: &[Outcome]) -> Result<PathBuf, OutputError> {
    let (mut charts, mut orders) = (Vec::new(), Vec::new());
    for case in CASES {
        let of_case: Vec<&Outcome> = (outcomes.iter())
            .filter(|outcome| outcome.job.case.name == case.name)
            .collect();
        for (name, svg) in comparisons(&of_case) {
            write(claims, &name, &svg)?;
            charts.push((case.name.to_owned(), name));
        }
        let found = orders_of(&of_case);
        if let Some(svg) = chart_of_orders(case, &found) {
            let name = format!("{}_order.svg", case.name);
            write(claims, &name, &svg)?;
            charts.push((case.name.to_owned(), name));
        }
        orders.extend(found);
    }
    let all: Vec<&Outcome> = outcomes.iter().collect();
    write(claims, PAGE, &page(&all, &orders, &charts))
}

/// Every curve of a case beside its reference, all methods in one chart, at the finest resolution of the run.
fn comparisons(outcomes: &[&Outcome]) -> Vec<(String, String)> {
    let finest = outcomes.iter().map(|outcome| outcome.job.resolution).max();
    let finest = || {
        let at = outcomes
            .iter()
            .filter(|of| Some(of.job.resolution) == finest);
        at.filter_map(|of| Some((of.job, of.result.as_ref().ok()?)))
    };
    let Some((job, first)) = finest().next() else {
        return Vec::new();
    };
    let draw = |(k, comparison): (usize, &overfall::validate::Comparison)| {
        let runs = finest().filter_map(|(job, findings)| {
            Some((job.method.name, &findings.comparisons.get(k)?.measured[..]))
        });
        let runs: Vec<_> = runs.collect();
        let (case, n, across) = (job.case, job.resolution, job.case.across);
        let title = format!("{}, {n} particles over the {across}", case.title);
        let axes = [comparison.x, comparison.y];
        let svg = draw_runs_beside_known(&title, axes, &runs, &comparison.known).ok()?;
        Some((format!("{}_{}.svg", case.name, comparison.name), svg))
    };
    first
        .comparisons
        .iter()
        .enumerate()
        .filter_map(draw)
        .collect()
}

/// The convergence of a case for every method that ran at more than one resolution.
fn orders_of(outcomes: &[&Outcome]) -> Vec<Convergence> {
    let mut found = Vec::new();
    for method in &METHODS {
        let of_method = outcomes.iter().filter(|of| of.job.method.key == method.key);
        let of_method: Vec<&Outcome> = of_method.copied().collect();
        if of_method.len() > 1 {
            found.extend(convergence(&of_method));
        }
    }
    found
}

fn chart_of_orders(case: &Case, found: &[Convergence]) -> Option<String> {
    let mut panels: Vec<ErrorPanel> = Vec::new();
    for of in found {
        let points = of.errors.iter().map(|&(n, error)| (n.into(), error));
        let series = (of.method.name.to_owned(), points.collect());
        match panels.iter_mut().find(|panel| panel.title == of.quantity) {
            Some(panel) => panel.series.push(series),
            None => panels.push(ErrorPanel {
                title: of.quantity.clone(),
                series: vec![series],
            }),
        }
    }
    draw_orders(&format!("{}: errors", case.title), case.across, &panels).ok()
}
