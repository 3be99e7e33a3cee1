//! Progress messages while a scene is set up: large scenes take minutes before their first step.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::{self, Builder};
use std::time::{Duration, Instant};

use super::console;

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(3);

/// Runs `work`; unless `quiet`, prints a message on standard error every few seconds until it is done.
pub(super) fn waiting<T>(what: &str, quiet: bool, work: impl FnOnce() -> T) -> T {
    if quiet {
        return work();
    }
    let started = Instant::now();
    let (done, ended) = channel::<()>();
    thread::scope(|scope| {
        let tell = move || {
            // The channel is closed when the work is done.
            while ended.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                console::note(&format!("{what}: {} s", started.elapsed().as_secs()));
            }
        };
        // If the system refuses a thread, the work is done without messages.
        let _ = Builder::new().spawn_scoped(scope, tell);
        let result = work();
        drop(done);
        result
    })
}
