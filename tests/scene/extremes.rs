//! Extreme numbers: values beyond single precision, the neighbour search or the start of a run are refused.

use overfall::scene::Scene;

/// A scene with one small body and additional text.
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
        // 0.8 of the stable step of a cubic lattice with the cubic spline, which shows 0.697 of the viscosity; both by
        // its lattice sums.
        let viscous = |nu: f32| 0.8 * 0.6971 * 0.0351 * h * h / nu;
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
                            // Where a step would be absurdly short, what causes it is the mistake.
                            !accepted
                                && error.contains(name)
                                && (error.contains("`min:")
                                    || limit < 1e-9 && error.contains("smaller")),
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
                // With such coarse coordinates a box may be impossible.
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

/// The initial density error that `check` would print, or the reason for refusing the scene.
fn start(scene: &str) -> Result<f32, String> {
    let scene = Scene::parse(scene, "s.ron", &[]).map_err(|error| error.to_string())?;
    let plan = overfall::plan(&scene).map_err(|error| error.to_string())?;
    Ok(plan.start_density.expect("few particles").max_error)
}

/// Two bodies in 2-D and 3-D with shifted lattices, and bodies beside solids of every thickness, which have one layer
/// of samples in their middle: a compressed start is refused with its depth and place, all others start at rest.
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
        // One layer of samples counts as thicker under the wider kernel of the plane.
        let thin = if dimension == 2 { 1.3 } else { 1.2 };
        for thickness in [0.1, 0.4, 0.9, 1.1, 1.25, 1.35, 1.6, 3.0] {
            let end = 0.2 + 0.02 * thickness;
            let bodies = format!("{}, {}", body(0.0, 0.0), body(end, 0.0));
            let plate = format!("Box(min: (0.2, 0, 0), max: ({end}, 0.4, {depth}))");
            ask(
                format!("{dimension}-D, plate of {thickness}"),
                scene(&bodies, &plate),
                Some(thickness > thin),
            );
            let outside = format!(
                "Tank(min: (0, 0, 0), max: (0.2, 0.2, {depth})), Tank(min: (-1, -1, -1), max: (1, 1, 1))"
            );
            let right = Some(thickness > thin);
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

/// A plate as a mesh, between two bodies of water, of every thickness and at every place of the fluid's lattice.
#[test]
fn thin_plates_of_meshes_rest_or_are_refused_with_depth_and_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("plate.obj");
    let (mut refused, mut taken) = (0, 0);
    for thickness in [0.2_f32, 0.6, 0.9, 1.1, 1.4, 2.0] {
        for shift in [0.0_f32, 0.35, 0.5] {
            let (left, right) = (0.2 + 0.02 * shift, 0.2 + 0.02 * (shift + thickness));
            let mut text = String::new();
            for k in 0..8 {
                let x = if k % 2 == 0 { left } else { right };
                let (y, z) = ([-0.05, 0.4][k / 2 % 2], [-0.05, 0.25][k / 4]);
                text += &format!("v {x} {y} {z}\n");
            }
            text += "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n";
            std::fs::write(&file, text).expect("a mesh");
            let body = |x: f32| {
                let end = x + 0.2;
                format!("(shape: Box(min: ({x}, 0, 0), max: ({end}, 0.2, 0.2)))")
            };
            let scene = format!(
                "(name: \"s\", spacing: 0.02, bodies: [{}, {}], boundaries: [Mesh(file: {file:?})])",
                body(0.0),
                body(right)
            );
            match start(&scene) {
                Ok(error) => {
                    taken += 1;
                    assert!(thickness > 0.8 && error < 0.1, "{thickness}: {error}");
                }
                Err(error) => {
                    refused += 1;
                    assert!(thickness < 1.1, "{thickness}: {error}");
                    assert!(
                        error.contains(") m") && error.contains("too near by 0."),
                        "{error}"
                    );
                }
            }
        }
    }
    assert!(refused >= 6 && taken >= 9, "{refused}, {taken}");
}

/// Bodies, solids and tanks by the thousand, most of them far from each other: the one that is wrong is found, and all
/// that is right is let through.
#[test]
fn among_many_bodies_and_solids_the_wrong_one_is_named() {
    const SIDE: usize = 40;
    let scene = |dimension: u8, spoilt: &str| {
        let (mut bodies, mut boundaries) = (Vec::new(), Vec::new());
        for k in 0..SIDE * SIDE {
            let (x, y) = ((k % SIDE) as f32, (k / SIDE) as f32);
            let depth = if dimension == 2 { 0.0 } else { 0.1 };
            bodies.push(format!(
                "(shape: Box(min: ({x}, {y}, 0), max: ({}, {}, {depth})))",
                x + 0.2,
                y + 0.2
            ));
            boundaries.push(match k % 2 {
                0 => format!(
                    "Tank(min: ({x}, {y}, 0), max: ({}, {}, {depth}), open: {})",
                    x + 0.4,
                    y + 0.2,
                    k % 4 == 0
                ),
                _ => format!("Sphere(center: ({}, {y}, 0), radius: 0.25)", x + 0.6),
            });
        }
        // Bodies beside the spheres stand in no tank.
        boundaries.push(format!(
            "Tank(min: (-1, -1, {}), max: (41, 41, {}))",
            if dimension == 2 { 0 } else { -1 },
            if dimension == 2 { 0 } else { 2 },
        ));
        let text = format!(
            "(name: \"s\", dimension: {dimension}, spacing: 0.1, bodies: [{}], boundaries: [{}])",
            bodies.join(", "),
            boundaries.join(", ")
        );
        let text = match spoilt.split_once(" => ") {
            Some((from, to)) => text.replacen(from, to, 1),
            None => text,
        };
        Scene::parse(&text, "s.ron", &[]).map_err(|error| error.to_string())
    };
    for dimension in [2, 3] {
        scene(dimension, "").unwrap_or_else(|error| panic!("{error}"));
        for (spoilt, named) in [
            (
                "min: (17, 12, 0), max: (17.2, 12.2 => min: (17, 12, 0), max: (17.2, 13.2",
                "`bodies.497`",
            ),
            (
                "center: (17.6, 12, 0) => center: (17.3, 12, 0)",
                "`boundaries.497`",
            ),
            (
                "Box(min: (16, 12, 0), max: (16.2 => Box(min: (16, 12, 0), max: (16.5",
                "`boundaries.496`",
            ),
            (
                "(0, 0, 0), max: (0.2, 0.2 => (-3, 0, 0), max: (-2.8, 0.2",
                "outside every tank",
            ),
        ] {
            let error = scene(dimension, spoilt).expect_err(spoilt);
            assert!(error.contains(named), "{spoilt}: {error}");
        }
    }
}

/// Bodies far from the origin have as many spacings as at the origin, although coordinates there are rounded to a
/// fraction of a spacing.
#[test]
fn bodies_far_away_keep_their_rows() {
    for far in [0.0, 1000.0, 4000.0, 8000.0] {
        let scene = format!(
            "(name: \"s\", spacing: 0.1, bodies: [(shape: Box(min: ({far}, 0, 0), max: ({}, 0.3, 0.3)))])",
            far + 0.3
        );
        let scene = Scene::parse(&scene, "s.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(
            overfall::filling::fluid_particles(&scene).len(),
            27,
            "{far}"
        );
    }
}

/// What repeats is told by numbers of one period: of larger ones nothing is left in single precision.
#[test]
fn numbers_of_what_repeats_are_within_what_steps_and_digits_follow() {
    let wave = |rest: &str| format!("body_forces: [Wave(amplitude: (1, 0, 0), {rest})]");
    let wall = |rest: &str| {
        format!(
            "boundaries: [Box(min: (5, 0, 0), max: (6, 1, 1), motion: Oscillation(amplitude: (0.01, 0, 0), {rest}))]"
        )
    };
    let turned = "boundaries: [Box(min: (5, 0, 0), max: (6, 1, 1), rotation: (0, 1e30, 0))]";
    let vortices = "TaylorGreen(speed: 1, wavelength: 1, origin: (1e8, 0, 0))";
    for (rest, part) in [
        (wave("frequency: 1e30"), "at most 5e7"),
        (wave("frequency: -6e7"), "at most 5e7"),
        (wave("frequency: 1, phase: 1e30"), "it repeats every 2π"),
        (wave("frequency: 1, phase: -2e4"), "it repeats every 2π"),
        (wall("frequency: 1e30"), "at most 5e7"),
        (wall("frequency: 1, phase: 1e9"), "it repeats every 2π"),
        (turned.to_owned(), "repeat every 360°"),
        (
            "gravity: (1e38, -3e38, 0)".to_owned(),
            "gravity is 3.162e38 m/s²",
        ),
        (
            wave("frequency: 1").replace("(1, 0", "(3e38, 3e38"),
            "beyond the largest number",
        ),
        (
            "output: (camera: (position: (1e30, 0, 0), target: (0, 0, 0)))".to_owned(),
            "1e9 m from the origin",
        ),
    ] {
        let error = small(0.1, &rest).expect_err(&rest);
        assert!(error.contains(part), "{rest}: {error}");
    }
    for rest in [
        wave("frequency: 5, phase: -1.5708"),
        wave("frequency: 1e6"),
        wall("frequency: 1, phase: 100"),
    ] {
        small(0.1, &rest).expect(&rest);
    }
    let body = format!(
        "(name: \"s\", dimension: 2, spacing: 0.1,
          bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)), velocity_field: {vortices})])"
    );
    let error = Scene::parse(&body, "s.ron", &[]).expect_err(&body);
    assert!(error.to_string().contains("way to the origin"), "{error}");
}
