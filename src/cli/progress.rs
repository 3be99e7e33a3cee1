//! Progress of a run: a bar on a terminal, plain lines elsewhere, with the same text in both.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use overfall::StepReport;

use super::console;
use super::schedule::Goal;

/// Time between two drawings of the bar.
const BAR_INTERVAL: Duration = Duration::from_millis(100);
/// Time between two lines: often enough to show progress, rarely enough for a log.
const LINE_INTERVAL: Duration = Duration::from_secs(3);
/// Averaging time of the speed from which the remaining time is estimated \[s].
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
    /// Starts the display, unless `quiet`.
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

    /// Records a step and the wall time it took; updates the display if it is time.
    pub(super) fn update(&mut self, report: &StepReport, taken: Duration) {
        let interval = match self.display {
            Display::Bar(_) => BAR_INTERVAL,
            Display::Lines => LINE_INTERVAL,
            Display::Nothing => return,
        };
        self.pace.steps += 1;
        self.pace.stepping += taken;
        self.pace.taken_back += report
            .taken_back
            .as_ref()
            .map_or(0, |back| u64::from(back.steps));
        let elapsed = self.shown.elapsed();
        if elapsed < interval {
            return;
        }
        self.shown = Instant::now();
        let fraction = self.goal.fraction(report.step, report.time);
        self.pace.advance(fraction, elapsed.as_secs_f64());
        let (way, state) = (way(&self.pace), state(self.goal, report, &self.pace));
        match &self.display {
            Display::Bar(bar) => {
                bar.set_position((fraction * BAR_LENGTH as f64) as u64);
                bar.set_prefix(way);
                bar.set_message(state);
            }
            Display::Lines => console::note(&format!("{way}, {state}")),
            Display::Nothing => {}
        }
    }

    /// The run resumes after this number of steps, at a time \[s].
    pub(super) fn go_on(&mut self, steps: u64, time: f64) {
        self.pace.fraction = self.goal.fraction(steps, time);
    }

    /// A function that prints messages during the run, from any thread, without disturbing the bar.
    pub(super) fn announcer(&self) -> impl Fn(&str) + Send + use<> {
        let bar = match &self.display {
            Display::Bar(bar) => Some(bar.clone()),
            Display::Lines | Display::Nothing => None,
        };
        move |text| match &bar {
            Some(bar) => bar.println(console::shown(text)),
            None => console::note(text),
        }
    }

    /// Shows that steps are finished and files are being completed.
    pub(super) fn finishing(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.set_message("writing the last frames");
        }
    }

    /// Removes the bar before the report is printed.
    pub(super) fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }
}

/// Two lines, so that everything fits into 80 columns.
fn bar(scene_name: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(BAR_LENGTH), ProgressDrawTarget::stderr());
    // Braces in a template start a field, so they are escaped.
    let name = console::name(scene_name)
        .replace('{', "{{")
        .replace('}', "}}");
    let template = format!("{name} {{wide_bar}} {{prefix}}\n{{wide_msg}}");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}

/// The current speed of the run.
#[derive(Debug, Default)]
struct Pace {
    /// Steps since the last update of the display.
    steps: u32,
    /// Completed fraction of the run at the last update.
    fraction: f64,
    /// Completed fraction per second of wall time, smoothed \[1/s]; 0 before the first update.
    per_second: f64,
    /// Wall time within these steps, without waiting for a frame to be written.
    stepping: Duration,
    /// Wall time per step, averaged over the steps before the last update \[ms].
    ms_per_step: f64,
    /// Steps rolled back in total.
    taken_back: u64,
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
        self.ms_per_step = 1e3 * self.stepping.as_secs_f64() / f64::from(self.steps.max(1));
        self.fraction = fraction;
        (self.steps, self.stepping) = (0, Duration::ZERO);
    }

    /// Remaining wall time \[s], if it can be estimated.
    fn time_left(&self) -> Option<f64> {
        (self.per_second > 0.0).then(|| (1.0 - self.fraction) / self.per_second)
    }
}

/// The completed fraction and the remaining time.
fn way(pace: &Pace) -> String {
    format!(
        "{:.0} %, {} left",
        (100.0 * pace.fraction).floor(),
        pace.time_left().map_or_else(|| "?".to_owned(), clock),
    )
}

/// The position of the run, and the result of the last step.
fn state(goal: Goal, report: &StepReport, pace: &Pace) -> String {
    let at = match goal {
        Goal::Time(end) => format!(
            "t {:.4}/{} s, step {}",
            report.time, end as f32, report.step
        ),
        Goal::Steps(end) => format!("step {}/{end}, t {:.4} s", report.step, report.time),
    };
    let mut state = format!(
        "{at}, dt {:.1e} s, {} iterations, error {:.2} %, {:.1} ms/step",
        report.dt,
        report.iterations,
        100.0 * report.max_density_error,
        pace.ms_per_step,
    );
    if pace.taken_back > 0 {
        state.push_str(&format!(", {} taken back", pace.taken_back));
    }
    state
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
        let mut report = StepReport::default();
        report.step = 250;
        report.time = 0.25;
        report.dt = 0.001;
        report.iterations = 4;
        report.max_density_error = 0.0098;
        let mut pace = Pace {
            steps: 250,
            stepping: Duration::from_secs(4),
            ..Pace::default()
        };
        pace.advance(0.25, 5.0);
        assert_eq!(way(&pace), "25 %, 0:15 left");
        assert_eq!(
            state(Goal::Time(1.0), &report, &pace),
            "t 0.2500/1 s, step 250, dt 1.0e-3 s, 4 iterations, error 0.98 %, 16.0 ms/step"
        );
        let state = state(Goal::Steps(1000), &report, &pace);
        assert!(state.starts_with("step 250/1000, t 0.2500 s"), "{state}");
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
