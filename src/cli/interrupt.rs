//! Ctrl-C: the first ends the run after the step in hand, the second ends the process.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Failure;

/// Exit status of a run that a signal ended.
pub(super) const EXIT_STATUS: u8 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// Turns SIGINT, SIGTERM and SIGHUP into a question that [`asked`] answers; `say` tells the user what happens now.
///
/// Until this is called a signal kills the process, which is right as long as there is nothing to save.
pub(super) fn listen(say: impl Fn(&str) + Send + 'static) -> Result<(), Failure> {
    // The handler runs in a thread of its own, not in the signal's context: it may write and exit.
    ctrlc::set_handler(move || {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(EXIT_STATUS.into());
        }
        say("interrupted: finishing the step and writing what there is; again to leave at once");
    })
    .map_err(|error| Failure::Failed(format!("cannot listen for signals: {error}")))
}

/// Whether a signal has asked the run to end.
pub(super) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
