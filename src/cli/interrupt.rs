//! Ctrl-C: the first ends the run after the step in hand, the second ends the process.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

use super::exit::{EXIT_STATUS, Failure};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Turns SIGINT, SIGTERM and SIGHUP into a question that [`asked`] answers; `say` tells the user what happens now.
///
/// Until this is called a signal kills the process, which is right as long as there is nothing to save. A signal that
/// the process was started to ignore stays ignored: `nohup` does that, and a shell to what it starts in the background.
pub(super) fn listen(say: impl Fn(&str) + Send + 'static) -> Result<(), Failure> {
    // It is called in a thread of its own, not in the signal's context: it may write and exit.
    let answer = move || {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(EXIT_STATUS.into());
        }
        say("interrupted: finishing the step and writing what there is; again to leave at once");
    };
    on_signals(answer)
        .map_err(|error| Failure::Failed(format!("cannot listen for signals: {error}")))
}

/// Whether a signal has asked the run to end.
pub(super) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

#[cfg(unix)]
fn on_signals(answer: impl Fn() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored();
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter();
    let heard = wanted.filter(|signal| ignored & (1 << (signal - 1)) == 0);
    let mut signals = signal_hook::iterator::Signals::new(heard)?;
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || signals.forever().for_each(|_| answer()))
        .map(|_| ())
}

/// The signals that the process was started to ignore, a bit each from the lowest for signal 1; none where the system
/// does not tell (Linux does): to ask it in another way takes unsafe code.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

#[cfg(not(unix))]
fn on_signals(answer: impl Fn() + Send + 'static) -> io::Result<()> {
    ctrlc::set_handler(answer).map_err(io::Error::other)
}
