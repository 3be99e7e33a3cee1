//! The shipped scenes load, and a scene needs only a short text.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use overfall::filling::fluid_particles;
use overfall::scene::{BoundaryShape, Criterion, Dimension, PressureMethod, Scene, TimeStep};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes")
}

fn load(name: &str) -> Scene {
    Scene::load(&scenes().join(format!("{name}.ron")), &[]).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn every_shipped_scene_loads_and_has_the_particles_its_comment_says() {
    let expected = BTreeMap::from([
        ("corner_dam_break_130k", 130_000),
        ("corner_dam_break_large", 1_698_728),
        ("corner_dam_break_small", 16_250),
        ("dam_break", 30_000),
        ("dam_break_2d", 3_200),
        ("dam_break_gauges", 800),
        ("drop", 13_712),
        ("gate", 1_200),
        ("glass", 0),
        ("glass_small", 0),
        ("goblet", 7_872),
        ("stability_column", 300),
        ("stability_impact", 400),
        ("still_water", 2_880),
        ("tap", 3_072),
    ]);
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(scenes()).expect("the folder of the scenes") {
        let path = entry.expect("an entry").path();
        // The folder of the meshes is beside the scenes.
        if path.is_dir() {
            continue;
        }
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        // Both are cut by their ground, and the large one takes long: see below.
        if name.starts_with("river") {
            continue;
        }
        let scene = load(&name);
        assert_eq!(scene.name, name, "a scene is named like its file");
        found.insert(name, fluid_particles(&scene).len());
    }
    let found: BTreeMap<_, _> = found.iter().map(|(name, &n)| (name.as_str(), n)).collect();
    assert_eq!(found, expected);
}

/// The river of the paper, by a tenth of its length: as much water above as much ground.
#[test]
fn the_small_river_has_the_shape_of_the_large() {
    let scene = load("river_small");
    let water = fluid_particles(&scene).len() as f32;
    let ground = overfall::sampling::sample(&scene).expect("samples").len() as f32;
    // 29 m² of water across, less half a spacing along a bed of 22 m.
    let across = water * scene.spacing.powi(3) / 37.4;
    assert!((19.0..29.0).contains(&across), "{across} m² of water");
    assert!((8_000.0..14_000.0).contains(&ground), "{ground}");
}

#[test]
fn the_corner_dam_break_is_the_papers() {
    let scene = load("corner_dam_break_130k");
    assert_eq!(scene.dimension, Dimension::Three);
    assert_eq!(scene.support_radius(), 0.04);
    assert_eq!(scene.time_step, TimeStep::Fixed(0.001));
    let PressureMethod::Pcisph(pcisph) = scene.pressure else {
        panic!("{:?}", scene.pressure)
    };
    assert_eq!(pcisph.max_density_error, 0.01);
    assert_eq!(pcisph.criterion, Criterion::Largest);
    assert_eq!(pcisph.min_iterations, 3);
}

#[test]
fn fluid_that_touches_a_wall_has_half_a_spacing_to_it() {
    for name in ["corner_dam_break_130k", "dam_break", "still_water"] {
        let scene = load(name);
        let BoundaryShape::Tank { min, .. } = scene.boundaries[0] else {
            panic!("{:?}", scene.boundaries)
        };
        let seeds = fluid_particles(&scene);
        for axis in 0..3 {
            let least = (seeds.iter().map(|seed| seed.position[axis])).fold(f32::MAX, f32::min);
            let gap = (least - min[axis]) / scene.spacing;
            assert!((gap - 0.5).abs() < 1e-4, "{name}: {gap} on axis {axis}");
        }
    }
}

#[test]
fn a_scene_in_the_plane_has_no_z() {
    let seeds = fluid_particles(&load("dam_break_2d"));
    assert!(seeds.iter().all(|seed| seed.position.z == 0.0));
}

#[test]
fn a_minimal_scene_takes_under_fifteen_lines() {
    let text = r#"(
    name: "minimal",
    spacing: 0.1,
    bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))],
    boundaries: [Tank(min: (0, 0, 0), max: (2, 2, 1))],
)"#;
    assert!(text.lines().count() < 15);
    let scene = Scene::parse(text, "minimal.ron", &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(fluid_particles(&scene).len(), 1000);
    assert_eq!(scene.fluid.rest_density, 1000.0);
}

#[test]
fn brackets_names_and_some_may_be_written_out_or_left_out() {
    let short = r#"(name: "a", spacing: 0.1, bodies: [(shape: Sphere(center: (0, 0, 0), radius: 1),
        jitter: (amplitude: 0.1))], pressure: Pcisph(max_density_error: 0.001))"#;
    let long = r#"Scene(name: "a", spacing: 0.1, bodies: [FluidBody(shape: Sphere(center: (0, 0, 0), radius: 1),
        jitter: Some(Jitter(amplitude: 0.1)))], pressure: Pcisph((max_density_error: 0.001)))"#;
    let parse = |text| Scene::parse(text, "a.ron", &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(parse(short), parse(long));
}

#[test]
fn an_order_file_is_looked_for_beside_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.ron");
    let text = "(name: \"a\", spacing: 0.1,\n order: \"mine.ron\", bodies: [(shape: Sphere(center: (0, 0, 0), radius: \
     1))])";
    std::fs::write(&path, text).expect("written");
    let error = Scene::load(&path, &[])
        .expect_err("no such order")
        .to_string();
    assert!(error.contains("a.ron:2:9: there is no file"), "{error}");

    let order = folder.path().join("mine.ron");
    std::fs::write(&order, "[]").expect("written");
    let scene = Scene::load(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.order.as_deref().map(Path::new), Some(&*order));
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = Scene::load(Path::new("no/such.ron"), &[]).expect_err("no file");
    assert!(error.to_string().starts_with("no/such.ron: "), "{error}");
}
