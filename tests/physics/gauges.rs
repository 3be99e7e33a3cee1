//! Gauges compared with known values: still water, free fall, a body in uniform motion.

use bevy_ecs::prelude::*;
use glam::DVec3;
use overfall::{
    Simulation,
    gauge::Gauges,
    particle::{Fluid, Velocity},
    scene::Scene,
};

pub(super) fn scene(text: &str) -> Scene {
    Scene::parse(text, "gauges.ron", &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn run(simulation: &mut Simulation, duration: f64) {
    while simulation.time() < duration {
        simulation.step_until(duration).expect("a step");
    }
}

pub(super) fn value(simulation: &Simulation, gauge: &str, column: &str) -> f64 {
    let gauges = simulation.world().resource::<Gauges>();
    let gauge = gauges.get(gauge).expect("a gauge");
    gauge
        .value(column)
        .unwrap_or_else(|| panic!("{column} of {gauge:?}"))
}

/// A body without gravity and walls in uniform motion with (1, 0.5, 0) m/s.
fn moving(dimension: u8, extra: &str) -> Scene {
    let z = if dimension == 2 { "0" } else { "0.4" };
    scene(&format!(
        "(name: \"moving\", dimension: {dimension}, spacing: 0.05, gravity: (0, 0, 0), fluid: (viscosity: None),
          bodies: [(shape: Box(min: (0, 0, 0), max: (1, 0.5, {z})), velocity: (1, 0.5, 0))],
          gauges: [{extra}], time_step: Fixed(0.002))"
    ))
}

#[test]
fn a_body_that_moves_as_one_has_its_velocity_everywhere_and_its_flow_through_a_surface() {
    for (dimension, across, flow) in [(2, "", 0.5), (3, ", across: (0, 0, 2)", 0.2)] {
        let corner = if dimension == 2 {
            "(0.6, -1, 0)"
        } else {
            "(0.6, -1, -0.5)"
        };
        let scene = moving(
            dimension,
            &format!(
                "(name: \"v\", kind: Velocity(at: (0.5, 0.3, 0))),
                 (name: \"q\", kind: Flux(corner: {corner}, along: (0, 3, 0){across}), window: 0.1, every: \
                 Seconds(0.1)),
                 (name: \"back\", kind: Flux(corner: (0.6, 2, {z}), along: (0, -3, 0){across})),
                 (name: \"half\", kind: Flux(corner: (0.6, -1, {z}), along: (0, 1.35, 0){across})),
                 (name: \"beside\", kind: Flux(corner: (-2, -1, {z}), along: (0, 3, 0){across}))",
                z = if dimension == 2 { "0" } else { "-0.5" }
            ),
        );
        let mut simulation = Simulation::with_threads(&scene, 2).expect("threads");
        run(&mut simulation, 0.1);
        let v = |axis| value(&simulation, "v", &format!("velocity_{axis}_m_per_s"));
        let found = ["x", "y", "z"].map(v);
        let error = DVec3::from_array(found).distance(DVec3::new(1.0, 0.5, 0.0));
        assert!(error < 2e-4, "{found:?}");
        // m/ρ0 differs from the cube of the spacing by up to 2 %.
        let flow_of = |name| value(&simulation, name, "volume_flux_m3_per_s");
        assert!((flow_of("q") / flow - 1.0).abs() < 0.02, "{}", flow_of("q"));
        let mean = value(&simulation, "q", "mean_volume_flux_m3_per_s");
        assert!((mean / flow - 1.0).abs() < 0.02, "{mean}");
        assert!((flow_of("back") / flow_of("q") + 1.0).abs() < 1e-6);
        // Its upper end is at y = 0.35, now 0.3 above the body's lower side.
        assert!(
            (flow_of("half") / flow_of("q") - 0.6).abs() < 1e-5,
            "{}",
            flow_of("half")
        );
        assert!(flow_of("beside") == 0.0);
    }
}

#[test]
fn falling_keeps_its_energy_but_for_what_the_scheme_takes() {
    for method in ["Dfsph", "Sesph(equation: Tait(stiffness: 100000))"] {
        let scene = scene(&format!(
            "(name: \"fall\", dimension: 2, spacing: 0.05, pressure: {method}, fluid: (viscosity: None),
              bodies: [(shape: Box(min: (0, 5, 0), max: (1, 6, 0)), velocity: (0.5, 1, 0))],
              gauges: [(name: \"e\", kind: Energy), (name: \"v\", kind: Velocity(at: (0.6, 5.5, 0))),
                       (name: \"top\", kind: Height(at: (0.6, 0, 0))),
                       (name: \"x\", kind: Front(from: (1, 0, 0), direction: (2, 0, 0)))],
              time_step: Fixed(0.001))"
        ));
        let mut simulation = Simulation::with_threads(&scene, 2).expect("threads");
        let energy = |simulation: &Simulation, name: &str| {
            value(simulation, "e", &format!("{name}_energy_J"))
        };
        simulation.step().expect("a step");
        let first = energy(&simulation, "kinetic") + energy(&simulation, "potential");
        run(&mut simulation, 0.1);
        let t = 0.1;
        assert!((value(&simulation, "v", "velocity_y_m_per_s") - (1.0 - 9.81 * t)).abs() < 1e-3);
        // Semi-implicit Euler: x = v t − g t (t + dt)/2.
        let top = 6.0 + t - 0.5 * 9.81 * t * (t + 0.001);
        assert!(
            (value(&simulation, "top", "height_m") - top).abs() < 2e-4,
            "{}",
            value(&simulation, "top", "height_m")
        );
        assert!((value(&simulation, "x", "front_m") - 0.05).abs() < 2e-4);
        let last = energy(&simulation, "kinetic") + energy(&simulation, "potential");
        assert!((last / first - 1.0).abs() < 1e-3);
        // It removes m g² dt/2 per second: 1000 kg and 1 m².
        let taken = 0.5 * 1000.0 * 9.81 * 9.81 * 0.001 * t;
        let dissipated = energy(&simulation, "dissipated");
        assert!(
            (dissipated / taken - 1.0).abs() < 0.05,
            "{method}: {dissipated} {taken}"
        );
        assert!(energy(&simulation, "compression") >= 0.0);
    }
}

/// Still water in a tank, with gauges on its floor and walls.
pub(super) fn still(dimension: u8, spacing: f64, method: &str) -> Scene {
    let (depth, z) = if dimension == 2 {
        ("0", "0")
    } else {
        ("0.4", "0.2")
    };
    // Particles are near, but it is air.
    let over = 0.4 + 1.2 * spacing;
    scene(&format!(
        "(name: \"still\", dimension: {dimension}, spacing: {spacing}, pressure: {method},
          bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.4, {depth})))],
          boundaries: [Tank(min: (0, 0, 0), max: (0.4, 0.8, {depth}), name: \"tank\"),
                       Sphere(center: (3, 3, 0), radius: 0.2, name: \"far\")],
          gauges: [
            (name: \"force\", kind: Force(boundary: \"tank\", about: (0.2, 0.2, {z})), {MEAN}),
            (name: \"far\", kind: Force(boundary: \"far\")),
            (name: \"now\", kind: Force(boundary: \"tank\")),
            (name: \"floor\", kind: WallPressure(at: (0.2, 0, {z}), normal: (0, 1, 0)), {MEAN}),
            (name: \"middle\", kind: Pressure(at: (0.2, 0.2, {z})), {MEAN}),
            (name: \"dry\", kind: WallPressure(at: (0.4, 0.7, {z}), normal: (-1, 0, 0))),
            (name: \"air\", kind: Pressure(at: (0.2, 0.7, {z}))),
            (name: \"over\", kind: Pressure(at: (0.2, {over}, {z}))),
            (name: \"splash\", kind: WallPressure(at: (0, {over}, {z}), normal: (1, 0, 0))),
            (name: \"level\", kind: Height(at: (0.2, 0, {z}))),
          ])"
    ))
}

const MEAN: &str = "window: 0.4, every: Seconds(0.4)";

#[test]
fn still_water_weighs_on_its_tank_what_it_weighs() {
    for (dimension, spacing, method) in [
        (2, 0.04, "Dfsph"),
        (2, 0.02, "Dfsph"),
        (2, 0.02, "Iisph"),
        (2, 0.02, "Pcisph"),
        (2, 0.02, "Sesph(equation: Tait(stiffness: 100000))"),
        (3, 0.05, "Dfsph"),
        (3, 0.04, "Dfsph"),
    ] {
        let scene = still(dimension, spacing, method);
        let mut simulation = Simulation::with_threads(&scene, 2).expect("threads");
        run(&mut simulation, 0.8);
        let of = |gauge: &str, column: &str| value(&simulation, gauge, column);
        let plan = overfall::plan(&scene).expect("a plan");
        let weight = plan.particles as f64 * f64::from(plan.particle_mass) * 9.81;
        let what = format!("{dimension}-D, {spacing} m, {method}");
        let force = ["x", "y", "z"].map(|axis| of("force", &format!("mean_force_{axis}_N")));
        assert!(
            (force[1] / weight + 1.0).abs() < 0.01,
            "{what}: {force:?} of {weight} N"
        );
        assert!(
            force[0].abs().max(force[2].abs()) < 0.01 * weight,
            "{what}: {force:?}"
        );
        let torque = of("force", "mean_torque_z_N_m");
        assert!(torque.abs() < 0.01 * weight * 0.4, "{what}: {torque} N m");
        assert_eq!(of("far", "force_y_N"), 0.0);
        // A column 0.4 m deep; the floor's pressure is known to be up to 25 % off.
        let depth = 9810.0 * 0.4;
        let floor = of("floor", "mean_pressure_Pa");
        assert!(
            (floor / depth - 1.0).abs() < 0.25,
            "{what}: {floor} of {depth} Pa"
        );
        let middle = of("middle", "mean_pressure_Pa");
        assert!(
            (middle / (0.5 * depth) - 1.0).abs() < 0.06,
            "{what}: {middle} Pa"
        );
        let least = if dimension == 2 { 4.0 } else { 10.0 };
        assert!(of("floor", "neighbours") >= least && of("middle", "neighbours") >= 1.5 * least);
        assert_eq!(
            (of("dry", "pressure_Pa"), of("dry", "neighbours")),
            (0.0, 0.0)
        );
        let gauges = simulation.world().resource::<Gauges>();
        let air = gauges
            .get("air")
            .and_then(|gauge| gauge.latest())
            .expect("a reading");
        assert_eq!(air.values, [None, Some(0.0)]);
        let over = gauges.get("over").and_then(|gauge| gauge.latest());
        assert_eq!(over.expect("a reading").values[0], None, "{what}");
        assert_eq!(of("splash", "pressure_Pa"), 0.0, "{what}");
        let level = of("level", "height_m");
        assert!((level - 0.4).abs() < 0.6 * spacing, "{what}: {level} m");
    }
}

#[test]
fn what_the_fluid_loses_of_its_momentum_its_walls_take() {
    let methods = [
        "Dfsph",
        "Iisph",
        "Pcisph",
        "Sesph(equation: Tait(stiffness: 20000))",
    ];
    let handlings = ["Akinci", "DirectForcing()"];
    for (method, handling) in methods
        .iter()
        .flat_map(|method| handlings.map(|handling| (method, handling)))
    {
        // A column, with its spray, falls onto a floor and against a wall.
        let scene = scene(&format!(
            "(name: \"fall\", dimension: 2, spacing: 0.02, pressure: {method}, boundary_handling: {handling},
              bodies: [(shape: Box(min: (0.1, 0.1, 0), max: (0.3, 0.4, 0)), velocity: (1.5, 0, 0)),
                       (shape: Box(min: (0.1, 0.6, 0), max: (0.12, 0.62, 0)))],
              boundaries: [Tank(min: (0, 0, 0), max: (0.5, 0.8, 0), name: \"walls\"),
                           Plane(center: (0.25, -0.5, 0), normal: (0, 1, 0), half_size: 0.1, name: \"walls\")],
              gauges: [(name: \"f\", kind: Force(boundary: \"walls\"))])"
        ));
        let mut simulation = Simulation::with_threads(&scene, 2).expect("threads");
        let plan = overfall::plan(&scene).expect("a plan");
        let mass = f64::from(plan.particle_mass);
        let momentum = |simulation: &mut Simulation| {
            let world = simulation.world_mut();
            let mut fluid = world.query_filtered::<&Velocity, With<Fluid>>();
            mass * fluid.iter(world).map(|v| v.0.as_dvec3()).sum::<DVec3>()
        };
        let start = momentum(&mut simulation);
        let weight = DVec3::new(0.0, -9.81 * mass * plan.particles as f64, 0.0);
        let mut taken = DVec3::ZERO;
        let mut largest = 0.0_f64;
        while simulation.time() < 0.35 {
            let dt = f64::from(simulation.step().expect("a step").dt);
            let force =
                ["x", "y", "z"].map(|axis| value(&simulation, "f", &format!("force_{axis}_N")));
            taken += dt * DVec3::from_array(force);
            largest = largest.max(taken.length());
        }
        let lost = start + weight * simulation.time() - momentum(&mut simulation);
        let scale = start.length() + (weight * 0.35).length();
        assert!(
            largest > 0.3 * start.length(),
            "{method}: nothing hit a wall"
        );
        assert!(
            (lost - taken).length() < 2e-3 * scale,
            "{method}, {handling}: {lost} N s were lost, {taken} N s taken, of {scale}"
        );
    }
}
