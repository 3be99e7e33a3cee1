//! Bodies and boundaries that are turned: they are where a rotation puts them, and physics does not mind.

use glam::{DQuat, DVec3, Vec3};
use overfall::{
    Simulation,
    filling::fluid_particles,
    output::Frame,
    sampling::sample,
    scene::{BoundaryShape, FluidBody, Scene, Shape},
};

use super::errors::refusal;

fn turned(point: DVec3, center: Vec3, angles: DVec3) -> DVec3 {
    let [x, y, z] = angles.to_array().map(f64::to_radians);
    let turn = DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x);
    center.as_dvec3() + turn * (point - center.as_dvec3())
}

/// Points of one list are those of the other, in the same order.
fn same(points: &[Vec3], expected: impl Iterator<Item = DVec3>, what: &str) {
    for (point, expected) in points.iter().zip(expected) {
        let apart = point.as_dvec3().distance(expected);
        assert!(apart < 1e-5, "{apart} at {point}: {what}");
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn every_shape_is_where_its_rotation_puts_it() {
    let center = Vec3::new(0.4, 0.7, -0.2);
    let (low, high) = (
        center - Vec3::new(0.3, 0.2, 0.4),
        center + Vec3::new(0.3, 0.2, 0.4),
    );
    let axis = Vec3::new(0.05, 0.2, 0.0);
    let shapes = [
        Shape::cuboid(low, high),
        Shape::sphere(center, 0.3),
        Shape::Cylinder {
            start: center - axis,
            end: center + axis,
            radius: 0.2,
        },
    ];
    let walls = [
        BoundaryShape::tank(low, high),
        BoundaryShape::open_tank(low, high),
        BoundaryShape::cuboid(low, high),
        BoundaryShape::sphere(center, 0.3),
        BoundaryShape::plane(center, [0.3, 1.0, 0.2], 0.4),
    ];
    for (dimension, angles) in [
        (3, DVec3::new(20.0, -35.0, 110.0)),
        (3, DVec3::new(0.0, 90.0, 0.0)),
        (3, DVec3::new(-400.0, 13.0, 1.0)),
        (2, DVec3::new(0.0, 0.0, 33.0)),
    ] {
        let flat = dimension == 2;
        let scene = |bodies: Vec<FluidBody>, boundaries: Vec<BoundaryShape>| Scene {
            bodies,
            boundaries,
            dimension: (dimension as u8).try_into().expect("a dimension"),
            ..Scene::new("turned", 0.05)
        };
        let flat_center = if flat { center.with_z(0.0) } else { center };
        for shape in &shapes {
            if flat && matches!(shape, Shape::Cylinder { .. }) {
                continue;
            }
            let shape = match shape {
                Shape::Sphere { radius, .. } => Shape::sphere(flat_center, *radius),
                other => other.clone(),
            };
            let plain = fluid_particles(&scene(vec![FluidBody::new(shape.clone())], Vec::new()));
            let body = FluidBody::new(shape).turned(angles);
            let what = format!("{body:?}");
            let found = fluid_particles(&scene(vec![body], Vec::new()));
            assert!(found.len() == plain.len() && found.len() > 30, "{what}");
            let found: Vec<Vec3> = found.iter().map(|seed| seed.position).collect();
            let expected = plain.iter().map(|seed| seed.position.as_dvec3());
            same(
                &found,
                expected.map(|x| turned(x, flat_center, angles)),
                &what,
            );
        }
        for wall in &walls {
            if flat
                && matches!(
                    wall,
                    BoundaryShape::Plane { .. } | BoundaryShape::Sphere { .. }
                )
            {
                continue;
            }
            let body = vec![FluidBody::new(Shape::sphere([9.0, 9.0, 0.0], 0.2))];
            let plain = sample(&scene(body.clone(), vec![wall.clone()])).expect("samples");
            let wall = wall.clone().turned(angles);
            let what = format!("{wall:?}");
            let found = sample(&scene(body, vec![wall])).expect("samples");
            assert!(found.len() == plain.len() && found.len() > 20, "{what}");
            let positions: Vec<Vec3> = found.iter().map(|sample| sample.position).collect();
            let expected = plain.iter().map(|sample| sample.position.as_dvec3());
            same(
                &positions,
                expected.map(|x| turned(x, flat_center, angles)),
                &what,
            );
            let normals: Vec<Vec3> = found.iter().map(|sample| sample.normal).collect();
            let expected = plain.iter().map(|sample| sample.normal.as_dvec3());
            same(
                &normals,
                expected.map(|x| turned(x, Vec3::ZERO, angles)),
                &what,
            );
        }
    }
}

/// A tank with fluid and an obstacle that are turned together, in gravity that is turned with them, does what the same
/// does upright: the lattice of the search and the axes of the boxes are nothing to physics.
#[test]
fn what_is_turned_with_gravity_moves_as_it_did_upright() {
    for (dimension, angles, steps) in [
        (2, DVec3::new(0.0, 0.0, 27.0), 60),
        (3, DVec3::new(25.0, -40.0, 70.0), 40),
    ] {
        let scene = |angles: DVec3| {
            // All centres are the origin's: a common rotation turns each about its own.
            let depth = if dimension == 2 { 0.0 } else { 0.2 };
            let around = |x: f32, y: f32| Vec3::new(x, y, depth * 1.5);
            let body = Shape::cuboid(-around(0.3, 0.2), around(0.3, 0.2));
            let gravity = turned(DVec3::new(3.0, -9.0, 0.0), Vec3::ZERO, angles);
            Scene {
                bodies: vec![FluidBody::new(body).turned(angles)],
                boundaries: vec![
                    BoundaryShape::tank(-around(0.6, 0.4), around(0.6, 0.4)).turned(angles),
                ],
                dimension: (dimension as u8).try_into().expect("a dimension"),
                gravity: gravity.as_vec3(),
                time_step: overfall::scene::TimeStep::Fixed(2e-3),
                ..Scene::new("turned", 0.05)
            }
        };
        let run = |scene: &Scene| {
            scene.check().unwrap_or_else(|error| panic!("{error}"));
            let mut simulation = Simulation::with_threads(scene, 2).expect("a start");
            for _ in 0..steps {
                simulation.step().expect("a step");
            }
            let frame = Frame::from_world(simulation.world_mut());
            let numbered = frame.ids.iter().zip(&frame.positions);
            let mut numbered: Vec<(u32, Vec3)> = numbered.map(|(id, x)| (*id, *x)).collect();
            numbered.sort_by_key(|(id, _)| *id);
            numbered
        };
        // Numbers follow the Z-curve of the start: each is told by its nearest.
        let (upright, tilted) = (run(&scene(DVec3::ZERO)), run(&scene(angles)));
        let upright: Vec<DVec3> = (upright.iter())
            .map(|(_, x)| turned(x.as_dvec3(), Vec3::ZERO, angles))
            .collect();
        let mut fallen = 0.0_f64;
        for (_, x) in &tilted {
            let nearest = upright.iter().map(|other| other.distance(x.as_dvec3()));
            let nearest = nearest.fold(f64::INFINITY, f64::min) / 0.05;
            assert!(nearest < 0.05, "{nearest} spacings in {dimension}-D");
            fallen = fallen.max(x.length().into());
        }
        assert!(fallen > 0.35);
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn what_a_turn_makes_wrong_is_refused() {
    let scene = |dimension: u8, body: &str, walls: &str, rest: &str| {
        format!(
            "(name: \"t\", dimension: {dimension}, spacing: 0.05, bodies: [(shape: {body})], \
             boundaries: [{walls}]{rest})"
        )
    };
    let cube = "Box(min: (0, 0, 0), max: (0.4, 0.4, 0.4))";
    let flat = "Box(min: (0, 0, 0), max: (0.4, 0.4, 0))";
    for (text, expected) in [
        (
            scene(2, &format!("{flat}, rotation: (0, 3, 0)"), "", ""),
            "3° about y in a 2-D scene",
        ),
        (
            scene(
                2,
                flat,
                "Tank(min: (0, 0, 0), max: (1, 1, 0), rotation: (1, 0, 0))",
                "",
            ),
            "1° about x",
        ),
        // It fits as it is written, and not turned; and the other way round.
        (
            scene(
                3,
                cube,
                "Tank(min: (0, 0, 0), max: (0.4, 0.4, 0.4), rotation: (0, 0, 45))",
                "",
            ),
            "sticks out of the tank `boundaries.0`",
        ),
        (
            scene(
                3,
                &format!("{cube}, rotation: (0, 0, 45)"),
                "Tank(min: (0, 0, 0), max: (0.4, 0.4, 0.4))",
                "",
            ),
            "sticks out of the tank",
        ),
        (
            scene(
                3,
                cube,
                "Box(min: (-0.7, 0.1, 0), max: (-0.02, 0.3, 0.4), rotation: (0, 0, 90))",
                "",
            ),
            "",
        ),
        (
            scene(
                3,
                cube,
                "Box(min: (0.2, 0.5, 0), max: (0.4, 0.9, 0.4), rotation: (0, 0, 90))",
                "",
            ),
            "",
        ),
        (
            scene(
                3,
                cube,
                "Box(min: (0.2, 0.45, 0), max: (0.3, 0.95, 0.4), rotation: (0, 0, 40))",
                "",
            ),
            "",
        ),
        (
            scene(
                3,
                cube,
                "Box(min: (0.42, 0, 0), max: (0.5, 1.2, 0.4), rotation: (0, 0, -30))",
                "",
            ),
            "overlaps the solid box `boundaries.0`",
        ),
        (
            scene(
                3,
                cube,
                "Plane(center: (0.2, -0.1, 0.2), normal: (0, 1, 0), half_size: 1, rotation: (0, 0, 40))",
                "",
            ),
            "overlaps the plane",
        ),
        (
            scene(
                3,
                cube,
                "Box(min: (-2, -0.5, -1), max: (2, -0.2, 1), rotation: (0, 0, 20))",
                ", periodic: (x: (0, 1))",
            ),
            "what is turned cannot go round a periodic axis",
        ),
    ] {
        match expected {
            "" => {
                Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}\n{text}"));
            }
            expected => {
                let error = refusal(&text);
                assert!(error.contains(expected), "{error}\n{text}");
            }
        }
    }
}
