//! Words while a scene is set up: large ones take minutes before their first step.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::{self, Builder};
use std::time::{Duration, Instant};

use super::console;

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(3);

/// Does `work`, and says on standard error that it goes on, every few seconds, unless `quiet`.
pub(super) fn waiting<T>(what: &str, quiet: bool, work: impl FnOnce() -> T) -> T {
    if quiet {
        return work();
    }
    let started = Instant::now();
    let (done, ended) = channel::<()>();
    thread::scope(|scope| {
        let tell = move || {
            // The channel ends with the work.
            while ended.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                console::note(&format!("{what}: {} s", started.elapsed().as_secs()));
            }
        };
        // Where the system refuses a thread, the work is done without words.
        let _ = Builder::new().spawn_scoped(scope, tell);
        let result = work();
        drop(done);
        result
    })
}
