//! Memory that threads need to start.
//!
//! A thread that finds no memory for its signal stack ends the process, and the standard library leaves nobody to tell
//! it to. So the memory of all threads is asked for at once, before the first of them starts.

use std::{
    env,
    io::{self, ErrorKind},
};

/// Stack of a thread whose size nobody sets \[bytes]; the standard library's.
const STACK: usize = 2 << 20;

/// What else belongs to a thread \[bytes]: guard pages, its signal stack and what it holds for itself.
const BESIDE_STACK: usize = 128 << 10;

/// Memory that stays for what the threads do \[bytes].
const WORK: usize = 8 << 20;

/// Fails if the process cannot have the address space that `threads` take when they start.
pub(super) fn needs_room(threads: usize) -> io::Result<()> {
    let stack = env::var("RUST_MIN_STACK").ok();
    let stack = stack.and_then(|size| size.parse().ok()).unwrap_or(STACK);
    let bytes = stack.saturating_add(BESIDE_STACK).saturating_mul(threads);
    // Nothing is written, so that no page of it is ever used.
    let mut room: Vec<u8> = Vec::new();
    room.try_reserve_exact(bytes.saturating_add(WORK))
        .map_err(|_| {
            let needed = crate::memory::in_words(bytes as f64);
            let reason =
                format!("there is no memory left for {threads} of them, which take {needed}");
            io::Error::new(ErrorKind::OutOfMemory, reason)
        })
}
