//! Emitters and outflow that cannot work are refused, with place and remedy.

use overfall::scene::Scene;

use crate::errors::refusal;

/// A valid scene in 3-D, to be modified.
const SCENE: &str = r#"(
    name: "flow",
    spacing: 0.1,
    bodies: [(shape: Box(min: (0, 0, 0), max: (1, 0.5, 1)))],
    emitters: [
        (shape: Disc(center: (0.5, 1.5, 0.5), normal: (0, -1, 0), radius: 0.2), speed: 1),
        (shape: Rectangle(center: (1.5, 1.5, 0.5), normal: (0, -1, 0), width: 0.4, height: 0.4), speed: 1),
    ],
    boundaries: [Tank(min: (0, 0, 0), max: (2, 2, 1))],
    domain: (min: (-1, -1, -1), max: (3, 3, 3)),
    time_step: Fixed(0.001),
    duration: 1,
)"#;

/// The same in 2-D.
const FLAT: &str = r#"(
    name: "flow", dimension: 2,
    spacing: 0.1,
    emitters: [
        (shape: Rectangle(center: (0.5, 1.5, 0), normal: (0, -1, 0), width: 0.4), speed: 1),
    ],
    bodies: [],
    duration: 1,
)"#;

/// A scene, a part of it, its replacement, the place of the error, parts of the message.
type Case<'a> = (&'a str, &'a str, String, &'a str, &'a [&'a str]);

#[test]
fn flow_that_cannot_be_is_refused() {
    for text in [SCENE, FLAT] {
        Scene::parse(text, "s.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
    }
    let disc = "normal: (0, -1, 0), radius: 0.2), speed: 1";
    let disc_with = |more: &str| format!("{disc}, {more}");
    let width = "width: 0.4, height: 0.4";
    #[rustfmt::skip]
    let cases: &[Case] = &[
        (SCENE, disc, disc.replace("speed: 1", "speed: 0"), "6:88", &["the speed is 0 m/s", "above 0"]),
        (SCENE, disc, disc.replace("speed: 1", "speed: -2"), "6:88", &["the speed is -2 m/s"]),
        (SCENE, disc, disc.replace("speed: 1", "speed: NaN"), "6:88", &["NaN", "finite"]),
        (SCENE, disc, disc.replace("speed: 1", "speed: 200"), "11:16", &["2.000e-1 m in a step", "`Cfl()`"]),
        (SCENE, disc, disc.replace("(0, -1, 0)", "(0, 0, 0)"), "6:55", &["the normal is zero"]),
        (SCENE, disc, disc.replace("0.2", "0"), "6:75", &["the radius is 0 m"]),
        (SCENE, disc, disc.replace("0.2", "0.01"), "6:17", &["too small for a particle", "0.05 m"]),
        (SCENE, disc, disc.replace("0.2", "1e6"), "6:17", &["a layer holds", "at most"]),
        (SCENE, disc, disc_with("start: -1"), "6:98", &["must not be before 0"]),
        (SCENE, disc, disc_with("start: 2, end: 1"), "6:106", &["enters at 1 s", "`end` must be above `start`"]),
        (SCENE, disc, disc_with("end: 0.001"), "6:96", &["not one layer"]),
        (SCENE, disc, disc_with("limit: 0"), "6:98", &["at most 0 particles", "the least is 1"]),
        (SCENE, disc, disc_with("jitter: (amplitude: 0.5)"), "6:111", &["the jitter is 0.5", "below 0.5"]),
        (SCENE, width, "width: 0.4".to_owned(), "7:17", &["a height, too"]),
        (SCENE, width, "width: 0, height: 0.4".to_owned(), "7:79", &["the width is 0 m"]),
        (SCENE, width, "width: 0.4, height: -1".to_owned(), "7:92", &["the height is -1 m"]),
        (SCENE, width, format!("{width}, up: (0, 1, 0)"), "7:101", &["along the normal"]),
        (FLAT, "width: 0.4", "width: 0.4, height: 1".to_owned(), "5:90", &["a segment", "leave `height` out"]),
        (FLAT, "width: 0.4", "width: 0.4, up: (0, 1, 0)".to_owned(), "5:86", &["leave `up` out"]),
        (FLAT, "(0, -1, 0)", "(0, -1, 1)".to_owned(), "5:58", &["2-D scene", "write 0"]),
        (FLAT, "(0.5, 1.5, 0)", "(0.5, 1.5, 1)".to_owned(), "5:35", &["2-D scene", "write 0"]),
        // Places.
        (SCENE, "(0.5, 1.5, 0.5)", "(0.5, 0.4, 0.5)".to_owned(), "6:17", &["overlaps the fluid of `bodies.0`"]),
        (SCENE, "(0.5, 1.5, 0.5)", "(0.1, 1.5, 0.5)".to_owned(), "6:17", &["sticks out of the tank", "−x side"]),
        (SCENE, "(0.5, 1.5, 0.5)", "(0.5, 1.9, 0.5)".to_owned(), "6:17", &["sticks out of the tank", "+y side"]),
        (SCENE, "(0.5, 1.5, 0.5)", "(0.5, 2.9, 0.5)".to_owned(), "6:17", &["out of the domain", "+y side"]),
        (SCENE, "(0.5, 1.5, 0.5)", "(1.4, 1.5, 0.5)".to_owned(), "7:17", &["overlaps that of `emitters.0`"]),
        (SCENE, "max: (2, 2, 1))", "max: (2, 2, 1)), Sphere(center: (0.5, 1.8, 0.5), radius: 0.1)".to_owned(), "6:17",
            &["overlaps the solid sphere `boundaries.1`", "make room behind it"]),
        (SCENE, "max: (2, 2, 1))", "max: (2, 2, 1)), Plane(center: (0.5, 1.6, 0.5), normal: (0, -1, 0), half_size: 1)"
            .to_owned(), "6:17", &["overlaps the plane"]),
        // Outflow.
        (SCENE, "duration: 1", "outflow: [(min: (0, 1.4, 0), max: (1, 2, 1))]".to_owned(), "6:17",
            &["in the box `outflow.0`"]),
        (SCENE, "duration: 1", "outflow: [(min: (0, 0, 0), max: (1, 0, 1))]".to_owned(), "12:37",
            &["`max` must be above"]),
        (SCENE, "duration: 1", "outflow: [Box(min: (0, 0, 0), max: (1, 1, 1))]".to_owned(), "12:",
            &["fields min, max"]),
        (FLAT, "duration: 1", "outside: Remove".to_owned(), "8:14", &["without a `domain`"]),
        (SCENE, "duration: 1", "outside: Delete".to_owned(), "12:14", &["Stop, Remove"]),
        (FLAT, "duration: 1", "duration: 1e9".to_owned(), "4:15", &["million particles", "`limit`"]),
        (FLAT, "emitters", "emiters".to_owned(), "4:5", &["did you mean `emitters`?"]),
    ];
    all_are_refused(cases);
}

#[test]
fn flow_that_meets_a_wall_or_an_image_is_refused() {
    let round = "periodic: (x: (1, 3))";
    #[rustfmt::skip]
    let cases: &[Case] = &[
        // Before the face.
        (SCENE, "max: (2, 2, 1))", "max: (2, 2, 1)), Box(min: (0.2, 1, 0), max: (0.8, 1.45, 1))".to_owned(), "6:17",
            &["meets the solid box `boundaries.1` right before the face"]),
        (SCENE, "(0.5, 1.5, 0.5), normal: (0, -1, 0)", "(0.5, 1.5, 0.95), normal: (0, 0, 1)".to_owned(), "6:17",
            &["meets the tank `boundaries.0` right before the face", "+z side"]),
        // Images along a periodic axis.
        (FLAT, "bodies: []", "periodic: (x: (1, 3)), bodies: [(shape: Box(min: (2.3, 1.5, 0), max: (2.7, 2, 0)))]"
            .to_owned(), "5:17", &["overlaps the fluid of `bodies.0`"]),
        (FLAT, "bodies: []", format!("{round}, boundaries: [Box(min: (2.3, 1.7, 0), max: (2.7, 2, 0))], bodies: []"),
            "5:17", &["overlaps the solid box `boundaries.0`"]),
        (FLAT, "bodies: []", format!("{round}, boundaries: [Box(min: (2.3, 1, 0), max: (2.7, 1.46, 0))], bodies: []"),
            "5:17", &["meets the solid box `boundaries.0`"]),
        (FLAT, "bodies: []", "periodic: (x: (1, 3)), outflow: [(min: (2.3, 1.5, 0), max: (2.7, 2, 0))], bodies: []"
            .to_owned(), "5:17", &["in the box `outflow.0`"]),
        (FLAT, "width: 0.4), speed: 1),", format!("width: 0.4), speed: 1),\n(shape: Disc(center: (2.6, 1.5, 0), \
            normal: (0, -1, 0), radius: 0.2), speed: 1)], {round}, outflow: ["), "6:9",
            &["overlaps that of `emitters.0`"]),
        (FLAT, "width: 0.4), speed: 1),", format!("width: 2.04), speed: 1)], {round}, outflow: ["), "5:17",
            &["overlaps its own image"]),
        (FLAT, "bodies: []", "periodic: (x: (0, 1e5)), bodies: []".to_owned(), "7:",
            &["it reaches x = 1.0", "1/100 of the spacing"]),
    ];
    all_are_refused(cases);
}

fn all_are_refused(cases: &[Case]) {
    let mut wrong = Vec::new();
    for (text, part, instead, place, message) in cases {
        assert!(text.contains(part), "{part}");
        let error = refusal(&text.replacen(part, instead, 1));
        let right_place = error.starts_with(&format!("s.ron:{place}"));
        if !right_place || !message.iter().all(|fragment| error.contains(fragment)) {
            wrong.push(format!(
                "{instead}: expected {place} and {message:?}, got {error}"
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Two emitters may follow each other in one place; faces may touch fluid and each other.
#[test]
fn emitters_that_do_not_meet_are_accepted() {
    let scene = |emitters: &str| {
        let text = format!(
            "(name: \"t\", dimension: 2, spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))],
            emitters: [{emitters}])"
        );
        Scene::parse(&text, "t.ron", &[])
    };
    let at = |x: f32, y: f32, more: &str| {
        format!(
            "(shape: Rectangle(center: ({x}, {y}, 0), normal: (0, -1, 0), width: 0.4), speed: 1{more})"
        )
    };
    for emitters in [
        at(0.5, 1.0, ""),
        format!("{}, {}", at(0.2, 1.5, ""), at(0.6, 1.5, "")),
        format!(
            "{}, {}",
            at(0.2, 1.5, ", end: 1"),
            at(0.3, 1.5, ", start: 1")
        ),
    ] {
        scene(&emitters).unwrap_or_else(|error| panic!("{emitters}: {error}"));
    }
    // A face as long as the period has no ends, and one on a face of the period is whole.
    for (face, more) in [
        ((0.5, 2.0, 1.0), ""),
        ((0.0, 1.5, 0.4), ""),
        (
            (3.0, 1.5, 0.4),
            "boundaries: [Tank(min: (0, 0, 0), max: (1, 2, 0))],",
        ),
    ] {
        let (x, y, width) = face;
        let text = format!(
            "(name: \"t\", dimension: 2, spacing: 0.1, periodic: (x: (0, 1)), {more}
            bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))],
            emitters: [(shape: Rectangle(center: ({x}, {y}, 0), normal: (0, -1, 0), width: {width}), speed: 1)])"
        );
        Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{text}: {error}"));
    }
    let both = format!(
        "{}, {}",
        at(0.2, 1.5, ", end: 1"),
        at(0.3, 1.5, ", start: 0.9")
    );
    assert!(scene(&both).is_err());
}
