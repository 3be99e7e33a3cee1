//! `overfall study` with a stability study: points on several threads, as CSV and maps.

use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use overfall::output::{OutputError, Provenance, write_atomically};
use overfall::scene::{Scene, SceneError};
use overfall::study::StudyError;
use overfall::study::chart::{MapPicture, draw_map};
use overfall::study::stability::{
    Class, Known, Reading, StabilityEvent, StabilityPlan, csv_of, run_stability, sort, text_of,
};
use serde_json::json;

use super::claims::Claims;
use super::exit::{Exit, Failure, cannot_write};
use super::folder::{self, SUMMARY};
use super::kinds::{Kind, with_kind};
use super::stages::Display;
use super::waiting::waiting;
use super::writer::Writer;
use super::{COMMIT, beside, caret, console, interrupt, options, report};

/// Name of the file with the results.
pub(super) const POINTS: &str = "points.csv";

/// Time between two versions of it while points are run.
const WRITE_INTERVAL: Duration = Duration::from_secs(2);

/// Runs a stability study and writes its results.
pub(super) fn study(options: &options::Study) -> Result<Exit, Failure> {
    let quiet = options.reporting.quiet;
    let plan = load(options)?;
    let study = &plan.study;
    let root = folder::root(options.out.as_deref(), &study.name);
    // Read before an older run is moved aside.
    let known = match options.fresh {
        true => Known::default(),
        false => Known::read(&beside::newest(&root, POINTS).join(POINTS)).unwrap_or_default(),
    };
    let writer = Writer {
        kind: "study",
        name: &study.name,
        force: options.force,
        inputs: inputs(&options.study, &plan),
    };
    let maps: Vec<String> = (plan.maps.iter().enumerate())
        .map(|(k, map)| map_name(k, &map.name))
        .collect();
    let planned = [&[POINTS.to_owned(), SUMMARY.to_owned()], &maps[..]].concat();
    let (claims, aside) = Claims::start(&root, &writer, &planned)?;
    if let Some(aside) = aside.filter(|_| !quiet) {
        console::note(&format!("the older results are in {} now", aside.display()));
    }
    let provenance = Provenance::of_this_process(COMMIT);
    let sink = Sink {
        plan: &plan,
        known: &known,
        path: claims.claim(POINTS).map_err(cannot_write)?,
        remarks: remarks(&options.study, &plan, &provenance),
    };
    let threads = options.threads.count();
    // What an older run has is in the new folder at once: a program that is stopped early loses nothing.
    sink.write(&[], false).map_err(cannot_write)?;
    let (readings, reused) = run(options, &sink, threads)?;
    // The points of variants that --only leaves out are kept.
    let is_whole = options.only.is_empty() && !interrupt::asked();
    sink.write(&readings, is_whole).map_err(cannot_write)?;
    let mut written = vec![sink.path.clone()];
    for (map, name) in plan.maps.iter().zip(&maps) {
        let picture = MapPicture {
            plan: &plan,
            map,
            readings: &readings,
            source: source(&provenance, threads),
        };
        match draw_map(&picture) {
            Ok(svg) => {
                let path = claims.claim(name).map_err(cannot_write)?;
                write_atomically(&path, |out| out.write_all(svg.as_bytes()))
                    .map_err(cannot_write)?;
                written.push(path);
            }
            Err(error) => console::note(&format!("{}: no map: {error}", console::name(&map.name))),
        }
    }
    let summary = report::pretty(&summary(&plan, &readings, (threads, reused), &provenance))?;
    let path = claims.claim(SUMMARY).map_err(cannot_write)?;
    write_atomically(&path, |out| out.write_all(summary.as_bytes())).map_err(cannot_write)?;
    written.push(path);
    if !interrupt::asked() {
        claims.complete()?;
    }
    let mut text = text_of(&plan, &readings);
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

fn load(options: &options::Study) -> Result<StabilityPlan, Failure> {
    let overrides = (options.set.parse()).map_err(|error| Failure::Refused(error.to_string()))?;
    let plan = waiting(
        "reading the study and its scenes",
        options.reporting.quiet,
        || StabilityPlan::load(&options.study, &overrides),
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

/// Runs the points, with progress; also returns the number of those that an older run had.
fn run(
    options: &options::Study,
    sink: &Sink,
    threads: usize,
) -> Result<(Vec<Reading>, usize), Failure> {
    let mut display = Display::start(options.reporting.quiet);
    interrupt::listen(display.announcer())?;
    let (mut wrote, mut looked, mut reused) = (Ok(()), Instant::now(), 0);
    let mut of = String::new();
    let version = format!(
        "{} {}",
        env!("CARGO_PKG_VERSION"),
        COMMIT.unwrap_or_default()
    );
    let readings = run_stability(sink.plan, threads, sink.known, &version, &mut |event| {
        match event {
            StabilityEvent::Waiting { fraction } => display.step("mapping", &of, fraction),
            StabilityEvent::Point {
                readings,
                all,
                known,
                fraction,
            } => {
                reused += usize::from(known);
                of = readings.last().map_or_else(String::new, said);
                display.step("mapping", &of, fraction);
                // A program that is killed loses the points of the last moments.
                if looked.elapsed() >= WRITE_INTERVAL {
                    wrote = sink.write(all, false);
                    looked = Instant::now();
                }
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
    if reused > 0 && !options.reporting.quiet {
        console::note(&format!(
            "{reused} points are those of an older run; --fresh runs them again"
        ));
    }
    Ok((readings, reused))
}

/// A finished point in words.
fn said(reading: &Reading) -> String {
    let Reading {
        variant,
        x,
        y,
        class,
        ..
    } = reading;
    format!("{variant}, {x}, {y}: {}", class.name())
}

/// Where the points are written.
struct Sink<'a> {
    plan: &'a StabilityPlan,
    known: &'a Known,
    path: PathBuf,
    remarks: Vec<String>,
}

impl Sink<'_> {
    /// Writes readings, and while the study is not finished those of an older one beside them.
    fn write(&self, readings: &[Reading], is_finished: bool) -> Result<(), OutputError> {
        let mut readings = readings.to_vec();
        if !is_finished {
            let more = self.known.beside(&readings);
            readings.extend(more);
        }
        sort(self.plan, &mut readings);
        let io = |source| OutputError::Io {
            path: self.path.clone(),
            source,
        };
        let text = csv_of(&readings, &self.remarks).map_err(io)?;
        write_atomically(&self.path, |out| out.write_all(&text))
    }
}

fn remarks(path: &Path, plan: &StabilityPlan, provenance: &Provenance) -> Vec<String> {
    let mut remarks = vec![
        format!("study {}: {}", path.display(), plan.study.title()),
        format!("rules {:?}", plan.study.rules),
    ];
    for map in &plan.maps {
        let (x, y) = (map.x.label(), map.y.label());
        remarks.push(format!("{}: x is {x}, y is {y}", map.name));
    }
    remarks.push(serde_json::to_string(provenance).unwrap_or_default());
    remarks
}

/// Machine, date and program in a line.
pub(super) fn source(provenance: &Provenance, threads: usize) -> String {
    let commit = provenance.commit.as_deref().unwrap_or("unknown");
    let short: String = commit.chars().take(12).collect();
    format!(
        "{}; {threads} at a time, one thread each; {}; overfall {} ({short})",
        provenance.cpu.as_deref().unwrap_or("unknown processor"),
        provenance.date,
        provenance.version,
    )
}

/// Name of a map's file: its number, and what its name has of letters and digits.
fn map_name(number: usize, name: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() {
            c.to_ascii_lowercase()
        } else {
            '_'
        }
    };
    let name: String = name.chars().map(plain).collect();
    format!("map_{}_{name}.svg", number + 1)
}

/// The files that a study reads.
fn inputs(study: &Path, plan: &StabilityPlan) -> Vec<PathBuf> {
    let mut inputs = vec![study.to_owned(), plan.scene_file.clone()];
    inputs.extend(Scene::fragments(&plan.scene_file));
    inputs
}

fn summary(
    plan: &StabilityPlan,
    readings: &[Reading],
    (threads, reused): (usize, usize),
    provenance: &Provenance,
) -> serde_json::Value {
    let last = plan.study.after.last().copied();
    let classes = |name: &str| -> serde_json::Value {
        let of_map = || {
            readings
                .iter()
                .filter(|of| of.variant == name && Some(of.after) == last)
        };
        Class::ALL
            .iter()
            .map(|class| {
                (
                    class.name().to_owned(),
                    of_map().filter(|of| of.class == *class).count(),
                )
            })
            .map(|(name, count)| (name, json!(count)))
            .collect::<serde_json::Map<_, _>>()
            .into()
    };
    let maps: Vec<_> = (plan.maps.iter())
        .map(|map| json!({"variant": map.name, "classes": classes(&map.name)}))
        .collect();
    json!({
        "study": plan.study.name,
        "status": if interrupt::asked() { "interrupted" } else { "done" },
        "threads": threads,
        "reused": reused,
        "provenance": provenance,
        "maps": maps,
    })
}
