//! Folders that runs write to: older runs, files of the user, inputs inside the folder.

use std::fs;

use crate::support::{
    TINY, assert_exit, folder_with, folder_with_tiny, names, overfall, read_json, stderr, stdout,
};

/// Boundary particles are in one file if walls stand, and in one per frame if a wall moves; also after going on.
#[test]
fn boundary_particles_have_files_of_their_own() {
    let moving = TINY.replace("name: \"tiny\"", "name: \"moving\"").replace(
        "max: (0.2, 0.2, 0.1))]",
        "max: (0.2, 0.2, 0.1)), Box(min: (0.15, 0.0, 0.0), max: (0.17, 0.1, 0.1), \
         motion: Velocity(velocity: (0.0, 0.5, 0.0)))]",
    );
    assert_ne!(moving, TINY);
    let folder = folder_with(&[("tiny.ron", TINY), ("moving.ron", &moving)]);
    let out = |name: &str| folder.path().join("out").join(name);
    for name in ["tiny", "moving"] {
        let scene = format!("{name}.ron");
        let run = [
            "run",
            &scene,
            "--quiet",
            "--duration=0.01",
            "--checkpoint=1",
        ];
        assert_exit(&overfall(&folder, &run), 0);
    }
    assert!(out("tiny").join("boundary.vtu").exists() && !out("tiny").join("boundary").exists());
    assert!(!out("moving").join("boundary.vtu").exists());
    let on = [
        "run",
        "moving.ron",
        "--quiet",
        "--duration=0.02",
        "--resume=out/moving",
    ];
    assert_exit(&overfall(&folder, &on), 0);
    let out = out("moving");
    let files = names(&out.join("boundary"));
    assert_eq!((files.len(), &files), (9, &names(&out.join("frames"))));
    let series = fs::read_to_string(out.join("boundary.pvd")).expect("a series");
    assert_eq!(series.matches("boundary/frame_").count(), 9);
    let [first, last] = [0, 8].map(|i| fs::read(out.join("boundary").join(&files[i])).ok());
    assert_ne!(first, last, "the box rises");
}

#[test]
fn a_second_run_moves_the_first_aside_or_replaces_it_and_touches_nothing_else() {
    let folder = folder_with_tiny();
    let run = |duration: &str, more: &[&str]| {
        let arguments = [
            "run",
            "tiny.ron",
            "--duration",
            duration,
            "--out=here",
            "--quiet",
        ];
        assert_exit(&overfall(&folder, &[&arguments, more].concat()), 0);
        names(&folder.path().join("here/frames")).len()
    };
    let long = run("0.02", &[]);
    fs::write(folder.path().join("here/frames/notes.txt"), "mine").expect("a file");
    fs::write(folder.path().join("here/frames/scan_00001.vtu"), "mine").expect("a file");
    let short = run("0.01", &[]);
    assert_eq!((long, short), (9, 5 + 2));
    let aside = folder.path().join("here/older_1");
    assert_eq!(names(&aside.join("frames")).len(), 9);
    assert_eq!(read_json(&aside.join("summary.json"))["simulated_s"], 0.02);
    assert_eq!(run("0.005", &["--force"]), 3 + 2);
    assert!(!folder.path().join("here/older_2").exists());
}

#[test]
fn files_of_the_users_are_never_overwritten() {
    // A name that a run writes, and whether it is also an input of the run.
    for name in [
        "history.csv",
        "summary.json",
        "contact_sheet.png",
        "tiny.pvd",
        "scene/scene.ron",
        "frames/frame_00003.vtu",
        "pictures/frame_00000.png",
        "history.csv.partial",
        "overfall_manifest.txt",
    ] {
        let folder = folder_with_tiny();
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, "mine").expect("a file");
        for force in [&[][..], &["--force"]] {
            let arguments = ["run", "tiny.ron", "--steps=1", "--out=.", "--pictures"];
            let output = overfall(&folder, &[&arguments, force].concat());
            assert_exit(&output, 2);
            assert!(stderr(&output).contains("--out"), "{}", stderr(&output));
        }
        assert_eq!(fs::read_to_string(&path).expect("a file"), "mine", "{name}");
        assert!(!folder.path().join("tiny.ron.partial").exists());
    }
}

#[test]
fn inputs_that_lie_in_the_folder_stay_as_they_are() {
    let order = include_str!("../../assets/orders/default.ron");
    let cube = |size: f32| {
        let mut text = String::new();
        for k in 0..8 {
            let at = |bit: i32| size * f32::from(u8::from(k & bit != 0));
            text.push_str(&format!("v {} {} {}\n", at(1), at(2), at(4)));
        }
        text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    };
    let scene = TINY
        .replace(
            "boundaries: [",
            "boundaries: [Mesh(file: \"mesh_1.obj\", translation: (0.5, 0, 0)), Mesh(file: \"mesh_0.obj\", \
             translation: (1, 0, 0)), ",
        )
        .replace("duration:", "order: \"order.ron\", duration:");
    let files = [
        ("scene.ron", scene.as_str()),
        ("mesh_0.obj", &cube(0.1)),
        ("mesh_1.obj", &cube(0.2)),
        ("order.ron", order),
    ];
    let folder = folder_with(&files);
    for more in [&[][..], &[], &["--force"]] {
        let arguments = ["run", "scene.ron", "--steps=1", "--out=.", "--quiet"];
        assert_exit(&overfall(&folder, &[&arguments, more].concat()), 0);
        for (name, text) in files {
            let kept = fs::read_to_string(folder.path().join(name)).expect("a file");
            assert_eq!(kept, text, "{name}");
        }
    }
    assert_eq!(
        names(&folder.path().join("scene")),
        ["mesh_1.obj", "mesh_2.obj", "order.ron", "scene.ron"]
    );
    // The copy of an older run is an input, too.
    let again = ["run", "scene/scene.ron", "--steps=1", "--out=.", "--force"];
    let output = overfall(&folder, &again);
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("it is an input"),
        "{}",
        stderr(&output)
    );
    assert!(folder.path().join("scene/scene.ron").exists());
}

#[test]
fn scenes_whose_names_map_to_one_folder_are_told_apart() {
    let folder = folder_with_tiny();
    for name in ["a b", "a_b", "a?b"] {
        let set = format!("name={name}");
        let arguments = ["run", "tiny.ron", "--steps=0", "--quiet", "--set", &set];
        assert_exit(&overfall(&folder, &arguments), 0);
    }
    let out = folder.path().join("out");
    let mut scenes: Vec<_> = names(&out)
        .iter()
        .map(|name| read_json(&out.join(name).join("summary.json"))["scene"].clone())
        .collect();
    scenes.sort_by_key(ToString::to_string);
    assert_eq!(scenes, ["a b", "a?b", "a_b"]);
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = folder_with_tiny();
    let output = overfall(
        &folder,
        &["run", "tiny.ron", "--steps=1", "--out=tiny.ron/deep"],
    );
    assert_exit(&output, 1);
    assert!(
        stderr(&output).contains("tiny.ron/deep"),
        "{}",
        stderr(&output)
    );
    assert!(stdout(&output).is_empty());
}
