//! How far the run is: a bar on a terminal, plain lines elsewhere, the same words in both.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use overfall::StepReport;

use super::console;
use super::schedule::Goal;

/// Time between two drawings of the bar.
const BAR_INTERVAL: Duration = Duration::from_millis(100);
/// Time between two lines: often enough to see that it lives, seldom enough for a log.
const LINE_INTERVAL: Duration = Duration::from_secs(3);
/// The speed that the time left is reckoned with is an average over about so long [s].
const MEMORY: f64 = 10.0;
/// Resolution of the bar.
const BAR_LENGTH: u64 = 1000;

/// Shows progress on standard error.
pub(super) struct Progress {
    goal: Goal,
    display: Display,
    pace: Pace,
    shown: Instant,
}

enum Display {
    Bar(ProgressBar),
    Lines,
    Nothing,
}

impl Progress {
    /// Starts showing, unless `quiet`.
    pub(super) fn start(scene_name: &str, goal: Goal, quiet: bool) -> Self {
        let display = if quiet {
            Display::Nothing
        } else if std::io::stderr().is_terminal() {
            Display::Bar(bar(scene_name))
        } else {
            Display::Lines
        };
        Self {
            goal,
            display,
            pace: Pace::default(),
            shown: Instant::now(),
        }
    }

    /// Takes note of a step; shows it if it is time.
    pub(super) fn update(&mut self, report: &StepReport) {
        let interval = match self.display {
            Display::Bar(_) => BAR_INTERVAL,
            Display::Lines => LINE_INTERVAL,
            Display::Nothing => return,
        };
        self.pace.steps += 1;
        let elapsed = self.shown.elapsed();
        if elapsed < interval {
            return;
        }
        self.shown = Instant::now();
        let fraction = self.goal.fraction(report.step, report.time);
        self.pace.advance(fraction, elapsed.as_secs_f64());
        let line = line(self.goal, report, &self.pace);
        match &self.display {
            Display::Bar(bar) => {
                bar.set_position((fraction * BAR_LENGTH as f64) as u64);
                bar.set_message(line);
            }
            Display::Lines => console::note(&line),
            Display::Nothing => {}
        }
    }

    /// Says that steps are over and files are being finished.
    pub(super) fn finishing(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.set_message("writing the last frames");
        }
    }

    /// Takes the bar away: what follows is the report.
    pub(super) fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }
}

fn bar(scene_name: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(BAR_LENGTH), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{prefix} {bar:24} {wide_msg}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_prefix(scene_name.to_owned());
    bar
}

/// How fast the run goes, lately.
#[derive(Debug, Default)]
struct Pace {
    /// Steps since the last showing.
    steps: u32,
    /// The fraction of the way done at the last showing.
    fraction: f64,
    /// Fraction of the way a second of wall time, smoothed [1/s]; 0 before the first showing.
    per_second: f64,
    /// Wall time a step since the last showing [ms].
    ms_per_step: f64,
}

impl Pace {
    fn advance(&mut self, fraction: f64, seconds: f64) {
        let now = (fraction - self.fraction) / seconds;
        let weight = if self.per_second > 0.0 {
            1.0 - (-seconds / MEMORY).exp()
        } else {
            1.0
        };
        self.per_second += weight * (now - self.per_second);
        self.ms_per_step = 1e3 * seconds / f64::from(self.steps.max(1));
        self.fraction = fraction;
        self.steps = 0;
    }

    /// Wall time left [s], if it can be told.
    fn time_left(&self) -> Option<f64> {
        (self.per_second > 0.0).then(|| (1.0 - self.fraction) / self.per_second)
    }
}

fn line(goal: Goal, report: &StepReport, pace: &Pace) -> String {
    let way = match goal {
        Goal::Time(end) => format!("t {:.4}/{end:.4} s, step {}", report.time, report.step),
        Goal::Steps(end) => format!("step {}/{end}, t {:.4} s", report.step, report.time),
    };
    format!(
        "{way}, {:.0} %, {} left, dt {:.2e} s, {} iterations, density error {:.2} %, {:.1} ms/step",
        (100.0 * pace.fraction).floor(),
        pace.time_left().map_or_else(|| "?".to_owned(), clock),
        report.dt,
        report.iterations,
        100.0 * report.max_density_error,
        pace.ms_per_step,
    )
}

/// Seconds as `h:mm:ss`, `m:ss` under an hour.
pub(super) fn clock(seconds: f64) -> String {
    let seconds = seconds.ceil() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if hours > 0 {
        format!("{hours}:{minutes:02}:{seconds:02}")
    } else {
        format!("{minutes}:{seconds:02}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_says_how_far_how_fast_and_how_well() {
        let report = StepReport {
            step: 250,
            time: 0.25,
            dt: 0.001,
            iterations: 4,
            max_density_error: 0.0098,
            ..StepReport::default()
        };
        let mut pace = Pace {
            steps: 250,
            ..Pace::default()
        };
        pace.advance(0.25, 5.0);
        assert_eq!(
            line(Goal::Time(1.0), &report, &pace),
            "t 0.2500/1.0000 s, step 250, 25 %, 0:15 left, dt 1.00e-3 s, 4 iterations, \
             density error 0.98 %, 20.0 ms/step"
        );
        assert!(line(Goal::Steps(1000), &report, &pace).starts_with("step 250/1000, t 0.2500 s"));
    }

    #[test]
    fn the_time_left_follows_a_run_that_gets_slower() {
        let mut pace = Pace::default();
        pace.advance(0.5, 10.0);
        let before = pace.time_left().unwrap_or_default();
        pace.advance(0.6, 10.0);
        let after = pace.time_left().unwrap_or_default();
        assert!((before - 10.0).abs() < 1e-9);
        assert!(after > 13.0 && after < 40.0, "{after}");
    }

    #[test]
    fn the_time_left_is_unknown_before_the_first_step() {
        assert_eq!(Pace::default().time_left(), None);
    }

    #[test]
    fn times_read_as_on_a_clock() {
        assert_eq!(clock(0.2), "0:01");
        assert_eq!(clock(75.0), "1:15");
        assert_eq!(clock(3.0 * 3600.0 + 62.0), "3:01:02");
    }
}
