//! Forces on the fluid as a whole: towards a point, from tables, waves, and gravity that grows.

use glam::Vec3;
use overfall::gauge::Gauges;

use crate::support::{measured, particles_of, run, simulation, simulation_of};

/// So soft that pressure has no effect.
const NO_PRESSURE: &str = "Sesph(equation: Gas(stiffness: 1e-9))";

/// A lone particle swings about the centre of a linear force, and falls with constant acceleration to that of a
/// constant one: `x0 cos ωt` and `x0 − g t²/2`, to the first order of the steps. What it has of energy it keeps.
#[test]
fn a_central_force_draws_as_it_says() {
    for dimension in [2, 3] {
        for (force, exact) in [
            (
                "linear: 16",
                (|t: f32| 0.5 * (4.0 * t).cos()) as fn(f32) -> f32,
            ),
            ("constant: 2", |t| 0.5 - t * t),
        ] {
            let text = format!(
                "(name: \"central\", dimension: {dimension}, spacing: 0.02, gravity: (0, 0, 0), pressure: {NO_PRESSURE},
                  time_step: Fixed(0.0005), body_forces: [Central(center: (0.1, 0.2, 0), {force})],
                  bodies: [(shape: Box(min: (0, 0, 0), max: (0.02, 0.02, 0.02)))])"
            );
            let center = Vec3::new(0.1, 0.2, 0.0);
            let towards = Vec3::new(0.6, 0.8, 0.0);
            let mut lone = simulation_of(&text, &[(center + 0.5 * towards, Vec3::ZERO)]);
            let (mut off, mut energies) = (0.0_f32, Vec::new());
            run(&mut lone, 0.6, |lone, report| {
                let place = particles_of(lone)[0].position - center;
                let expected = exact(report.time as f32) * towards;
                off = off.max(place.distance(expected));
                energies.push(report.kinetic_energy + report.potential_energy);
            });
            let (least, most) = energies
                .iter()
                .fold((f64::MAX, 0.0_f64), |(a, b), &e| (a.min(e), b.max(e)));
            let figures = format!(
                "{dimension}-D {force}: {off:.1e} m off, energy {least:.4e} to {most:.4e} J"
            );
            measured(&figures);
            assert!(off < 2e-3 && most - least < 5e-3 * most, "{figures}");
        }
    }
}

/// A table of accelerations gives a lone particle the velocity of its integral, whatever the steps are.
#[test]
fn a_table_shakes_by_its_integral() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("shake.csv");
    std::fs::write(&file, "t,ax,ay\n0,0,1\n0.1,2,1\n0.3,-4,1\n").expect("a file");
    for time_step in ["Fixed(0.0007)", "Fixed(0.01)", "Cfl()"] {
        let text = format!(
            "(name: \"shaken\", dimension: 2, spacing: 0.02, gravity: (0, 0, 0), pressure: {NO_PRESSURE},
              time_step: {time_step}, body_forces: [Table(file: {:?})],
              bodies: [(shape: Box(min: (0, 0, 0), max: (0.02, 0.02, 0)))])",
            file.display().to_string()
        );
        let mut lone = simulation(&text);
        run(&mut lone, 0.4, |_, _| {});
        // 0.1, then −0.2, then −4 for what is left.
        let t = lone.time() as f32;
        let expected = Vec3::new(-0.1 - 4.0 * (t - 0.3), t, 0.0);
        let velocity = particles_of(&mut lone)[0].velocity;
        assert!(
            velocity.distance(expected) < 1e-4,
            "{time_step}: {velocity}, not {expected}"
        );
    }
}

/// A wave gives resting particles the velocity of its integral over time, wherever they are and whatever the steps are.
#[test]
fn a_wave_pushes_by_its_formula() {
    let (k, frequency, phase) = (Vec3::new(9.0, -4.0, 0.0), 2.0, 0.3);
    let omega = std::f32::consts::TAU * frequency;
    for time_step in ["Fixed(0.0007)", "Fixed(0.01)", "Cfl()"] {
        for place in [
            Vec3::ZERO,
            Vec3::new(0.3, 0.1, 0.0),
            Vec3::new(-0.2, 0.7, 0.0),
        ] {
            let text = format!(
                "(name: \"wave\", dimension: 2, spacing: 0.02, gravity: (0, 0, 0), pressure: {NO_PRESSURE},
                  time_step: {time_step}, body_forces: [Wave(amplitude: (0.01, 0.02, 0), wave_number: (9, -4, 0),
                  frequency: {frequency}, phase: {phase})],
                  bodies: [(shape: Box(min: (0, 0, 0), max: (0.02, 0.02, 0)))])"
            );
            let mut lone = simulation_of(&text, &[(place, Vec3::ZERO)]);
            run(&mut lone, 0.4, |_, _| {});
            let start = k.dot(place) + phase;
            let end = start - omega * lone.time() as f32;
            let expected = (start.sin() - end.sin()) / omega * Vec3::new(0.01, 0.02, 0.0);
            let velocity = particles_of(&mut lone)[0].velocity;
            assert!(
                velocity.distance(expected) < 2e-5,
                "{time_step}, {place}: {velocity}, not {expected}"
            );
        }
    }
}

/// With a ramp of T a lone particle falls by the integral of `g (t/T − sin(2πt/T)/2π)`, at T with g T/2, and then with
/// all of gravity; the same whatever the steps are.
#[test]
fn gravity_grows_over_its_ramp() {
    for time_step in ["Fixed(0.0007)", "Fixed(0.005)", "Cfl()"] {
        let text = format!(
            "(name: \"ramp\", dimension: 2, spacing: 0.02, gravity: (0, -8, 0), gravity_ramp: 0.2,
              pressure: {NO_PRESSURE}, time_step: {time_step},
              bodies: [(shape: Box(min: (0, 0, 0), max: (0.02, 0.02, 0)))])"
        );
        let mut lone = simulation_of(&text, &[(Vec3::ZERO, Vec3::ZERO)]);
        run(&mut lone, 0.4, |lone, report| {
            let t = report.time as f32 / 0.2;
            let part = t.min(1.0);
            let turn = std::f32::consts::TAU;
            let grown = 0.5 * part * part + ((turn * part).cos() - 1.0) / turn.powi(2);
            let expected = -8.0 * 0.2 * (grown + (t - part));
            let velocity = particles_of(lone)[0].velocity.y;
            assert!(
                (velocity - expected).abs() < 1e-4,
                "{time_step}: {velocity}, not {expected}"
            );
        });
    }
}

/// Without a ramp the weight of water meets pressures that an equation of state has yet to build up: in the middle it
/// swings between nothing and twice that of water at rest. With one of ten times the time that sound takes through the
/// depth it stays within a tenth of it.
#[test]
fn a_ramp_of_gravity_starts_without_a_shock() {
    let found = [0.0, 1.0].map(|ramp| {
        let mut tank = simulation(&format!(
            "(name: \"ramp\", dimension: 2, spacing: 0.0833333, gravity: (0, -1, 0), gravity_ramp: {ramp},
              pressure: Sesph(equation: Tait(stiffness: 14285)),
              fluid: (viscosity: Laminar(kinematic_viscosity: 0.02)),
              bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))],
              boundaries: [Tank(min: (0, 0, 0), max: (1, 1.5, 0))],
              gauges: [(name: \"p\", kind: Pressure(at: (0.5, 0.5, 0)))])"
        ));
        let mut fastest = 0.0_f32;
        run(&mut tank, 1.2, |_, report| fastest = fastest.max(report.max_speed));
        let gauges = tank.world().resource::<Gauges>();
        let readings = gauges.get("p").into_iter().flat_map(|gauge| gauge.readings());
        let late = readings.filter(|reading| reading.time > ramp);
        let off = late.filter_map(|reading| Some((reading.values[0]? - 500.0).abs() / 500.0));
        (fastest, off.fold(0.0, f64::max))
    });
    let figures = format!("fastest, and pressure off, without and with a ramp: {found:.3?}");
    measured(&figures);
    assert!(found[1].0 < 0.4 * found[0].0, "{figures}");
    assert!(found[0].1 > 0.9 && found[1].1 < 0.1, "{figures}");
}
