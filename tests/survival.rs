//! Runs survive `kill -9`: twenty times here, two hundred times in `cargo bench --bench survival`.
#![cfg(all(unix, feature = "cli"))]

#[path = "survival_support/mod.rs"]
mod survival_support;

use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn a_run_that_is_killed_twenty_times_loses_nothing_but_the_steps_since_its_checkpoint() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = Path::new(env!("CARGO_BIN_EXE_overfall"));
    let left = survival_support::kill_again_and_again(program, folder.path(), 20, |_, _| {});
    assert!(left.steps >= 60 && left.frames > 10, "{left:?}");
    // The rows, frames and gauges are those of a run that nobody killed.
    let run = |rest: &[&str]| {
        let steps = format!("--steps={}", left.steps + 5);
        let status = Command::new(program)
            .current_dir(folder.path())
            .args(["run", "killed.ron", "--quiet", &steps])
            .args(rest)
            .output()
            .expect("overfall starts");
        assert!(status.status.success(), "{status:?}");
    };
    run(&["--resume", "out/killed"]);
    run(&["--out", "whole"]);
    let [killed, whole] = ["out/killed", "whole"].map(|out| folder.path().join(out));
    let rows = |out: &Path| -> Vec<String> {
        let text = fs::read_to_string(out.join("history.csv")).expect("a history");
        let row = |row: &str| row.split(',').take(13).collect::<Vec<_>>().join(",");
        text.lines().map(row).collect()
    };
    assert_eq!(rows(&killed), rows(&whole));
    let frames = fs::read_dir(whole.join("frames")).expect("frames");
    for frame in frames {
        let name = frame.expect("a frame").file_name();
        let [a, b] = [&killed, &whole].map(|out| fs::read(out.join("frames").join(&name)).ok());
        assert!(a == b, "{name:?}");
    }
}
