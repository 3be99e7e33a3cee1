//! How much memory there is: what a run would need is held against it before anything is allocated.

/// Memory that the process may have \[bytes]: the machine's, or less where a control group or the process' own limit
/// (`ulimit -v`) says so. Where the system does not tell there is no limit, nor without the feature `memory`.
#[cfg(feature = "memory")]
pub(crate) fn of_machine() -> u64 {
    use std::sync::OnceLock;

    use sysinfo::{MemoryRefreshKind, System};

    static BYTES: OnceLock<u64> = OnceLock::new();
    *BYTES.get_or_init(|| {
        let Ok(mut system) = System::new() else {
            return of_process();
        };
        system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
        let known = |bytes: u64| if bytes == 0 { u64::MAX } else { bytes };
        let group = system.cgroup_limits().map_or(0, |group| group.total_memory);
        known(system.total_memory())
            .min(known(group))
            .min(of_process())
    })
}

#[cfg(not(feature = "memory"))]
pub(crate) fn of_machine() -> u64 {
    u64::MAX
}

#[cfg(all(unix, feature = "memory"))]
fn of_process() -> u64 {
    use rustix::process::{Resource, getrlimit};
    getrlimit(Resource::As).current.unwrap_or(u64::MAX)
}

#[cfg(not(all(unix, feature = "memory")))]
fn of_process() -> u64 {
    u64::MAX
}

/// Whether the process can have so many bytes more. Nothing is written, so that no page of them is ever used.
pub(crate) fn is_left(bytes: usize) -> bool {
    let mut room: Vec<u8> = Vec::new();
    // Else a compiler may leave the allocation out, and take it for granted.
    std::hint::black_box(&mut room)
        .try_reserve_exact(bytes)
        .is_ok()
}

/// Address space that the heaps of a number of threads reserve beside what is in them \[bytes]: glibc gives each thread
/// one of 64 MiB, and no more than eight for each core or `MALLOC_ARENA_MAX`.
const HEAP: usize = 64 << 20;

/// Threads of the program beside those of the loops: the main one, signals, progress, files.
const OTHERS: usize = 3;

/// Whether the process can have so many bytes more, by its limit on address space (`ulimit -v`); true where there is
/// none. Heaps of threads count there, whatever is in them.
pub(crate) fn is_left_by_limit(bytes: f64, threads: usize) -> bool {
    if of_process() == u64::MAX {
        return true;
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let most = std::env::var("MALLOC_ARENA_MAX").ok();
    let most = most
        .and_then(|most| most.parse().ok())
        .filter(|&most| most > 0);
    let heaps = (threads + OTHERS).min(most.unwrap_or(8 * cores));
    let with_heaps = bytes + heaps as f64 * HEAP as f64;
    // Also false for what is beyond any address.
    with_heaps < isize::MAX as f64 && is_left(with_heaps as usize)
}

/// A number of bytes in words.
pub(crate) fn in_words(bytes: f64) -> String {
    match bytes {
        b if b >= 1e9 => format!("{:.1} GB", b / 1e9),
        b if b >= 1e6 => format!("{:.0} MB", b / 1e6),
        b => format!("{:.0} kB", (b / 1e3).ceil()),
    }
}
