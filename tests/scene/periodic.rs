//! Periodic axes that cannot be are refused, with place and remedy; those that can be start at their rest density.

use overfall::scene::Scene;

use crate::errors::refusal;

/// A channel along x; 10 × 6 particles.
const CHANNEL: &str = r#"(
    name: "channel",
    dimension: 2,
    spacing: 0.1,
    periodic: (x: (0, 1)),
    bodies: [(shape: Box(min: (0, 0, 0), max: (1, 0.6, 0)))],
    boundaries: [Box(min: (0, -0.5, 0), max: (1, 0, 0))],
    duration: 1,
)"#;

/// Each case: what is replaced, by what, the place of the error, parts of the message.
#[test]
fn periodic_axes_that_cannot_be_are_refused() {
    let (axes, body, wall, end) = (
        "periodic: (x: (0, 1))",
        "max: (1, 0.6, 0)",
        "Box(min: (0, -0.5, 0), max: (1, 0, 0))",
        "duration: 1",
    );
    #[rustfmt::skip]
    let cases: &[(&str, &str, &str, &[&str])] = &[
        (axes, "periodic: (x: (0, 0.7))", "5:19", &["2.69 support radii", "at least 3, 0.78"]),
        (axes, "periodic: (x: (1, 0))", "5:19", &["must be above the first"]),
        (axes, "periodic: (x: (0, inf))", "5:", &["finite"]),
        (axes, "periodic: (x: (0, 1), z: (0, 1))", "5:30", &["only x and y"]),
        (axes, "periodic: (w: (0, 1))", "5:", &["`w`"]),
        (axes, "periodic: (x: (0, 1.05))", "6:22",
            &["along x", "1.500 spacings before", "holds 10 rows", "0.105000 m"]),
        (body, "max: (0.9, 0.6, 0)", "", &[]),
        (body, "max: (1.2, 0.6, 0)", "6:22", &["meets its own image along x", "-1.000 spacings"]),
        (wall, "Sphere(center: (0.5, -0.8, 0), radius: 0.6)", "7:", &["meets its own image"]),
        (wall, "Plane(center: (0, -1.5, 0), normal: (0.5, 1, 0), half_size: 2)", "7:", &["must lie along it"]),
        (wall, "Box(min: (0, -0.5, 0), max: (1, 0, 0), \
            motion: Rotation(center: (0, 0, 0), angular_velocity: (0, 0, 1)))",
            "7:", &["cannot turn"]),
        (end, "duration: 1, domain: (min: (0.2, -1, 0), max: (2, 2, 0))", "5:19", &["widen `domain`"]),
        (end, "duration: 1, body_forces: [Central(center: (0, 0, 0), linear: 1)]", "8:", &["does not repeat along x"]),
        (end, "duration: 1, body_forces: [Wave(amplitude: (1, 0, 0), wave_number: (5, 1, 0))]", "8:",
            &["x is periodic", "0.7958 waves", "6.2831855"]),
        (end, "duration: 1, body_forces: [Wave(amplitude: (1, 0, 1), frequency: 1)]", "8:", &["z = 0"]),
        (end, "duration: 1, body_forces: [Wave(amplitude: (1, 0, 0), wave_number: (6.2832, 1, 0))]", "", &[]),
        (end, "duration: 1, gauges: [(name: \"f\", kind: Front(direction: (1, 0, 0)))]", "8:", &["no front along it"]),
    ];
    let mut wrong = Vec::new();
    for (part, other, place, message) in cases {
        assert!(CHANNEL.contains(part), "the scene has no {part}");
        let text = CHANNEL.replacen(part, other, 1);
        if message.is_empty() {
            assert!(Scene::parse(&text, "s.ron", &[]).is_ok(), "{other}");
            continue;
        }
        let error = refusal(&text);
        let right_place = error.starts_with(&format!("s.ron:{place}"));
        if !right_place || !message.iter().all(|fragment| error.contains(fragment)) {
            wrong.push(format!(
                "{other}: expected {place} and {message:?}, got {error}"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Wherever the faces are, and for walls as long as the period or longer: the fluid has its rest density.
#[test]
fn a_channel_starts_at_its_rest_density_across_the_seam() {
    for low in [0.0, -0.5, 0.37, -0.93] {
        for walls in [
            "(0, -0.5, 0), max: (1, 0, 0)",
            "(-3, -0.5, 0), max: (4.2, 0, 0)",
        ] {
            let text = CHANNEL
                .replacen("x: (0, 1)", &format!("x: ({low}, {})", low + 1.0), 1)
                .replacen("(0, -0.5, 0), max: (1, 0, 0)", walls, 1);
            let scene = Scene::parse(&text, "s.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
            let plan = overfall::plan(&scene).unwrap_or_else(|error| panic!("{error}"));
            let start = plan.start_density.expect("a density");
            assert!(start.max_error < 5e-3, "{low}, {walls}: {start:?}");
            let [from, to] = [plan.fluid_box.0.x, plan.fluid_box.1.x];
            assert!(f64::from(from) >= low - 1e-6 && f64::from(to) <= low + 1.0 + 1e-6);
        }
    }
    // Two bodies that overlap across the seam are found by the density.
    let text = CHANNEL.replacen(
        "(shape: Box(min: (0, 0, 0), max: (1, 0.6, 0)))",
        "(shape: Box(min: (0, 0, 0), max: (0.5, 0.6, 0))), (shape: Box(min: (0.55, 0, 0), max: (1.05, 0.6, 0)))",
        1,
    );
    let scene = Scene::parse(&text, "s.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
    assert!(overfall::plan(&scene).is_err(), "dense fluid");
}
