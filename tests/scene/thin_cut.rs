//! Bodies that boundaries cut, beside boundaries of all thicknesses: the fluid starts at its rest density.

use overfall::scene::Scene;

use crate::mesh_support::Surface;

/// Largest density error at the start of fluid around `boundary`, in a tank, at a spacing of 0.05 m; or why it is
/// refused.
fn start(dimension: u8, boundary: &str) -> Result<f32, String> {
    let (low, high) = if dimension == 2 {
        ("(-0.4, 0, 0)", "(0.4, 0.5, 0)")
    } else {
        ("(-0.4, 0, -0.4)", "(0.4, 0.5, 0.4)")
    };
    let text = format!(
        "(name: \"cut\", dimension: {dimension}, spacing: 0.05,
          bodies: [(shape: Box(min: {low}, max: {high}), cut: true)],
          boundaries: [Tank(min: {low}, max: {high}), {boundary}])"
    );
    let scene = Scene::parse(&text, "cut.ron", &[]).map_err(|error| error.to_string())?;
    let plan = overfall::plan(&scene).map_err(|error| error.to_string())?;
    Ok(plan.start_density.expect("fluid").max_error)
}

/// Thicknesses \[spacings].
const THICK: [f32; 8] = [0.1, 0.3, 0.6, 0.9, 1.1, 1.3, 1.6, 2.5];

fn assert_at_rest(dimension: u8, boundary: &str, what: &str, failed: &mut Vec<String>) {
    match start(dimension, boundary) {
        // The most is that of a wire, 0.3 spacings thick, whose samples lie in a line: 7 %.
        Ok(error) if error < 0.08 => {}
        other => failed.push(format!("{what}: {other:?}")),
    }
}

#[test]
fn fluid_that_is_cut_around_thin_surfaces_of_revolution_starts_at_rest() {
    let mut failed = Vec::new();
    for thick in [0.1, 0.3, 0.9, 1.3, 1.6] {
        let w = 0.05 * thick;
        let (out, up) = (0.2 + w, 0.1 + w);
        let profiles = [
            (
                "tube",
                format!("(0.2, 0.1), ({out}, 0.1), ({out}, 0.8), (0.2, 0.8), (0.2, 0.1)"),
            ),
            (
                "ring",
                format!("(0.2, 0.1), ({out}, 0.1), ({out}, {up}), (0.2, {up}), (0.2, 0.1)"),
            ),
            (
                "cup",
                format!("(0, 0.1), ({out}, 0.1), ({out}, 0.8), (0.2, 0.8), (0.2, {up}), (0, {up})"),
            ),
            (
                "disc",
                format!(
                    "(0, 0.2), (0.22, 0.2), (0.22, {}), (0, {})",
                    0.2 + w,
                    0.2 + w
                ),
            ),
            (
                "rod",
                format!("(0, 0.1), ({0}, 0.1), ({0}, 0.8), (0, 0.8)", 0.5 * w),
            ),
            (
                "funnel",
                format!(
                    "({w}, 0.1), (0.3, 0.4), ({}, 0.4), (0.001, 0.1), ({w}, 0.1)",
                    0.3 - w
                ),
            ),
        ];
        for (name, profile) in profiles {
            let turned = ["tube", "disc"].contains(&name).then_some("25, 10, -40");
            for angles in ["0, 0, 0"].into_iter().chain(turned) {
                let boundary = format!(
                    "Revolution(profile: [{profile}], center: (0, 0.01, 0), rotation: ({angles}))"
                );
                assert_at_rest(
                    3,
                    &boundary,
                    &format!("{name} of {thick}, {angles}"),
                    &mut failed,
                );
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn fluid_that_is_cut_around_thin_solids_starts_at_rest() {
    let mut failed = Vec::new();
    let folder = tempfile::tempdir().expect("a folder");
    for thick in THICK {
        let w = 0.5 * 0.05 * thick;
        let plate = Surface::block([-0.15, -0.15, -w].into(), [0.15, 0.15, w].into());
        let file = folder.path().join(format!("{thick}.obj"));
        std::fs::write(&file, plate.obj()).expect("a file");
        for angles in ["0, 0, 0", "20, 0, 0", "45, 30, 10"] {
            let what = |name: &str| format!("{name} of {thick}, {angles}");
            let mesh = format!(
                "Mesh(file: {file:?}, rotation: ({angles}), translation: (0.01, 0.25, 0.013))"
            );
            assert_at_rest(3, &mesh, &what("mesh"), &mut failed);
            let solid = format!(
                "Box(min: (-0.14, 0.1, {}), max: (0.16, 0.4, {w}), rotation: ({angles}))",
                -w
            );
            assert_at_rest(3, &solid, &what("box"), &mut failed);
        }
        for angle in [0, 20, 45] {
            let solid = format!(
                "Box(min: (-0.14, {}, 0), max: (0.16, {}, 0), rotation: (0, 0, {angle}))",
                0.25 - w,
                0.25 + w
            );
            assert_at_rest(
                2,
                &solid,
                &format!("2-D box of {thick}, {angle}"),
                &mut failed,
            );
        }
        for dimension in [2, 3] {
            let ball = format!("Sphere(center: (0.01, 0.24, 0), radius: {w})");
            assert_at_rest(
                dimension,
                &ball,
                &format!("{dimension}-D ball of {thick}"),
                &mut failed,
            );
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Only what is beside the thin part goes: as far away as from a thick wall, all lattice points stay.
#[test]
fn a_cut_beside_a_thick_mesh_takes_no_more_than_beside_a_box() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("block.obj");
    let block = Surface::block([-0.15, 0.1, -0.15].into(), [0.15, 0.4, 0.15].into());
    std::fs::write(&file, block.obj()).expect("a file");
    let particles = |boundary: &str| {
        let text = format!(
            "(name: \"cut\", spacing: 0.05,
              bodies: [(shape: Box(min: (-0.4, 0, -0.4), max: (0.4, 0.5, 0.4)), cut: true)],
              boundaries: [{boundary}])"
        );
        let scene = Scene::parse(&text, "cut.ron", &[]).expect("a scene");
        overfall::filling::fluid_particles(&scene).len()
    };
    let around_mesh = particles(&format!("Mesh(file: {file:?})"));
    let around_box = particles("Box(min: (-0.15, 0.1, -0.15), max: (0.15, 0.4, 0.15))");
    assert_eq!(around_mesh, around_box);
}
