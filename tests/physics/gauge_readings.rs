//! Readings of gauges: independent of threads, of roll-backs and of what a host does.

use super::gauges::{scene, still, value};
use bevy_ecs::prelude::*;
use overfall::{
    Simulation,
    boundary::refresh_boundary,
    gauge::{Gauge, Gauges, Reading},
    particle::{Boundary, Fluid, Position, Velocity},
    scene::Scene,
};

/// Every kind of gauge in a dam break.
fn all_kinds(extra: &str) -> Scene {
    scene(&format!(
        "(name: \"all\", spacing: 0.05, {extra},
          bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.6, 0.3)), jitter: (amplitude: 0.1))],
          boundaries: [Tank(min: (0, 0, 0), max: (1, 1, 0.3), name: \"tank\")],
          gauges: [
            (name: \"p\", kind: Pressure(at: (0.2, 0.2, 0.15), radius: 0.31), window: 0.01),
            (name: \"wall\", kind: WallPressure(at: (0, 0.1, 0.15), normal: (2, 0, 0)), every: Seconds(0.003)),
            (name: \"v\", kind: Velocity(at: (0.3, 0.1, 0.1))),
            (name: \"h\", kind: Height(at: (0.1, 0, 0.1), radius: 0.1), every: Steps(2)),
            (name: \"x\", kind: Front(direction: (1, 0.1, 0), within: (min: (0, 0, 0), max: (1, 0.2, 1)))),
            (name: \"f\", kind: Force(boundary: \"tank\", about: (0, 1, 2)), window: 0.02),
            (name: \"q\", kind: Flux(corner: (0.4, 0, 0), along: (0, 0.5, 0.1), across: (0.1, 0, 0.3))),
            (name: \"e\", kind: Energy),
          ])"
    ))
}

/// All readings, to the bit.
fn readings(
    scene: &Scene,
    threads: usize,
    steps: usize,
) -> Vec<(String, u64, u64, Vec<Option<u64>>)> {
    let mut simulation = Simulation::with_threads(scene, threads).expect("threads");
    for _ in 0..steps {
        simulation.step().expect("a step");
    }
    let gauges = simulation.world().resource::<Gauges>();
    let of = |gauge: &Gauge| -> Vec<_> {
        let bits = |reading: &Reading| reading.values.iter().map(|v| v.map(f64::to_bits)).collect();
        let row = |r: &Reading| (gauge.name().to_owned(), r.step, r.time.to_bits(), bits(r));
        gauge.readings().map(row).collect()
    };
    gauges.iter().flat_map(of).collect()
}

#[test]
fn figures_do_not_depend_on_the_number_of_threads() {
    for extra in [
        "time_step: Cfl()",
        "neighbours: Recomputed, pressure: Sesph(equation: Tait(stiffness: 20000)), reorder_interval: 3",
        "executor: Parallel, boundary_handling: DirectForcing(()), index: (structure: ZIndexSort)",
    ] {
        let scene = all_kinds(extra);
        let expected = readings(&scene, 1, 40);
        assert!(expected.len() > 5 * 40 + 20, "{}", expected.len());
        for threads in [2, 3] {
            assert!(
                readings(&scene, threads, 40) == expected,
                "{threads} threads, {extra}"
            );
        }
    }
}

#[test]
fn steps_that_are_taken_back_leave_no_reading() {
    let scene = scene(
        "(name: \"splash\", spacing: 0.02, pressure: Dfsph(max_density_error: 0.001), reorder_interval: 5,
          bodies: [(shape: Box(min: (0, 0, 0), max: (0.2, 0.08, 0.2))),
                   (shape: Sphere(center: (0.1, 0.16, 0.1), radius: 0.05), velocity: (0, -6, 0))],
          boundaries: [Tank(min: (0, 0, 0), max: (0.2, 0.4, 0.2))],
          gauges: [(name: \"e\", kind: Energy), (name: \"h\", kind: Height(at: (0.1, 0, 0.1)), window: 0.002, every: \
          Seconds(0.001))],
          time_step: Adaptive(max: 5e-3, initial: 2.9e-3, density_error: 0.003))",
    );
    let mut simulation = Simulation::with_threads(&scene, 2).expect("threads");
    let mut good: Vec<(u64, f64, f64)> = Vec::new();
    let mut went_back = 0;
    while simulation.time() < 0.02 {
        let report = simulation.step().expect("a step");
        match &report.taken_back {
            Some(taken) => {
                went_back += u32::from(taken.steps > 1);
                good.retain(|step| step.0 <= report.step);
            }
            None => good.push((report.step, report.time, report.kinetic_energy)),
        }
    }
    assert!(went_back > 0, "no good step was taken back");
    let gauges = simulation.world().resource::<Gauges>();
    let readings: Vec<&Reading> = gauges.get("e").expect("a gauge").readings().collect();
    let found: Vec<_> = readings
        .iter()
        .map(|r| (r.step, r.time, r.values[0].expect("energy")))
        .collect();
    assert_eq!(found, good);
    // The dissipated energy is what is missing at the end, whatever was rolled back meanwhile.
    let total = |r: &Reading| {
        r.values
            .iter()
            .map(|value| value.expect("energy"))
            .sum::<f64>()
    };
    let (first, last) = (total(readings[0]), total(readings[readings.len() - 1]));
    assert!((last / first - 1.0).abs() < 1e-6, "{first} {last}");
    let times: Vec<f64> = gauges
        .get("h")
        .expect("a gauge")
        .readings()
        .map(|r| r.time)
        .collect();
    assert!(
        times.is_sorted_by(|a, b| a < b) && times.len() >= 8,
        "{times:?}"
    );
}

#[test]
fn a_host_reads_gauges_without_files_and_takes_what_it_has_read() {
    let mut simulation =
        Simulation::with_threads(&all_kinds("time_step: Fixed(0.001)"), 2).expect("threads");
    {
        let gauges = simulation.world().resource::<Gauges>();
        assert!(
            gauges
                .iter()
                .all(|gauge| gauge.latest().is_none() && gauge.value("x").is_none())
        );
        assert_eq!(
            gauges.get("p").expect("a gauge").columns(),
            ["pressure_Pa", "neighbours", "mean_pressure_Pa"]
        );
        assert!(gauges.get("q2").is_none());
    }
    for _ in 0..5 {
        simulation.step().expect("a step");
    }
    let mut gauges = simulation.world_mut().resource_mut::<Gauges>();
    assert_eq!(gauges.get("v").expect("a gauge").readings().count(), 5);
    let taken: Vec<usize> = gauges
        .take_readings(3)
        .map(|readings| readings.len())
        .collect();
    assert_eq!(taken, [3, 1, 3, 1, 3, 3, 3, 3]);
    let left = gauges.get("v").expect("a gauge").readings().map(|r| r.step);
    assert_eq!(left.collect::<Vec<_>>(), [4, 5]);
    let latest = gauges.get("v").and_then(Gauge::latest).expect("a reading");
    assert!(latest.step == 5 && (latest.time - 0.005).abs() < 1e-6);
}

#[test]
fn a_scene_without_gauges_has_nothing_of_them() {
    let mut plain = all_kinds("time_step: Fixed(0.001)");
    plain.gauges.clear();
    let simulation = Simulation::with_threads(&plain, 1).expect("threads");
    assert!(!simulation.world().contains_resource::<Gauges>());
    // The run is identical to one without gauges.
    let state = |scene: &Scene| {
        let mut simulation = Simulation::with_threads(scene, 1).expect("threads");
        for _ in 0..10 {
            simulation.step().expect("a step");
        }
        let world = simulation.world_mut();
        let mut fluid = world.query_filtered::<(&Position, &Velocity), With<Fluid>>();
        let rows = fluid.iter(world).map(|(x, v)| {
            (
                x.0.to_array().map(f32::to_bits),
                v.0.to_array().map(f32::to_bits),
            )
        });
        rows.collect::<Vec<_>>()
    };
    assert!(state(&plain) == state(&all_kinds("time_step: Fixed(0.001)")));
}

#[test]
fn forces_go_on_after_a_host_has_changed_the_walls() {
    let scene = still(2, 0.04, "Dfsph");
    let [as_before, changed] = [false, true].map(|changes| {
        let mut simulation = Simulation::with_threads(&scene, 1).expect("threads");
        simulation.step().expect("a step");
        if changes {
            let world = simulation.world_mut();
            // A sample that belongs to no boundary, far away.
            world.spawn((Boundary, Position(glam::Vec3::new(9.0, 9.0, 0.0))));
            refresh_boundary(world, &scene).expect("walls");
        }
        simulation.step().expect("a step");
        assert_eq!(value(&simulation, "far", "force_y_N"), 0.0);
        value(&simulation, "now", "force_y_N")
    });
    assert!(
        changed < -100.0 && (changed / as_before - 1.0).abs() < 1e-3,
        "{changed} {as_before}"
    );
}
