//! Starts out of balance: what an equation of state makes of density errors, told before and found in the run.

use overfall::{Simulation, scene::Scene};

/// Water in a tank, disturbed by jitter; `below` is how far down a fall might go \[m].
fn disturbed(dimension: u8, spacing: f32, method: &str, amplitude: f32, below: f32) -> Scene {
    let depth = if dimension == 2 { 0.0 } else { 0.2 };
    let text = format!(
        "(name: \"start\", dimension: {dimension}, spacing: {spacing}, pressure: {method},
          bodies: [(shape: Box(min: (0, 0, 0), max: (0.2, 0.2, {depth})),
                    jitter: (amplitude: {amplitude}, seed: 1))],
          boundaries: [Tank(min: (0, 0, 0), max: (0.2, 0.4, {depth})),
                       Sphere(center: (0, -{below}, 0), radius: 0.1)])"
    );
    Scene::parse(&text, "start.ron", &[]).expect("a scene")
}

/// Largest root mean square of the speeds \[m/s] while sound covers so many support radii.
fn burst(scene: &Scene, sound_speed: f32, radii: f32) -> f64 {
    let mut simulation = Simulation::with_threads(scene, 2).expect("a start");
    let end = f64::from(radii * scene.support_radius() / sound_speed);
    let mass = overfall::plan(scene).expect("a plan").particle_mass;
    let mut most = 0.0_f64;
    while simulation.time() < end {
        let report = simulation.step_until(end).expect("a step");
        let energy = 2.0 * report.kinetic_energy / (f64::from(mass) * report.particles as f64);
        most = most.max(energy.sqrt());
    }
    most
}

#[test]
fn the_speed_of_a_burst_is_what_the_start_foretells() {
    let mut failed = Vec::new();
    for (dimension, spacing) in [(2, 0.02), (2, 0.01), (3, 0.04), (3, 0.025)] {
        for amplitude in [0.1, 0.2, 0.3] {
            // Half a second of sound's way is enough for an equation of state; diffusion takes longer.
            for (method, sound_speed, radii) in [
                ("Sesph(equation: Tait(stiffness: 57143))", 20.0, 1.5),
                ("Sesph(equation: Tait(stiffness: 1428571))", 100.0, 1.5),
                ("Sesph(equation: Gas(stiffness: 400))", 20.0, 1.5),
                ("DeltaSph(sound_speed: 100)", 100.0, 6.0),
                ("DeltaSph(sound_speed: 300)", 300.0, 6.0),
            ] {
                // So deep that no burst is refused.
                let scene = disturbed(dimension, spacing, method, amplitude, 400.0);
                let plan = overfall::plan(&scene).expect("a plan");
                let told = (2.0 * plan.start_density.expect("fluid").mean_energy).sqrt();
                let found = burst(&scene, sound_speed, radii);
                let what = format!(
                    "{dimension}-D, {spacing} m, {method}, {amplitude}: {told:.3} told, {found:.3} m/s found"
                );
                if !(0.5..2.0).contains(&(found / told)) {
                    failed.push(what);
                }
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn density_errors_that_an_equation_of_state_turns_into_a_burst_are_refused() {
    for (dimension, depth) in [(2, 0.0), (3, 0.16)] {
        for spacing in [0.02, 0.04] {
            for (method, amplitude, answer) in [
                ("Sesph(equation: Tait(stiffness: 1e6))", 0.2, Err(())),
                ("Sesph(equation: Gas(stiffness: 7e3))", 0.2, Err(())),
                ("Sesph(equation: Tait(stiffness: 2e4))", 0.05, Ok(false)),
                ("Sesph(equation: Tait(stiffness: 3e4))", 0.2, Ok(true)),
                ("Sesph(equation: Tait(stiffness: 6e4))", 0.3, Err(())),
                ("DeltaSph()", 0.05, Ok(false)),
                ("DeltaSph(sound_speed: 300)", 0.3, Ok(false)),
                ("DeltaSph(sound_speed: 1e4)", 0.3, Err(())),
                ("Dfsph", 0.2, Ok(false)),
                ("Pcisph", 0.2, Ok(false)),
            ] {
                let text = format!(
                    "(name: \"burst\", dimension: {dimension}, spacing: {spacing}, pressure: {method},
                    bodies: [(shape: Box(min: (0, 0, 0), max: (0.32, 0.32, {depth})),
                        jitter: (amplitude: {amplitude}, seed: 1))],
                    boundaries: [Tank(min: (0, 0, 0), max: (0.32, 0.64, {depth}))])"
                );
                let scene = Scene::parse(&text, "burst.ron", &[]).expect("a scene");
                let what = format!("{dimension}-D, {spacing}, {method}, {amplitude}");
                let told = overfall::plan(&scene).map(|plan| {
                    let about = |warning: &String| warning.contains("throws it apart");
                    plan.warnings.iter().any(about)
                });
                match answer {
                    Ok(warned) => assert_eq!(told.expect(&what), warned, "{what}"),
                    Err(()) => {
                        let error = told.expect_err(&what).to_string();
                        assert!(error.contains("jitter.amplitude"), "{what}: {error}");
                    }
                }
            }
        }
    }
}

/// Jitter that compresses single particles beyond the limit of the guard is refused before a step, with an amplitude
/// that runs; what is not refused runs.
#[test]
fn jitter_is_worked_off_or_refused_with_an_amplitude_that_is() {
    let (mut refused, mut taken) = (0, 0);
    for (dimension, depth) in [(2, 0.0), (3, 0.3)] {
        for (amplitude, seed) in [(0.3, 3), (0.35, 4), (0.4, 3), (0.45, 5), (0.49, 6)] {
            for method in ["Pcisph", "Iisph", "Dfsph", "DeltaSph"] {
                let run = |amplitude: f32| {
                    let text = format!(
                        "(name: \"jitter\", dimension: {dimension}, spacing: 0.05, pressure: {method},
                        bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.4, {depth})),
                            jitter: (amplitude: {amplitude}, seed: {seed}))],
                        boundaries: [Tank(min: (0, 0, 0), max: (0.8, 0.8, {depth}))])"
                    );
                    let scene = Scene::parse(&text, "jitter.ron", &[]).expect("a scene");
                    let refusal = overfall::plan(&scene).err().map(|error| error.to_string());
                    let mut simulation = match Simulation::with_threads(&scene, 2) {
                        Ok(simulation) => simulation,
                        Err(error) => {
                            assert_eq!(refusal, Some(error.to_string()));
                            return Err(error.to_string());
                        }
                    };
                    assert_eq!(refusal, None);
                    for _ in 0..10 {
                        simulation
                            .step()
                            .unwrap_or_else(|error| panic!("{text}: {error}"));
                    }
                    Ok(())
                };
                let Err(said) = run(amplitude) else {
                    taken += 1;
                    continue;
                };
                refused += 1;
                let (_, fitting) = said.split_once("`jitter.amplitude` of ").expect(&said);
                let fitting = fitting.split(' ').next().unwrap_or_default();
                let fitting: f32 = fitting.parse().expect("a number");
                assert!((0.2..amplitude).contains(&fitting), "{said}");
                run(fitting).unwrap_or_else(|error| panic!("{error}"));
            }
        }
    }
    assert!(
        refused > 8 && taken > 12,
        "{refused} refused, {taken} taken"
    );
}

/// A limit of the guard that the lattice itself exceeds is refused with one that it does not.
#[test]
fn limits_that_the_start_exceeds_are_refused() {
    let scene = |limit: f32| {
        let text = format!(
            "(name: \"limit\", spacing: 0.1, support: 2, kernel: CubicSpline, limits: (compression: {limit}),
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.4, 0.4)))],
            boundaries: [Tank(min: (0, 0, 0), max: (0.4, 1, 0.4))])"
        );
        let scene = Scene::parse(&text, "limit.ron", &[]).expect("a scene");
        overfall::plan(&scene)
            .map(drop)
            .map_err(|error| error.to_string())
    };
    let said = scene(1e-4).expect_err("compressed corners");
    let (_, rest) = said.split_once("would fail; ").expect(&said);
    let limit = rest.split(' ').next().unwrap_or_default();
    scene(limit.parse().expect("a number")).unwrap_or_else(|error| panic!("{error}"));
}
