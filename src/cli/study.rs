//! `overfall study`: variants of a scene side by side, as a table, CSV and a chart.

use std::collections::BTreeMap;
use std::io::{BufReader, Write as _};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use overfall::input;
use overfall::output::{OutputError, Provenance, write_atomically, write_durably};
use overfall::scene::{Scene, SceneError};
use overfall::simd::InstructionSet;
use overfall::study::{Event, Pause, Plan, StudyError, StudyKind, Table, chart, resume};
use serde::Serialize;

use super::claims::Claims;
use super::exit::{Exit, Failure, cannot_write};
use super::folder::{self, SUMMARY};
use super::kinds::{Kind, with_kind};
use super::stages::Display;
use super::waiting::waiting;
use super::writer::Writer;
use super::{COMMIT, beside, caret, console, frontier, interrupt, options, stability};

/// Names in the folder, in addition to the summary's.
const TABLE: &str = "table.csv";
const CHART: &str = "chart.svg";
/// What is finished, and the state to go on from.
const PROGRESS: &str = "progress.overfall";

/// Time between two checks that the folder still exists.
const LOOK_INTERVAL: Duration = Duration::from_secs(1);

/// Runs a study of any kind and writes its results.
pub(super) fn study(options: &options::Study) -> Result<Exit, Failure> {
    match StudyKind::of(&options.study) {
        Ok(StudyKind::Stability) => stability::study(options),
        Ok(StudyKind::Frontier) => frontier::study(options),
        Ok(StudyKind::Table) => table(options),
        Err(error) => Err(Failure::Refused(caret::of_study(&error))),
    }
}

/// Runs a study of variants side by side.
fn table(options: &options::Study) -> Result<Exit, Failure> {
    if options.fresh || !options.only.is_empty() {
        let message = "--only and --fresh are of studies of kind Stability or Frontier; this one measures all its \
                       variants in turns";
        return Err(Failure::Refused(message.to_owned()));
    }
    let started = Instant::now();
    let quiet = options.reporting.quiet;
    let plan = planned(options, quiet)?;
    let mut root = folder::root(options.out.as_deref(), &plan.study.name);
    if options.resume {
        root = beside::newest(&root, PROGRESS);
    }
    let writer = Writer {
        kind: "study",
        name: &plan.study.name,
        force: options.force,
        inputs: inputs(&options.study, &plan),
    };
    let planned = [TABLE, CHART, SUMMARY, PROGRESS].map(str::to_owned);
    let (claims, aside) = if options.resume {
        (Claims::go_on(&root, &writer)?, None)
    } else {
        Claims::start(&root, &writer, &planned)?
    };
    let from = options.resume.then(|| progress(&root)).transpose()?;
    if let Some(aside) = aside.filter(|_| !quiet) {
        console::note(&format!("the older table is in {} now", aside.display()));
    }
    let files = Files::of(&claims).map_err(cannot_write)?;

    let mut display = Display::start(quiet);
    interrupt::listen(display.announcer())?;
    let threads = options.threads.count();
    let mut wrote = Ok(());
    let mut looked = Instant::now();
    let ended = resume(&plan, threads, from.as_ref(), &mut |event| {
        match event {
            Event::Step {
                stage,
                of,
                fraction,
            } => {
                display.step(stage, of, fraction);
                if looked.elapsed() >= LOOK_INTERVAL {
                    wrote = claims.check();
                    looked = Instant::now();
                }
            }
            // Written after every turn, so that finished blocks are kept however the program ends.
            Event::Turn(table, pause) => {
                wrote = table.write_csv(&files.table).and_then(|()| match pause {
                    Some(pause) => write_durably(&files.progress, &pause.to_bytes()),
                    None => Ok(()),
                });
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
    let table = ended.map_err(|error| match error {
        StudyError::Install { .. } | StudyError::Resume(_) => Failure::Refused(error.to_string()),
        other => Failure::Failed(other.to_string()),
    })?;

    let elapsed = started.elapsed();
    let json = options.reporting.json;
    report(&plan, &table, (&claims, &files), (threads, elapsed), json)?;
    if is_empty(&table) && !interrupt::asked() {
        return Err(Failure::Failed("no variant could be measured".into()));
    }
    Ok(if interrupt::asked() {
        Exit::Interrupted
    } else {
        Exit::Done
    })
}

/// Whether no variant could be measured.
fn is_empty(table: &Table) -> bool {
    table.rows.iter().all(|row| row.blocks.is_empty())
}

/// The study of a file, with its scenes.
fn planned(options: &options::Study, quiet: bool) -> Result<Plan, Failure> {
    let overrides = (options.set.parse()).map_err(|error| Failure::Refused(error.to_string()))?;
    let plan = waiting("reading the study and its scenes", quiet, || {
        Plan::load_with(&options.study, &overrides)
    });
    plan.map_err(|error| {
        let refusal = caret::of_study(&error);
        Failure::Refused(match error {
            StudyError::Scene(SceneError::Syntax { .. }) => {
                with_kind(refusal, &options.study, Kind::Study)
            }
            _ => refusal,
        })
    })
}

/// The progress of the study in a folder.
fn progress(root: &Path) -> Result<Pause, Failure> {
    let file = root.join(PROGRESS);
    let refused = |reason: String| Failure::Refused(format!("{}: {reason}", file.display()));
    let opened = input::open(&file).map_err(|error| refused(error.to_string()))?;
    Pause::read(&mut BufReader::new(opened)).map_err(|error| refused(error.to_string()))
}

/// Writes the table, the chart and the summary, and prints the table.
fn report(
    plan: &Plan,
    table: &Table,
    (claims, files): (&Claims, &Files),
    (threads, elapsed): (usize, Duration),
    json: bool,
) -> Result<(), Failure> {
    table.write_csv(&files.table).map_err(cannot_write)?;
    let mut written = vec![&files.table, &files.summary];
    if let Some(wanted) = &plan.study.chart {
        match chart::draw(table, wanted) {
            Ok(svg) => {
                write_atomically(&files.chart, |out| out.write_all(svg.as_bytes()))
                    .map_err(cannot_write)?;
                written.push(&files.chart);
            }
            // An interrupted study may have nothing to draw; its table is still useful.
            Err(error) => console::note(&format!("no chart: {error}")),
        }
    }
    let summary = Summary::of(plan, table, threads, elapsed);
    summary.write(&files.summary).map_err(cannot_write)?;
    if !is_empty(table) && !interrupt::asked() {
        claims.complete()?;
    }
    if json {
        return console::print(&super::report::pretty(&summary)?);
    }

    let mut text = table.text();
    text.push_str(&format!(
        "\n{threads} {}, {}, {:.0} s in total\n",
        if threads == 1 { "thread" } else { "threads" },
        summary.instruction_set,
        summary.wall_s
    ));
    for file in written {
        text.push_str(&format!("  {}\n", claims.place(file).display()));
    }
    console::print(&text)
}

/// The files that a study writes.
struct Files {
    table: PathBuf,
    chart: PathBuf,
    summary: PathBuf,
    progress: PathBuf,
}

impl Files {
    fn of(claims: &Claims) -> Result<Self, OutputError> {
        Ok(Self {
            table: claims.claim(TABLE)?,
            chart: claims.claim(CHART)?,
            summary: claims.claim(SUMMARY)?,
            progress: claims.claim(PROGRESS)?,
        })
    }
}

/// The files that a study reads.
fn inputs(study: &Path, plan: &Plan) -> Vec<PathBuf> {
    let folder = study.parent().unwrap_or(Path::new(""));
    let mut inputs = vec![study.to_owned(), folder.join(&plan.study.scene)];
    inputs.extend(Scene::fragments(&folder.join(&plan.study.scene)));
    inputs.extend((plan.study.reference.iter()).map(|name| folder.join(name)));
    for variant in plan.cases.iter().flat_map(|case| &case.variants) {
        let mut scene = variant.scene.clone();
        inputs.extend(scene.files_mut().map(|file| PathBuf::from(&*file)));
    }
    inputs.sort();
    inputs.dedup();
    inputs
}

/// Content of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    study: &'a str,
    /// `done` or `interrupted`.
    status: &'static str,
    threads: usize,
    instruction_set: &'static str,
    /// Wall time, starts and warm-ups included \[s].
    wall_s: f64,
    provenance: Provenance,
    rows: Vec<SummaryRow<'a>>,
}

#[derive(Serialize)]
struct SummaryRow<'a> {
    case: &'a str,
    variant: &'a str,
    blocks: usize,
    steps: u64,
    failure: Option<&'a str>,
    /// Its figures, by column.
    figures: BTreeMap<&'a str, f64>,
}

impl<'a> Summary<'a> {
    fn of(plan: &'a Plan, table: &'a Table, threads: usize, wall: Duration) -> Self {
        Self {
            study: &plan.study.name,
            status: if interrupt::asked() {
                "interrupted"
            } else {
                "done"
            },
            threads,
            instruction_set: InstructionSet::detect().name(),
            wall_s: wall.as_secs_f64(),
            provenance: Provenance::of_this_process(COMMIT),
            rows: (0..table.rows.len())
                .map(|number| (number, &table.rows[number]))
                .map(|(number, row)| SummaryRow {
                    case: &row.case,
                    variant: &row.variant,
                    blocks: row.blocks.len(),
                    steps: row.steps(),
                    failure: row.failure.as_deref(),
                    figures: (table.columns.iter().enumerate())
                        .filter_map(|(column, of)| {
                            let figure = table.figure(number, column)?;
                            Some((of.name.as_str(), figure.value))
                        })
                        .collect(),
                })
                .collect(),
        }
    }

    fn write(&self, path: &Path) -> Result<(), OutputError> {
        write_atomically(path, |out| {
            serde_json::to_writer_pretty(&mut *out, self)?;
            out.write_all(b"\n")
        })
    }
}
