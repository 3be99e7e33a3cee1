//! A scene that cannot work is refused: file, line, column, what is wrong, what would be right.

use overfall::{loading::Override, scene::Scene};

/// A right scene of ten lines, to be spoilt.
const SCENE: &str = r#"(
    name: "spoilt",
    spacing: 0.1,
    fluid: (rest_density: 1000),
    bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))],
    boundaries: [Tank(min: (0, 0, 0), max: (2, 2, 1))],
    pressure: Pcisph(max_density_error: 0.01),
    time_step: Fixed(0.001),
    duration: 1,
)"#;

fn refusal(text: &str) -> String {
    match Scene::parse(text, "s.ron", &[]) {
        Ok(_) => panic!("accepted: {text}"),
        Err(error) => error.to_string(),
    }
}

/// Each case: a part of the scene, what stands in its place, the place of the error, parts of the message.
#[test]
fn every_spoilt_scene_is_refused_with_its_place_and_a_remedy() {
    // One case a line: the columns are read together.
    #[rustfmt::skip]
    let cases: &[(&str, &str, &str, &[&str])] = &[
        // The text.
        ("spacing", "spaceing", "3:5", &["unknown field `spaceing`", "did you mean `spacing`?", "fields: name,"]),
        ("rest_density", "density", "4:13", &["did you mean `rest_density`?", "viscosity"]),
        ("max_density_error", "max_error", "7:22", &["did you mean `max_density_error`?"]),
        ("Pcisph", "PCISPH", "7:15", &["unknown variant `PCISPH`", "did you mean `Pcisph`?", "Sesph"]),
        ("Tank", "Bucket", "6:18", &["unknown variant `Bucket`", "Tank, Box, Sphere, Plane"]),
        ("    spacing: 0.1,\n", "", "1:1", &["the field `spacing`", "no default"]),
        ("    duration: 1,", "    duration: 1, spacing: 2,", "9:18", &["`spacing` is given twice"]),
        ("spacing: 0.1", "spacing: \"fine\"", "3:14", &["expected a number"]),
        ("(0, 0, 0), max: (1, 1, 1)", "(0, 0), max: (1, 1, 1)", "5:31", &["expected 3 numbers, found 2"]),
        ("shape: Box(min: (0, 0, 0), max: (1, 1, 1))", "velocity: (0, 0, 0)", "5:14", &["`shape`", "no default"]),
        ("spacing: 0.1,", "spacing: 0.1", "4:5", &["expected a comma"]),
        ("duration: 1,\n)", "duration: 1,", "9:17", &["not closed"]),
        ("name:", "dimension: 4, name:", "2:16", &["dimension is 4; it must be 2 or 3"]),
        ("Pcisph(max_density_error: 0.01)", "Sesph", "7:15", &["`Sesph` lacks the field `equation`"]),
        // Slips.
        ("Fixed(0.001)", "0.001", "8:16", &["one of Fixed, Cfl, Adaptive", "did you mean `Fixed(0.001)`?"]),
        ("Fixed(0.001)", "Fixed", "8:16", &["`Fixed` needs its values in a bracket", "a number"]),
        ("rest_density: 1000", "viscosity: 0.01", "4:24", &["did you mean `Laminar(kinematic_viscosity: 0.01)`?"]),
        ("rest_density: 1000", "viscosity: (kinematic_viscosity: 0.01)", "4:24", &["did you mean `Laminar(kinematic_viscosity: 0.01)`?"]),
        ("rest_density: 1000", "viscosity: Laminar(0.01)", "4:32", &["did you mean `kinematic_viscosity: 0.01`?"]),
        ("(rest_density: 1000)", "1000", "4:12", &["did you mean `(rest_density: 1000)`?"]),
        ("spacing: 0.1", "spacing: 0,05", "3:14", &["decimal point", "did you mean `0.05`?"]),
        ("duration: 1", "duration: 1s", "9:15", &["in SI units", "did you mean `1`?"]),
        ("duration: 1", "duration: 20 ms", "9:15", &["in SI units", "did you mean `0.02`?"]),
        ("duration: 1", "duration: \"1\"", "9:15", &["no quotes", "did you mean `1`?"]),
        ("duration: 1", "index: UniformGrid", "9:12", &["structure, cell_size", "did you mean `(structure: UniformGrid)`?"]),
        ("duration: 1", "index: 0.5", "9:12", &["did you mean `(cell_size: 0.5)`?"]),
        ("duration: 1", "gravity: [0, -1, 0]", "9:14", &["did you mean `(0, -1, 0)`?"]),
        ("duration: 1", "gravity: -9.81", "9:14", &["a vector of three numbers"]),
        ("duration: 1", "output: (formats: Ply)", "9:23", &["did you mean `[Ply]`?"]),
        ("duration: 1", "executor: \"Parallel\"", "9:15", &["did you mean `Parallel`?"]),
        ("duration: 1", "executor: 4", "9:15", &["one of Auto, Parallel, SingleThreaded", "`4`"]),
        // Single numbers.
        ("\"spoilt\"", "\"a/b\"", "2:11", &["without slashes"]),
        ("spacing: 0.1", "spacing: -0.1", "3:14", &["`spacing` is -0.1 m; it must be above 0"]),
        ("spacing: 0.1", "spacing: 1e99", "3:14", &["`spacing` is inf", "finite"]),
        ("spacing: 0.1", "spacing: 0.1, support: 8", "3:28", &["from 1.2", "to 4"]),
        ("(0, 0, 0), max: (1,", "(0, NaN, 0), max: (1,", "5:35", &["`bodies.0.shape.min.1` is NaN"]),
        ("1000", "0", "4:27", &["above 0"]),
        ("1000", "1, viscosity: Laminar(kinematic_viscosity: -1)", "4:70", &["must not be negative"]),
        ("_error: 0.01", "_error: 1.5", "7:41", &["above 0 and below 1"]),
        ("_error: 0.01", "_error: 0.1, max_iterations: 2", "7:62", &["at most 2 iterations, at least 3"]),
        ("0.001", "0", "8:22", &["above 0"]),
        ("Fixed(0.001)", "Cfl(min: 0.1, max: 0.01)", "8:35", &["below the smallest"]),
        ("Fixed(0.001)", "Cfl(min: 0.1)", "8:16", &["below the smallest"]),
        ("Fixed(0.001)", "Cfl(factor: 1.5)", "8:28", &["at most 1"]),
        ("Fixed(0.001)", "Adaptive(min: 0.1)", "8:16", &["below the smallest"]),
        ("Fixed(0.001)", "Adaptive(initial: 0.1)", "8:34", &["the first time step", "0.005 s (`max`)"]),
        ("Fixed(0.001)", "Adaptive(density_error: 1.5)", "8:40", &["above 0 and below 1"]),
        ("Fixed(0.001)", "Adaptive(density_error: 0.5)", "8:16", &["below the mean"]),
        ("duration: 1", "duration: 0", "9:15", &["above 0"]),
        ("duration: 1", "index: (cell_size: 1.2)", "9:24", &["at most 1"]),
        ("duration: 1", "output: (frames_per_second: -1)", "9:33", &["must not be negative"]),
        ("duration: 1", "output: (camera: (position: (1, 1, 1), target: (1, 1, 1)))", "9:52", &["looks at the place"]),
        // Shapes.
        ("[(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))]", "[]", "5:13", &["no body of fluid"]),
        ("max: (1, 1, 1)", "max: (1, 0, 1)", "5:47", &["y = 0 m", "`max` must be above `min`"]),
        ("max: (1, 1, 1)", "max: (1, 0.05, 1)", "5:22", &["holds no particle", "thinner than the spacing"]),
        ("Box(min: (0, 0, 0), max: (1, 1, 1))", "Sphere(center: (1, 1, 1), radius: 0)", "5:56", &["above 0"]),
        ("max: (2, 2, 1)", "max: (0, 2, 1)", "6:44", &["`max` must be above `min`"]),
        ("boundaries: [", "boundaries: [Plane(center: (0, 0, 0), normal: (0, 0, 0), half_size: 1), ", "6:51", &["normal is zero"]),
        ("1, 1)))]", "1, 1)), jitter: (amplitude: 0.6))]", "5:79", &["below 0.5"]),
        ("spacing: 0.1", "spacing: 0.001", "3:14", &["million particles", "GB", "a spacing of"]),
        // Gauges.
        ("duration: 1", "gauges: [(name: \"a b\", kind: Energy)]", "9:21", &["cannot name the gauge's file", "letters"]),
        ("duration: 1", "gauges: [(name: \"e\", kind: Energy), (name: \"E\", kind: Energy)]", "9:49", &["\"E\" is given twice"]),
        ("duration: 1", "gauges: [(name: \"e\", kind: Energie)]", "9:32", &["unknown variant `Energie`", "did you mean `Energy`?"]),
        ("duration: 1", "gauges: [(name: \"e\", kind: Energy, every: Seconds(0))]", "9:47", &["every 0 s", "above 0"]),
        ("duration: 1", "gauges: [(name: \"e\", kind: Energy, every: Steps(0))]", "9:47", &["every 0 steps", "least is 1"]),
        ("duration: 1", "gauges: [(name: \"e\", kind: Energy, window: -1)]", "9:48", &["must not be below 0"]),
        ("duration: 1", "gauges: [(name: \"e\", kind: Energy, every: Seconds(0.1), window: 0.05)]", "9:69", &["0.05 s is shorter", "0.1 s"]),
        ("duration: 1", "gauges: [(name: \"e\", kind: Energy, every: Steps(100), window: 0.05)]", "9:66", &["0.05 s is shorter", "(100 steps)"]),
        ("duration: 1", "gauges: [(name: \"p\", kind: Pressure(at: (1, 1, 1), radius: 0))]", "9:64", &["the radius is 0 m"]),
        ("duration: 1", "domain: (min: (0, 0, 0), max: (2, 2, 2)), gauges: [(name: \"p\", kind: Velocity(at: (1, 3, 1)))]", "9:82", &["(1, 3, 1) m is outside the domain"]),
        ("duration: 1", "gauges: [(name: \"p\", kind: WallPressure(at: (1, 1, 1), normal: (0, 0, 0)))]", "9:68", &["normal is zero"]),
        ("duration: 1", "gauges: [(name: \"x\", kind: Front(direction: (0, 0, 0)))]", "9:49", &["direction is zero"]),
        ("duration: 1", "gauges: [(name: \"x\", kind: Front(direction: (1, 0, 0), within: (min: (0, 0, 0), max: (0, 1, 1))))]", "9:92", &["`max` must be above `min`"]),
        ("duration: 1", "gauges: [(name: \"f\", kind: Force(boundary: \"tank\"))]", "9:48", &["none has a name", "Tank(name: \"tank\""]),
        ("max: (2, 2, 1))],", "max: (2, 2, 1), name: \"tank\")], gauges: [(name: \"f\", kind: Force(boundary: \"tnak\"))],", "6:110", &["unknown boundary name `tnak`", "did you mean `tank`?"]),
        ("max: (2, 2, 1)", "max: (2, 2, 1), name: \"\"", "6:66", &["the name is empty"]),
        ("duration: 1", "gauges: [(name: \"q\", kind: Flux(corner: (0, 0, 0), along: (1, 0, 0)))]", "9:32", &["span a surface"]),
        ("duration: 1", "gauges: [(name: \"q\", kind: Flux(corner: (0, 0, 0), along: (0, 0, 0), across: (1, 0, 0)))]", "9:63", &["edge is zero"]),
        ("duration: 1", "gauges: [(name: \"e\", kind: Energy, reference: (file: \"none.csv\"))]", "9:58", &["there is no file `none.csv`"]),
        ("duration: 1", "gauges: [(name: \"e\", kind: Energy, reference: (file: \"none.csv\", quantity: \"heat\"))]", "9:80", &["unknown column `heat`", "kinetic_energy_J"]),
        // Room.
        ("min: (0, 0, 0), max: (1, 1, 1)", "min: (-0.05, 0, 0), max: (1, 1, 1)", "5:22", &["sticks out of the tank `boundaries.0` by 0.0500 m (0.50 spacings) at its −x side"]),
        ("min: (0, 0, 0), max: (1, 1, 1)", "min: (3, 0, 0), max: (4, 1, 1)", "5:22", &["from (3.0000, 0.0000, 0.0000) m", "outside every tank"]),
        ("boundaries: [", "boundaries: [Box(min: (0.8, 0, 0), max: (1.5, 1, 1)), ", "5:22", &["overlaps the solid box `boundaries.0` by 0.2000 m (2.00 spacings)"]),
        ("boundaries: [", "boundaries: [Sphere(center: (1.5, 0.5, 0.5), radius: 0.7), ", "5:22", &["overlaps the solid sphere `boundaries.0`", "most at (0.9500, 0."]),
        ("boundaries: [", "boundaries: [Plane(center: (0, 0.2, 0.5), normal: (0, 2, 0), half_size: 3), ", "5:22", &["overlaps the plane `boundaries.0` by 0.2000 m"]),
        ("1, 1)))]", "1, 1))), (shape: Sphere(center: (1, 1, 0.5), radius: 0.3))]", "5:68", &["overlaps that of `bodies.0`", "0.0000 m"]),
        ("duration: 1", "domain: (min: (0, 0, 0), max: (0.5, 2, 2))", "5:22", &["out of the domain by 0.5000 m (5.00 spacings) at its +x side"]),
    ];
    let mut wrong = Vec::new();
    for (part, other, place, message) in cases {
        assert!(SCENE.contains(part), "the scene has no {part}");
        let error = refusal(&SCENE.replacen(part, other, 1));
        let right_place = error.starts_with(&format!("s.ron:{place}: "));
        if !right_place || !message.iter().all(|fragment| error.contains(fragment)) {
            wrong.push(format!(
                "{other}: expected {place} and {message:?}, got {error}"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_plane_scene_has_nothing_outside_its_plane() {
    let scene = |rest: &str| {
        format!(
            "(name: \"a\", dimension: 2, spacing: 0.1, {rest}, bodies: [(shape: Sphere(center: (0, 0, 0), radius: 1))])"
        )
    };
    assert!(Scene::parse(&scene("gravity: (0, -9.81, 0)"), "s.ron", &[]).is_ok());
    assert!(refusal(&scene("gravity: (0, 0, -9.81)")).contains("plane z = 0"));
    let tank = "boundaries: [Tank(min: (-1, -1, 1), max: (1, 1, 2))]";
    assert!(refusal(&scene(tank)).contains("misses the plane z = 0"));
    for (kind, message) in [
        ("Pressure(at: (0, 0, 1))", "plane z = 0"),
        ("Front(direction: (0, 0, 1))", "plane z = 0"),
        (
            "Flux(corner: (0, 0, 0), along: (0, 1, 0), across: (0, 0, 1))",
            "leave `across` out",
        ),
    ] {
        let gauges = format!("gauges: [(name: \"g\", kind: {kind})]");
        let error = refusal(&scene(&gauges));
        assert!(error.contains(message), "{kind}: {error}");
    }
    let cylinder = scene("support: 2").replace(
        "Sphere(center: (0, 0, 0), radius: 1)",
        "Cylinder(start: (0, 0, 0), end: (1, 0, 0), radius: 1)",
    );
    assert!(refusal(&cylinder).contains("a cylinder needs `dimension: 3`"));
}

#[test]
fn an_open_tank_lets_fluid_stand_above_its_rim() {
    let text = SCENE.replacen("max: (1, 1, 1)", "max: (1, 3, 1)", 1);
    assert!(refusal(&text).contains("at its +y side"));
    let open = text.replacen("max: (2, 2, 1)", "max: (2, 2, 1), open: true", 1);
    assert!(Scene::parse(&open, "s.ron", &[]).is_ok());
}

#[test]
fn a_tank_may_stand_in_a_tank() {
    let text = SCENE.replacen(
        "boundaries: [",
        "boundaries: [Tank(min: (-1, -1, -1), max: (3, 3, 3)), ",
        1,
    );
    assert!(Scene::parse(&text, "s.ron", &[]).is_ok());
}

#[test]
fn bodies_that_touch_are_no_overlap() {
    let text = SCENE.replacen(
        "1, 1)))]",
        "1, 1))), (shape: Box(min: (1, 0, 0), max: (1.5, 1, 1)))]",
        1,
    );
    assert!(Scene::parse(&text, "s.ron", &[]).is_ok());
}

#[test]
fn a_scene_built_in_code_is_checked_by_the_same_rules() {
    let mut scene = Scene::parse(SCENE, "s.ron", &[]).unwrap_or_else(|e| panic!("{e}"));
    scene.spacing = f32::NAN;
    let error = scene.check().expect_err("refused").to_string();
    assert!(error.starts_with("spacing: "), "{error}");
}

#[test]
fn text_that_is_no_scene_is_refused_without_a_panic() {
    let deep = "(".repeat(100_000);
    for text in [
        "",
        "(",
        ")",
        "(name",
        "\"",
        "/* ",
        "r#\"",
        "'",
        "b",
        "ü: (",
        "(name: r##\"\"#)",
        &deep,
    ] {
        refusal(text);
    }
    // Every text that a scene starts with, and every scene with one character too few.
    for (at, c) in SCENE.char_indices() {
        refusal(&SCENE[..at]);
        let without = format!("{}{}", &SCENE[..at], &SCENE[at + c.len_utf8()..]);
        let _ = Scene::parse(&without, "s.ron", &[]);
    }
}

/// The scene with overrides; the message if one is refused.
fn set(overrides: &[&str]) -> Result<Scene, String> {
    let overrides: Result<Vec<_>, _> = overrides.iter().map(|text| Override::parse(text)).collect();
    Scene::parse(SCENE, "s.ron", &overrides.map_err(|e| e.to_string())?).map_err(|e| e.to_string())
}

#[test]
fn an_override_is_the_same_as_the_field_in_the_file() {
    // One case a line: the columns are read together.
    #[rustfmt::skip]
    let cases: &[(&[&str], &str, &str)] = &[
        (&["spacing=0.05"], "spacing: 0.1", "spacing: 0.05"),
        (&["name=other"], "\"spoilt\"", "\"other\""),
        (&["name=two words"], "\"spoilt\"", "\"two words\""),
        (&["name=\"quoted\""], "\"spoilt\"", "\"quoted\""),
        (&["pressure.max_density_error=0.001"], "_error: 0.01", "_error: 0.001"),
        (&["pressure.criterion=Mean"], "0.01", "0.01, criterion: Mean"),
        (&["pressure=Sesph(equation: Tait(stiffness: 1e5))"], "Pcisph(max_density_error: 0.01)", "Sesph(equation: Tait(stiffness: 1e5))"),
        (&["pressure=Pcisph()"], "0.01", "0.01"),
        (&["pressure=Dfsph"], "Pcisph(max_density_error: 0.01)", "Dfsph()"),
        (&["time_step=Cfl"], "Fixed(0.001)", "Cfl()"),
        (&["boundary_handling=DirectForcing"], "duration", "boundary_handling: DirectForcing(), duration"),
        (&["time_step=Cfl(factor: 0.3)", "time_step.max=0.01"], "Fixed(0.001)", "Cfl(factor: 0.3, max: 0.01)"),
        (&["time_step.0=0.002"], "0.001", "0.002"),
        (&["bodies.0.velocity=(1,0,0)"], "1, 1)))", "1, 1)), velocity: (1, 0, 0))"),
        (&["bodies.0.shape.max.x=0.5"], "max: (1,", "max: (0.5,"),
        (&["bodies.0.jitter.amplitude=0.1"], "1, 1)))", "1, 1)), jitter: (amplitude: 0.1))"),
        (&["bodies.0.jitter=(amplitude: 0.1, seed: 7)", "bodies.0.jitter.seed=8"], "1, 1)))", "1, 1)), jitter: (amplitude: 0.1, seed: 8))"),
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
    // One case a line: the columns are read together.
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

/// Every variant whose fields have defaults may stand alone, in either spelling of the others' brackets, anywhere in a
/// text.
#[test]
fn a_variant_alone_is_the_one_with_its_defaults() {
    for (alone, whole) in [
        ("Pcisph", "Pcisph()"),
        ("Iisph", "Iisph()"),
        ("Dfsph", "Dfsph()"),
    ] {
        for (time_step, written) in [("Cfl", "Cfl()"), ("Adaptive /* ß */", "Adaptive()")] {
            let scene = |pressure: &str, time_step: &str| {
                let text = SCENE
                    .replace("Pcisph(max_density_error: 0.01)", pressure)
                    .replace("Fixed(0.001)", time_step);
                Scene::parse(&text, "s.ron", &[]).unwrap_or_else(|e| panic!("{e}"))
            };
            assert_eq!(scene(alone, time_step), scene(whole, written));
        }
    }
    let double = SCENE
        .replace(
            "Pcisph(max_density_error: 0.01)",
            "Pcisph((max_density_error: 0.01))",
        )
        .replace("Fixed(0.001)", "Cfl");
    assert!(Scene::parse(&double, "s.ron", &[]).is_ok());
    // What is wrong behind it is told where it stands.
    let wrong = SCENE
        .replace(
            "Pcisph(max_density_error: 0.01)",
            "Pcisph, time_step: Cfl, limit: 3",
        )
        .replace("    time_step: Fixed(0.001),\n", "");
    assert!(
        refusal(&wrong).starts_with("s.ron:7:39: unknown field `limit`"),
        "{}",
        refusal(&wrong)
    );
}

/// A scene is written in the spelling that scene files use, and read as the same again.
#[test]
fn a_scene_is_written_as_it_is_read() {
    let text = SCENE.replace(
        "(rest_density: 1000)",
        "(viscosity: None, surface_tension: None)",
    );
    let text = text.replace("\"spoilt\"", "\"r#None, spoilt\"");
    let scene = Scene::parse(&text, "s.ron", &[]).unwrap_or_else(|e| panic!("{e}"));
    let written = scene.to_ron().unwrap_or_else(|e| panic!("{e}"));
    assert!(written.contains("viscosity: None,"), "{written}");
    assert_eq!(written.matches("r#").count(), 1, "{written}");
    assert_eq!(Scene::parse(&written, "s.ron", &[]).ok(), Some(scene));
}

#[test]
fn a_mark_before_the_text_moves_no_place() {
    let marked = format!("\u{feff}{}", SCENE.replacen("spacing", "spaceing", 1));
    assert!(refusal(&marked).starts_with("s.ron:3:5: unknown field"));
    assert!(Scene::parse(&format!("\u{feff}{SCENE}"), "s.ron", &[]).is_ok());
}

/// A scene of one small body and what else is said.
fn small(spacing: f32, rest: &str) -> Result<Scene, String> {
    let end = 3.01 * spacing;
    let text = format!(
        "(name: \"small\", spacing: {spacing:e},
        bodies: [(shape: Box(min: (0, 0, 0), max: ({end:e}, {end:e}, {end:e})))], {rest})"
    );
    Scene::parse(&text, "s.ron", &[]).map_err(|error| error.to_string())
}

#[test]
fn needles_and_sheets_are_counted_along_all_of_their_length() {
    for length in ["1e7", "1e8", "3e9", "1e20", "1e38"] {
        for shape in [
            format!("Box(min: (10, 0, 0), max: ({length}, 0.001, 0.001))"),
            format!("Box(min: (10, 0, 0), max: (10.001, {length}, {length}))"),
            format!("Tank(min: (-1, -1, -1), max: ({length}, 1, 1))"),
            format!("Tank(min: (-1, -1, -1), max: (1, 1, {length}), open: true)"),
            format!("Sphere(center: (-{length}, 0, 0), radius: {length})"),
            format!("Plane(center: (0, -1, 0), normal: (0, 1, 0), half_size: {length})"),
        ] {
            let error = small(0.1, &format!("boundaries: [{shape}]")).expect_err(&shape);
            let says = ["million particles", "single precision"];
            assert!(says.iter().any(|part| error.contains(part)), "{error}");
        }
    }
}

#[test]
fn cells_that_a_search_cannot_go_through_are_refused() {
    for size in ["0.001", "0.049", "1e-30", "0"] {
        let error = small(0.1, &format!("index: (cell_size: {size})")).expect_err(size);
        assert!(error.contains("at least 0.05"), "{error}");
    }
    for size in ["0.05", "0.3334"] {
        small(0.1, &format!("index: (cell_size: {size})")).expect(size);
    }
}

#[test]
fn a_least_time_step_leaves_room_for_every_certain_limit() {
    for spacing in [2e-4_f32, 0.01, 0.1, 10.0] {
        let h = 2.0 * spacing;
        let viscous = |nu: f32| h * h / (32.0 * nu);
        let falling = 0.25 * (h / 9.81_f32).sqrt();
        for (rest, limit, name) in [
            (
                "gravity: (0, 0, 0), fluid: (viscosity: Laminar(kinematic_viscosity: 20))",
                viscous(20.0),
                "viscosity",
            ),
            (
                "gravity: (0, 0, 0), fluid: (viscosity: Laminar(kinematic_viscosity: 2e5))",
                viscous(2e5),
                "viscosity",
            ),
            ("gravity: (0, 0, 9.81)", falling, "gravity"),
            (
                "gravity: (0, 0, 0), pressure: Sesph(equation: Tait(stiffness: 1e9))",
                0.4 * h / 2645.75,
                "sound",
            ),
        ] {
            for scheme in ["Cfl", "Adaptive"] {
                for (part, accepted) in [(0.5, true), (0.99, true), (1.01, false), (30.0, false)] {
                    let min = part * limit;
                    let steps = format!("{rest}, time_step: {scheme}(min: {min:e}, max: 1e9)");
                    match small(spacing, &steps) {
                        Ok(_) => assert!(accepted, "{spacing}: {steps}"),
                        Err(error) => assert!(
                            !accepted && error.contains(name) && error.contains("`min:"),
                            "{spacing}: {steps}: {error}"
                        ),
                    }
                }
            }
        }
    }
}

#[test]
fn masses_and_kernels_that_single_precision_does_not_carry_are_refused() {
    for spacing in [1e-20_f32, 1e-13, 1e-11, 1e10, 1e13, 1e20] {
        let error = small(spacing, "gravity: (0, 0, 0)").expect_err("no spacing");
        assert!(error.contains("single precision"), "{spacing}: {error}");
    }
    for density in ["1e-38", "1e-33", "1e38"] {
        let error = small(0.1, &format!("fluid: (rest_density: {density})")).expect_err(density);
        assert!(error.contains("single precision"), "{density}: {error}");
    }
}

#[test]
fn coordinates_that_do_not_carry_a_part_of_the_spacing_are_refused() {
    for spacing in [1e-3_f32, 0.1, 5.0] {
        for (spacings, accepted) in [(8e4, true), (9e4, false), (1e7, false), (1e12, false)] {
            let at = spacings * spacing;
            let (start, end) = (at - 4.0 * spacing, at);
            for shape in [
                format!("Box(min: ({start:e}, 0, 0), max: ({end:e}, {spacing:e}, {spacing:e}))"),
                format!("Sphere(center: (0, -{at:e}, 0), radius: {spacing:e})"),
                format!(
                    "Plane(center: (0, 0, -{at:e}), normal: (0, 0, 1), half_size: {spacing:e})"
                ),
            ] {
                // In so coarse coordinates there may be no box at all.
                match small(
                    spacing,
                    &format!("gravity: (0, 0, 0), boundaries: [{shape}]"),
                ) {
                    Ok(_) => assert!(accepted, "{shape}"),
                    Err(error) => assert!(
                        !accepted
                            && (error.contains("single precision")
                                || error.contains("above `min`")),
                        "{shape}: {error}"
                    ),
                }
            }
        }
    }
}

/// The density error at the start that `check` would print, or why the scene is refused.
fn start(scene: &str) -> Result<f32, String> {
    let scene = Scene::parse(scene, "s.ron", &[]).map_err(|error| error.to_string())?;
    let plan = overfall::plan(&scene).map_err(|error| error.to_string())?;
    Ok(plan.start_density.expect("few particles").max_error)
}

/// Two bodies in 2-D and 3-D whose lattices are shifted, and bodies at solids of every thickness, which have one layer
/// of samples in their middle: what starts compressed is refused with its depth and place, all else starts at rest.
#[test]
fn fluid_starts_at_rest_or_is_refused_with_depth_and_place() {
    let (mut refused, mut taken) = (0, 0);
    let mut ask = |what: String, scene: String, is_right: Option<bool>| match start(&scene) {
        Ok(error) => {
            taken += 1;
            assert!(is_right != Some(false) && error < 0.03, "{what}: {error}");
        }
        Err(error) => {
            refused += 1;
            let told = error.contains(" spacings)")
                && (error.contains(") m") || error.contains("+x side"));
            assert!(is_right != Some(true) && told, "{what}: {error}");
        }
    };
    for (dimension, depth) in [(2, 0.0), (3, 0.2)] {
        let scene = |bodies: &str, boundaries: &str| {
            format!(
                "(name: \"s\", dimension: {dimension}, spacing: 0.02, bodies: [{bodies}], boundaries: [{boundaries}])"
            )
        };
        let body = |x: f64, y: f64| {
            format!(
                "(shape: Box(min: ({x}, {y}, 0), max: ({}, {}, {depth})))",
                x + 0.2,
                y + 0.2
            )
        };
        for shift in [0.0, 0.004, 0.01, 0.1, 0.19, 0.196, 0.2, 0.206, 0.25] {
            for aside in [0.0, 0.01] {
                let bodies = format!("{}, {}", body(0.0, 0.0), body(shift, aside));
                ask(
                    format!("{dimension}-D, {shift} aside"),
                    scene(&bodies, ""),
                    Some(shift > 0.199),
                );
            }
        }
        for thickness in [0.1, 0.4, 0.9, 1.1, 1.25, 1.6, 3.0] {
            let end = 0.2 + 0.02 * thickness;
            let bodies = format!("{}, {}", body(0.0, 0.0), body(end, 0.0));
            let plate = format!("Box(min: (0.2, 0, 0), max: ({end}, 0.4, {depth}))");
            ask(
                format!("{dimension}-D, plate of {thickness}"),
                scene(&bodies, &plate),
                Some(thickness > 1.2),
            );
            let outside = format!(
                "Tank(min: (0, 0, 0), max: (0.2, 0.2, {depth})), Tank(min: (-1, -1, -1), max: (1, 1, 1))"
            );
            let right = Some(thickness > 1.2);
            ask(
                format!("{dimension}-D, outside a tank by {thickness}"),
                scene(&body(end, 0.0), &outside),
                right,
            );
            let radius = 0.02 * thickness;
            let disc = format!(
                "Sphere(center: ({}, 0.1, {}), radius: {radius})",
                -radius,
                0.5 * depth
            );
            ask(
                format!("{dimension}-D, disc of {thickness}"),
                scene(&body(0.0, 0.0), &disc),
                None,
            );
        }
    }
    assert!(
        refused > 30 && taken > 30,
        "{refused} refused, {taken} taken"
    );
}

/// Bodies are as many spacings long far from the origin as at it, where numbers are rounded to a part of a spacing.
#[test]
fn bodies_far_away_keep_their_rows() {
    for far in [0.0, 1000.0, 4000.0, 8000.0] {
        let scene = format!(
            "(name: \"s\", spacing: 0.1, bodies: [(shape: Box(min: ({far}, 0, 0), max: ({}, 0.3, 0.3)))])",
            far + 0.3
        );
        let scene = Scene::parse(&scene, "s.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(
            overfall::scene::shapes::fluid_particles(&scene).len(),
            27,
            "{far}"
        );
    }
}
