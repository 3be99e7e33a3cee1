//! Files that are no whole checkpoint, or hold something else than the run, are refused or used, and never a panic.

use overfall::{
    Simulation,
    checkpoint::{self, Checkpoint, CheckpointError, FORMAT_VERSION},
    scene::IndexStructure,
};

use super::checkpoints::{STEP_CONTROLS, scene};
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
    assert!(
        error.to_string().contains("newer") || error.to_string().contains("format 2"),
        "{error}"
    );
}

/// A file that is whole, but whose content nobody has written: it is used or refused, and a step after it, too.
#[test]
fn whatever_is_in_a_checkpoint_is_used_or_refused() {
    let scenes = [
        (pcisph(), IndexStructure::CompactHashing, STEP_CONTROLS[1]),
        (pcisph(), IndexStructure::UniformGrid, STEP_CONTROLS[2]),
    ];
    for (method, structure, control) in scenes {
        let scene = scene(method, structure, control);
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
