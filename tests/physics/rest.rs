//! Fluid at rest: the density of a lattice, and water that starts without pressure. Still water under its pressure is
//! in `validation.rs`.

use std::path::Path;

use overfall::{Simulation, loading::Override, scene::Scene};

use crate::support::{Particle, measured, particles_of, run, simulation, step};

/// Densities divided by the rest density for the lattice of `text`, each with the number of walls of the tank 0–`size`
/// m within `spacing` m.
fn lattice_densities(text: &str, spacing: f32, size: f32, axes: usize) -> Vec<(usize, f32)> {
    let mut simulation = simulation(text);
    let start: Vec<Particle> = particles_of(&mut simulation);
    step(&mut simulation);
    let after = particles_of(&mut simulation);
    start
        .iter()
        .zip(after)
        .map(|(start, after)| {
            assert_eq!(start.entity, after.entity);
            let near = start.position.to_array()[..axes]
                .iter()
                .filter(|x| **x < spacing || **x > size - spacing)
                .count();
            (near, after.density / 1000.0)
        })
        .collect()
}

/// Smallest and largest density of the particles near `walls` walls.
fn range(densities: &[(usize, f32)], walls: usize) -> (f32, f32) {
    let chosen = densities.iter().filter(|(near, _)| *near == walls);
    let range = chosen.fold((f32::INFINITY, 0.0_f32), |(low, high), (_, rho)| {
        (low.min(*rho), high.max(*rho))
    });
    assert!(range.1 > 0.0, "no particle is near {walls} walls");
    range
}

/// A tank that the lattice fills.
fn full_tank(dimension: u32) -> String {
    let depth = if dimension == 2 { "0" } else { "1" };
    format!(
        "(name: \"full\", dimension: {dimension}, spacing: 0.1, gravity: (0, 0, 0), time_step: Fixed(1e-4),
          reorder_interval: 0, limits: (compression: 0.9),
          pressure: Sesph((equation: Gas(stiffness: 1e-3))),
          bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, {depth})))],
          boundaries: [Tank(min: (0, 0, 0), max: (1, 1, {depth}))])"
    )
}

/// The mass is defined by the density of the lattice (Σ m W = ρ0), so only rounding remains: 1e-4 is a hundred times
/// the rounding error of a sum of 33 terms.
#[test]
fn lattice_at_rest_has_the_rest_density_in_the_interior() {
    for dimension in [2, 3] {
        let densities = lattice_densities(&full_tank(dimension), 0.1, 1.0, dimension as usize);
        let (low, high) = range(&densities, 0);
        measured(&format!("{dimension}-D interior: {low:.6}–{high:.6} ρ0"));
        // The kernel of the plane reaches from the second row to the wall, whose samples are made for the first.
        let tolerance = if dimension == 2 { 2e-3 } else { 1e-4 };
        assert!((low - 1.0).abs() < tolerance && (high - 1.0).abs() < 1e-4);
    }
}

/// The volumes of boundary particles are calibrated on an infinite flat wall; near the edges of a face they differ. In
/// edges and corners a lattice may start a few per cent below its rest density, without pressure. If it started above
/// it, the wall would push it away.
#[test]
fn lattice_at_a_wall_has_the_rest_density() {
    for dimension in [2, 3] {
        let densities = lattice_densities(&full_tank(dimension), 0.1, 1.0, dimension as usize);
        for walls in 1..=dimension as usize {
            let (low, high) = range(&densities, walls);
            measured(&format!(
                "{dimension}-D, {walls} walls: {low:.4}–{high:.4} ρ0"
            ));
            let tolerance = if walls == 1 { 0.01 } else { 0.05 };
            assert!(
                (low - 1.0).abs() < tolerance && high < 1.01,
                "{dimension}-D, {walls} walls: {low}–{high}"
            );
        }
    }
}

/// Still water in 2-D, `depth` layers of 1 cm, which starts without pressure.
fn still_water(depth: u32, width: u32, pressure: &str) -> String {
    let (height, width) = (0.01 * f64::from(depth), 0.01 * f64::from(width));
    format!(
        "(name: \"still\", dimension: 2, spacing: 0.01, pressure: {pressure},
          bodies: [(shape: Box(min: (0, 0, 0), max: ({width}, {height}, 0)))],
          boundaries: [Tank(min: (0, 0, 0), max: ({width}, {}, 0))])",
        1.3 * height
    )
}

/// Water at rest must not rise: all its energy is potential. Ninety layers fall onto a pressure that has not built up
/// yet; when their compression was removed in ever shorter steps, they gained 0.4 to 1.6 times their energy.
#[test]
fn deep_water_gains_no_energy_as_its_weight_arrives_at_the_floor() {
    for (pressure, limit) in [
        ("Iisph()", 0.01),
        ("Iisph(max_density_error: 1e-4)", 0.01),
        ("Dfsph()", 0.015),
    ] {
        let mut simulation = simulation(&still_water(90, 30, pressure));
        let (mut start, mut gained) = (None, 0.0_f64);
        run(&mut simulation, 0.06, |_, report| {
            let energy = report.kinetic_energy + report.potential_energy;
            gained = gained.max(energy / *start.get_or_insert(energy) - 1.0);
        });
        measured(&format!(
            "{pressure}: energy gained {:.3} %",
            100.0 * gained
        ));
        assert!(gained < limit, "{pressure}: {gained}");
    }
}

/// With momentum, information crosses N layers in N iterations instead of N² for Jacobi.
#[test]
fn momentum_saves_iterations_in_deep_water() {
    let iterations = |momentum: &str| -> u32 {
        let text = still_water(
            60,
            10,
            &format!("Iisph(max_density_error: 1e-4, {momentum})"),
        );
        let mut simulation = simulation(&text);
        (0..4).map(|_| step(&mut simulation).iterations).sum()
    };
    let (with, without) = (
        iterations("momentum: true"),
        iterations("momentum: false, relaxation: 0.5, max_iterations: 5000"),
    );
    measured(&format!("with momentum {with}, without {without}"));
    assert!(3 * with < without, "{with} against {without}");
}

/// If steps end after few and varying numbers of iterations, waves may be excited: with momentum from the first
/// iteration on, half of these runs, which differ only in the order of their sums, oscillate with 1 to 2 % of sqrt(g H)
/// for one or two seconds.
#[test]
fn still_water_stands_whatever_the_rounding() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases/hydrostatic_3d/scene.ron");
    let (depth, gravity) = (0.4, 9.81);
    for interval in [21, 24] {
        let sets = [
            "pressure=Iisph()".to_owned(),
            format!("reorder_interval={interval}"),
        ];
        let sets = sets.map(|set| Override::parse(&set).expect("an override"));
        let scene = Scene::load(&path, &sets).expect("the scene");
        let mut tank = Simulation::with_threads(&scene, 2).expect("threads");
        let mut worst = 0.0_f64;
        run(&mut tank, 2.5, |_, report| {
            if report.time > 1.0 {
                let mass = 0.2 * depth * 0.2 * 1000.0;
                worst = worst.max((2.0 * report.kinetic_energy / mass).sqrt());
            }
        });
        let worst = worst / (gravity * depth).sqrt();
        measured(&format!(
            "reordered every {interval} steps: speeds of {:.2} % of sqrt(g H)",
            100.0 * worst
        ));
        assert!(worst < 0.01, "every {interval} steps: {worst}");
    }
}

/// The wall's part of the density does no work in the fluid and must not act as pressure: before, the pressure beside a
/// side wall was 1.4 to 1.6 times that at the same depth.
#[test]
fn pressure_at_a_wall_is_that_of_its_depth() {
    let text = still_water(30, 15, "Iisph()").replace(
        "dimension: 2",
        "dimension: 2, fluid: (viscosity: Artificial(alpha: 0.5, sound_speed: 17))",
    );
    let mut simulation = simulation(&text);
    let (mut wall, mut inside) = ([0.0_f64; 2], [0.0_f64; 2]);
    run(&mut simulation, 1.0, |simulation, report| {
        if report.time < 0.5 {
            return;
        }
        for particle in particles_of(simulation) {
            let x = particle.position;
            if x.y > 0.05 && x.y < 0.25 {
                let sums = match (x.x - 0.075).abs() {
                    0.0..0.04 => &mut inside,
                    0.065.. => &mut wall,
                    _ => continue,
                };
                sums[0] += f64::from(particle.pressure) / (9810.0 * f64::from(0.3 - x.y));
                sums[1] += 1.0;
            }
        }
    });
    let ratio = wall[0] / wall[1] / (inside[0] / inside[1]);
    measured(&format!(
        "at the side walls {ratio:.3} times the pressure inside"
    ));
    assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
}
