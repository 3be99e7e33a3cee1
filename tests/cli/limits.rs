//! Limits of the machine: disk space, a closed reader, a missing folder, threads.

use std::fs;
use std::process::{Command, Stdio};

use overfall::output::{Status, Summary};

use super::signals::{LONG, command_after, folder, signal, spawn, start, wait, wait_until};
use crate::support::{assert_exit, command, overfall, stderr};

#[test]
fn a_write_that_fails_ends_the_run_with_path_and_cause() {
    let folder = folder();
    // A limit on the size of files simulates a full disk: boundary particles and frames no longer fit, a summary does.
    let output = command_after(&folder, "ulimit -f 16")
        .args(["run", "long.ron", "--quiet"])
        .output()
        .expect("sh starts");
    assert_exit(&output, 1);
    let errors = stderr(&output);
    assert!(errors.contains("out/long/boundary.vtu"), "{errors}");
    assert!(errors.contains("File too large"), "{errors}");
    let out = folder.path().join("out/long");
    let summary = Summary::read(&out.join("summary.json")).expect("a summary");
    assert_eq!(summary.status, Status::Failed);
    assert!(
        summary
            .failure
            .is_some_and(|text| text.contains("boundary.vtu"))
    );
    assert!(!out.join("boundary.vtu").exists());
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
        let mut run = start(
            command(&folder)
                .args(arguments)
                .stdout(Stdio::piped())
                .stderr(Stdio::piped()),
        );
        drop(run.stdout.take());
        let (status, errors) = wait(run);
        assert_eq!(status, Some(0), "{errors}");
        assert!(!errors.contains("panicked"), "{errors}");
    }
}

#[test]
fn a_folder_that_is_removed_ends_the_run() {
    for again in [false, true] {
        let folder = folder();
        let run =
            spawn(command(&folder).args(["run", "long.ron", "--quiet", "--frames-per-second=0"]));
        let out = folder.path().join("out/long");
        wait_until("no frames appear", || {
            out.join("frames/frame_00000.vtu").exists()
        });
        fs::rename(&out, folder.path().join("moved")).expect("moved away");
        if again {
            // Another file with that name does not belong to the run.
            fs::create_dir_all(&out).expect("a folder");
            fs::write(out.join("history.csv"), "mine").expect("a file");
        }
        let (status, errors) = wait(run);
        assert_eq!(status, Some(1), "{errors}");
        assert!(
            errors.contains("history.csv: the file or its folder was removed"),
            "{errors}"
        );
        if again {
            let kept = fs::read_to_string(out.join("history.csv")).expect("a file");
            assert_eq!(kept, "mine");
        }
    }
}

#[test]
fn a_full_disk_leaves_whole_rows_and_a_summary() {
    let folder = folder();
    let small = LONG
        .replace("max: (0.1, 0.1, 0.1)", "max: (0.03, 0.03, 0.03)")
        .replace("max: (0.1, 0.2, 0.1)", "max: (0.03, 0.2, 0.03)");
    fs::write(folder.path().join("long.ron"), small).expect("a scene file");
    // A limit on the size of files simulates a full disk: 27 particles fit, a few thousand rows do not.
    let output = command_after(&folder, "ulimit -f 64")
        .args(["run", "long.ron", "--quiet", "--frames-per-second=0"])
        .output()
        .expect("sh starts");
    assert_exit(&output, 1);
    let errors = stderr(&output);
    assert!(errors.contains("history.csv"), "{errors}");
    let out = folder.path().join("out/long");
    let summary = Summary::read(&out.join("summary.json")).expect("a summary");
    assert_eq!(summary.status, Status::Failed);
    let history = fs::read_to_string(out.join("history.csv")).expect("a history");
    let columns = history.lines().next().expect("a header").split(',').count();
    assert!(history.lines().count() > 10 && history.ends_with('\n'));
    assert!(history.lines().all(|row| row.split(',').count() == columns));
}

/// A checkpoint that does not fit any more leaves the one before it.
#[test]
fn a_disk_that_fills_up_keeps_the_last_checkpoint() {
    let folder = folder();
    // A jet adds twenty particles per step, so that checkpoints grow and rows hardly do.
    let jet = r#"(
        name: "long",
        dimension: 2,
        spacing: 0.01,
        bodies: [],
        emitters: [(shape: Disc(center: (0, 0, 0), normal: (1, 0, 0), radius: 0.1), speed: 10)],
        time_step: Fixed(0.0005),
        pressure: Sesph(equation: Gas(stiffness: 10)),
        duration: 1000,
        output: (pictures: false),
    )"#;
    fs::write(folder.path().join("long.ron"), jet).expect("a scene file");
    let arguments = [
        "run",
        "long.ron",
        "--quiet",
        "--frames-per-second=0",
        "--checkpoint=1",
    ];
    let output = command_after(&folder, "trap '' XFSZ; ulimit -f 128")
        .args(arguments)
        .output()
        .expect("sh starts");
    assert_exit(&output, 1);
    let errors = stderr(&output);
    assert!(errors.contains("File too large"), "{errors}");
    let out = folder.path().join("out/long");
    let summary = Summary::read(&out.join("summary.json")).expect("a summary");
    assert_eq!(summary.status, Status::Failed);
    let rest = [
        "--resume",
        "out/long",
        "--steps",
        &(summary.steps + 3).to_string(),
    ]
    .map(str::to_owned);
    let output = command(&folder)
        .args(arguments)
        .args(rest)
        .output()
        .expect("overfall starts");
    assert_exit(&output, 0);
}

#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_nobody_may_write_is_named() {
    let folder = folder();
    for out in ["/proc/overfall", "/proc/self/fd/overfall", "/sys/overfall"] {
        for command in [
            &["run", "long.ron", "--steps=1"][..],
            &["validate", "free_flight"],
        ] {
            let output = overfall(&folder, &[command, &["--quiet", "--out", out]].concat());
            let errors = stderr(&output);
            assert_exit(&output, 1);
            assert!(
                errors.contains(out) && !errors.contains("panicked"),
                "{errors}"
            );
        }
    }
}

#[test]
fn what_is_no_file_is_refused_at_once() {
    let folder = folder();
    let made = Command::new("sh")
        .args(["-c", "mkfifo pipe.ron && ln -s /dev/zero zero.ron && ln -s /dev/zero zero.obj && mkdir folder.ron run \
         && \
            mkfifo run/checkpoint.overfall"])
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
        (
            &["run", "long.ron", "--set", "order=pipe.ron"],
            "`pipe.ron` is a pipe",
        ),
        (&["run", "long.ron", "--resume", "pipe.ron"], "a pipe"),
        (&["run", "long.ron", "--resume", "zero.ron"], "a device"),
        (&["run", "long.ron", "--resume", "run"], "a pipe"),
    ] {
        let output = overfall(&folder, arguments);
        assert_exit(&output, 2);
        assert!(stderr(&output).contains(named), "{}", stderr(&output));
    }
    for out in ["long.ron", "pipe.ron", "zero.ron", "long.ron/below"] {
        let output = overfall(&folder, &["run", "long.ron", "--steps=1", "--out", out]);
        assert_exit(&output, 1);
        assert!(stderr(&output).contains("no folder"), "{}", stderr(&output));
    }
}

#[test]
#[cfg(target_os = "linux")]
fn threads_that_cannot_be_had_are_an_error() {
    let folder = folder();
    // Stacks have 2 MiB each: below 900 MB the loops' threads do not fit into the address space, below 1700 MB the same
    // number again for systems does not. Whatever fails, the failure must be reported in words.
    for limit in (200_000..1_700_000).step_by(100_000) {
        let output = command_after(&folder, &format!("ulimit -v {limit}"))
            // One heap per core would also take address space.
            .env("MALLOC_ARENA_MAX", "1")
            .args(["run", "long.ron", "--steps=1", "--threads=400"])
            .args(["--set=executor=Parallel", "--force"])
            .output()
            .expect("sh starts");
        let errors = stderr(&output);
        assert!(!errors.contains("panicked"), "{limit}: {errors}");
        assert!(errors.contains("threads"), "{limit}: {errors}");
        assert_eq!(output.status.code(), Some(2), "{limit}: {errors}");
    }
}

/// With too little memory a run is refused in words: the allocator never ends it.
#[test]
#[cfg(target_os = "linux")]
fn pictures_without_memory_are_refused_in_words() {
    let folder = folder();
    let with = |limit: u32, arguments: &[&str]| {
        command_after(&folder, &format!("ulimit -v {limit}"))
            .args(arguments)
            .output()
            .expect("sh starts")
    };
    // The least that the program itself starts with.
    let least = (20_000..200_000)
        .step_by(2000)
        .find(|&limit| with(limit, &["--version"]).status.success())
        .expect("a limit");
    let (mut refused, mut drawn) = (0, 0);
    for limit in (least + 2000..least + 500_000).step_by(33_000) {
        let output = with(
            limit,
            &[
                "run",
                "long.ron",
                "--steps=2",
                "--pictures",
                "--threads=1",
                "--force",
            ],
        );
        let errors = stderr(&output);
        match output.status.code() {
            Some(0) => drawn += 1,
            Some(1 | 2) => {
                assert!(errors.contains("memory"), "{limit}: {errors}");
                refused += 1;
            }
            other => panic!("{limit}: {other:?}, {errors}"),
        }
    }
    assert!(refused > 0 && drawn > 0, "{refused} refused, {drawn} drawn");
}

#[test]
#[cfg(target_os = "linux")]
fn pictures_keep_to_the_number_of_threads() {
    let folder = folder();
    let arguments = ["run", "long.ron", "--quiet", "--pictures", "--threads=1"];
    let mut run = spawn(command(&folder).args(arguments));
    let picture = folder.path().join("out/long/pictures/frame_00001.png");
    wait_until("no pictures appear", || {
        assert_eq!(run.try_wait().expect("the run can be waited for"), None);
        picture.exists()
    });
    let tasks = format!("/proc/{}/task", run.id());
    let names: Vec<String> = fs::read_dir(tasks)
        .expect("threads")
        .map(|task| fs::read_to_string(task.expect("a thread").path().join("comm")))
        .map(|name| name.expect("a name").trim().to_owned())
        .collect();
    signal(&run, "INT");
    assert_eq!(wait(run).0, Some(130));
    // Threads: the main one, one for steps and drawing, the frame writer's and the signals'.
    assert_eq!(names.len(), 4, "{names:?}");
}
