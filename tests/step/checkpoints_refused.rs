//! Files that are no whole checkpoint, or hold something else than the run, are refused or used, and never a panic.

use std::fs;

use overfall::{
    Simulation,
    checkpoint::{self, Checkpoint, CheckpointError, FORMAT_VERSION},
    scene::{IndexStructure, Neighbours, Scene},
};

use super::checkpoints::{STEP_CONTROLS, reports, scene};
use crate::common::{pcisph, run};

#[test]
fn what_is_no_whole_checkpoint_is_refused_with_the_reason() {
    let scene = scene(pcisph(), IndexStructure::CompactHashing, STEP_CONTROLS[2]);
    let mut simulation = Simulation::with_threads(&scene, 1).expect("a scene that runs");
    run(&mut simulation, 3);
    let bytes = Checkpoint::of(simulation.world_mut())
        .expect("a checkpoint")
        .to_bytes();
    let refusal = |bytes: &[u8]| {
        Checkpoint::read(&mut &bytes[..])
            .map(|_| ())
            .expect_err("a refusal")
    };
    for foreign in [
        &b""[..],
        b"ply\nformat ascii 1.0\n",
        b"(name: \"x\")",
        &[0; 64],
    ] {
        assert!(
            matches!(refusal(foreign), CheckpointError::Foreign),
            "{foreign:?}"
        );
    }
    for length in (1..bytes.len())
        .step_by(997)
        .chain([8, 19, 20, 21, bytes.len() - 1])
    {
        let error = refusal(&bytes[..length]);
        assert!(
            matches!(error, CheckpointError::Truncated { .. }),
            "{length}: {error}"
        );
    }
    for at in (20..bytes.len())
        .step_by(1013)
        .chain([8, 11, bytes.len() - 1])
    {
        let mut altered = bytes.clone();
        altered[at] ^= 0x10;
        let error = refusal(&altered);
        assert!(
            matches!(error, CheckpointError::Altered { .. }),
            "{at}: {error}"
        );
    }
    let longer = [&bytes[..], b"\n"].concat();
    assert!(matches!(refusal(&longer), CheckpointError::Altered { .. }));
    let mut newer = bytes[..bytes.len() - 4].to_vec();
    newer[8..12].copy_from_slice(&(FORMAT_VERSION + 1).to_le_bytes());
    newer.extend(crc32fast::hash(&newer).to_le_bytes());
    let error = refusal(&newer);
    assert!(matches!(error, CheckpointError::Version { .. }), "{error}");
    let told = format!("format {}", FORMAT_VERSION + 1);
    assert!(error.to_string().contains(&told), "{error}");
}

/// A file that is whole, but whose content nobody has written: it is used or refused, and a step after it, too.
#[test]
fn whatever_is_in_a_checkpoint_is_used_or_refused() {
    let scenes = [
        (
            IndexStructure::CompactHashing,
            STEP_CONTROLS[1],
            Neighbours::Stored,
        ),
        (
            IndexStructure::UniformGrid,
            STEP_CONTROLS[2],
            Neighbours::Stored,
        ),
        (
            IndexStructure::SpatialHashing,
            STEP_CONTROLS[0],
            Neighbours::Verlet { skin: 0.1 },
        ),
    ];
    for (structure, control, neighbours) in scenes {
        let scene = Scene {
            neighbours,
            ..scene(pcisph(), structure, control)
        };
        let mut simulation = Simulation::with_threads(&scene, 1).expect("a scene that runs");
        run(&mut simulation, 3);
        let bytes = Checkpoint::of(simulation.world_mut())
            .expect("a checkpoint")
            .to_bytes();
        let content = 20..bytes.len() - 4;
        let (mut used, mut refused) = (0, 0);
        let mut state = 2011_u64;
        let mut random = |below: usize| {
            // Numerical Recipes' generator: its upper bits are even enough.
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 33) as usize % below
        };
        for _ in 0..150 {
            let mut spoilt = bytes[content.clone()].to_vec();
            for _ in 0..1 + random(3) {
                let at = random(spoilt.len());
                let length = 1 + random(9).min(spoilt.len() - at - 1);
                match random(4) {
                    0 => spoilt[at] ^= 1 << random(8),
                    1 => spoilt[at..at + length].fill(0xff),
                    2 => drop(spoilt.drain(at..at + length)),
                    _ => {
                        let part = spoilt[at..at + length].to_vec();
                        drop(spoilt.splice(at..at, part));
                    }
                }
            }
            let mut whole = bytes[..12].to_vec();
            whole.extend((spoilt.len() as u64 + 24).to_le_bytes());
            whole.extend(&spoilt);
            whole.extend(crc32fast::hash(&whole).to_le_bytes());
            let restored = checkpoint::restore(simulation.world_mut(), &mut &whole[..]);
            match restored {
                Err(error) => {
                    refused += 1;
                    assert!(!error.to_string().is_empty());
                }
                Ok(()) => used += 1,
            }
            // What was spoilt may be a particle's place: then the step is refused, and needs another world.
            if simulation.step().is_err() {
                simulation = Simulation::with_threads(&scene, 1).expect("a scene that runs");
            }
        }
        assert!(used > 10 && refused > 10, "{used} used, {refused} refused");
    }
}

/// Whatever file a scene names: it belongs to the run, even where the start alone depends on it.
#[test]
fn a_file_that_has_changed_is_another_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    let shipped = |name: &str| {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        fs::read_to_string(root.join(name)).expect("a file")
    };
    let text = r#"(
        name: "named files",
        spacing: 0.1,
        order: "order.ron",
        body_forces: [Table(file: "shake.csv")],
        bodies: [(
            shape: Box(min: (0, 0, 0), max: (0.4, 0.4, 0.4)),
            velocity_field: Table(file: "field.csv"),
        )],
        boundaries: [
            Tank(min: (0, 0, 0), max: (0.9, 0.6, 0.4)),
            Box(min: (0.7, 0, 0), max: (0.9, 0.4, 0.4), motion: Table(file: "piston.csv", direction: (1, 0, 0))),
            Mesh(file: "block.obj", scale: 0.1, translation: (5, 5, 5)),
        ],
        gauges: [(name: "energy", kind: Energy, reference: (file: "known.csv"))],
    )"#;
    for (name, text) in [
        ("piston.csv", "t,x\n0,0\n1,0.1\n"),
        ("shake.csv", "t,ax\n0,1\n"),
        (
            "field.csv",
            "x,y,vx,vy\n0,0,1,0\n1,0,1,0\n0,1,1,0\n1,1,1,0\n",
        ),
        ("known.csv", "t,E\n0,1\n"),
    ] {
        put(name, text);
    }
    put("order.ron", &shipped("assets/orders/default.ron"));
    put("block.obj", &shipped("tests/meshes/block.obj"));
    let scene = folder.path().join("scene.ron");
    fs::write(&scene, text).expect("a file");
    let scene = Scene::load(&scene, &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut whole = Simulation::with_threads(&scene, 1).unwrap_or_else(|error| panic!("{error}"));
    reports(&mut whole, 2);
    let checkpoint = Checkpoint::of(whole.world_mut()).expect("a checkpoint");
    let mut names = 0;
    for file in scene.clone().files_mut() {
        names += 1;
        let before = fs::read_to_string(&*file).expect("a text");
        let comment = if file.ends_with(".ron") { "//" } else { "#" };
        fs::write(&*file, format!("{comment} another\n{before}")).expect("a file");
        let mut other =
            Simulation::with_threads(&scene, 1).unwrap_or_else(|error| panic!("{error}"));
        let error = checkpoint
            .restore(other.world_mut())
            .expect_err("refused")
            .to_string();
        assert!(
            error.contains(&format!("the file {file} has changed")),
            "{error}"
        );
        fs::write(&*file, before).expect("a file");
    }
    assert_eq!(names, 6);
    let mut same = Simulation::with_threads(&scene, 1).unwrap_or_else(|error| panic!("{error}"));
    checkpoint.restore(same.world_mut()).expect("the same run");
}
