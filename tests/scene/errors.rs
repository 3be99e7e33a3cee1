//! A scene that cannot work is refused, with file, line, column, the mistake and the remedy.

use overfall::scene::Scene;

/// A valid scene of ten lines, to be modified.
pub(super) const SCENE: &str = r#"(
    name: "spoilt",
    spacing: 0.1,
    fluid: (rest_density: 1000),
    bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))],
    boundaries: [Tank(min: (0, 0, 0), max: (2, 2, 1))],
    pressure: Pcisph(max_density_error: 0.01),
    time_step: Fixed(0.001),
    duration: 1,
)"#;

pub(super) fn refusal(text: &str) -> String {
    match Scene::parse(text, "s.ron", &[]) {
        Ok(_) => panic!("accepted: {text}"),
        Err(error) => error.to_string(),
    }
}

/// A part of the scene, its replacement, the place of the error, parts of the message.
type Case = (
    &'static str,
    &'static str,
    &'static str,
    &'static [&'static str],
);

/// One case per line, so that the columns can be read together.
#[rustfmt::skip]
const CASES: &[Case] = &[
    // Syntax.
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
    ("Pcisph(max_density_error: 0.01)", "DeltaSph(), boundary_handling: Extrapolated", "7:46",
        &["for methods that solve for the pressure", "`Akinci` or `Layers`"]),
    // Typing errors.
    ("Fixed(0.001)", "0.001", "8:16", &["one of Fixed, Cfl, Adaptive", "did you mean `Fixed(0.001)`?"]),
    ("Fixed(0.001)", "Fixed", "8:16", &["`Fixed` needs its values in a bracket", "a number"]),
    ("rest_density: 1000", "viscosity: 0.01", "4:24", &["did you mean `Laminar(kinematic_viscosity: 0.01)`?"]),
    ("rest_density: 1000", "viscosity: (kinematic_viscosity: 0.01)", "4:24",
        &["did you mean `Laminar(kinematic_viscosity: 0.01)`?"]),
    ("rest_density: 1000", "viscosity: Laminar(0.01)", "4:32", &["did you mean `kinematic_viscosity: 0.01`?"]),
    ("(rest_density: 1000)", "1000", "4:12", &["did you mean `(rest_density: 1000)`?"]),
    ("spacing: 0.1", "spacing: 0,05", "3:14", &["decimal point", "did you mean `0.05`?"]),
    ("duration: 1", "duration: 1s", "9:15", &["in SI units", "did you mean `1`?"]),
    ("duration: 1", "duration: 20 ms", "9:15", &["in SI units", "did you mean `0.02`?"]),
    ("duration: 1", "duration: \"1\"", "9:15", &["no quotes", "did you mean `1`?"]),
    ("duration: 1", "index: UniformGrid", "9:12", &["structure, cell_size",
        "did you mean `(structure: UniformGrid)`?"]),
    ("duration: 1", "index: 0.5", "9:12", &["did you mean `(cell_size: 0.5)`?"]),
    ("duration: 1", "gravity: [0, -1, 0]", "9:14", &["did you mean `(0, -1, 0)`?"]),
    ("duration: 1", "gravity: -9.81", "9:14", &["a vector of three numbers"]),
    ("duration: 1", "output: (formats: Ply)", "9:23", &["did you mean `[Ply]`?"]),
    ("duration: 1", "executor: \"Parallel\"", "9:15", &["did you mean `Parallel`?"]),
    ("duration: 1", "executor: 4", "9:15", &["one of Auto, Parallel, SingleThreaded", "`4`"]),
    // Single numbers.
    ("\"spoilt\"", "\"a/b\"", "2:11", &["without slashes"]),
    ("spacing: 0.1", "spacing: -0.1", "3:14", &["`spacing` is -0.1 m; it must be above 0"]),
    ("spacing: 0.1", "spacing: 1e99", "3:14", &["`spacing` is 1e99", "at most 3.4e38"]),
    ("spacing: 0.1", "spacing: 0.1, support: 8", "3:28", &["from 1.2", "to 4", "is usual for this kernel"]),
    ("spacing: 0.1", "spacing: 0.1, kernel: WendlandC6", "3:27",
        &["CubicSpline, WendlandC2, WendlandC4, QuinticSpline"]),
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
    ("boundaries: [", "boundaries: [Plane(center: (0, 0, 0), normal: (0, 0, 0), half_size: 1), ", "6:51",
        &["normal is zero"]),
    ("1, 1)))]", "1, 1)), jitter: (amplitude: 0.6))]", "5:79", &["below 0.5"]),
    ("spacing: 0.1", "spacing: 0.001", "3:14", &["million particles", "GB", "a spacing of"]),
    // Gauges.
    ("duration: 1", "gauges: [(name: \"a b\", kind: Energy)]", "9:21", &["cannot name the gauge's file",
        "letters"]),
    ("duration: 1", "gauges: [(name: \"e\", kind: Energy), (name: \"E\", kind: Energy)]", "9:48",
        &["\"E\" is given twice"]),
    ("duration: 1", "gauges: [(name: \"e\", kind: Energie)]", "9:32", &["unknown variant `Energie`",
        "did you mean `Energy`?"]),
    ("duration: 1", "gauges: [(name: \"e\", kind: Energy, every: Seconds(0))]", "9:47", &["every 0 s", "above 0"]),
    ("duration: 1", "gauges: [(name: \"e\", kind: Energy, every: Steps(0))]", "9:47", &["every 0 steps",
        "least is 1"]),
    ("duration: 1", "gauges: [(name: \"e\", kind: Energy, window: -1)]", "9:48", &["must not be below 0"]),
    ("duration: 1", "gauges: [(name: \"e\", kind: Energy, every: Seconds(0.1), window: 0.05)]", "9:69",
        &["0.05 s is shorter", "0.1 s"]),
    ("duration: 1", "gauges: [(name: \"e\", kind: Energy, every: Steps(100), window: 0.05)]", "9:67",
        &["0.05 s is shorter", "(100 steps)"]),
    ("duration: 1", "gauges: [(name: \"p\", kind: Pressure(at: (1, 1, 1), radius: 0))]", "9:64",
        &["the radius is 0 m"]),
    ("duration: 1", "gauges: [(name: \"p\", kind: Velocity(at: (1, 1, 1), radius: 1e30))]", "9:64",
        &["the radius is 10000000", "half a spacing"]),
    ("duration: 1", "gauges: [(name: \"p\", kind: Front(direction: (1e30, 0, 0)))]", "9:49",
        &["beyond single precision"]),
    ("duration: 1", "domain: (min: (0, 0, 0), max: (2, 2, 2)), gauges: [(name: \"p\", kind: Velocity(at: (1, 3, \
     1)))]", "9:87", &["(1, 3, 1) m is outside the domain"]),
    ("duration: 1", "domain: (min: (0, 0, 0), max: (2, 2, 2)), gauges: [(name: \"h\", kind: Height(at: (1, 9, \
     3)))]", "9:85", &["outside the domain"]),
    ("duration: 1", "domain: (min: (0, 0, 0), max: (2, 2, 2)), gauges: [(name: \"q\", kind: Flux(corner: (3, -1, \
     0), along: (0, 4, 0), across: (0, 0, 1)))]", "9:87", &["the surface is outside the domain"]),
    ("duration: 1", "gauges: [(name: \"p\", kind: WallPressure(at: (1, 1, 1), normal: (0, 0, 0)))]", "9:68",
        &["normal is zero"]),
    ("duration: 1", "gauges: [(name: \"x\", kind: Front(direction: (0, 0, 0)))]", "9:49", &["direction is zero"]),
    ("duration: 1", "gauges: [(name: \"x\", kind: Front(direction: (1, 0, 0), within: (min: (0, 0, 0), max: (0, \
     1, 1))))]", "9:90", &["`max` must be above `min`"]),
    ("duration: 1", "gauges: [(name: \"f\", kind: Force(boundary: \"tank\"))]", "9:48", &["none has a name",
        "Tank(name: \"tank\""]),
    ("max: (2, 2, 1))],", "max: (2, 2, 1), name: \"tank\")], gauges: [(name: \"f\", kind: Force(boundary: \
     \"tnak\"))],", "6:114", &["unknown boundary name `tnak`", "did you mean `tank`?"]),
    ("max: (2, 2, 1)", "max: (2, 2, 1), name: \"\"", "6:61", &["the name is empty"]),
    ("duration: 1", "gauges: [(name: \"q\", kind: Flux(corner: (0, 0, 0), along: (1, 0, 0)))]", "9:32",
        &["span a surface"]),
    ("duration: 1", "gauges: [(name: \"q\", kind: Flux(corner: (0, 0, 0), along: (0, 0, 0), across: (1, 0, \
     0)))]", "9:63", &["edge is zero"]),
    ("duration: 1", "gauges: [(name: \"e\", kind: Energy, reference: (file: \"none.csv\"))]", "9:58",
        &["there is no file `none.csv`"]),
    ("duration: 1", "gauges: [(name: \"e\", kind: Energy, reference: (file: \"none.csv\", quantity: \"heat\"))]",
        "9:80", &["unknown column `heat`", "kinetic_energy_J"]),
    // Size.
    ("min: (0, 0, 0), max: (1, 1, 1)", "min: (-0.05, 0, 0), max: (1, 1, 1)", "5:22",
        &["sticks out of the tank `boundaries.0` by 0.0500 m (0.50 spacings) at its −x side"]),
    ("min: (0, 0, 0), max: (1, 1, 1)", "min: (3, 0, 0), max: (4, 1, 1)", "5:22",
        &["from (3.0000, 0.0000, 0.0000) m", "outside every tank"]),
    ("boundaries: [", "boundaries: [Box(min: (0.8, 0, 0), max: (1.5, 1, 1)), ", "5:22",
        &["overlaps the solid box `boundaries.0` by 0.2000 m (2.00 spacings)"]),
    ("boundaries: [", "boundaries: [Sphere(center: (1.5, 0.5, 0.5), radius: 0.7), ", "5:22",
        &["overlaps the solid sphere `boundaries.0`", "most at (0.9500, 0."]),
    ("boundaries: [", "boundaries: [Plane(center: (0, 0.2, 0.5), normal: (0, 2, 0), half_size: 3), ", "5:22",
        &["overlaps the plane `boundaries.0` by 0.2000 m"]),
    ("1, 1)))]", "1, 1))), (shape: Sphere(center: (1, 1, 0.5), radius: 0.3))]", "5:68",
        &["overlaps that of `bodies.0`", "0.0000 m"]),
    ("duration: 1", "domain: (min: (0, 0, 0), max: (0.5, 2, 2))", "5:22",
        &["out of the domain by 0.5000 m (5.00 spacings) at its +x side"]),
];

#[test]
fn every_spoilt_scene_is_refused_with_its_place_and_a_remedy() {
    let mut wrong = Vec::new();
    for (part, other, place, message) in CASES {
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
    // Every prefix of a scene's text, and every scene with one character removed.
    for (at, c) in SCENE.char_indices() {
        refusal(&SCENE[..at]);
        let without = format!("{}{}", &SCENE[..at], &SCENE[at + c.len_utf8()..]);
        let _ = Scene::parse(&without, "s.ron", &[]);
    }
}

/// Every variant whose fields have defaults may be written without brackets, with either notation elsewhere, anywhere
/// in a text.
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
    // An error behind it is reported at its place.
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

/// A scene is written in the notation of scene files, and read back as the same scene.
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
