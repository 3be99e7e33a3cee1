//! Bodies that files make, bodies that boundaries cut, and ground.

use std::path::Path;

use glam::{DVec3, Vec3};
use overfall::{
    Simulation,
    filling::fluid_particles,
    output::Frame,
    sampling::sample,
    scene::{
        BoundaryShape, FileShape, FluidBody, FrameFormat, Heights, Scene, Shape, TerrainBoundary,
    },
};

use super::errors::refusal;

/// A closed box of quads \[m], as OBJ.
fn block(low: [f32; 3], high: [f32; 3], without: usize) -> String {
    let mut text = String::new();
    for k in 0..8 {
        let at = [0, 1, 2].map(|axis| [low, high][k >> axis & 1][axis]);
        text += &format!("v {} {} {}\n", at[0], at[1], at[2]);
    }
    let faces = [
        "1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6",
    ];
    for face in &faces[without..] {
        text += &format!("f {face}\n");
    }
    text
}

fn body(shape: Shape) -> Scene {
    Scene {
        bodies: vec![FluidBody::new(shape)],
        ..Scene::new("file", 0.05)
    }
}

fn written(folder: &Path, name: &str, text: &str) -> FileShape {
    let file = folder.join(name);
    std::fs::write(&file, text).expect("a file");
    FileShape::new(file.display().to_string())
}

/// A mesh of a box holds the particles of the box, scaled, moved and turned.
#[test]
fn a_block_of_triangles_is_filled_as_a_box_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = written(
        folder.path(),
        "b.obj",
        &block([0.0; 3], [400.0, 300.0, 200.0], 0),
    );
    let file = FileShape {
        scale: 1e-3,
        translation: DVec3::new(0.1, 0.2, 0.3),
        ..file
    };
    let mut scene = body(Shape::Mesh(file));
    scene.check().unwrap_or_else(|error| panic!("{error}"));
    let found = fluid_particles(&scene);
    let same = body(Shape::cuboid([0.1, 0.2, 0.3], [0.5, 0.5, 0.5]));
    let expected = fluid_particles(&same);
    assert_eq!(found.len(), 8 * 6 * 4);
    for (a, b) in found.iter().zip(&expected) {
        assert!(a.position.distance(b.position) < 1e-6);
    }
    // About the file's origin, which is at (0.1, 0.2, 0.3).
    scene.bodies[0].rotation = DVec3::new(0.0, 90.0, 0.0);
    scene.check().unwrap_or_else(|error| panic!("{error}"));
    let turned = fluid_particles(&scene);
    for (a, b) in turned.iter().zip(&expected) {
        let from = b.position - Vec3::new(0.1, 0.2, 0.3);
        let wanted = Vec3::new(0.1, 0.2, 0.3) + Vec3::new(from.z, from.y, -from.x);
        assert!(a.position.distance(wanted) < 1e-6);
    }
    let plan = overfall::plan(&scene).expect("a plan");
    assert_eq!(plan.particles, 192);
    assert!(
        plan.start_density
            .is_some_and(|start| start.max_error < 1e-3)
    );
}

#[test]
fn a_hollow_body_is_hollow_and_one_that_is_not_closed_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let outer = block([0.0; 3], [0.8; 3], 0);
    // The cavity is wound the other way, and its faces count from vertex 9.
    let mut cavity = String::new();
    for line in block([0.2; 3], [0.6; 3], 0).lines() {
        cavity += &match line.strip_prefix("f ") {
            None => format!("{line}\n"),
            Some(rest) => {
                let rows = rest
                    .split(' ')
                    .rev()
                    .map(|row| row.parse::<u32>().expect("a row"));
                let rows: Vec<String> = rows.map(|row| (row + 8).to_string()).collect();
                format!("f {}\n", rows.join(" "))
            }
        };
    }
    let hollow = body(Shape::Mesh(written(
        folder.path(),
        "h.obj",
        &(outer + &cavity),
    )));
    hollow.check().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(fluid_particles(&hollow).len(), 16 * 16 * 16 - 8 * 8 * 8);

    let open = body(Shape::Mesh(written(
        folder.path(),
        "o.obj",
        &block([0.0; 3], [0.8; 3], 1),
    )));
    let error = open.check().expect_err("open").to_string();
    assert!(
        error.contains("bodies.0.shape.file") && error.contains("is not closed"),
        "{error}"
    );
    let absent = body(Shape::Mesh(FileShape::new("/there/is/none.obj")));
    let error = absent.check().expect_err("absent").to_string();
    assert!(error.contains("none.obj"), "{error}");
    let huge = FileShape {
        scale: 1e5,
        ..written(folder.path(), "b.obj", &block([0.0; 3], [0.8; 3], 0))
    };
    let error = body(Shape::Mesh(huge))
        .check()
        .expect_err("huge")
        .to_string();
    assert!(error.contains("million rows"), "{error}");
    let flat = format!(
        "(name: \"t\", dimension: 2, spacing: 0.1, bodies: [(shape: Mesh(file: {:?}))])",
        folder.path().join("b.obj")
    );
    assert!(refusal(&flat).contains("a mesh needs `dimension: 3`"));
}

/// A run's frame is where a next run starts: positions and velocities are the same to the last bit, in both formats.
#[test]
fn a_frame_is_a_body() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut scene = body(Shape::cuboid([0.0; 3], [0.3, 0.4, 0.2]));
    scene.bodies[0].velocity = Vec3::new(0.3, 0.1, -0.2);
    let mut simulation = Simulation::with_threads(&scene, 1).expect("a start");
    for _ in 0..5 {
        simulation.step().expect("a step");
    }
    let frame = Frame::from_world(simulation.world_mut());
    for format in [FrameFormat::Ply, FrameFormat::Vtu] {
        let path = folder.path().join(format!("f.{}", format.extension()));
        frame.write(&path, format).expect("a file");
        let again = body(Shape::Particles(FileShape::new(path.display().to_string())));
        again.check().unwrap_or_else(|error| panic!("{error}"));
        assert!((again.max_initial_speed() - frame.max_speed()).abs() < 1e-5);
        let seeds = fluid_particles(&again);
        assert_eq!(seeds.len(), frame.positions.len());
        for (seed, (x, v)) in seeds
            .iter()
            .zip(frame.positions.iter().zip(&frame.velocities))
        {
            assert_eq!((seed.position, seed.velocity), (*x, *v));
        }
        let mut simulation = Simulation::with_threads(&again, 1).expect("a start");
        simulation.step().expect("a step");
    }
    let file = folder.path().join("f.ply").display().to_string();
    let flat = format!(
        "(name: \"t\", dimension: 2, spacing: 0.05, bodies: [(shape: Particles(file: {file:?}))])"
    );
    assert!(refusal(&flat).contains("must have z = 0"));
}

/// What a boundary has no room for is left out, and nothing else; without `cut` the scene is refused.
#[test]
fn a_body_that_is_cut_keeps_all_that_there_is_room_for() {
    let ball = (Vec3::new(0.4, 0.35, 0.4), 0.25_f32);
    for walls in [
        vec![BoundaryShape::sphere(ball.0, ball.1)],
        vec![BoundaryShape::cuboid([0.1, 0.1, 0.1], [0.3, 0.5, 0.6]).turned([0.0, 30.0, 10.0])],
    ] {
        let mut scene = body(Shape::cuboid([0.0; 3], [0.8; 3]));
        scene.boundaries = walls;
        let error = scene.check().expect_err("it overlaps").to_string();
        assert!(error.contains("overlaps the solid"), "{error}");
        scene.bodies[0].cut = true;
        scene.check().unwrap_or_else(|error| panic!("{error}"));
        let found = fluid_particles(&scene);
        assert!(found.len() < 4096 - 200, "{}", found.len());
        if let BoundaryShape::Sphere { center, radius, .. } = scene.boundaries[0] {
            let all = fluid_particles(&body(Shape::cuboid([0.0; 3], [0.8; 3])));
            let room = |x: Vec3| x.distance(center) - radius >= 0.4985 * 0.05;
            let expected = all.iter().filter(|seed| room(seed.position)).count();
            assert_eq!(found.len(), expected);
        }
        Simulation::with_threads(&scene, 1)
            .expect("a start")
            .step()
            .expect("a step");
    }
    let mut scene = body(Shape::cuboid([0.0; 3], [0.2; 3]));
    scene.bodies[0].cut = true;
    scene.boundaries = vec![BoundaryShape::sphere([0.1; 3], 0.5)];
    let error = scene.check().expect_err("nothing is left").to_string();
    assert!(error.contains("boundaries leave no room"), "{error}");
}

/// Ground of every kind lies where its file or formula says, solid below, with normals upwards.
#[test]
fn ground_is_where_its_heights_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let grid = folder.path().join("g.csv");
    std::fs::write(&grid, "0,0.1,0.2\n0,0.1,0.2\n").expect("a file");
    let grid = Heights::Grid {
        file: grid.display().to_string(),
        scale: 2.0,
    };
    let image = folder.path().join("g.png");
    let mut encoder = png::Encoder::new(std::fs::File::create(&image).expect("a file"), 3, 2);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().expect("a header");
    writer
        .write_image_data(&[0, 50, 100, 0, 50, 100])
        .expect("data");
    writer.finish().expect("an end");
    let image = Heights::Image {
        file: image.display().to_string(),
        black: 0.0,
        white: 1.02,
    };
    for heights in [grid, image] {
        let mut scene = body(Shape::cuboid([-0.3, 0.5, -0.3], [0.3, 0.8, 0.3]));
        let terrain = TerrainBoundary {
            translation: DVec3::new(0.0, 0.1, 0.0),
            ..TerrainBoundary::new(heights, [2.0, 1.0])
        };
        scene.boundaries = vec![BoundaryShape::Terrain(terrain)];
        scene.check().unwrap_or_else(|error| panic!("{error}"));
        let samples = sample(&scene).expect("samples");
        let area = 2.0 * 1.02_f64.sqrt() / 0.0025;
        assert!(
            (samples.len() as f64 / area - 1.0).abs() < 0.12,
            "{} for {area}",
            samples.len()
        );
        let slope = Vec3::new(-0.2, 1.0, 0.0).normalize();
        for sample in &samples {
            assert!(sample.normal.distance(slope) < 1e-5);
            let height = 0.1 + 0.2 * (sample.position.x + 1.0);
            let depth = (height - sample.position.y) * slope.y;
            assert!((0.4..0.8).contains(&(depth / 0.05)), "{depth}");
        }
        // Fluid below it is in the solid, however deep; fluid beside it is not.
        scene.bodies[0].shape = Shape::cuboid([-0.3, -9.0, -0.3], [0.3, -8.7, 0.3]);
        let error = scene.check().expect_err("below").to_string();
        assert!(error.contains("overlaps the ground"), "{error}");
        scene.bodies[0].shape = Shape::cuboid([3.0, -9.0, -0.3], [3.3, -8.7, 0.3]);
        scene.check().unwrap_or_else(|error| panic!("{error}"));
    }
    for (terrain, expected) in [
        (
            "size: (0, 1), heights: Generated(cell: 1)",
            "both edges must be above 0",
        ),
        ("size: (1, 1), heights: Generated(cell: 0)", "above 0"),
        (
            "size: (1, 1), heights: Generated(cell: 1, octaves: 90)",
            "at most 16",
        ),
        ("size: (9e3, 9e3), heights: Generated(cell: 1)", "would do"),
        (
            "size: (1, 1), heights: Generated(cell: 1, channel: (depth: 1, width: 0))",
            "above 0",
        ),
        (
            "size: (1, 1), heights: Grid(file: \"none.csv\")",
            "none.csv",
        ),
    ] {
        let text = format!(
            "(name: \"t\", spacing: 0.05, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))], \
             boundaries: [Terrain({terrain})])"
        );
        let error = refusal(&text);
        assert!(error.contains(expected), "{error}");
    }
    let flat = "(name: \"t\", dimension: 2, spacing: 0.05, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))], \
                boundaries: [Terrain(size: (1, 1), heights: Generated(cell: 1))])";
    assert!(refusal(flat).contains("a terrain needs `dimension: 3`"));
}

/// Files whose particles lie in one place, or within a spacing that is another one, are refused before their pairs are
/// summed; others are not.
#[test]
fn files_whose_particles_lie_in_one_place_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (apart, count, is_right) in [
        (0.0_f64, 70_000, false),
        (1e-6, 1000, false),
        (0.05, 1000, true),
        (0.01, 1000, false),
    ] {
        let mut text = "x,y,z\n".to_owned();
        for k in 0..count {
            let place = [k % 10, k / 10 % 10, k / 100].map(|k| apart * f64::from(k));
            text += &format!("{},{},{}\n", place[0], place[1], place[2]);
        }
        let file = written(folder.path(), "particles.csv", &text);
        match body(Shape::Particles(file)).check() {
            Ok(()) => assert!(is_right, "{apart}"),
            Err(error) => {
                let said = error.to_string();
                assert!(
                    !is_right && said.contains("lie within a spacing"),
                    "{apart}: {said}"
                );
            }
        }
    }
}
