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
        (wall, "motion: Oscillation(amplitude: (1, 0, 0), frequency: 100)", "8:16", &["628.3", "`Cfl()`"]),
        (wall, "motion: Table(file: \"none.csv\", direction: (1, 0, 0))", "6:75", &["none.csv"]),
        (wall, "slip: Partial(length: 0)", "6:", &["must be above 0", "NoSlip"]),
        (wall, "slip: Rough", "6:", &["Free, NoSlip, Partial"]),
        (force, "body_forces: [Central(center: (0, 0, 0))]", "9:32", &["zero everywhere", "`linear`"]),
        (force, "body_forces: [Central(center: (0, 0, 0), linear: inf)]", "9:", &["is inf", "finite"]),
        (force, "body_forces: [Table(file: \"none.csv\")]", "9:44", &["none.csv"]),
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

/// Files of tables: the scene's field, what the file says, and the message with the file's line.
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
    for ((part, other), text, expected) in [
        (
            &motion,
            "t,x\n0,0\n1,NaN\n",
            "table.csv:3: `NaN` in column `x` is not a number",
        ),
        (
            &motion,
            "t,x\n0,0\n2,1\n1,2\n",
            "table.csv:4: the time 1 s comes after 2 s; times must ascend",
        ),
        (
            &motion,
            "t,x\n0,0\n0,1\n",
            "table.csv:3: the time 0 s comes after 0 s",
        ),
        (
            &motion,
            "t,y\n0,0\n",
            "there is no column `x`; the columns are t, y",
        ),
        (&motion, "t,x\n", "there is no row of figures"),
        (&motion, "", "there is no line with the names"),
        (&motion, "t,x\n0,0\n0.01,2\n", "up to 200.000 m/s"),
        (
            &force,
            "t,ax\n0,1\n0.5,2\n0.4,1\n",
            "table.csv:4: the time 0.4 s comes after 0.5 s",
        ),
        (
            &force,
            "t,ax\n0,1\n0.5,inf\n",
            "table.csv:3: `inf` in column `ax`",
        ),
        (
            &field,
            "x,y,vx,vy\n0,0,1,0\n1,0,1,0\n1,1,0,0\n",
            "3 rows are not one for every point of a grid",
        ),
        (
            &field,
            "x,y,vx,vy\n0,0,1,0\n0.5,0,1,0\n0,1,0,0\n0.5,1,0,0\n",
            "from x = 0 to 0.5 m, the particles of the body from",
        ),
    ] {
        std::fs::write(&file, text).expect("a file");
        let error = refusal(&SCENE.replacen(part, other, 1));
        assert!(
            error.starts_with("s.ron:") && error.contains(expected),
            "{text}: {error}"
        );
    }
    for (part, other, text) in [
        (motion.0, &motion.1, "# a piston\nt,x,v\n0,0,0\n1,1,2\n"),
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
