//! Runs that are killed at any moment, again and again: what they leave behind is whole, and they go on from it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use overfall::checkpoint::Checkpoint;
use overfall::output::{Frame, Series};

use running::{PATIENCE, Running};

mod running;

/// Sixty-four particles in a tank: steps, frames and checkpoints take a few milliseconds each.
const SCENE: &str = r#"(
    name: "killed",
    spacing: 0.02,
    neighbours: Verlet(skin: 0.1),
    bodies: [(shape: Box(min: (0, 0, 0), max: (0.08, 0.08, 0.08)))],
    boundaries: [Tank(min: (0, 0, 0), max: (0.16, 0.16, 0.08))],
    time_step: Fixed(0.0005),
    pressure: Pcisph(not_converged: Accept),
    duration: 1000,
    output: (frames_per_second: 500, pictures: false),
)
"#;

/// What is left after a kill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Left {
    /// Steps of the checkpoint.
    pub(crate) steps: u64,
    /// Whole frames that the series names.
    pub(crate) frames: usize,
}

/// Kills a run of `program` in a folder, and its continuations, so many times, each at a random moment after the first
/// checkpoint. Gives what the last kill left; `told` gets it after each.
///
/// # Panics
/// If a checkpoint or a frame is not whole, if steps are lost that a checkpoint had, or if a run does not continue.
pub(crate) fn kill_again_and_again(
    program: &Path,
    folder: &Path,
    times: u32,
    mut told: impl FnMut(u32, Left),
) -> Left {
    fs::write(folder.join("killed.ron"), SCENE).expect("a scene file");
    let out = folder.join("out/killed");
    let mut random = 2011_u64;
    let mut left = Left {
        steps: 0,
        frames: 0,
    };
    for round in 0..times {
        let mut command = Command::new(program);
        command
            .current_dir(folder)
            .args([
                "run",
                "killed.ron",
                "--quiet",
                "--threads=1",
                "--checkpoint=3",
            ])
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        if round > 0 {
            command.args(["--resume", "out/killed"]);
        }
        let before = checkpoint(&out);
        let mut run = Running(command.spawn().expect("overfall starts"));
        let started = Instant::now();
        // Until it has a newer checkpoint, and then some: in a step, or while files are written and renamed.
        while checkpoint(&out) == before {
            let ended = run.0.try_wait().expect("it can be waited for");
            assert!(ended.is_none(), "round {round}: the run ended, {ended:?}");
            assert!(started.elapsed() < PATIENCE, "round {round}: no checkpoint");
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_micros(random_below(&mut random, 20_000)));
        run.0.kill().expect("a running program");
        run.0.wait().expect("its end");
        let now = check(&out).unwrap_or_else(|reason| panic!("round {round}: {reason}"));
        assert!(
            now.steps > left.steps,
            "round {round}: {now:?} after {left:?}"
        );
        left = now;
        told(round, left);
    }
    left
}

/// Numerical Recipes' generator: its upper bits are even enough.
fn random_below(state: &mut u64, limit: u64) -> u64 {
    *state = state
        .wrapping_mul(6364136223846793005)
        .wrapping_add(1442695040888963407);
    (*state >> 33) % limit
}

fn file(out: &Path) -> PathBuf {
    out.join("checkpoint.overfall")
}

/// The bytes of the checkpoint in a folder.
fn checkpoint(out: &Path) -> Option<Vec<u8>> {
    fs::read(file(out)).ok()
}

/// Reads everything that a killed run left.
fn check(out: &Path) -> Result<Left, String> {
    let bytes = checkpoint(out).ok_or("no checkpoint")?;
    let checkpoint = Checkpoint::read(&mut &bytes[..]).map_err(|error| error.to_string())?;
    let scene = checkpoint.scene().map_err(|error| error.to_string())?;
    let simulation = overfall::Simulation::with_threads(&scene, 1);
    let mut simulation = simulation.map_err(|error| error.to_string())?;
    let restored = checkpoint.restore(simulation.world_mut());
    restored.map_err(|error| error.to_string())?;
    simulation.step().map_err(|error| error.to_string())?;
    let steps = simulation.world().resource::<overfall::step::Clock>().step - 1;
    let series = Series::read(out.join("killed.pvd")).map_err(|error| error.to_string())?;
    for entry in series.entries() {
        let frame = Frame::read(&out.join(&entry.file)).map_err(|error| error.to_string())?;
        if (frame.len(), frame.time) != (64, entry.time) {
            return Err(format!("{}: {} particles", entry.file, frame.len()));
        }
    }
    Ok(Left {
        steps,
        frames: series.entries().len(),
    })
}
