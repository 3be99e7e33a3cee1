//! `--set PATH=VALUE` has the same effect as the field in the file, or is refused with the same message.

use overfall::{loading::Override, scene::Scene};

use super::errors::SCENE;

/// The scene with overrides, or the message if one is refused.
fn set(overrides: &[&str]) -> Result<Scene, String> {
    let overrides: Result<Vec<_>, _> = overrides.iter().map(|text| Override::parse(text)).collect();
    Scene::parse(SCENE, "s.ron", &overrides.map_err(|e| e.to_string())?).map_err(|e| e.to_string())
}

#[test]
fn an_override_is_the_same_as_the_field_in_the_file() {
    // One case per line, so that the columns can be read together.
    #[rustfmt::skip]
    let cases: &[(&[&str], &str, &str)] = &[
        (&["spacing=0.05"], "spacing: 0.1", "spacing: 0.05"),
        (&["name=other"], "\"spoilt\"", "\"other\""),
        (&["name=two words"], "\"spoilt\"", "\"two words\""),
        (&["name=\"quoted\""], "\"spoilt\"", "\"quoted\""),
        (&["pressure.max_density_error=0.001"], "_error: 0.01", "_error: 0.001"),
        (&["pressure.criterion=Mean"], "0.01", "0.01, criterion: Mean"),
        (&["pressure=Sesph(equation: Tait(stiffness: 1e5))"], "Pcisph(max_density_error: 0.01)",
            "Sesph(equation: Tait(stiffness: 1e5))"),
        (&["pressure=Pcisph()"], "0.01", "0.01"),
        (&["pressure=Dfsph"], "Pcisph(max_density_error: 0.01)", "Dfsph()"),
        (&["time_step=Cfl"], "Fixed(0.001)", "Cfl()"),
        (&["boundary_handling=DirectForcing"], "duration", "boundary_handling: DirectForcing(), duration"),
        (&["time_step=Cfl(factor: 0.3)", "time_step.max=0.01"], "Fixed(0.001)", "Cfl(factor: 0.3, max: 0.01)"),
        (&["time_step.0=0.002"], "0.001", "0.002"),
        (&["bodies.0.velocity=(1,0,0)"], "1, 1)))", "1, 1)), velocity: (1, 0, 0))"),
        (&["bodies.0.shape.max.x=0.5"], "max: (1,", "max: (0.5,"),
        (&["bodies.0.jitter.amplitude=0.1"], "1, 1)))", "1, 1)), jitter: (amplitude: 0.1))"),
        (&["bodies.0.jitter=(amplitude: 0.1, seed: 7)", "bodies.0.jitter.seed=8"], "1, 1)))",
            "1, 1)), jitter: (amplitude: 0.1, seed: 8))"),
        (&["gravity.y=-1"], "duration", "gravity: (0, -1, 0), duration"),
        (&["fluid.viscosity=None"], "1000", "1000, viscosity: None"),
        (&["fluid.viscosity.kinematic_viscosity=0.01"], "1000", "1000, viscosity: Laminar(kinematic_viscosity: 0.01)"),
        (&["output.formats=[Ply]"], "duration", "output: (formats: [Ply]), duration"),
        (&["index.cell_size=0.5", "index.cell_size=0.7"], "duration", "index: (cell_size: 0.7), duration"),
        (&["dimension=2 // the plane", " spacing = 0.2 "], "spacing: 0.1", "dimension: 2, spacing: 0.2"),
    ];
    for (overrides, part, other) in cases {
        let text = SCENE.replacen(part, other, 1);
        let expected = Scene::parse(&text, "s.ron", &[]).unwrap_or_else(|e| panic!("{e}"));
        match set(overrides) {
            Ok(scene) => assert_eq!(scene, expected, "{overrides:?}"),
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn a_wrong_override_is_refused_in_its_own_words() {
    // One case per line, so that the columns can be read together.
    #[rustfmt::skip]
    let cases: &[(&str, &[&str])] = &[
        ("spacing", &["expected PATH=VALUE"]),
        ("=1", &["expected a path"]),
        ("pressure.=1", &["expected a path"]),
        ("spacing=", &["expected a value"]),
        ("spaceing=1", &["unknown field `spaceing`", "did you mean `spacing`?"]),
        ("pressure.max_error=0.1", &["unknown field `max_error` in `Pcisph`", "did you mean `max_density_error`?"]),
        ("pressure=Pcisph(max_error: 0.1)", &["did you mean `max_density_error`?"]),
        ("pressure=Sesph(equation: Taitt(stiffness: 1e5))", &["unknown variant `Taitt`", "did you mean `Tait`?"]),
        ("bodies.1.velocity=(1, 0, 0)", &["`bodies` has no entry `1`; it has 1"]),
        ("bodies.first.velocity=(1, 0, 0)", &["no entry `first`"]),
        ("spacing.x=1", &["`spacing` is the single value `0.1`"]),
        ("output.camera.field_of_view=30", &["`output.camera` is `None`", "set all of it"]),
        ("spacing=0.1, support: 3", &["not RON"]),
        ("spacing=wide", &["expected a number"]),
        ("spacing=0,05", &["decimal point", "did you mean `spacing=0.05`?"]),
        ("duration=1s", &["SI units", "did you mean `duration=1`?"]),
        ("duration=1 s", &["SI units", "did you mean `duration=1`?"]),
        ("time_step=0.001", &["did you mean `time_step=Fixed(0.001)`?"]),
        ("fluid.viscosity=0.01", &["did you mean `fluid.viscosity=Laminar(kinematic_viscosity: 0.01)`?"]),
        ("index=UniformGrid", &["did you mean `index.structure=UniformGrid`?"]),
        ("gravity=0,-1,0", &["did you mean `gravity=(0,-1,0)`?"]),
        ("output.formats=Ply", &["did you mean `output.formats=[Ply]`?"]),
        ("output.pictures=yes", &["did you mean `output.pictures=true`?"]),
        ("output.pictures=Off", &["did you mean `output.pictures=false`?"]),
        ("reorder_interval=1e2", &["whole number", "did you mean `reorder_interval=100`?"]),
        ("reorder_interval=2.5", &["expected a whole number, found `2.5`"]),
        ("gravity=0 -9.81 0", &["did you mean `gravity=(0, -9.81, 0)`?"]),
        ("gravity=(x: 0, y: -1, z: 0)", &["no names", "did you mean `gravity=(0, -1, 0)`?"]),
        ("gravity=(0,-9,8,0)", &["decimal point", "4 numbers", "one too many"]),
        ("gravity.y=-9.81m/s2", &["SI units", "did you mean `gravity.y=-9.81`?"]),
        ("time_step=Fixed 0.001", &["did you mean `time_step=Fixed(0.001)`?"]),
        ("time_step=Fixed(dt: 0.001)", &["did you mean `time_step=Fixed(0.001)`?"]),
        ("time_step=Fixed(0,001)", &["decimal point", "did you mean `time_step=Fixed(0.001)`?"]),
        ("pressure=Pcisph(max_density_error=0.01)", &["did you mean `pressure=Pcisph(max_density_error: 0.01)`?"]),
        ("pressure=\"dfsph\"", &["did you mean `pressure=Dfsph`?"]),
        ("index=\"UniformGrid\"", &["did you mean `index=(structure: UniformGrid)`?"]),
        ("viscosity=None", &["did you mean `fluid.viscosity=None`?"]),
        ("max_density_error=0.01", &["did you mean `pressure.max_density_error=0.01`?"]),
        ("bodies[0].shape.max.x=1", &["did you mean `bodies.0.shape.max.x=1`?"]),
        ("bodies.0.max.x=1", &["did you mean `bodies.0.shape.max.x=1`?"]),
        ("fluid.viscosity.x=1", &["unknown field `x` in `Laminar`"]),
        ("spacing=-1", &["`spacing` is -1 m; it must be above 0"]),
        ("pressure=Pcisph(max_density_error: 2)", &["above 0 and below 1"]),
        ("pressure=Iisph(relaxation: 0.6)", &["with momentum", "at most 0.54", "0.4 is usual"]),
        ("pressure=Dfsph(relaxation: 1.5, momentum: false)", &["without momentum", "at most 1"]),
        ("pressure=Iisph(warm_start_steps: 0)", &["mean over 0 steps", "at least 1"]),
        (
            "pressure=Pcisph(warm_start: 0, warm_start_steps: 9)",
            &["9 steps", "warm_start above 0", "warm_start_steps to 1"],
        ),
        ("bodies.0.shape.min.x=-1", &["sticks out of the tank"]),
        ("reorder_interval=-1", &["whole number"]),
    ];
    let mut wrong = Vec::new();
    for (text, message) in cases {
        let error = set(&[text]).map(|_| ()).expect_err(text);
        let right_place = error.starts_with(&format!("--set {text}: "));
        if !right_place || !message.iter().all(|fragment| error.contains(fragment)) {
            wrong.push(format!("expected {message:?}, got {error}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
