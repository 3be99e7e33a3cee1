//! The memory that `check` tells is that which a run takes, and what a scene may not take is refused before.

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

/// Part of the peak by which the plan may be wrong \[-].
const OFF: f64 = 0.1;

#[test]
fn a_plan_tells_the_memory_of_the_run() {
    let folder = folder_with(&[("pond.ron", SCENE)]);
    let plan = json(
        &folder,
        &["check", "pond.ron", "--json", "--duration", "0.02"],
    );
    let planned = plan["memory_bytes"].as_f64().expect("a number");
    let parts = plan["memory"].as_array().expect("a list");
    let sum: f64 = (parts.iter().filter_map(|part| part["bytes"].as_f64())).sum();
    assert!((sum - planned).abs() < 1.0, "{plan}");
    let summary = json(
        &folder,
        &[
            "run",
            "pond.ron",
            "--json",
            "--steps",
            "3",
            "--threads",
            "2",
        ],
    );
    if let Some(peak) = summary["peak_rss_bytes"].as_f64() {
        assert!(
            (planned / peak - 1.0).abs() < OFF,
            "{planned} bytes planned, {peak} taken: {:?}",
            parts
        );
    }
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
    // Just above it all is well, and without pictures and frames half a gap below, too.
    let limit = format!("memory_limit={:e}", 1.01e-9 * planned);
    let output = overfall(
        &folder,
        &["check", "pond.ron", "--set", &limit, "--duration", "0.02"],
    );
    assert_exit(&output, 0);
}
