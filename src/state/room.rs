//! Memory that threads need to start.
//!
//! A thread that finds no memory for its signal stack ends the process, and the standard library leaves nobody to tell
//! it to. So the memory of all threads is asked for at once, before the first of them starts.

use std::{
    env,
    io::{self, ErrorKind},
};

use crate::memory::{in_words, is_left};

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
    if is_left(bytes.saturating_add(WORK)) {
        return Ok(());
    }
    let needed = in_words(bytes as f64);
    let reason = format!("there is no memory left for {threads} of them, which take {needed}");
    Err(io::Error::new(ErrorKind::OutOfMemory, reason))
}
