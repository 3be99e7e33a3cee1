//! Values, fields and overrides as people write them at first, and what is answered.

use overfall::{loading::Override, scene::Scene};

use super::errors::{SCENE, refusal};

/// Lines of a file, and a part of the answer. Lines stand in place of those of the same field.
#[rustfmt::skip]
const LINES: [(&str, &str); 38] = [
    ("gravity: -9.81", "did you mean `(0, -9.81, 0)`?"),
    ("gravity: 9.81", "did you mean `(0, -9.81, 0)`?"),
    ("gravity: 0", "did you mean `(0, 0, 0)`?"),
    ("gravity: off", "did you mean `(0, 0, 0)`?"),
    ("gravity: None", "did you mean `(0, 0, 0)`?"),
    ("gravity: (0, -9.81)", "found 2; did you mean `(0, -9.81, 0)`?"),
    ("gravity: (0, 0, 0, -9.81)", "expected 3 numbers, found 4"),
    ("dimension: 2D", "did you mean `2`?"),
    ("dimension: \"3d\"", "did you mean `3`?"),
    ("dimension: two", "did you mean `2`?"),
    ("spacing: [0.1]", "did you mean `0.1`?"),
    ("spacing: (0.1)", "did you mean `0.1`?"),
    ("duration: [1]", "did you mean `1`?"),
    ("reorder_interval: never", "did you mean `0`?"),
    ("reorder_interval: None", "did you mean `0`?"),
    ("pressure: (type: \"Dfsph\")", "did you mean `Dfsph`?"),
    ("pressure: Tait", "did you mean `Sesph`?"),
    ("pressure: Sesph(stiffness: 1000)", "`equation: Tait(stiffness: 1000)`, `equation: Gas(stiffness: 1000)`"),
    ("index: (structure: \"Grid\")", "it is an unknown variant `Grid`; did you mean `UniformGrid`?"),
    ("time_step: Fixed(dt = 0.001)", "stands behind a colon, `name: value`"),
    ("time_step: \"adaptive\"", "did you mean `Adaptive`?"),
    ("fluid: (kinematic_viscosity: 1e-6)", "did you mean `viscosity: Laminar(kinematic_viscosity: 1e-6)`?"),
    ("fluid: (kappa: 0.1)", "did you mean `surface_tension: BeckerTeschner(kappa: 0.1)`?"),
    ("gauges: [(name: \"a\", kind: Height(0.5, 0, 0.5))]", "did you mean `at: (0.5, 0, 0.5)`?"),
    ("gauges: [Height(at: (0.5, 0, 0.5))]", "did you mean `(kind: Height(at: (0.5, 0, 0.5)), name: …)`?"),
    ("emitters: [Disc(center: (1, 1, 0.5), normal: (0, -1, 0), radius: 0.1)]", "radius: 0.1), speed: …)`?"),
    ("emitters: [(shape: Disc(center: (1, 1, 0.5), normal: (0, -1, 0), radius: 0.1), speed: (0, -1, 0))]",
        "expected a number, found `(0, -1, 0)`; did you mean `1`?"),
    ("body_forces: [Wave((1, 0, 0))]", "did you mean `amplitude: (1, 0, 0)`?"),
    ("body_forces: [(0, -1, 0)]", "is added to `gravity`"),
    ("body_forces: [Constant((0, -1, 0))]", "is added to `gravity`"),
    ("body_forces: [Uniform(acceleration: (0, -1, 0))]", "is added to `gravity`"),
    ("threads: 4", "an option of the command, `--threads 4`"),
    ("num_threads: 4", "an option of the command, `--threads 4`"),
    ("limits: (energy: 1e300)", "`limits.energy` is 1e300, which is beyond single precision"),
    ("gravity: (0, -1e39, 0)", "`gravity.1` is -1e39, which is beyond single precision"),
    ("fluid: (rest_density: 1e-50)", "`fluid.rest_density` is 1e-50, which is 0 in single precision"),
    ("boundaries: [Box(min: (3, 0, 0), max: (4, 1, 1), motion: Oscillation(amplitude: (0.01, 0, 0), frequency: 1, \
        phase: 1e4))]", "the phase is 1e4 rad"),
    ("duration: 1e-60", "which is 0 in single precision"),
];

#[test]
fn values_as_people_write_them_at_first_are_answered() {
    let mut wrong = Vec::new();
    for (line, part) in LINES {
        let name = line.split(':').next().unwrap_or_default();
        let others = SCENE
            .lines()
            .filter(|other| !other.trim_start().starts_with(&format!("{name}:")));
        let others: Vec<&str> = others.collect();
        let text = others.join("\n");
        let said = refusal(&text.replacen("name:", &format!("{line}, name:"), 1));
        if !said.contains(part) {
            wrong.push(format!("{line}: {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Overrides, and a part of the answer.
#[rustfmt::skip]
const OVERRIDES: [(&str, &str); 10] = [
    ("spacing:0.1", "did you mean `spacing=0.1`?"),
    ("spacing 0.1", "did you mean `spacing=0.1`?"),
    ("spacing", "such as `spacing=0.01`"),
    ("spacing=0.1,duration=1", "`--set duration=1`"),
    ("spacing=0.1 duration=1", "RON"),
    ("limits.energy=1e300", "`limits.energy` is 1e300, which is beyond single precision"),
    ("gravity=-9.81", "did you mean `gravity=(0, -9.81, 0)`?"),
    ("gravity=(0, -9.81)", "did you mean"),
    ("dimension=2D", "did you mean `dimension=2`?"),
    ("spacing=[0.1]", "did you mean `spacing=0.1`?"),
];

#[test]
fn overrides_as_people_write_them_at_first_are_answered() {
    let mut wrong = Vec::new();
    for (text, part) in OVERRIDES {
        let refused = Override::parse(text)
            .and_then(|change| Scene::parse(SCENE, "s.ron", &[change]))
            .expect_err(text)
            .to_string();
        if !refused.contains(part) || !refused.contains(text) {
            wrong.push(format!("{text}: {refused}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
