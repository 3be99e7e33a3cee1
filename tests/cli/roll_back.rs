//! Output of a run that rolls back: frames, pictures, series and history of the steps that remain.

use std::collections::BTreeSet;
use std::fs;

use overfall::output::{Frame, Series, Summary};

use crate::support::{assert_exit, folder_with, names, overfall, stdout};

/// A drop is thrown into a pool at 6 m/s. The first time step is just short enough for its flight. Every step has a
/// frame.
const SPLASH: &str = r#"(
    name: "splash",
    spacing: 0.02,
    bodies: [
        (shape: Box(min: (0, 0, 0), max: (0.2, 0.08, 0.2))),
        (shape: Sphere(center: (0.1, 0.16, 0.1), radius: 0.05), velocity: (0, -6, 0)),
    ],
    boundaries: [Tank(min: (0, 0, 0), max: (0.2, 0.4, 0.2))],
    time_step: Adaptive(max: 5e-3, initial: 2.9e-3),
    pressure: Pcisph(warm_start: 0, recovery: 1, momentum: false, mean_density_error: None), // as published
    duration: 0.008,
    output: (frames_per_second: 1e6, formats: [Vtu, Ply], pictures: true),
)
"#;

/// Step and time \[s] of the remaining steps, and the number of roll-backs, from the history.
fn standing(history: &str) -> (Vec<(u64, f64)>, u64, u64) {
    let mut lines = history.lines();
    let names: Vec<_> = lines.next().expect("a header").split(',').collect();
    let column = |name: &str| {
        names
            .iter()
            .position(|other| *other == name)
            .expect("a column")
    };
    let columns = ["step", "t_s", "steps_taken_back"].map(column);
    let (mut steps, mut roll_backs, mut taken_back): (Vec<(u64, f64)>, u64, u64) =
        (vec![(0, 0.0)], 0, 0);
    for line in lines {
        let values: Vec<_> = line.split(',').collect();
        let [step, time, back] = columns.map(|column| values[column]);
        let (step, back): (u64, u64) = (
            step.parse().expect("a step"),
            back.parse().expect("a count"),
        );
        let time: f64 = time.parse().expect("a time");
        if back > 0 {
            (roll_backs, taken_back) = (roll_backs + 1, taken_back + back);
            // The failed step has no row of its own.
            steps.truncate(steps.len() - (back - 1) as usize);
            assert_eq!(steps.last(), Some(&(step, time)), "{line}");
        } else {
            steps.push((step, time));
        }
    }
    (steps, roll_backs, taken_back)
}

#[test]
fn output_of_steps_taken_back_is_withdrawn_and_the_history_shows_it() {
    let folder = folder_with(&[("splash.ron", SPLASH)]);
    let output = overfall(&folder, &["run", "splash.ron", "--out", "out"]);
    assert_exit(&output, 0);
    let told = stdout(&output);
    assert!(told.contains("went back"), "{told}");

    let out = folder.path().join("out");
    let history = fs::read_to_string(out.join("history.csv")).expect("a history");
    let (steps, roll_backs, taken_back) = standing(&history);
    assert!(
        taken_back > roll_backs && roll_backs > 0,
        "a step with a frame was taken back"
    );
    assert!(
        steps
            .windows(2)
            .all(|pair| pair[0].0 + 1 == pair[1].0 && pair[0].1 < pair[1].1)
    );
    let summary = Summary::read(&out.join("summary.json")).expect("a summary");
    assert_eq!(
        (summary.roll_backs, summary.steps_taken_back),
        (roll_backs, taken_back)
    );
    assert_eq!(summary.steps + 1, steps.len() as u64);
    assert_eq!(summary.simulated_s, steps[steps.len() - 1].1);
    // After a roll-back, the previous frame represents the shorter steps that follow. The last multiple but one is
    // covered by the end of the run.
    assert!(summary.frames + 2 * roll_backs + 1 >= steps.len() as u64);

    let series = Series::read(out.join("splash.pvd")).expect("a series");
    let times: Vec<_> = series.entries().iter().map(|entry| entry.time).collect();
    assert_eq!(times.len() as u64, summary.frames);
    assert!(times.is_sorted_by(|a, b| a < b), "{times:?}");
    assert_eq!(times.last(), steps.last().map(|step| &step.1));
    let mut frames = BTreeSet::new();
    for entry in series.entries() {
        for file in [entry.file.clone(), entry.file.replace(".vtu", ".ply")] {
            let frame = Frame::read(&out.join(&file)).expect("a frame");
            assert_eq!(frame.time, entry.time, "{file}");
            assert!(
                steps.contains(&(frame.step, frame.time)),
                "{file} is of a step taken back"
            );
            frames.insert(file.replace("frames/", ""));
        }
    }
    assert_eq!(
        names(&out.join("frames")),
        Vec::from_iter(frames.clone()),
        "and no other"
    );
    let pictures = frames.iter().filter_map(|name| name.strip_suffix(".vtu"));
    let pictures: BTreeSet<_> = pictures.map(|name| format!("{name}.png")).collect();
    assert_eq!(names(&out.join("pictures")), Vec::from_iter(pictures));
}
