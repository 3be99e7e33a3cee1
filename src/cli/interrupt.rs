//! Ctrl-C: the first ends the run after the current step, the second ends the process.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

use super::exit::{EXIT_STATUS, Failure};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Handles SIGINT, SIGTERM, SIGHUP and SIGXCPU (`ulimit -S -t`): [`asked`] then returns true, and `say` tells the
/// user.
///
/// Before this is called, a signal kills the process, which is right as long as there is nothing to save. Signals that
/// the process was started to ignore stay ignored: `nohup` starts programs like that, and so does a shell in the
/// background.
pub(super) fn listen(say: impl Fn(&str) + Send + 'static) -> Result<(), Failure> {
    // Runs in a thread of its own, not in the signal's context: it may write and exit.
    let answer = move || {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(EXIT_STATUS.into());
        }
        say("interrupted: finishing the step and writing the results; again to leave at once");
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
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXCPU};
    let ignored = ignored();
    let wanted = [SIGINT, SIGTERM, SIGHUP, SIGXCPU].into_iter();
    let heard = wanted.filter(|signal| ignored & (1 << (signal - 1)) == 0);
    let mut signals = signal_hook::iterator::Signals::new(heard)?;
    std::thread::Builder::new()
        .name("signals".to_owned())
        .spawn(move || signals.forever().for_each(|_| answer()))
        .map(|_| ())
}

/// Makes a write beyond a limit on the size of files (`ulimit -f`) fail, as on a full disk. Otherwise the system ends
/// the process, and leaves no summary.
#[cfg(unix)]
pub(super) fn outlive_size_limits() {
    let heard = std::sync::Arc::new(AtomicBool::new(false));
    // Where it cannot be had, only such a limit is answered worse.
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, heard).ok();
}

#[cfg(not(unix))]
pub(super) fn outlive_size_limits() {}

/// The signals that the process was started to ignore, one bit each, signal 1 in the lowest bit. 0 if the system does
/// not report them (Linux does): other ways to find out need unsafe code.
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
