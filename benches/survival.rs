//! Runs that are killed two hundred times: `cargo bench --bench survival`, or another number after `--`. Every kill is
//! followed by a check of the checkpoint and of every frame, and by a continuation.
#![expect(clippy::print_stdout, reason = "a report for whoever runs it")]

#[path = "../tests/survival_support/mod.rs"]
mod survival_support;

use std::path::Path;

fn main() {
    let arguments = std::env::args().skip(1);
    let times = arguments.filter_map(|word| word.parse().ok()).next();
    let times = times.unwrap_or(200);
    let folder = tempfile::tempdir().expect("a folder");
    let program = Path::new(env!("CARGO_BIN_EXE_overfall"));
    let left = survival_support::kill_again_and_again(program, folder.path(), times, |k, left| {
        if (k + 1).is_multiple_of(20) {
            println!(
                "{} kills: {} steps, {} frames",
                k + 1,
                left.steps,
                left.frames
            );
        }
    });
    println!(
        "killed {times} times: every checkpoint was whole, {} steps and {} frames in the end",
        left.steps, left.frames
    );
}
