//! Threads that bevy runs systems on, in scenes whose executor is `Parallel`.

use std::io::{self, ErrorKind};
#[cfg(feature = "parallel")]
use std::{
    panic::catch_unwind,
    sync::{Arc, Mutex, mpsc},
    thread::Builder,
};

#[cfg(feature = "parallel")]
use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};

#[cfg(feature = "parallel")]
use super::room::needs_room;

/// Says which feature of the crate is missing.
#[cfg(not(feature = "parallel"))]
pub(crate) fn start_task_threads(_: usize) -> io::Result<()> {
    let reason =
        "`executor: Parallel` needs the feature `parallel` of the crate, which this build lacks";
    Err(io::Error::new(ErrorKind::Unsupported, reason))
}

/// Starts the threads that bevy runs systems on, unless the process has them.
///
/// Bevy panics where the system refuses a thread, so as many are tried first.
#[cfg(feature = "parallel")]
pub(crate) fn start_task_threads(threads: usize) -> io::Result<()> {
    if ComputeTaskPool::try_get().is_some() {
        return Ok(());
    }
    needs_room(threads)?;
    let (release, wait) = mpsc::channel::<()>();
    let wait = Arc::new(Mutex::new(wait));
    let tried: io::Result<Vec<_>> = (0..threads)
        .map(|_| {
            let wait = wait.clone();
            // All of them live until the last was started.
            Builder::new().spawn(move || drop(wait.lock().map(|wait| wait.recv())))
        })
        .collect();
    drop(release);
    for thread in tried? {
        let _ = thread.join();
    }
    // Another program may have taken the threads since.
    catch_unwind(|| {
        let start = || TaskPoolBuilder::new().num_threads(threads).build();
        ComputeTaskPool::get_or_init(start);
    })
    .map_err(|_| io::Error::new(ErrorKind::WouldBlock, "a thread was refused"))
}
