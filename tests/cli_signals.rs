//! What is left of a run that is stopped from outside: by a signal, a full disk, a reader that has gone away.
#![cfg(all(feature = "cli", unix))]

#[path = "cli_support/mod.rs"]
mod support;

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use overfall::output::{Frame, Series, Status, Summary};
use support::{command, folder_with};
use tempfile::TempDir;

/// A thousand particles, and more steps than any machine takes within a test.
const LONG: &str = r#"(
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

/// Long enough for a loaded machine; a test that works does not wait for it.
const PATIENCE: Duration = Duration::from_secs(60);

fn folder() -> TempDir {
    folder_with(&[("long.ron", LONG)])
}

/// Starts a run and waits until it has written some frames.
fn start(folder: &TempDir) -> (Child, PathBuf) {
    let run = command(folder)
        .args(["run", "long.ron", "--quiet"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("overfall starts");
    let out = folder.path().join("out/long");
    let started = Instant::now();
    while !out.join("frames/frame_00003.vtu").exists() {
        assert!(started.elapsed() < PATIENCE, "no frames appear");
        std::thread::sleep(Duration::from_millis(5));
    }
    (run, out)
}

fn signal(run: &Child, name: &str) {
    // The shell's own `kill`: not every system has a program of that name.
    let sent = Command::new("sh")
        .args(["-c", &format!("kill -s {name} {}", run.id())])
        .status()
        .expect("kill starts");
    assert!(sent.success());
}

fn wait(mut run: Child) -> (Option<i32>, String) {
    let started = Instant::now();
    let status = loop {
        if let Some(status) = run.try_wait().expect("the run can be waited for") {
            break status;
        }
        assert!(started.elapsed() < PATIENCE, "the run does not end");
        std::thread::sleep(Duration::from_millis(5));
    };
    let mut text = String::new();
    if let Some(mut errors) = run.stderr.take() {
        errors.read_to_string(&mut text).expect("text");
    }
    (status.code(), text)
}

/// Reads the whole output of a run back: the summary, every frame of the series, every row of the history.
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
        let (run, out) = start(&folder);
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
    let mut run = command(&folder)
        .args(["run", "long.ron"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("overfall starts");
    let out = folder.path().join("out/long");
    let started = Instant::now();
    while !out.join("long.pvd").exists() {
        assert!(started.elapsed() < PATIENCE, "the first frame is missing");
        std::thread::sleep(Duration::from_millis(5));
    }
    signal(&run, "INT");
    // Two signals at once would be one: the second follows the answer to the first.
    let mut errors = run.stderr.take().expect("a pipe");
    let mut text = String::new();
    let mut buffer = [0; 256];
    while !text.contains("again to leave at once") {
        assert!(started.elapsed() < PATIENCE, "no answer: {text}");
        let read = errors.read(&mut buffer).expect("text");
        text.push_str(&String::from_utf8_lossy(&buffer[..read]));
    }
    assert_eq!(run.try_wait().expect("the run can be waited for"), None);
    signal(&run, "INT");
    assert_eq!(wait(run).0, Some(130));
    let series = Series::read(out.join("long.pvd")).expect("a series");
    for entry in series.entries() {
        Frame::read(&out.join(&entry.file)).expect("a whole frame");
    }
}

#[test]
fn a_write_that_fails_ends_the_run_with_path_and_cause() {
    let folder = folder();
    // A limit on the size of files stands for a full disk: frames no longer fit, a summary does.
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 16; exec \"$0\" \"$@\""])
        .args([env!("CARGO_BIN_EXE_overfall"), "run", "long.ron", "--quiet"])
        .current_dir(folder.path())
        .output()
        .expect("sh starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("frame_00000.vtu"), "{errors}");
    assert!(errors.contains("File too large"), "{errors}");
    let out = folder.path().join("out/long");
    let summary = Summary::read(&out.join("summary.json")).expect("a summary");
    assert_eq!(summary.status, Status::Failed);
    assert!(
        summary
            .failure
            .is_some_and(|text| text.contains("frame_00000.vtu"))
    );
    let left = fs::read_dir(out.join("frames")).expect("a folder").count();
    assert_eq!(left, 0, "no half-written frame stays");
}

#[test]
fn a_reader_that_has_gone_away_is_no_failure() {
    let folder = folder();
    for arguments in [
        &["run", "long.ron", "--steps=1", "--quiet"][..],
        &["run", "long.ron", "--steps=1", "--quiet", "--json"],
        &["check", "long.ron"],
        &["run", "--help"],
    ] {
        let mut run = command(&folder)
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("overfall starts");
        drop(run.stdout.take());
        let (status, errors) = wait(run);
        assert_eq!(status, Some(0), "{errors}");
        assert!(!errors.contains("panicked"), "{errors}");
    }
}

#[test]
fn progress_shows_as_plain_lines_where_there_is_no_terminal() {
    let folder = folder();
    let mut run = command(&folder)
        .args(["run", "long.ron"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("overfall starts");
    // Until the second line, which knows a speed; the pipe is read as it fills.
    let mut errors = run.stderr.take().expect("a pipe");
    let mut text = String::new();
    let mut buffer = [0; 256];
    let started = Instant::now();
    while text.lines().count() < 2 {
        assert!(started.elapsed() < PATIENCE, "no progress: {text}");
        let read = errors.read(&mut buffer).expect("text");
        text.push_str(&String::from_utf8_lossy(&buffer[..read]));
    }
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
    let run = Command::new("sh")
        .args(["-c", "trap '' HUP; exec \"$0\" \"$@\""])
        .args([env!("CARGO_BIN_EXE_overfall"), "run", "long.ron", "--quiet"])
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("sh starts");
    let frames = folder.path().join("out/long/frames");
    let count = || fs::read_dir(&frames).map_or(0, Iterator::count);
    let wait_for = |frames: usize| {
        let started = Instant::now();
        while count() < frames {
            assert!(
                started.elapsed() < PATIENCE,
                "no more than {} frames",
                count()
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    wait_for(2);
    signal(&run, "HUP");
    wait_for(count() + 5);
    signal(&run, "TERM");
    assert_eq!(wait(run).0, Some(130));
}

#[test]
fn a_folder_that_is_removed_ends_the_run() {
    for again in [false, true] {
        let folder = folder();
        let run = command(&folder)
            .args(["run", "long.ron", "--quiet", "--frames-per-second=0"])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("overfall starts");
        let out = folder.path().join("out/long");
        let started = Instant::now();
        while !out.join("frames/frame_00000.vtu").exists() {
            assert!(started.elapsed() < PATIENCE, "no frames appear");
            std::thread::sleep(Duration::from_millis(5));
        }
        fs::rename(&out, folder.path().join("moved")).expect("moved away");
        if again {
            // Another file by that name is not the run's.
            fs::create_dir_all(&out).expect("a folder");
            fs::write(out.join("history.csv"), "mine").expect("a file");
        }
        let (status, errors) = wait(run);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("history.csv: it was removed"), "{errors}");
        if again {
            let kept = fs::read_to_string(out.join("history.csv")).expect("a file");
            assert_eq!(kept, "mine");
        }
    }
}

#[test]
fn a_second_run_into_the_folder_is_refused() {
    let folder = folder();
    let (run, _) = start(&folder);
    for arguments in [
        &["run", "long.ron", "--steps=1", "--force"][..],
        &["picture", "out/long"],
    ] {
        let output = support::overfall(&folder, arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains("another overfall"), "{errors}");
    }
    signal(&run, "INT");
    assert_eq!(wait(run).0, Some(130));
}

#[test]
fn a_full_disk_leaves_whole_rows_and_a_summary() {
    let folder = folder();
    let small = LONG
        .replace("max: (0.1, 0.1, 0.1)", "max: (0.03, 0.03, 0.03)")
        .replace("max: (0.1, 0.2, 0.1)", "max: (0.03, 0.2, 0.03)");
    fs::write(folder.path().join("long.ron"), small).expect("a scene file");
    // A limit on the size of files stands for a full disk: 27 particles fit, some thousand rows do not.
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$0\" \"$@\""])
        .args([env!("CARGO_BIN_EXE_overfall"), "run", "long.ron", "--quiet"])
        .args(["--frames-per-second=0"])
        .current_dir(folder.path())
        .output()
        .expect("sh starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("history.csv"), "{errors}");
    let out = folder.path().join("out/long");
    let summary = Summary::read(&out.join("summary.json")).expect("a summary");
    assert_eq!(summary.status, Status::Failed);
    let history = fs::read_to_string(out.join("history.csv")).expect("a history");
    let columns = history.lines().next().expect("a header").split(',').count();
    assert!(history.lines().count() > 10 && history.ends_with('\n'));
    assert!(history.lines().all(|row| row.split(',').count() == columns));
}

#[test]
fn what_is_no_file_is_refused_at_once() {
    let folder = folder();
    let made = Command::new("sh")
        .args(["-c", "mkfifo pipe.ron && ln -s /dev/zero zero.ron && ln -s /dev/zero zero.obj && mkdir folder.ron"])
        .current_dir(folder.path())
        .status()
        .expect("sh starts");
    assert!(made.success());
    let mesh = LONG.replace("boundaries: [", "boundaries: [Mesh(file: \"zero.obj\"), ");
    fs::write(folder.path().join("mesh.ron"), mesh).expect("a scene file");
    for (arguments, named) in [
        (&["run", "pipe.ron"][..], "a pipe"),
        (&["run", "zero.ron"], "a device"),
        (&["run", "folder.ron"], "a folder"),
        (&["study", "pipe.ron"], "a pipe"),
        (&["study", "zero.ron"], "a device"),
        (&["run", "mesh.ron"], "zero.obj"),
        (&["run", "long.ron", "--set", "order=pipe.ron"], "pipe.ron"),
    ] {
        let output = support::overfall(&folder, arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains(named), "{errors}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn threads_that_cannot_be_had_are_an_error() {
    let folder = folder();
    // Stacks of 2 MiB each: the loops' threads fit into the address space, as many again for systems do not, and none
    // of the second. What the limit cuts off differs from machine to machine; that it is told in words does not.
    let mut told = 0;
    for limit in [700_000, 1_000_000, 1_300_000] {
        let output = Command::new("sh")
            .args(["-c", &format!("ulimit -v {limit}; exec \"$0\" \"$@\"")])
            // Heaps a core would take address space, too.
            .env("MALLOC_ARENA_MAX", "1")
            .args([
                env!("CARGO_BIN_EXE_overfall"),
                "run",
                "long.ron",
                "--steps=1",
            ])
            .args(["--threads=400", "--set=executor=Parallel", "--force"])
            .current_dir(folder.path())
            .output()
            .expect("sh starts");
        let errors = String::from_utf8_lossy(&output.stderr);
        // Where the heap itself has no room left nothing can be told: the process is ended by a signal.
        if output.status.code().is_none() {
            continue;
        }
        assert!(!errors.contains("panicked"), "{errors}");
        assert!(errors.contains("threads"), "{errors}");
        assert_eq!(output.status.code(), Some(2), "{errors}");
        told += 1;
    }
    assert!(told > 0, "no limit leaves room for an answer");
}

#[test]
#[cfg(target_os = "linux")]
fn pictures_keep_to_the_number_of_threads() {
    let folder = folder();
    let mut run = command(&folder)
        .args(["run", "long.ron", "--quiet", "--pictures", "--threads=1"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("overfall starts");
    let started = Instant::now();
    while !folder
        .path()
        .join("out/long/pictures/frame_00001.png")
        .exists()
    {
        assert!(started.elapsed() < PATIENCE, "no pictures appear");
        assert_eq!(run.try_wait().expect("the run can be waited for"), None);
        std::thread::sleep(Duration::from_millis(5));
    }
    let tasks = format!("/proc/{}/task", run.id());
    let names: Vec<String> = fs::read_dir(tasks)
        .expect("threads")
        .map(|task| fs::read_to_string(task.expect("a thread").path().join("comm")))
        .map(|name| name.expect("a name").trim().to_owned())
        .collect();
    signal(&run, "INT");
    assert_eq!(wait(run).0, Some(130));
    // The program's, one to step with, one to draw with, the frame writer's and the signals'.
    assert_eq!(names.len(), 5, "{names:?}");
}
