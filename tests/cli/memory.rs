//! The memory that `check` tells is that of a run, output included, and what a scene may not take is refused before.

use serde_json::Value;

use crate::support::{assert_exit, folder_with, overfall, stderr, stdout};

/// Water on ground, so that a third of all particles are boundary particles; emitters, pictures and frames besides.
const SCENE: &str = r#"(
    name: "pond", spacing: 0.03, pressure: Pcisph, boundary_handling: DirectForcing(),
    bodies: [(shape: Box(min: (-0.9, -0.1, -0.9), max: (0.9, 0.3, 0.9)), cut: true)],
    emitters: [(shape: Disc(center: (0, 0.6, 0), normal: (0, -1, 0), radius: 0.1), speed: 1)],
    boundaries: [Terrain(size: (2, 2), heights: Generated(seed: 3, cell: 0.05, amplitude: 0.05, wavelength: 0.5))],
    domain: (min: (-1, -0.5, -1), max: (1, 1, 1)), outside: Remove, duration: 1,
)"#;

fn json(folder: &tempfile::TempDir, arguments: &[&str]) -> Value {
    let output = overfall(folder, arguments);
    assert_exit(&output, 0);
    serde_json::from_str(stdout(&output)).expect("JSON")
}

#[test]
fn a_plan_tells_the_memory_of_a_run_and_what_is_more_is_refused() {
    let folder = folder_with(&[("pond.ron", SCENE)]);
    let plan = json(
        &folder,
        &["check", "pond.ron", "--json", "--duration", "0.02"],
    );
    let planned = plan["memory_bytes"].as_f64().expect("a number");
    let parts = plan["memory"].as_array().expect("a list");
    let sum: f64 = (parts.iter().filter_map(|part| part["bytes"].as_f64())).sum();
    assert!((sum - planned).abs() < 1.0, "{plan}");
    // The peak itself depends on how the program is compiled: without optimisation it is half as much again.
    for part in ["fluid particles", "a frame", "its picture", "the program"] {
        let holds = |of: &&Value| of["part"] == part && of["bytes"].as_f64() > Some(0.0);
        assert!(parts.iter().any(|of| holds(&of)), "{part}: {plan}");
    }
    let mut without = vec!["check", "pond.ron", "--json", "--duration", "0.02"];
    without.extend(["--set", "output.pictures=false"]);
    let less = json(&folder, &without)["memory_bytes"].as_f64();
    assert!(less < Some(planned - 3e7), "{less:?} {planned}");
    // Half of it is refused, and nothing is written.
    let limit = format!("memory_limit={:e}", 0.5e-9 * planned);
    for command in ["check", "run"] {
        let output = overfall(
            &folder,
            &[command, "pond.ron", "--set", &limit, "--out", "none"],
        );
        assert_exit(&output, 2);
        let message = stderr(&output);
        assert!(message.contains("`memory_limit`"), "{message}");
    }
    assert!(!folder.path().join("none").exists());
    // Just above it all is well.
    let limit = format!("memory_limit={:e}", 1.01e-9 * planned);
    let output = overfall(
        &folder,
        &["check", "pond.ron", "--set", &limit, "--duration", "0.02"],
    );
    assert_exit(&output, 0);
}
