//! Checkpoints of a run: when one is due, what the run itself adds to it, and how a run resumes from one.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::{Duration, Instant};

use bevy_ecs::world::World;
use overfall::checkpoint::{Checkpoint, CheckpointError, steps_between};
use overfall::input;
use overfall::output::RunTotals;
use serde::{Deserialize, Serialize};

use super::exit::Failure;
use super::folder::{CHECKPOINT, HISTORY};
use super::manifest::MANIFEST;
use super::schedule::{ClockState, Goal};
use super::{beside, console};

/// Name of the run's own part of a checkpoint.
const PART: &str = "run";

/// Largest number of further steps after a signal until a checkpoint is possible.
pub(super) const MOST_STEPS_TO_LEAVE: u64 = 100;

/// Refuses an order with which no checkpoint is possible, and warns of one with which it seldom is.
pub(super) fn are_possible(world: &World) -> Result<(), Failure> {
    match steps_between(world) {
        u64::MAX => {
            let error = CheckpointError::NeverPossible;
            Err(Failure::Refused(format!("--checkpoint: {error}")))
        }
        between => {
            if between > MOST_STEPS_TO_LEAVE {
                console::note(&format!(
                    "warning: with this order a checkpoint is possible every {between} steps only, also after Ctrl-C"
                ));
            }
            Ok(())
        }
    }
}

/// Interval between checkpoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Every {
    /// Steps.
    Steps(u64),
    /// Simulated time \[s].
    Simulated(f64),
    /// Wall time.
    Wall(Duration),
}

impl FromStr for Every {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let wrong = "it must be a number of steps (30), simulated seconds (0.5s) or wall time (10min, 2h), above 0";
        let text = text.trim();
        // The unit starts at the first character that cannot be part of a number.
        let end = text
            .rfind(|c: char| c.is_ascii_digit() || c == '.')
            .map_or(0, |at| at + 1);
        let (number, unit) = (text[..end].trim(), text[end..].trim());
        if matches!(unit, "" | "step" | "steps") {
            let steps = number.parse().ok().filter(|steps| *steps > 0);
            return steps.map(Self::Steps).ok_or(wrong);
        }
        let number = number.parse::<f64>().ok();
        let number = number
            .filter(|number| number.is_finite() && *number > 0.0)
            .ok_or(wrong)?;
        let wall = |seconds: f64| {
            let every = Duration::try_from_secs_f64(number * seconds);
            every.map(Self::Wall).map_err(|_| wrong)
        };
        match unit {
            "s" => Ok(Self::Simulated(number)),
            "min" => wall(60.0),
            "h" => wall(3600.0),
            _ => Err(wrong),
        }
    }
}

/// Decides when a checkpoint is due.
#[derive(Debug)]
pub(super) struct CheckpointClock {
    every: Option<Every>,
    last: (u64, f64, Instant),
}

impl CheckpointClock {
    /// For a run that starts or resumes after `step` steps, at `time` \[s].
    pub(super) fn new(every: Option<Every>, step: u64, time: f64) -> Self {
        Self {
            every,
            last: (step, time, Instant::now()),
        }
    }

    /// Whether a checkpoint is due after `step` steps, at `time` \[s]: a multiple of the interval was passed since the
    /// last one. No step gets two checkpoints.
    pub(super) fn is_due(&self, step: u64, time: f64) -> bool {
        let (last_step, last_time, at) = self.last;
        match self.every {
            None => false,
            Some(Every::Steps(steps)) => step / steps > last_step / steps,
            Some(Every::Simulated(every)) => (time / every).floor() > (last_time / every).floor(),
            Some(Every::Wall(every)) => step != last_step && at.elapsed() >= every,
        }
    }

    /// Records that a checkpoint was written.
    pub(super) fn done(&mut self, step: u64, time: f64) {
        self.last = (step, time, Instant::now());
    }
}

/// State of a run besides that of its simulation.
#[derive(Debug, Default, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct RunState {
    /// Times of the frames \[s], and their steps.
    pub(super) frames: Vec<(f64, u64)>,
    /// State of the clock that says when the next frame is due.
    pub(super) frame_clock: ClockState,
    pub(super) totals: RunTotals,
    /// Wall time within the steps \[s].
    pub(super) stepping: f64,
    pub(super) history_rows: u64,
    pub(super) gauge_rows: Vec<u64>,
}

impl RunState {
    /// Tells of rows that the history had at the checkpoint, and has no longer.
    pub(super) fn tell_of_lost_rows(&self, rows: u64) {
        if rows < self.history_rows {
            console::note(&format!(
                "warning: {HISTORY} has {rows} of the {} rows before the checkpoint; the others are lost",
                self.history_rows
            ));
        }
    }

    /// Adds this state to a checkpoint.
    pub(super) fn attach(&self, checkpoint: &mut Checkpoint) -> Result<(), Failure> {
        let bytes = postcard::to_stdvec(self)
            .map_err(|error| Failure::Failed(format!("cannot write the checkpoint: {error}")))?;
        checkpoint.attach(PART, bytes);
        Ok(())
    }
}

/// A checkpoint from which a run resumes.
pub(super) struct Resumed {
    pub(super) checkpoint: Checkpoint,
    pub(super) state: RunState,
    /// The file.
    pub(super) file: PathBuf,
    /// The folder of the run that wrote it, if it is still there.
    folder: Option<PathBuf>,
}

impl Resumed {
    /// Reads a checkpoint file, or the checkpoint in a run's folder.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let file = if path.is_dir() {
            beside::newest(path, CHECKPOINT).join(CHECKPOINT)
        } else {
            path.to_owned()
        };
        let refused = |reason: String| Failure::Refused(format!("{}: {reason}", file.display()));
        let opened = input::open(&file).map_err(|error| {
            let hint = if path.is_dir() {
                " (a run keeps a checkpoint with --checkpoint, or when it is interrupted)"
            } else {
                ""
            };
            refused(format!("{error}{hint}"))
        });
        let checkpoint = Checkpoint::read(&mut std::io::BufReader::new(opened?))
            .map_err(|error| refused(error.to_string()))?;
        let state = match checkpoint.attached(PART) {
            // A host wrote it: frames start from the beginning.
            None => RunState::default(),
            Some(bytes) => postcard::from_bytes(bytes).map_err(|error| {
                refused(format!("the checkpoint's run cannot be used: {error}"))
            })?,
        };
        let folder = file.parent().unwrap_or(Path::new(""));
        let folder = if folder == Path::new("") {
            Path::new(".")
        } else {
            folder
        };
        let folder = folder.join(MANIFEST).is_file().then(|| folder.to_owned());
        Ok(Self {
            checkpoint,
            state,
            folder,
            file,
        })
    }

    /// Refuses a goal that lies before the checkpoint, at `time` \[s]: output after it would be removed, and nothing
    /// added.
    pub(super) fn ends_before(&self, goal: Goal, time: f64) -> Result<(), Failure> {
        let steps = self.state.totals.steps();
        let end = match goal {
            Goal::Steps(end) if end < steps => format!("{end} steps"),
            // The duration is a number in single precision.
            Goal::Time(end) if end < time * (1.0 - 1e-6) => format!("{} s", end as f32),
            _ => return Ok(()),
        };
        Err(Failure::Refused(format!(
            "{}: the checkpoint is after {steps} steps, at {} s, and the run ends at {end}; name a later end \
             (`--duration`, `--steps`), or start a new run",
            self.file.display(),
            time as f32
        )))
    }

    /// The folder in which the run continues, given `--out`; `None` if it continues in a new one.
    pub(super) fn folder(&self, out: Option<&Path>) -> Option<&Path> {
        let folder = self.folder.as_deref()?;
        let same = |out: &Path| out.canonicalize().ok() == folder.canonicalize().ok();
        let is_here = |out: &Path| same(out) || same(&beside::unfinished(out));
        out.is_none_or(is_here).then_some(folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_steps_simulated_or_wall_time() {
        for (text, expected) in [
            ("30", Some(Every::Steps(30))),
            ("30 steps", Some(Every::Steps(30))),
            ("0.5s", Some(Every::Simulated(0.5))),
            ("1e-3 s", Some(Every::Simulated(1e-3))),
            ("10min", Some(Every::Wall(Duration::from_secs(600)))),
            ("2 h", Some(Every::Wall(Duration::from_secs(7200)))),
            ("0", None),
            ("-1", None),
            ("0s", None),
            ("1.5", None),
            ("5 parsecs", None),
            ("1e300h", None),
            ("", None),
        ] {
            assert_eq!(text.parse::<Every>().ok(), expected, "{text}");
        }
    }

    #[test]
    fn a_checkpoint_is_due_once_in_every_interval() {
        let mut clock = CheckpointClock::new(Some(Every::Steps(10)), 13, 0.0);
        assert!(!clock.is_due(19, 0.0) && clock.is_due(20, 0.0) && clock.is_due(21, 0.0));
        clock.done(21, 0.0);
        assert!(!clock.is_due(29, 0.0) && clock.is_due(30, 0.0));
        let mut clock = CheckpointClock::new(Some(Every::Simulated(0.5)), 0, 0.0);
        assert!(!clock.is_due(1, 0.49) && clock.is_due(2, 0.51));
        clock.done(2, 0.51);
        assert!(!clock.is_due(3, 0.99) && clock.is_due(4, 1.0));
        assert!(!CheckpointClock::new(None, 0, 0.0).is_due(1000, 10.0));
    }
}
