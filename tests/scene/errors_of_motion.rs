//! Motions of walls, slip, body forces and velocity fields that cannot work are refused, with place and remedy.

use overfall::scene::Scene;

use crate::errors::{SCENE, refusal};

/// Each case: a part of the scene, what comes to it, the place of the error, parts of the message.
#[test]
fn motions_forces_and_fields_that_cannot_be_are_refused() {
    let (wall, force, body) = ("max: (2, 2, 1)", "duration: 1", "max: (1, 1, 1))");
    #[rustfmt::skip]
    let cases: &[(&str, &str, &str, &[&str])] = &[
        (wall, "motion: Velocity(velocity: (0, 0, 0))", "6:82", &["the velocity is zero", "leave `motion` out"]),
        (wall, "motion: Velocity(velocity: (NaN, 0, 0))", "6:", &["is NaN", "finite"]),
        (wall, "motion: Velocity(velocity: (1, 0, 0), start: 2, end: 1)", "6:108",
            &["stops at 1 s", "`end` must be above"]),
        (wall, "motion: Velocity(velocity: (1, 0, 0), start: -1)", "6:100", &["must not be before 0"]),
        (wall, "motion: Velocity(velocity: (200, 0, 0))", "8:16",
            &["200.000 m/s", "2.000e-1 m in a step", "`Cfl()`"]),
        (wall, "motion: Rotation(center: (0, 0, 0), angular_velocity: (0, 0, 0))", "6:109",
            &["the angular velocity is zero"]),
        (wall, "motion: Rotation(center: (0, 0, 0), angular_velocity: (0, 0, 50))", "8:16", &["141.4", "`Cfl()`"]),
        (wall, "motion: Oscillation(amplitude: (1, 0, 0), frequency: 0)", "6:108", &["must be above 0"]),
        (wall, "motion: Oscillation(amplitude: (20, 0, 0), frequency: 5)", "8:16", &["628.3", "`Cfl()`"]),
        (wall, "motion: Oscillation(amplitude: (0.01, 0, 0), frequency: 1000)", "8:16",
            &["back and forth in 1.000e-3 s", "a twentieth", "`Fixed(4e-5)`", "`Cfl()`"]),
        (wall, "motion: Oscillation(amplitude: (0.01, 0, 0), frequency: 51)", "8:16", &["a twentieth"]),
        (wall, "motion: Table(file: \"none.csv\", direction: (1, 0, 0))", "6:75", &["none.csv"]),
        (wall, "slip: Partial(length: 0)", "6:", &["must be above 0", "NoSlip"]),
        (wall, "slip: Rough", "6:", &["Free, NoSlip, Partial"]),
        (force, "body_forces: [Central(center: (0, 0, 0))]", "9:32", &["zero everywhere", "`linear`"]),
        (force, "body_forces: [Central(center: (0, 0, 0), linear: inf)]", "9:", &["is inf", "finite"]),
        (force, "body_forces: [Table(file: \"none.csv\")]", "9:44", &["none.csv"]),
        (force, "body_forces: [Wave(amplitude: (0, 0, 0), frequency: 1)]", "9:48", &["zero everywhere", "m/s²"]),
        (force, "body_forces: [Wave(amplitude: (1, 0, 0))]", "9:",
            &["the same everywhere", "`gravity`", "`frequency`"]),
        (force, "body_forces: [Wave(amplitude: (1, 0, 0), wave_number: (0, 100, 0))]", "9:",
            &["0.0628 m", "0.4 m, four spacings"]),
        (force, "body_forces: [Wave(amplitude: (1, NaN, 0), frequency: 1)]", "9:", &["is NaN", "finite"]),
        (force, "gravity_ramp: -1", "9:", &["0 or more"]),
        (force, "gravity_ramp: inf", "9:", &["is inf", "finite"]),
        (body, "velocity_field: TaylorGreen(speed: 0, wavelength: 1)", "5:", &["the speed is zero", "at rest"]),
        (body, "velocity_field: Rotation(center: (0, 0, 0), angular_velocity: (0, 0, 0))", "5:",
            &["the angular velocity is zero"]),
        (body, "velocity_field: TaylorGreen(speed: 1, wavelength: 0.1)", "5:109", &["four spacings"]),
        (body, "velocity_field: Table(file: \"none.csv\")", "5:", &["none.csv"]),
    ];
    let mut wrong = Vec::new();
    for (part, more, place, message) in cases {
        let error = refusal(&SCENE.replacen(part, &format!("{part}, {more}"), 1));
        let right_place = error.starts_with(&format!("s.ron:{place}"));
        if !right_place || !message.iter().all(|fragment| error.contains(fragment)) {
            wrong.push(format!(
                "{more}: expected {place} and {message:?}, got {error}"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn walls_that_leave_the_domain_are_refused_before_they_do() {
    let scene = |walls: &str, domain: &str| {
        let all = format!("boundaries: [{walls}], domain: (min: (0, 0, 0), max: {domain}),");
        SCENE.replacen(
            "boundaries: [Tank(min: (0, 0, 0), max: (2, 2, 1))],",
            &all,
            1,
        )
    };
    let tank = "Tank(min: (0, 0, 0), max: (2, 2, 1), motion: Velocity(velocity: (1, 0, 0)";
    let gate =
        "Tank(min: (0, 0, 0), max: (2, 2, 1)), Box(min: (1.5, 0, 0), max: (1.6, 1, 1), motion: ";
    let lid = "Tank(min: (0, 0, 0), max: (2, 2, 1)), Box(min: (1.5, 1.75, 0), max: (1.6, 1.95, 1), motion: ";
    for (walls, domain, expected) in [
        (
            format!("{tank}))"),
            "(2.5, 2, 1)",
            "carries its fluid out of `domain`",
        ),
        (
            format!("{gate}Velocity(velocity: (0, 3, 0)))"),
            "(2, 2, 1)",
            "the wall has left `domain`",
        ),
        (
            // It is outside between the times at which all walls are looked at.
            format!("{lid}Oscillation(amplitude: (0, 0.3, 0), frequency: 50))"),
            "(2, 2, 1)",
            "at 0.0050 s the wall has left `domain`",
        ),
    ] {
        let error = refusal(&scene(&walls, domain));
        assert!(
            error.starts_with("s.ron:6:") && error.contains(expected),
            "{walls}: {error}"
        );
        assert!(error.contains("stop it before"), "{error}");
    }
    for (walls, domain) in [
        (format!("{tank}, end: 0.4))"), "(2.5, 2, 1)"),
        (format!("{tank}))"), "(3, 2, 1)"),
        (
            format!("{gate}Velocity(velocity: (0, 3, 0), end: 0.6))"),
            "(2, 2, 1)",
        ),
    ] {
        let scene = scene(&walls, domain);
        let checked = Scene::parse(&scene, "s.ron", &[]);
        assert!(
            checked.is_ok(),
            "{walls}: {}",
            checked.expect_err("refused")
        );
    }
}

/// Where a table stands, what it says, and the message with its line.
const BAD_TABLES: &[(&str, &str, &str)] = &[
    (
        "motion",
        "t,x\n0,0\n1,NaN\n",
        "table.csv:3: `NaN` in column `x` is not a number",
    ),
    (
        "motion",
        "t,x\n0,0\n2,1\n1,2\n",
        "table.csv:4: the time 1 s comes after 2 s; times must ascend",
    ),
    (
        "motion",
        "t,x\n0,0\n0,1\n",
        "table.csv:3: the time 0 s comes after 0 s",
    ),
    (
        "motion",
        "t,y\n0,0\n",
        "table.csv:1: unknown column `y` (columns: t, x, v (optional))",
    ),
    (
        "motion",
        "t\n0\n",
        "there is no column `x`; the columns are t",
    ),
    (
        "motion",
        "x,v\n0,0\n",
        "there is no column `t`; the columns are x, v",
    ),
    (
        "motion",
        "t,x,V\n0,0,1\n",
        "unknown column `V`; did you mean `v`?",
    ),
    ("motion", "t,x,x\n0,0,1\n", "`x` is there twice"),
    ("motion", "t,x\n0,1\n2,1\n", "is the same in every row"),
    ("motion", "t,x\n0,1\n", "is the same in every row"),
    (
        "motion",
        "t,x\n0,0\n0.002,0.001\n0.004,0\n0.006,0.001\n1,0.001\n",
        "back and forth in 4.000e-3 s",
    ),
    ("force", "t,ax\n0,0\n1,0\n", "all accelerations in it are 0"),
    (
        "force",
        "ax,t\n100,0\n-100,0.005\n100,0.01\n-100,0.015\n",
        "goes back and forth in 1.000e-2 s",
    ),
    (
        "field",
        "x,y,vx,vy\n0,0,0,0\n1,0,0,0\n0,1,0,0\n1,1,0,0\n",
        "every velocity in it is zero",
    ),
    (
        "field",
        "x,y,vx,vy\n0,0,1,0\n1,0,1,0\n",
        "the grid has one plane, y = 0 m",
    ),
    (
        "field",
        "x,y,z,vx,vy\n0,0,0,1,0\n1,0,0,1,0\n0,1,0,1,0\n1,1,0,1,0\n",
        "one plane of `z`",
    ),
    ("motion", "t,x\n", "there is no row of figures"),
    ("motion", "", "there is no line with the names"),
    ("motion", "t,x\n0,0\n0.01,2\n", "up to 200.000 m/s"),
    (
        "force",
        "t,ax\n0,1\n0.5,2\n0.4,1\n",
        "table.csv:4: the time 0.4 s comes after 0.5 s",
    ),
    (
        "force",
        "t,ax\n0,1\n0.5,inf\n",
        "table.csv:3: `inf` in column `ax`",
    ),
    (
        "field",
        "x,y,vx,vy\n0,0,1,0\n1,0,1,0\n1,1,0,0\n",
        "3 rows are not one for every point of a grid",
    ),
    (
        "field",
        "x,y,vx,vy\n0,0,1,0\n0.5,0,1,0\n0,1,0,0\n0.5,1,0,0\n",
        "from x = 0 to 0.5 m, the particles of the body from",
    ),
];

/// Files of tables that are refused, and some that are not.
#[test]
fn a_table_that_cannot_be_used_is_refused_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("table.csv");
    let name = format!("{:?}", file.display().to_string());
    let motion = (
        "max: (2, 2, 1))",
        format!("max: (2, 2, 1), motion: Table(file: {name}, direction: (1, 0, 0)))"),
    );
    let force = (
        "duration: 1,",
        format!("duration: 1, body_forces: [Table(file: {name})],"),
    );
    let field = (
        "max: (1, 1, 1))",
        format!("max: (1, 1, 1)), velocity_field: Table(file: {name})"),
    );
    for (of, text, expected) in BAD_TABLES {
        let (part, other) = match *of {
            "motion" => &motion,
            "force" => &force,
            _ => &field,
        };
        std::fs::write(&file, text).expect("a file");
        let error = refusal(&SCENE.replacen(part, other, 1));
        assert!(
            error.starts_with("s.ron:") && error.contains(expected),
            "{text}: {error}"
        );
    }
    for (part, other, text) in [
        (motion.0, &motion.1, "# a piston\nt,x,v\n0,0,0\n1,1,2\n"),
        (motion.0, &motion.1, "x,time\n0,0\n1,1\n"),
        (force.0, &force.1, "t,az\n0,1\n"),
        (
            field.0,
            &field.1,
            "x,y,vx,vy\n0,0,1,0\n1,0,1,0\n0,1,0,0\n1,1,0,0\n",
        ),
    ] {
        std::fs::write(&file, text).expect("a file");
        let scene = SCENE.replacen(part, other, 1);
        assert!(Scene::parse(&scene, "s.ron", &[]).is_ok(), "{scene}");
    }
}

#[test]
fn walls_hold_what_is_viscous_alone() {
    for (viscosity, fine) in [
        ("None", false),
        ("Artificial(alpha: 0.1, sound_speed: 20)", false),
        ("Laminar(kinematic_viscosity: 0.01)", true),
    ] {
        let scene = SCENE.replacen("rest_density: 1000", &format!("viscosity: {viscosity}"), 1);
        let scene = scene.replacen("max: (2, 2, 1))", "max: (2, 2, 1), slip: NoSlip)", 1);
        match Scene::parse(&scene, "s.ron", &[]) {
            Ok(_) => assert!(fine, "{viscosity}"),
            Err(error) => {
                let error = error.to_string();
                let told = error.starts_with("s.ron:6:") && error.contains("laminar viscosity");
                assert!(told && !fine, "{viscosity}: {error}");
            }
        }
    }
}

/// A step that is chosen follows walls and forces: its limits are those of their speeds and periods. Where the least
/// step does not, the cause is named at its place, and no step that nobody could take is advised.
#[test]
fn the_least_step_leaves_room_for_walls_and_forces() {
    let scene = SCENE.replacen("time_step: Fixed(0.001),", "", 1);
    for (part, more, place, message) in [
        (
            "max: (2, 2, 1)",
            "motion: Velocity(velocity: (-3e38, 0, 0))",
            "6:",
            "up to 3.000e38 m/s",
        ),
        (
            "max: (2, 2, 1)",
            "motion: Velocity(velocity: (3e38, 3e38, 0))",
            "6:",
            "up to inf m/s",
        ),
        (
            "max: (2, 2, 1)",
            "motion: Velocity(velocity: (1e6, 0, 0))",
            "6:",
            "`min: 8e-9` in `time_step`",
        ),
        (
            "max: (2, 2, 1)",
            "motion: Rotation(center: (0, 0, 0), angular_velocity: (0, 0, 1e20))",
            "6:",
            "moves with",
        ),
        (
            "max: (2, 2, 1)",
            "motion: Oscillation(amplitude: (1e-9, 0, 0), frequency: 1e6)",
            "6:",
            "in 1.000e-6 s",
        ),
        (
            "max: (1, 1, 1))",
            "velocity: (1e15, 0, 0)",
            "5:",
            "starts with up to 1.000e15 m/s",
        ),
        (
            "duration: 1",
            "gravity: (0, -1e15, 0)",
            "9:",
            "gravity is 1.000e15 m/s²",
        ),
        (
            "duration: 1",
            "body_forces: [Central(center: (9, 9, 9), constant: 1e25)]",
            "9:",
            "by gravity and body forces",
        ),
        (
            "rest_density: 1000",
            "viscosity: Laminar(kinematic_viscosity: 1e9)",
            "4:",
            "by viscosity",
        ),
    ] {
        let error = refusal(&scene.replacen(part, &format!("{part}, {more}"), 1));
        let placed = error.starts_with(&format!("s.ron:{place}"));
        assert!(placed && error.contains(message), "{more}: {error}");
        assert!(
            !error.contains("0e0") && !error.contains("allows"),
            "{error}"
        );
    }
    // What is written is what is wrong.
    let written = SCENE.replacen("Fixed(0.001)", "Cfl(min: 0.01, max: 0.02)", 1);
    let error = refusal(&written.replacen(
        "max: (2, 2, 1)",
        "max: (2, 2, 1), motion: Velocity(velocity: (100, 0, 0))",
        1,
    ));
    assert!(
        error.starts_with("s.ron:8:") && error.contains("leaves room"),
        "{error}"
    );
}
