//! Stages with another kernel than the scene's: `WithKernel` in an order.

use std::f32::consts::TAU;

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Simulation, plan,
    scene::{Cfl, KernelFunction, PressureMethod, Scene, SurfaceTension, TimeStep, Viscosity},
    state::particle::{Fluid, Position, Velocity},
    step::{Accelerations, Clock, Product, Stage, Stages},
};

use super::orders::{STAGES, ordered, unordered};
use crate::common::{self, bits_after, run, state};

const VISCOSITY: &str = r#"Run("viscosity")"#;
const TENSION: &str = r#"Run("surface_tension")"#;

/// The default order with a stage in this group.
fn within(stage: &str, kernel: &str) -> String {
    assert!(STAGES.contains(stage));
    let group = format!("WithKernel({kernel}stages: [{stage}])");
    format!("(stages: [{}])", STAGES.replace(stage, &group))
}

/// The kernel of the scene is the scene's kernel, whether an order names it or not: no bit changes, with any method,
/// any viscosity, lists or none, groups inside and outside.
#[test]
fn a_stage_with_the_kernel_of_the_scene_changes_no_bit() {
    let both = STAGES.replace(
        &format!("{VISCOSITY}, {TENSION}"),
        &format!("WithKernel(kernel: CubicSpline, stages: [Every(1, [{VISCOSITY}]), {TENSION}])"),
    );
    let sub_steps = STAGES.replace(
        VISCOSITY,
        &format!("SubSteps(1, [WithKernel(support: 2.0, stages: [{VISCOSITY}])])"),
    );
    let orders = [
        within(VISCOSITY, ""),
        within(TENSION, "kernel: CubicSpline, support: 2.0, "),
        format!("(stages: [{both}])"),
        format!("(stages: [{sub_steps}])"),
    ];
    let laminar = Viscosity::Laminar {
        kinematic_viscosity: 0.01,
        numerical: Some(0.1),
    };
    // δ-SPH has a stage more.
    for (k, pressure) in common::methods()[..4].iter().enumerate() {
        for viscosity in [unordered().fluid.viscosity, laminar] {
            let mut scene = Scene {
                pressure: *pressure,
                support: Some(2.0),
                kernel: Some(KernelFunction::CubicSpline),
                ..unordered()
            };
            scene.fluid.viscosity = viscosity;
            if k == 1 {
                scene.neighbours = overfall::scene::Neighbours::Recomputed;
            }
            let expected = bits_after(&scene, 2, 12);
            for order in &orders {
                let (ordered, _folder) = ordered(order);
                let scene = Scene {
                    order: ordered.order,
                    ..scene.clone()
                };
                assert!(
                    bits_after(&scene, 3, 12) == expected,
                    "{pressure:?}: {order}"
                );
            }
        }
    }
}

/// Accelerations by the forces of a step, noted by a stage of the host.
#[derive(Resource, Default)]
struct Noted(Vec<Vec3>);

const NOTE: Stage = Stage {
    needs: &[Product::Columns],
    wanted: |scene| scene.order.is_some(),
    install: |world, _| world.insert_resource(Noted::default()),
    ..Stage::new("note", overfall::Phase::Forces, |_| {
        let note = |mut noted: ResMut<Noted>, accelerations: Res<Accelerations>| {
            noted.0 = accelerations.to_vec();
        };
        note.into_configs()
    })
};

/// Accelerations of the tension alone \[m/s²], by row, with the kernel of a scene and that of the stage.
fn tension(kernel: KernelFunction, support: f32, of_stage: &str) -> Vec<Vec3> {
    let group = match of_stage {
        "" => TENSION.to_owned(),
        kernel => format!("WithKernel({kernel}, stages: [{TENSION}])"),
    };
    let stages = STAGES
        .replace(&format!("{VISCOSITY}, "), "")
        .replace(TENSION, &format!("{group}, Run(\"note\")"));
    let (scene, _folder) = ordered(&format!("(stages: [{stages}])"));
    let mut scene = Scene {
        kernel: Some(kernel),
        support: Some(support),
        gravity: Vec3::ZERO,
        time_step: TimeStep::Fixed(1e-6),
        reorder_interval: 0,
        ..scene
    };
    scene.fluid.viscosity = Viscosity::None;
    let mut stages = Stages::default();
    stages.register(NOTE).expect("a name");
    let mut world = World::new();
    world.insert_resource(stages);
    let mut simulation =
        Simulation::in_world(world, &scene).unwrap_or_else(|error| panic!("{error}"));
    run(&mut simulation, 1);
    std::mem::take(&mut simulation.world_mut().resource_mut::<Noted>().0)
}

/// A sum with another kernel is the sum of a scene with that kernel.
#[test]
fn the_tension_of_a_stage_is_that_of_a_scene_with_its_kernel() {
    use KernelFunction::{CubicSpline, QuinticSpline, WendlandC2};
    for (of_scene, other) in [
        ((WendlandC2, 2.4), (CubicSpline, 2.4)),
        ((CubicSpline, 2.4), (QuinticSpline, 2.4)),
        ((CubicSpline, 2.4), (CubicSpline, 1.6)),
        ((QuinticSpline, 3.0), (WendlandC2, 1.8)),
    ] {
        let alone = tension(other.0, other.1, "");
        let own = format!("kernel: {:?}, support: {:?}", other.0, other.1);
        let own = tension(of_scene.0, of_scene.1, &own);
        let largest = alone.iter().map(|a| a.length()).fold(0.0, f32::max);
        assert!(largest > 0.0 && alone.len() == own.len());
        for (a, b) in alone.iter().zip(&own) {
            // Particles beyond the smaller support are in the sum, with weight 0: it is rounded in another order.
            let tolerance = if of_scene.1 == other.1 {
                0.0
            } else {
                1e-5 * largest
            };
            assert!(
                a.distance(*b) <= tolerance,
                "{of_scene:?} {other:?}: {a} and {b}"
            );
        }
        let scenes = tension(of_scene.0, of_scene.1, "");
        assert!(
            scenes
                .iter()
                .zip(&own)
                .any(|(a, b)| a.distance(*b) > 1e-3 * largest)
        );
    }
}

/// A shear wave `v_x = sin(2π y)` in periodic space, of 40 particles a period, decays with `ν k²`: here over one step,
/// as a fraction of that rate.
fn decay(kernel: KernelFunction, support: f32, of_stage: Option<&str>) -> f64 {
    const NU: f32 = 0.01;
    let text = format!(
        "(name: \"wave\", dimension: 2, spacing: 0.025, kernel: {kernel:?}, support: {support:?},
          gravity: (0, 0, 0), fluid: (viscosity: Laminar(kinematic_viscosity: {NU}, numerical: 0)),
          bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))], periodic: (x: (0, 1), y: (0, 1)),
          time_step: Fixed(0.0001), pressure: Sesph(equation: Gas(stiffness: 1)), reorder_interval: 0)"
    );
    let mut scene = Scene::parse(&text, "wave.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
    let stages = STAGES.replace(&format!(", {TENSION}"), "");
    let group = of_stage.map(|kernel| format!("WithKernel({kernel}, stages: [{VISCOSITY}])"));
    let stages = stages.replace(VISCOSITY, group.as_deref().unwrap_or(VISCOSITY));
    let (ordered, _folder) = ordered(&format!("(stages: [{stages}])"));
    scene.order = ordered.order;
    let mut simulation = common::simulation(&scene);
    let mut fluid = simulation
        .world_mut()
        .query_filtered::<(&Position, &mut Velocity), With<Fluid>>();
    for (x, mut v) in fluid.iter_mut(simulation.world_mut()) {
        v.0 = Vec3::X * (TAU * x.0.y).sin();
    }
    let amplitude = |simulation: &mut Simulation| -> f64 {
        let all = state(simulation.world_mut());
        let of = all
            .iter()
            .map(|(_, x, v)| f64::from(v.x * (TAU * x.y).sin()));
        2.0 * of.sum::<f64>() / all.len() as f64
    };
    let before = amplitude(&mut simulation);
    run(&mut simulation, 1);
    let dt = f64::from(simulation.world().resource::<Clock>().dt);
    (1.0 - amplitude(&mut simulation) / before) / (f64::from(NU * TAU * TAU) * dt)
}

/// The viscosity is the nominal one, whatever the kernels of scene and stage are.
#[test]
fn a_shear_wave_decays_with_the_nominal_viscosity_with_every_kernel() {
    use KernelFunction::{CubicSpline, QuinticSpline, WendlandC2, WendlandC4};
    for (kernel, support) in [
        (CubicSpline, 2.0),
        (QuinticSpline, 3.0),
        (WendlandC2, 2.6),
        (WendlandC4, 3.0),
    ] {
        let alone = decay(kernel, support, None);
        let own = format!("kernel: {kernel:?}, support: {support:?}");
        let own = decay(CubicSpline, 3.0, Some(&own));
        // The wave is 40 particles long: the discrete Laplacian lacks a little.
        assert!((alone - 1.0).abs() < 0.03, "{kernel:?}: {alone}");
        assert!(
            (own - alone).abs() < 0.003,
            "{kernel:?}: {own} beside {alone}"
        );
    }
}

/// Forces of pairs stay opposite: momentum changes by rounding alone.
#[test]
fn forces_with_another_kernel_conserve_momentum() {
    let group =
        format!("WithKernel(kernel: WendlandC2, support: 1.7, stages: [{VISCOSITY}, {TENSION}])");
    let stages = STAGES.replace(&format!("{VISCOSITY}, {TENSION}"), &group);
    assert!(stages.contains("WithKernel"));
    let (scene, _folder) = ordered(&format!("(stages: [{stages}])"));
    let mut scene = Scene {
        gravity: Vec3::ZERO,
        boundaries: Vec::new(),
        ..scene
    };
    scene.fluid.surface_tension = SurfaceTension::BeckerTeschner { kappa: 0.1 };
    let mut simulation = common::simulation(&scene);
    let mut fluid = simulation
        .world_mut()
        .query_filtered::<(&Position, &mut Velocity), With<Fluid>>();
    for (x, mut v) in fluid.iter_mut(simulation.world_mut()) {
        let x = 91.0 * x.0;
        v.0 = Vec3::new((x.y + x.z).sin(), (1.3 * x.z).cos(), (x.x - x.y).sin());
    }
    let sums = |simulation: &mut Simulation| {
        let all = state(simulation.world_mut());
        let momentum: glam::DVec3 = all.iter().map(|of| of.2.as_dvec3()).sum();
        let speeds: f64 = all.iter().map(|of| f64::from(of.2.length())).sum();
        (momentum, speeds)
    };
    let (before, speeds) = sums(&mut simulation);
    run(&mut simulation, 20);
    let (after, _) = sums(&mut simulation);
    assert!(
        before.distance(after) < 1e-5 * speeds,
        "{before} {after}, speeds {speeds}"
    );
}

#[test]
fn kernels_that_make_no_sense_are_refused_with_their_place() {
    for (order, reason) in [
        (within(r#"Run("density")"#, ""), "gradient of the densities"),
        (
            within(r#"Run("pressure")"#, "support: 1.5, "),
            "gradient of the densities",
        ),
        (within(r#"Run("gravity")"#, ""), "no kernel of its own"),
        (
            within(r#"Run("find_neighbours")"#, ""),
            "no kernel of its own",
        ),
        (
            within(VISCOSITY, "support: 2.1, "),
            "within which neighbours are found",
        ),
        (within(VISCOSITY, "support: 1.1, "), "too few neighbours"),
        (within(VISCOSITY, "support: -1, "), "too few neighbours"),
        (within(VISCOSITY, "kernel: Gauss, "), "WendlandC2"),
        (
            within(VISCOSITY, "").replace(VISCOSITY, &format!("WithKernel(stages: [{VISCOSITY}])")),
            "within one `WithKernel`",
        ),
    ] {
        let (scene, _folder) = ordered(&order);
        let scene = Scene {
            kernel: Some(KernelFunction::CubicSpline),
            support: Some(2.0),
            pressure: PressureMethod::Pcisph(Default::default()),
            ..scene
        };
        let error = plan(&scene).expect_err(&order).to_string();
        assert!(
            error.contains(reason) && error.contains("order.ron:"),
            "{order}: {error}"
        );
    }
}

/// A narrower kernel needs shorter steps: they are taken, foretold, and not less than the least step.
#[test]
fn a_narrower_kernel_shortens_the_steps() {
    let scene = |kernel: &str, min: f32| {
        let (scene, folder) = ordered(&within(VISCOSITY, kernel));
        let mut scene = Scene {
            kernel: Some(KernelFunction::CubicSpline),
            support: Some(3.0),
            time_step: TimeStep::Cfl(Cfl {
                min,
                ..Cfl::default()
            }),
            ..scene
        };
        scene.fluid.viscosity = Viscosity::Laminar {
            kinematic_viscosity: 0.1,
            numerical: None,
        };
        (scene, folder)
    };
    let limits = |kernel: &str| {
        let (scene, _folder) = scene(kernel, 1e-9);
        let planned = plan(&scene).expect("a plan").time_step_limits;
        let of = |name: &str| planned.iter().find(|limit| limit.0 == name).map(|of| of.1);
        let mut simulation = common::simulation(&scene);
        run(&mut simulation, 1);
        let dt = simulation.world().resource::<Clock>().dt;
        (
            of("viscosity"),
            of("viscosity with the kernel of the order"),
            dt,
        )
    };
    let (wide, none, dt_wide) = limits("");
    let wide = wide.expect("a limit");
    assert_eq!(none, Some(wide));
    let (same, narrow, dt) = limits("support: 1.5, ");
    let narrow = narrow.expect("a limit");
    assert_eq!(same, Some(wide));
    assert!(
        narrow < 0.5 * wide && dt <= narrow && dt < dt_wide,
        "{narrow} {wide} {dt} {dt_wide}"
    );
    let (scene, _folder) = scene("support: 1.5, ", 1.01 * narrow);
    let error = plan(&scene).expect_err("too long").to_string();
    assert!(error.contains("least time step"), "{error}");
}
