//! `overfall run`: steps until the goal, and everything that is written on the way.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::With;
use overfall::output::{Frame, History, OutputError, RunTotals, Status, Summary};
use overfall::scene::Scene;
use overfall::state::Execution;
use overfall::state::particle::{Boundary, Fluid};
use overfall::{Simulation, StepError};
use overfall::{state::Clock, step::warnings};

use super::claims::{Claims, Writer};
use super::exit::{Exit, Failure, cannot_write};
use super::folder::{HISTORY, Reserve, RunFolder, SUMMARY};
use super::gauges::GaugeFiles;
use super::progress::Progress;
use super::recorder::{GaveUp, Recorder};
use super::scene_copy::SceneCopy;
use super::schedule::{FrameClock, Goal};
use super::waiting::waiting;
use super::{console, interrupt, options, picture, report};

/// Runs a scene and writes what comes of it.
pub(super) fn run(options: &options::Run) -> Result<Exit, Failure> {
    let started = Instant::now();
    let scene = options.effective_scene()?;
    let threads = options.scene.threads();
    let warnings = warnings(&scene).map_err(|error| options.scene.refuse(&error.into()))?;
    if !options.quiet {
        for warning in warnings {
            console::note(&format!("warning: {warning}"));
        }
    }
    let simulation = waiting("setting the scene up", options.quiet, || {
        Simulation::with_threads(&scene, threads)
    });
    let simulation = simulation.map_err(|error| options.scene.refuse(&error))?;
    let goal = options
        .steps
        .map_or_else(|| Goal::duration(scene.duration), Goal::Steps);

    let folder = RunFolder::new(options.out.as_deref(), &scene.name);
    let copy = SceneCopy::of(&scene)?;
    let writer = Writer {
        kind: "run",
        name: &scene.name,
        force: options.force,
        inputs: inputs(options, &scene),
    };
    let (claims, aside) = folder.prepare(&writer, &scene, &copy)?;
    let claims = Arc::new(claims);
    if let Some(aside) = aside.filter(|_| !options.quiet) {
        console::note(&format!("the older run is in {} now", aside.display()));
    }
    let progress = Progress::start(&scene.name, goal, options.quiet);
    interrupt::listen(progress.announcer())?;
    let reserve = Reserve::take(&claims).map_err(cannot_write)?;
    let summary_file = claims.claim(SUMMARY).map_err(cannot_write)?;
    let history = claims
        .claim(HISTORY)
        .and_then(|path| History::create(&path));
    copy.write(folder.root(), &claims)?;
    let mut run = Run {
        simulation,
        goal,
        clock: FrameClock::new(&scene.output, goal),
        history: history.map_err(cannot_write)?,
        gauges: GaugeFiles::start(&folder, &claims, &scene)?,
        recorder: Recorder::start(&folder, &claims, &scene, threads)?,
        progress,
        totals: RunTotals::default(),
        stepping: Duration::ZERO,
        recorded_steps: Vec::new(),
    };
    let ended = run.step_to_the_end();
    let mut summary = run.finish(ended, &scene, &folder, &claims, threads);
    summary.scene.clone_from(&scene.name);
    summary.threads = threads;
    summary.wall_s = started.elapsed().as_secs_f64();
    reserve.release();
    let written = summary.write(&summary_file).map_err(cannot_write);

    let printed = console::print(&if options.json {
        report::json(&summary)?
    } else {
        report::text(&summary, &scene, &folder)
    });
    // The run's own failure comes before that of telling about it.
    if let Some(failure) = summary.failure {
        return Err(Failure::Failed(failure));
    }
    written.and(printed)?;
    Ok(match summary.status {
        Status::Interrupted => Exit::Interrupted,
        Status::Done | Status::Failed => Exit::Done,
    })
}

/// The files that a run reads.
fn inputs(options: &options::Run, scene: &Scene) -> Vec<PathBuf> {
    let mut scene = scene.clone();
    let named = scene.files_mut().map(|file| PathBuf::from(&*file));
    named.chain([options.scene.scene.clone()]).collect()
}

/// A run on its way.
struct Run {
    simulation: Simulation,
    goal: Goal,
    clock: FrameClock,
    history: History,
    gauges: GaugeFiles,
    recorder: Recorder,
    progress: Progress,
    totals: RunTotals,
    /// Wall time within the steps: unlike the run's wall time, without waiting for the recorder.
    stepping: Duration,
    /// The steps that have a frame.
    recorded_steps: Vec<u64>,
}

/// Why a run stops before its goal.
enum Stop {
    /// Something failed.
    Failure(String),
    /// The recorder failed; it says why when it is finished.
    GaveUp,
}

impl Run {
    /// Steps until the goal or a signal.
    fn step_to_the_end(&mut self) -> Result<Status, Stop> {
        self.record()?;
        loop {
            let (steps, time) = (self.totals.steps(), self.simulation.time());
            if self.goal.is_reached(steps, time) {
                return Ok(Status::Done);
            }
            if interrupt::asked() {
                return Ok(Status::Interrupted);
            }
            let started = Instant::now();
            let report = match self.clock.until(time) {
                Some(until) => self.simulation.step_until(until),
                None => self.simulation.step(),
            }?;
            let taken = started.elapsed();
            self.stepping += taken;
            self.totals.add(&report);
            self.history.push(&report)?;
            self.gauges.take(self.simulation.world_mut(), false)?;
            if report.taken_back.is_some() {
                self.withdraw(report.time)?;
                self.progress.update(&report, taken);
                continue;
            }
            let next_dt = self.simulation.world().resource::<Clock>().next_dt;
            if self.clock.is_due(report.time, next_dt.into()) {
                self.record()?;
            }
            self.progress.update(&report, taken);
        }
    }

    /// Hands the present state to the recorder, unless it has it.
    fn record(&mut self) -> Result<(), GaveUp> {
        let step = self.totals.steps();
        if self.recorded_steps.last() == Some(&step) {
            return Ok(());
        }
        self.recorded_steps.push(step);
        let frame = Frame::from_world(self.simulation.world_mut());
        self.recorder.record(frame)
    }

    /// Takes back what was written of steps after `time` [s], where the run stands again.
    fn withdraw(&mut self, time: f64) -> Result<(), GaveUp> {
        self.clock.set_back(time);
        let step = self.totals.steps();
        let frames = self.recorded_steps.len();
        self.recorded_steps.retain(|&recorded| recorded <= step);
        if self.recorded_steps.len() < frames {
            self.recorder.withdraw_after(time)?;
        }
        Ok(())
    }

    /// Writes all that is left to write, and sums up.
    fn finish(
        mut self,
        ended: Result<Status, Stop>,
        scene: &Scene,
        folder: &RunFolder,
        claims: &Claims,
        threads: usize,
    ) -> Summary {
        self.progress.finishing();
        let (mut status, mut failures) = match ended {
            Ok(status) => (status, Vec::new()),
            Err(Stop::GaveUp) => (Status::Failed, Vec::new()),
            Err(Stop::Failure(failure)) => (Status::Failed, vec![failure]),
        };
        // After a failed step too: the columns keep the last good state, and that is what one wants to see.
        let last_frame = self.record();
        failures.extend(
            self.history
                .flush()
                .err()
                .map(|error| cannot_write(error).into_text()),
        );
        failures.extend(self.gauges.finish(self.simulation.world_mut()));
        let recorded = self.recorder.finish();
        debug_assert!(last_frame.is_ok() || recorded.failure.is_some());
        failures.extend(recorded.failure);
        if scene.output.pictures
            && let Err(failure) = picture::write_contact_sheet(scene, folder, claims, threads)
        {
            failures.push(failure.into_text());
        }
        self.progress.finish();

        if !failures.is_empty() {
            status = Status::Failed;
        }
        let world = self.simulation.world_mut();
        let instruction_set = world.resource::<Execution>().instruction_set.name();
        Summary {
            status,
            failure: (!failures.is_empty()).then(|| failures.join("; ")),
            particles: world
                .query_filtered::<(), With<Fluid>>()
                .iter(world)
                .count(),
            boundary_particles: world
                .query_filtered::<(), With<Boundary>>()
                .iter(world)
                .count(),
            instruction_set: instruction_set.to_owned(),
            frames: recorded.frames,
            ms_per_step: 1e3 * self.stepping.as_secs_f64() / self.totals.steps().max(1) as f64,
            ..self.totals.summary()
        }
    }
}

impl From<StepError> for Stop {
    fn from(error: StepError) -> Self {
        Self::Failure(error.to_string())
    }
}

impl From<OutputError> for Stop {
    fn from(error: OutputError) -> Self {
        Self::Failure(cannot_write(error).into_text())
    }
}

impl From<GaveUp> for Stop {
    fn from(_: GaveUp) -> Self {
        Self::GaveUp
    }
}
