//! `overfall run`: takes steps until the goal and writes all output.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::With;
use overfall::checkpoint::{Checkpoint, CheckpointError, steps_until_possible};
use overfall::output::{History, OutputError, Provenance, RunTotals, Status, Summary};
use overfall::scene::Scene;
use overfall::state::particle::{Boundary, Fluid};
use overfall::state::{Clock, Execution};
use overfall::{Simulation, StepError};

use super::checkpoints::{
    CheckpointClock, Every, MOST_STEPS_TO_LEAVE, Resumed, RunState, are_possible,
};
use super::claims::Claims;
use super::exit::{Exit, Failure, cannot_write};
use super::folder::{HISTORY, Reserve, RunFolder, SUMMARY};
use super::gauges::GaugeFiles;
use super::progress::Progress;
use super::recorder::{GaveUp, Recorder};
use super::scene_copy::SceneCopy;
use super::schedule::{FrameClock, Goal};
use super::spent::Spent;
use super::waiting::waiting;
use super::writer::Writer;
use super::{COMMIT, console, interrupt, options, picture, report};

/// Runs a scene and writes its results.
pub(super) fn run(options: &options::Run) -> Result<Exit, Failure> {
    let started = Instant::now();
    let begun = Provenance::of_this_process(None).date;
    let quiet = options.reporting.quiet;
    let scene = waiting("reading the scene", quiet, || options.effective_scene())?;
    let threads = options.scene.threads();
    report::warn(options, &scene)?;
    let resumed = (options.resume.as_deref()).map(Resumed::read).transpose()?;
    let simulation = set_up(options, &scene, threads, resumed.as_ref())?;
    let goal = options
        .steps
        .map_or_else(|| Goal::duration(scene.duration), Goal::Steps);

    if let Some(resumed) = &resumed {
        resumed.ends_before(goal, simulation.time())?;
    }
    let own_folder = (resumed.as_ref()).and_then(|of| of.folder(options.out.as_deref()));
    let mut folder = RunFolder::new(own_folder.or(options.out.as_deref()), &scene.name);
    let copy = SceneCopy::of(&scene)?;
    let writer = Writer {
        kind: "run",
        name: &scene.name,
        force: options.force,
        inputs: inputs(options, &scene),
    };
    let mut state = resumed.as_ref().map(|of| of.state.clone());
    let (claims, aside) = match &mut state {
        Some(state) if own_folder.is_some() => {
            (folder.reopen(&writer, &scene, state.frames.len())?, None)
        }
        state => {
            // The rows before the checkpoint are in another folder.
            if let Some(state) = state {
                state.history_rows = 0;
                state.gauge_rows.clear();
            }
            folder.prepare(&writer, &scene, &copy)?
        }
    };
    let claims = Arc::new(claims);
    if let Some(aside) = aside.filter(|_| !options.reporting.quiet) {
        console::note(&format!("the older run is in {} now", aside.display()));
    }
    let progress = Progress::start(&scene.name, goal, options.reporting.quiet);
    interrupt::listen(progress.announcer())?;
    let reserve = Reserve::take(&claims).map_err(cannot_write)?;
    let summary_file = claims.claim(SUMMARY).map_err(cannot_write)?;
    copy.write(folder.root(), &claims)?;
    let mut run = Run::start(
        (simulation, goal, progress),
        (&folder, &claims, &scene),
        options.checkpoint,
        state,
    )?;
    run.spent.set_up = started.elapsed();
    let ended = run.step_to_the_end();
    let mut summary = run.finish(ended, &scene, &folder, &claims);
    summary.provenance = Provenance::of_this_process(COMMIT);
    summary.provenance.date = begun;
    summary.scene.clone_from(&scene.name);
    summary.threads = threads;
    summary.wall_s = started.elapsed().as_secs_f64();
    reserve.release();
    let mut written = summary.write(&summary_file).map_err(cannot_write);
    if written.is_ok() && summary.status == Status::Done {
        written = folder.complete(&claims);
    }

    let printed = console::print(&if options.reporting.json {
        report::pretty(&summary)?
    } else {
        report::text(&summary, &scene, &folder)
    });
    // A failure of the run is reported before a failure to print the report.
    if let Some(failure) = summary.failure {
        return Err(Failure::Failed(failure));
    }
    written.and(printed)?;
    Ok(match summary.status {
        Status::Interrupted => Exit::Interrupted,
        Status::Done | Status::Failed => Exit::Done,
    })
}

/// The simulation of a scene, at its start or resumed from a checkpoint.
fn set_up(
    options: &options::Run,
    scene: &Scene,
    threads: usize,
    resumed: Option<&Resumed>,
) -> Result<Simulation, Failure> {
    waiting("setting the scene up", options.reporting.quiet, || {
        let mut simulation = Simulation::with_threads(scene, threads)
            .map_err(|error| options.scene.refuse(&error))?;
        if options.checkpoint.is_some() {
            are_possible(simulation.world())?;
        }
        if let Some(resumed) = resumed {
            (resumed.checkpoint.restore(simulation.world_mut())).map_err(|error| {
                Failure::Refused(format!("{}: {error}", resumed.file.display()))
            })?;
        }
        Ok(simulation)
    })
}

/// The files that a run reads.
fn inputs(options: &options::Run, scene: &Scene) -> Vec<PathBuf> {
    let mut scene = scene.clone();
    let named = scene.files_mut().map(|file| PathBuf::from(&*file));
    let named = named.chain([options.scene.scene.clone()]);
    let named = named.chain(Scene::fragments(&options.scene.scene));
    named.chain(options.resume.clone()).collect()
}

/// A run in progress.
struct Run {
    simulation: Simulation,
    goal: Goal,
    clock: FrameClock,
    history: History,
    gauges: GaugeFiles,
    recorder: Recorder,
    progress: Progress,
    totals: RunTotals,
    /// Wall time within the steps: unlike the wall time of the run, it excludes waiting for the recorder.
    stepping: Duration,
    /// Times of the frames \[s], and their steps.
    frames: Vec<(f64, u64)>,
    checkpoints: CheckpointClock,
    spent: Spent,
}

/// Why a run stops before its goal.
enum Stop {
    /// Something failed.
    Failure(String),
    /// The recorder failed; `finish` returns its reason.
    GaveUp,
}

impl Run {
    /// A run at its start, or where it resumes.
    fn start(
        (simulation, goal, mut progress): (Simulation, Goal, Progress),
        (folder, claims, scene): (&RunFolder, &Arc<Claims>, &Scene),
        every: Option<Every>,
        resumed: Option<RunState>,
    ) -> Result<Self, Failure> {
        let time = simulation.time();
        let mut clock = FrameClock::new(&scene.output, goal);
        if let Some(state) = &resumed {
            clock.set_state(state.frame_clock, time);
        }
        let state = resumed.unwrap_or_default();
        progress.go_on(state.totals.steps(), time);
        let history = (claims.claim(HISTORY))
            .and_then(|path| History::resume_after_rows(&path, state.history_rows))
            .map_err(cannot_write)?;
        state.tell_of_lost_rows(history.rows());
        // The painter draws with the threads of the steps: there are no others.
        let execution = simulation.world().resource::<Execution>().clone();
        let times: Vec<f64> = state.frames.iter().map(|frame| frame.0).collect();
        Ok(Self {
            simulation,
            goal,
            clock,
            history,
            gauges: GaugeFiles::start(folder, claims, scene, &state.gauge_rows)?,
            recorder: Recorder::start(folder, claims, scene, &execution, &times)?,
            progress,
            checkpoints: CheckpointClock::new(every, state.totals.steps(), time),
            totals: state.totals,
            stepping: Duration::try_from_secs_f64(state.stepping).unwrap_or_default(),
            frames: state.frames,
            spent: Spent::default(),
        })
    }

    /// Passes a checkpoint of the current state to the recorder.
    fn checkpoint(&mut self) -> Result<(), Stop> {
        self.history.flush()?;
        let state = RunState {
            frames: self.frames.clone(),
            frame_clock: self.clock.state(),
            totals: self.totals,
            stepping: self.stepping.as_secs_f64(),
            history_rows: self.history.rows(),
            gauge_rows: self.gauges.flush()?,
        };
        self.recorder.wait()?;
        let failed = |error: CheckpointError| Stop::Failure(error.to_string());
        let mut checkpoint = Checkpoint::of(self.simulation.world_mut()).map_err(failed)?;
        (state.attach(&mut checkpoint)).map_err(|failure| Stop::Failure(failure.into_text()))?;
        self.recorder.checkpoint(checkpoint.to_bytes())?;
        (self.checkpoints).done(self.totals.steps(), self.simulation.time());
        Ok(())
    }

    /// Whether the run may end here after a signal: it writes a checkpoint first, which may need some more steps.
    fn may_leave(&mut self) -> Result<bool, Stop> {
        match steps_until_possible(self.simulation.world_mut()) {
            0 => self.checkpoint()?,
            1..=MOST_STEPS_TO_LEAVE => return Ok(false),
            _ => {}
        }
        Ok(true)
    }

    /// Takes steps until the goal or a signal.
    fn step_to_the_end(&mut self) -> Result<Status, Stop> {
        // A resumed run has its first frame already, and a checkpoint alone is no reason for another frame.
        if self.frames.is_empty() {
            self.record()?;
        }
        loop {
            let (steps, time) = (self.totals.steps(), self.simulation.time());
            if self.goal.is_reached(steps, time) {
                return Ok(Status::Done);
            }
            if interrupt::asked() && self.may_leave()? {
                return Ok(Status::Interrupted);
            }
            if self.checkpoints.is_due(steps, time)
                && steps_until_possible(self.simulation.world_mut()) == 0
            {
                self.checkpoint()?;
            }
            let started = Instant::now();
            let report = match self.clock.until(time) {
                Some(until) => self.simulation.step_until(until),
                None => self.simulation.step(),
            }?;
            let taken = started.elapsed();
            self.stepping += taken;
            self.spent.stepping += taken;
            self.totals.add(&report);
            self.history.push(&report)?;
            self.gauges.take(self.simulation.world_mut(), false)?;
            self.spent.rows += started.elapsed().saturating_sub(taken);
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

    /// Passes the current state to the recorder, unless it was already passed.
    fn record(&mut self) -> Result<(), GaveUp> {
        let step = self.totals.steps();
        if self.frames.last().is_some_and(|last| last.1 == step) {
            return Ok(());
        }
        self.frames.push((self.simulation.time(), step));
        let started = Instant::now();
        let recorded = self.recorder.record(self.simulation.world_mut());
        self.spent.waiting += started.elapsed();
        recorded
    }

    /// Removes the output of steps after `time` \[s], to which the run went back.
    fn withdraw(&mut self, time: f64) -> Result<(), GaveUp> {
        self.clock.set_back(time);
        let step = self.totals.steps();
        let frames = self.frames.len();
        self.frames.retain(|recorded| recorded.1 <= step);
        if self.frames.len() < frames {
            self.recorder.withdraw_after(time)?;
        }
        Ok(())
    }

    /// Writes the remaining output and summarises the run.
    fn finish(
        mut self,
        ended: Result<Status, Stop>,
        scene: &Scene,
        folder: &RunFolder,
        claims: &Claims,
    ) -> Summary {
        self.progress.finishing();
        let execution = self.simulation.world().resource::<Execution>().clone();
        let (mut status, mut failures) = match ended {
            Ok(status) => (status, Vec::new()),
            Err(Stop::GaveUp) => (Status::Failed, Vec::new()),
            Err(Stop::Failure(failure)) => (Status::Failed, vec![failure]),
        };
        // Also after a failed step: the columns keep the last good state, which helps to find the cause.
        let last_frame = self.record();
        failures.extend(
            self.history
                .flush()
                .err()
                .map(|error| cannot_write(error).into_text()),
        );
        failures.extend(self.gauges.finish(self.simulation.world_mut()));
        let finishing = Instant::now();
        let recorded = self.recorder.finish();
        self.spent.waiting += finishing.elapsed();
        debug_assert!(last_frame.is_ok() || recorded.failure.is_some());
        failures.extend(recorded.failure);
        let world = self.simulation.world_mut();
        let particles = (world.query_filtered::<(), With<Fluid>>())
            .iter(world)
            .len();
        let boundary_particles = (world.query_filtered::<(), With<Boundary>>())
            .iter(world)
            .len();
        // Reading and drawing a dozen frames takes memory, too.
        drop(self.simulation);
        let painting = Instant::now();
        if scene.output.pictures
            && let Err(failure) = picture::write_contact_sheet(scene, folder, claims, &execution)
        {
            failures.push(failure.into_text());
        }
        let sheet = painting.elapsed();
        self.progress.finish();

        if !failures.is_empty() {
            status = Status::Failed;
        }
        Summary {
            status,
            failure: (!failures.is_empty()).then(|| failures.join("; ")),
            particles,
            boundary_particles,
            instruction_set: execution.instruction_set.name().to_owned(),
            frames: recorded.frames,
            wall_s_by_part: self.spent.by_part(recorded.times, sheet),
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
