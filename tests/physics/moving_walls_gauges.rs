//! Gauges of walls in prescribed motion: forces and pressures where the walls are.

use overfall::gauge::Gauges;

use crate::moving_walls::METHODS;
use crate::support::{measured, particles_of, run, simulation};

/// What walls that move do to the fluid is what its momentum changes by, as the gauge of forces tells it.
#[test]
fn the_force_on_walls_that_move_is_the_change_of_momentum() {
    for (dimension, methods) in [(2, &METHODS[..]), (3, &METHODS[2..])] {
        let deep = if dimension == 2 { 0.0 } else { 0.1 };
        for (method, slip) in methods
            .iter()
            .flat_map(|method| [(method, "Free"), (method, "NoSlip")])
        {
            let mut tank = simulation(&format!(
                "(name: \"push\", dimension: {dimension}, spacing: 0.02, gravity: (0, 0, 0), pressure: {method},
                  time_step: Fixed(0.0005), fluid: (viscosity: Laminar(kinematic_viscosity: 0.01)),
                  bodies: [(shape: Box(min: (0.1, 0, 0), max: (0.3, 0.1, {deep})))],
                  boundaries: [Tank(min: (0, 0, 0), max: (0.8, 0.2, {deep}), name: \"walls\", slip: {slip}),
                    Box(min: (0, 0, 0), max: (0.1, 0.2, {deep}), name: \"walls\", slip: {slip},
                      motion: Oscillation(amplitude: (0.04, 0, 0), frequency: 2))],
                  gauges: [(name: \"force\", kind: Force(boundary: \"walls\"))])"
            ));
            let mass = {
                let world = tank.world_mut();
                f64::from(world.resource::<overfall::state::Material>().particle_mass)
            };
            let momentum = |tank: &mut overfall::Simulation| {
                let velocities = particles_of(tank)
                    .into_iter()
                    .map(|p| p.velocity.as_dvec3());
                mass * velocities.sum::<glam::DVec3>()
            };
            let (mut before, mut time) = (momentum(&mut tank), 0.0);
            let (mut off, mut most) = (0.0_f64, 0.0_f64);
            run(&mut tank, 0.1, |tank, report| {
                let now = momentum(tank);
                let expected = (before - now) / (report.time - time);
                (before, time) = (now, report.time);
                let gauges = tank.world().resource::<Gauges>();
                let gauge = gauges.get("force").expect("a gauge");
                let of = |axis: &str| gauge.value(&format!("force_{axis}_N")).unwrap_or(f64::NAN);
                let found = glam::DVec3::new(of("x"), of("y"), of("z"));
                off = off.max(found.distance(expected));
                most = most.max(expected.length());
            });
            let figures =
                format!("{dimension}-D {method} {slip}: off by {off:.2e} of up to {most:.2e} N");
            measured(&figures);
            assert!(most > 0.1 && off < 2e-3 * most, "{figures}");
        }
    }
}

/// A gauge on a wall goes with it: the hydrostatic pressure of a tank that moves with its water.
#[test]
fn a_gauge_on_a_wall_goes_where_the_wall_goes() {
    for (dimension, deep, z) in [(2, 0.0, 0.0), (3, 0.12, 0.06)] {
        let mut tank = simulation(&format!(
            "(name: \"gauge\", dimension: {dimension}, spacing: 0.02,
              fluid: (viscosity: Laminar(kinematic_viscosity: 0.001)),
              bodies: [(shape: Box(min: (0, 0, 0), max: (0.16, 0.12, {deep})), velocity: (0.5, 0, 0))],
              boundaries: [Tank(min: (0, 0, 0), max: (0.16, 0.2, {deep}), name: \"tank\",
                motion: Velocity(velocity: (0.5, 0, 0)))],
              gauges: [
                (name: \"with\", window: 0.2, every: Seconds(0.2),
                  kind: WallPressure(at: (0, 0.04, {z}), normal: (1, 0, 0), boundary: \"tank\")),
                (name: \"without\", kind: WallPressure(at: (0, 0.04, {z}), normal: (1, 0, 0)))])"
        ));
        run(&mut tank, 0.61, |_, _| {});
        let gauges = tank.world().resource::<Gauges>();
        let value =
            |name: &str, column: &str| gauges.get(name).and_then(|gauge| gauge.value(column));
        let with = value("with", "mean_pressure_Pa").unwrap_or(f64::NAN);
        let without = value("without", "pressure_Pa");
        let expected = 1000.0 * 9.81 * 0.08;
        let figures = format!(
            "{dimension}-D: {with:.0} Pa, expected {expected:.0} Pa; {without:?} where it was"
        );
        measured(&figures);
        assert!(
            (with / expected - 1.0).abs() < 0.15 && without == Some(0.0),
            "{figures}"
        );
    }
}
