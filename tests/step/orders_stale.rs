//! Orders in which some stages run only every few steps, so that others use stale products.

use super::orders::{STAGES, ordered, unordered};
use crate::common::{self, bits_after, run, sesph, simulation};
use glam::Vec3;
use overfall::{
    Simulation,
    neighbours::FluidNeighbours,
    plan,
    scene::{Iisph, PressureMethod, Scene},
    state::{
        Positions,
        particle::{Fluid, Position},
    },
    step::Product,
};

/// As [`ordered`], with lists that are found every few steps and rows that are not reordered.
fn with_stale_lists(every: u32) -> (Scene, tempfile::TempDir) {
    let stages = STAGES.replace(
        r#"Run("find_neighbours")"#,
        &format!(r#"Every({every}, [Run("find_neighbours")])"#),
    );
    let stages = stages.replace(r#", Run("reorder")"#, "");
    ordered(&format!(
        "(stages: [{stages}], allow_stale: true, leave_out: [\"reorder\"])"
    ))
}

#[test]
fn stale_neighbours_are_kept_between_the_steps_that_find_them() {
    let (scene, _folder) = with_stale_lists(2);
    let mut simulation = simulation(&scene);
    let mut pairs = Vec::new();
    for _ in 0..40 {
        run(&mut simulation, 1);
        let lists = simulation.world().resource::<FluidNeighbours>().lists();
        let rows = common::DAM_PARTICLES;
        pairs.push(
            (0..rows)
                .map(|row| lists.of(row).to_vec())
                .collect::<Vec<_>>(),
        );
    }
    for step in (0..40).step_by(2) {
        assert!(pairs[step] == pairs[step + 1], "step {}", step + 2);
    }
    assert!(pairs[0] != pairs[38], "nothing moved");
    let planned = plan(&scene).expect("a plan").phases;
    let lines: Vec<_> = planned.into_iter().flat_map(|(_, lines)| lines).collect();
    assert!(lines.contains(&"every 2 steps: find_neighbours".to_owned()));
}

#[test]
fn particles_may_come_and_go_while_neighbours_are_stale() {
    let stages = STAGES.replace(
        r#"Run("find_neighbours")"#,
        r#"Every(4, [Run("find_neighbours")])"#,
    );
    let (scene, _folder) = ordered(&format!("(stages: [{stages}], allow_stale: true)"));
    for change in 0..3 {
        let mut simulation = simulation(&scene);
        run(&mut simulation, 1);
        let world = simulation.world_mut();
        let particles = common::state(world);
        match change {
            0 => {
                world.spawn((Fluid, Position(Vec3::new(0.3, 0.3, 0.1))));
            }
            1 => {
                world.despawn(particles[common::DAM_PARTICLES - 1].0);
            }
            // The last row takes the place of the first, which is in the lists of other rows.
            _ => {
                world.despawn(particles[0].0);
            }
        }
        run(&mut simulation, 1);
        // The rows hold other particles, so lists are found again although they are not due.
        let world = simulation.world();
        let (lists, positions) = (
            world.resource::<FluidNeighbours>(),
            world.resource::<Positions>(),
        );
        let h = scene.support_radius();
        for row in 0..positions.rows() {
            for &other in lists.lists().of(row) {
                let distance = positions.points()[row].distance(positions.points()[other as usize]);
                assert!(distance < 1.5 * h, "{row} and {other}: {distance}");
            }
        }
        run(&mut simulation, 4);
    }
}

/// A drop in free fall for 0.1 s under an order with these stages: distance fallen \[m].
fn fall(stages: &str) -> f32 {
    let (ordered, _folder) = ordered(&format!(
        "(stages: [{stages}], allow_stale: true, leave_out: [\"reorder\"])"
    ));
    let scene = Scene::parse(
        "(name: \"fall\", spacing: 0.05, bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.3, 0.3)))],
          time_step: Fixed(0.001), reorder_interval: 50, pressure: Sesph(equation: Gas(stiffness: 1)))",
        "fall.ron",
        &[],
    );
    let scene = Scene {
        order: ordered.order.clone(),
        ..scene.expect("a scene")
    };
    let mut simulation = simulation(&scene);
    let height = |simulation: &mut Simulation| {
        let mut places = simulation.world_mut().query::<&Position>();
        let heights: Vec<f32> = places.iter(simulation.world()).map(|x| x.0.y).collect();
        heights.iter().sum::<f32>() / heights.len() as f32
    };
    let before = height(&mut simulation);
    run(&mut simulation, 100);
    before - height(&mut simulation)
}

#[test]
fn an_index_that_is_stale_slows_nothing_down() {
    let stages = STAGES.replace(r#", Run("reorder")"#, "");
    for stale in [
        stages.clone(),
        stages.replace(
            r#"Run("rebuild_index")"#,
            r#"Every(2, [Run("rebuild_index")])"#,
        ),
        stages.replace(
            r#"Run("rebuild_index"), Run("find_neighbours")"#,
            r#"Every(5, [Run("rebuild_index"), Run("find_neighbours")])"#,
        ),
    ] {
        let fallen = fall(&stale);
        // Semi-implicit Euler: g dt² n (n + 1)/2.
        assert!(
            (fallen - 9.81e-6 * 5050.0).abs() < 1e-5,
            "{stale}: {fallen} m"
        );
    }
}

#[test]
fn the_flow_of_data_says_what_is_stale() {
    let (scene, _folder) = with_stale_lists(5);
    let flow = plan(&scene).expect("a plan").flow;
    let of = |name: &str| {
        let found = flow.iter().find(|flow| flow.stage == name);
        found.unwrap_or_else(|| panic!("no {name} in {flow:?}"))
    };
    assert_eq!(of("find_neighbours").every, 5);
    assert_eq!(of("find_neighbours").writes, [Product::Neighbours]);
    assert!(of("density").reads.contains(&(Product::Neighbours, 4)));
    assert!(of("density").reads.contains(&(Product::Columns, 0)));
    assert_eq!(of("density").writes, [Product::Density]);
}

fn shipped(order: &str, pressure: PressureMethod) -> Scene {
    let orders = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/orders");
    Scene {
        pressure,
        order: Some(format!("{orders}/{order}.ron")),
        reorder_interval: 0,
        ..unordered()
    }
}

/// What a stage reads is as old as the last stage that makes it, wherever in the step that is.
#[test]
fn what_ends_a_step_is_one_step_old_in_the_next() {
    for (order, stage, product) in [
        ("integration_first", "integrate", Product::Pressure),
        ("density_after_forces", "viscosity", Product::Density),
    ] {
        let flow = plan(&shipped(order, sesph())).expect("a plan").flow;
        let reads = flow.iter().find(|flow| flow.stage == stage);
        let reads = &reads.expect("the stage").reads;
        assert!(reads.contains(&(product, 1)), "{order}: {reads:?}");
    }
}

/// The default order, begun elsewhere in its cycle: the same motion, unless a solve starts from pressures, which are
/// those of the first step then.
#[test]
fn integration_may_come_first_and_moves_the_fluid_alike() {
    let methods = [
        (sesph(), true),
        (
            PressureMethod::Iisph(Iisph {
                warm_start: 0.0,
                ..Iisph::default()
            }),
            true,
        ),
        (PressureMethod::Iisph(Iisph::default()), false),
    ];
    for (method, is_same) in methods {
        let [first, last] = ["integration_first", "default"].map(|order| {
            let scene = shipped(order, method);
            bits_after(&scene, 2, 25)
        });
        assert_eq!(first == last, is_same, "{method:?}");
    }
}
