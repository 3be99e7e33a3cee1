//! Progress of work in stages: studies, validations.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::{console, progress};

/// Time between two drawings of the bar.
const BAR_INTERVAL: Duration = Duration::from_millis(100);
/// Time between two lines without a terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Resolution of the bar.
const BAR_LENGTH: u64 = 1000;

/// Display of the progress: a bar on a terminal, plain lines elsewhere.
pub(super) struct Display {
    bar: Option<ProgressBar>,
    stage: String,
    since: Instant,
    shown: Option<Instant>,
    quiet: bool,
}

impl Display {
    /// Starts the display; `quiet` shows nothing.
    pub(super) fn start(quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let target = ProgressDrawTarget::stderr();
            let bar = ProgressBar::with_draw_target(Some(BAR_LENGTH), target);
            if let Ok(style) = ProgressStyle::with_template("{prefix} {wide_bar}\n{wide_msg}") {
                bar.set_style(style.progress_chars("=> "));
            }
            bar
        });
        Self {
            bar,
            stage: String::new(),
            since: Instant::now(),
            shown: None,
            quiet,
        }
    }

    /// Shows the completed fraction of a stage, if it is time.
    pub(super) fn step(&mut self, stage: &str, of: &str, fraction: f64) {
        if self.quiet {
            return;
        }
        if self.stage != stage {
            (self.stage, self.since, self.shown) = (stage.to_owned(), Instant::now(), None);
        }
        let interval = if self.bar.is_some() {
            BAR_INTERVAL
        } else {
            LINE_INTERVAL
        };
        if self.shown.is_some_and(|shown| shown.elapsed() < interval) {
            return;
        }
        self.shown = Some(Instant::now());
        let way = way(fraction, self.since.elapsed().as_secs_f64());
        match &self.bar {
            Some(bar) => {
                bar.set_position((fraction * BAR_LENGTH as f64) as u64);
                bar.set_prefix(console::name(&format!("{stage}: {way}")));
                bar.set_message(console::name(of));
            }
            None if of.is_empty() => console::note(&format!("{stage}: {way}")),
            None => console::note(&format!("{stage}: {way}, {of}")),
        }
    }

    /// A function that prints messages without disturbing the bar.
    pub(super) fn announcer(&self) -> impl Fn(&str) + Send + use<> {
        let bar = self.bar.clone();
        move |text| match &bar {
            Some(bar) => bar.println(console::shown(text)),
            None => console::note(text),
        }
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// The completed fraction of a stage and the remaining time.
fn way(fraction: f64, elapsed: f64) -> String {
    let left = if fraction > 0.01 {
        progress::clock(elapsed * (1.0 - fraction) / fraction)
    } else {
        "?".to_owned()
    };
    format!("{:.0} %, {left} left", (100.0 * fraction).floor())
}

#[cfg(test)]
mod tests {
    use super::way;

    #[test]
    fn the_time_left_is_told_from_the_part_done() {
        assert_eq!(way(0.0, 0.0), "0 %, ? left");
        assert_eq!(way(0.25, 20.0), "25 %, 1:00 left");
    }
}
