//! Output of a run that is stopped from outside, by a signal or by another run.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use overfall::output::{Frame, Series, Status, Summary};
use tempfile::TempDir;

use crate::running::{PATIENCE, Running};
use crate::support::{assert_exit, command, folder_with, overfall, stderr};

/// A thousand particles, and more steps than any machine takes during a test.
pub(super) const LONG: &str = r#"(
    name: "long",
    spacing: 0.01,
    bodies: [(shape: Box(min: (0.0, 0.0, 0.0), max: (0.1, 0.1, 0.1)))],
    boundaries: [Tank(min: (0.0, 0.0, 0.0), max: (0.1, 0.2, 0.1))],
    time_step: Fixed(0.0002),
    pressure: Pcisph(not_converged: Accept),
    duration: 1000.0,
    output: (frames_per_second: 1000, pictures: false),
)
"#;

pub(super) fn folder() -> TempDir {
    folder_with(&[("long.ron", LONG)])
}

/// Waits until a condition holds; `missing` describes it.
pub(super) fn wait_until(missing: &str, mut is_so: impl FnMut() -> bool) {
    let started = Instant::now();
    while !is_so() {
        assert!(started.elapsed() < PATIENCE, "{missing}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Starts the program with a pipe for its errors.
pub(super) fn spawn(command: &mut Command) -> Running {
    start(command.stdout(Stdio::null()).stderr(Stdio::piped()))
}

/// Starts the program with the given pipes.
pub(super) fn start(command: &mut Command) -> Running {
    Running(command.spawn().expect("overfall starts"))
}

/// The program in a folder, started by a shell after a preparatory command.
pub(super) fn command_after(folder: &TempDir, before: &str) -> Command {
    let mut command = Command::new("sh");
    command
        .args(["-c", &format!("{before}; exec \"$0\" \"$@\"")])
        .arg(env!("CARGO_BIN_EXE_overfall"))
        .current_dir(folder.path());
    command
}

/// Starts a run and waits until it has written some frames.
fn start_long(folder: &TempDir) -> (Running, PathBuf) {
    let run = spawn(command(folder).args(["run", "long.ron", "--quiet"]));
    let out = folder.path().join("out/long");
    wait_until("no frames appear", || {
        out.join("frames/frame_00003.vtu").exists()
    });
    (run, out)
}

pub(super) fn signal(run: &Child, name: &str) {
    // The shell's own `kill`: not every system has a program with that name.
    let sent = Command::new("sh")
        .args(["-c", &format!("kill -s {name} {}", run.id())])
        .status()
        .expect("kill starts");
    assert!(sent.success());
}

/// Exit status and messages of a run that ends.
pub(super) fn wait(mut run: Running) -> (Option<i32>, String) {
    let mut status = None;
    wait_until("the run does not end", || {
        status = run.try_wait().expect("the run can be waited for");
        status.is_some()
    });
    let mut text = String::new();
    if let Some(mut errors) = run.stderr.take() {
        errors.read_to_string(&mut text).expect("text");
    }
    (status.and_then(|status| status.code()), text)
}

/// Reads the messages of a run as they arrive, until `enough` is true.
fn read_until(errors: &mut ChildStderr, is_enough: impl Fn(&str) -> bool) -> String {
    let started = Instant::now();
    let (mut text, mut buffer) = (String::new(), [0; 256]);
    while !is_enough(&text) {
        assert!(started.elapsed() < PATIENCE, "no more than: {text}");
        let read = errors.read(&mut buffer).expect("text");
        text.push_str(&String::from_utf8_lossy(&buffer[..read]));
    }
    text
}

/// Reads the whole output of a run: the summary, every frame of the series, every row of the history.
#[track_caller]
fn assert_valid(out: &Path, status: Status) -> Summary {
    let summary = Summary::read(&out.join("summary.json")).expect("a summary");
    assert_eq!(summary.status, status);
    let series = Series::read(out.join("long.pvd")).expect("a series");
    assert_eq!(series.entries().len() as u64, summary.frames);
    for entry in series.entries() {
        let frame = Frame::read(&out.join(&entry.file)).expect("a whole frame");
        assert_eq!(frame.len(), 1000);
        assert_eq!(frame.time, entry.time);
    }
    let last = series.entries().last().map(|entry| entry.time);
    assert_eq!(
        last,
        Some(summary.simulated_s),
        "the last state has a frame"
    );
    let history = fs::read_to_string(out.join("history.csv")).expect("a history");
    assert_eq!(history.lines().count() as u64, 1 + summary.steps);
    summary
}

#[test]
fn an_interrupted_run_leaves_valid_files_and_says_so() {
    for name in ["INT", "TERM"] {
        let folder = folder();
        let (run, out) = start_long(&folder);
        signal(&run, name);
        let (status, errors) = wait(run);
        assert_eq!(status, Some(130), "{errors}");
        let summary = assert_valid(&out, Status::Interrupted);
        assert_eq!(summary.failure, None);
        assert!(summary.steps > 0);
    }
}

#[test]
fn a_second_interrupt_leaves_a_step_that_does_not_end() {
    let folder = folder();
    let endless = LONG.replace(
        "not_converged: Accept",
        "not_converged: Accept, min_iterations: 1000000000, max_iterations: 1000000000",
    );
    fs::write(folder.path().join("long.ron"), endless).expect("a scene file");
    let mut run = spawn(command(&folder).args(["run", "long.ron"]));
    let out = folder.path().join("out/long");
    wait_until("the first frame is missing", || {
        out.join("long.pvd").exists()
    });
    signal(&run, "INT");
    // Two signals at once would count as one: the second is sent after the answer to the first.
    let mut errors = run.stderr.take().expect("a pipe");
    read_until(&mut errors, |text| text.contains("again to leave at once"));
    assert_eq!(run.try_wait().expect("the run can be waited for"), None);
    signal(&run, "INT");
    assert_eq!(wait(run).0, Some(130));
    let series = Series::read(out.join("long.pvd")).expect("a series");
    for entry in series.entries() {
        Frame::read(&out.join(&entry.file)).expect("a whole frame");
    }
}

#[test]
fn progress_shows_as_plain_lines_where_there_is_no_terminal() {
    let folder = folder();
    let mut run = spawn(command(&folder).args(["run", "long.ron"]));
    // The second line includes the speed.
    let mut errors = run.stderr.take().expect("a pipe");
    let mut text = read_until(&mut errors, |text| text.lines().count() >= 2);
    signal(&run, "INT");
    errors.read_to_string(&mut text).expect("text");
    assert_eq!(wait(run).0, Some(130));
    for word in [
        " s, step ",
        " %",
        " left",
        "dt ",
        "iterations",
        "error",
        "ms/step",
    ] {
        assert!(text.contains(word), "{word} is missing in {text}");
    }
    assert!(!text.contains('\u{1b}'), "no control characters: {text}");
}

#[test]
fn a_signal_that_was_ignored_stays_ignored() {
    let folder = folder();
    // As `nohup` starts a program.
    let mut command = command_after(&folder, "trap '' HUP");
    let run = spawn(command.args(["run", "long.ron", "--quiet"]));
    let frames = folder.path().join("out/long/frames");
    let count = || fs::read_dir(&frames).map_or(0, Iterator::count);
    let wait_for = |frames: usize| wait_until("too few frames", || count() >= frames);
    wait_for(2);
    signal(&run, "HUP");
    wait_for(count() + 5);
    signal(&run, "TERM");
    assert_eq!(wait(run).0, Some(130));
}

#[test]
fn a_second_run_into_the_folder_is_refused() {
    let folder = folder();
    let (run, _) = start_long(&folder);
    for arguments in [
        &["run", "long.ron", "--steps=1", "--force"][..],
        &["picture", "out/long"],
    ] {
        let output = overfall(&folder, arguments);
        assert_exit(&output, 2);
        let errors = stderr(&output);
        assert!(errors.contains("another overfall"), "{errors}");
    }
    signal(&run, "INT");
    assert_eq!(wait(run).0, Some(130));
}
