//! Walls that continue the pressure bear what rests on them, and nothing of what slides along them or falls from them.

use glam::Vec3;
use overfall::{Simulation, scene::Scene};

use super::gauges::value;
use crate::support::particles_of;

/// Methods and walls that continue the pressure.
const WALLS: [(&str, &str); 6] = [
    ("DeltaSph()", "Layers"),
    ("Dfsph", "Layers"),
    ("Iisph", "Layers"),
    ("Dfsph", "Extrapolated"),
    ("Iisph", "Extrapolated"),
    ("Pcisph", "Extrapolated"),
];

fn scene((method, walls): (&str, &str), rest: &str) -> Scene {
    let text = format!(
        "(name: \"layers\", spacing: 0.02, pressure: {method}, boundary_handling: {walls}, fluid: (viscosity: None),
        {rest})"
    );
    Scene::parse(&text, "layers.ron", &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// Mean velocity and root mean square of the speeds at a time \[m/s].
fn velocities(scene: &Scene, time: f64) -> (Vec3, f32) {
    let mut simulation = Simulation::with_threads(scene, 1).expect("a start");
    while simulation.time() < time - 1e-9 {
        simulation.step_until(time).expect("a step");
    }
    let particles = particles_of(&mut simulation);
    let mean = |of: &dyn Fn(Vec3) -> Vec3| {
        particles.iter().map(|p| of(p.velocity)).sum::<Vec3>() / particles.len() as f32
    };
    let squares = mean(&|v| Vec3::splat(v.length_squared()));
    (mean(&|v| v), squares.x.sqrt())
}

/// A sheet of four rows on a slope without friction: `v = g t` along it.
#[test]
fn water_slides_freely_along_layers() {
    for walls in WALLS {
        for (dimension, depth, middle) in [(2, "0", "0"), (3, "0.24", "0.12")] {
            // Three support radii and more.
            let periodic = if dimension == 2 {
                "(x: (0, 0.32))"
            } else {
                "(x: (0, 0.32), z: (0, 0.24))"
            };
            let scene = scene(
                walls,
                &format!(
                    "dimension: {dimension}, gravity: (4.905, -8.496, 0), periodic: {periodic},
                    bodies: [(shape: Box(min: (0, 0, 0), max: (0.32, 0.08, {depth})))],
                    boundaries: [Plane(center: (0.16, 0, {middle}), normal: (0, 1, 0), half_size: 0.16)]"
                ),
            );
            let (mean, _) = velocities(&scene, 0.2);
            assert!(
                (mean.x / 0.981 - 1.0).abs() < 0.005,
                "{walls:?}, {dimension}-D: {mean}"
            );
        }
    }
}

/// A block under a lid, narrower than it and as wide as the tank, falls as in free air.
#[test]
fn water_falls_from_a_lid() {
    for walls in WALLS {
        for (low, high) in [(0.08, 0.24), (0.0, 0.32)] {
            let scene = scene(
                walls,
                &format!(
                    "dimension: 2, bodies: [(shape: Box(min: ({low}, 0.32, 0), max: ({high}, 0.48, 0)))],
                    boundaries: [Tank(min: (0, 0, 0), max: (0.32, 0.48, 0))]"
                ),
            );
            let (mean, _) = velocities(&scene, 0.1);
            assert!((mean.y / -0.981 - 1.0).abs() < 0.02, "{walls:?}: {mean}");
        }
    }
}

/// Water that fills a closed tank does not circulate: with tension under the lid it did at a quarter of `sqrt(g H)`,
/// and gained energy. Of δ-SPH's motion 3 to 6 % of it are left: docs/decisions/delta_sph.md.
#[test]
fn a_full_closed_tank_is_at_rest() {
    for (walls, part) in [
        (("DeltaSph()", "Layers"), 0.1),
        (("Dfsph", "Layers"), 0.01),
        // One layer of samples leaves 0.006 to 0.013, with the pressure of the particle too.
        (("Dfsph", "Extrapolated"), 0.015),
    ] {
        for rows in [10, 20] {
            let (width, height) = (0.2, 0.02 * rows as f32);
            let scene = scene(
                walls,
                &format!(
                    "dimension: 2, bodies: [(shape: Box(min: (0, 0, 0), max: ({width}, {height}, 0)))],
                    boundaries: [Tank(min: (0, 0, 0), max: ({width}, {height}, 0))]"
                ),
            );
            let (_, rms) = velocities(&scene, 1.0);
            let wave = (9.81 * height).sqrt();
            assert!(
                rms < part * wave,
                "{walls:?}, {rows} rows: {rms} of {wave} m/s"
            );
        }
    }
}

/// An equation of state stores energy: if its walls pushed more than they store, still water would gain it.
#[test]
fn an_equation_of_state_gains_no_energy_beside_layers() {
    for (dimension, size) in [(2, (0.24, 0.8, "0")), (3, (0.16, 0.16, "0.16"))] {
        for stiffness in [1e5, 1e6] {
            let (width, height, depth) = size;
            let text = format!(
                "(name: \"still\", dimension: {dimension}, spacing: 0.02, boundary_handling: Layers,
                pressure: Sesph(equation: Tait(stiffness: {stiffness})),
                bodies: [(shape: Box(min: (0, 0, 0), max: ({width}, {height}, {depth})))],
                boundaries: [Tank(min: (0, 0, 0), max: ({width}, 2, {depth}))])"
            );
            let scene = Scene::parse(&text, "still.ron", &[]).expect("a scene");
            let (_, speed) = velocities(&scene, 1.0);
            let fall = (9.81_f32 * height).sqrt();
            assert!(
                speed < 0.1 * fall,
                "{dimension}-D, {stiffness}: {speed} m/s"
            );
        }
    }
}

/// A full tank that is shaken, and a block that cohesion alone holds: no wave of gravity and no speed tells how stiff
/// they have to be.
#[test]
fn what_shakes_or_holds_the_fluid_compresses_it_little() {
    for (dimension, depth) in [(2, "0"), (3, "0.2")] {
        for spacing in [0.05, 0.025] {
            if dimension == 3 && spacing < 0.05 {
                continue;
            }
            let body = format!("shape: Box(min: (0, 0, 0), max: (0.4, 0.4, {depth}))");
            let shaken = format!(
                "bodies: [({body}, velocity: (0.2513, 0, 0))], boundaries: [Tank(min: (0, 0, 0),
                max: (0.4, 0.4, {depth}), motion: Oscillation(amplitude: (0.02, 0, 0), frequency: 2))]"
            );
            let held = format!(
                "bodies: [({body})], fluid: (surface_tension: BeckerTeschner(kappa: {}))",
                if dimension == 2 { 1.0 } else { 0.05 }
            );
            for rest in [shaken, held] {
                let text = format!(
                    "(name: \"stiff\", dimension: {dimension}, spacing: {spacing}, gravity: (0, 0, 0),
                    pressure: DeltaSph(), {rest})"
                );
                let scene = Scene::parse(&text, "stiff.ron", &[]).expect("a scene");
                let mut simulation = Simulation::with_threads(&scene, 2).expect("a start");
                let mut most = 0.0_f32;
                while simulation.time() < 0.3 {
                    let report = simulation
                        .step()
                        .unwrap_or_else(|error| panic!("{error}: {text}"));
                    most = most.max(report.max_density_error);
                }
                assert!(most < 0.06, "{most}: {text}");
            }
        }
    }
}

/// A row at the surface has no pressure, and that of the rows below presses it into walls whose pressure is that of the
/// row itself: in a tenth of a second to a sixth of a spacing.
#[test]
fn the_surface_is_not_pressed_into_extrapolated_walls() {
    for (dimension, size) in [(2, [30, 10, 0]), (2, [8, 20, 0]), (3, [8, 10, 8])] {
        for method in ["Dfsph", "Iisph", "Pcisph"] {
            let nearest = |walls: &str| {
                let spacing = 0.02;
                let [width, height, depth] = size.map(|count: u32| spacing * count as f32);
                let text = format!(
                    "(name: \"still\", dimension: {dimension}, spacing: {spacing}, pressure: {method},
                    boundary_handling: {walls},
                    bodies: [(shape: Box(min: (0, 0, 0), max: ({width}, {height}, {depth})))],
                    boundaries: [Tank(min: (0, 0, 0), max: ({width}, {top}, {depth}))])",
                    top = height + 0.1
                );
                let scene = Scene::parse(&text, "still.ron", &[]).expect("a scene");
                let mut simulation = Simulation::with_threads(&scene, 1).expect("a start");
                let mut nearest = f32::INFINITY;
                while simulation.time() < 0.12 {
                    simulation.step().expect("a step");
                    for particle in particles_of(&mut simulation) {
                        let x = particle.position.x;
                        nearest = nearest.min(x.min(width - x) / spacing);
                    }
                }
                nearest
            };
            let (before, after) = (nearest("Akinci"), nearest("Extrapolated"));
            assert!(
                after > 1.2 * before && after > 0.19,
                "{method}, {dimension}-D, {size:?}: {after} instead of {before} spacings"
            );
        }
    }
}

/// The pressure on the floor is the weight of the water above it: with extrapolated walls the error is at most two
/// thirds of the one with walls that have the pressure of the particle. PCISPH in space is left out: most of its error,
/// 4.6 of 5.3 %, is not the walls' but that of the slope.
#[test]
fn extrapolated_walls_bear_the_weight_of_the_water() {
    let (plane, space) = ([12, 20, 0], [8, 12, 8]);
    for (dimension, methods, [width, height, depth]) in [
        (2, &["Dfsph", "Iisph", "Pcisph"][..], plane),
        (3, &["Dfsph", "Iisph"][..], space),
    ] {
        for method in methods {
            let error = |walls: &str| {
                let spacing = 0.02_f32;
                let [w, h, d] = [width, height, depth].map(|count: u32| spacing * count as f32);
                let text = format!(
                    "(name: \"still\", dimension: {dimension}, spacing: {spacing}, pressure: {method},
                    boundary_handling: {walls},
                    bodies: [(shape: Box(min: (0, 0, 0), max: ({w}, {h}, {d})))],
                    boundaries: [Tank(min: (0, 0, 0), max: ({w}, {top}, {d}))],
                    gauges: [(name: \"floor\", kind: WallPressure(at: ({x}, 0, {z}), normal: (0, 1, 0)))])",
                    top = h + 0.1,
                    x = 0.5 * w,
                    z = 0.5 * d,
                );
                let scene = Scene::parse(&text, "still.ron", &[]).expect("a scene");
                let mut simulation = Simulation::with_threads(&scene, 1).expect("a start");
                let (mut sum, mut time) = (0.0, 0.0);
                while simulation.time() < 1.2 {
                    let dt = f64::from(simulation.step().expect("a step").dt);
                    if simulation.time() > 0.6 {
                        sum += dt * value(&simulation, "floor", "pressure_Pa");
                        time += dt;
                    }
                }
                sum / time / (1000.0 * 9.81 * f64::from(h)) - 1.0
            };
            let (before, after) = (error("Akinci"), error("Extrapolated"));
            assert!(
                after.abs() < 0.67 * before.abs(),
                "{method}, {dimension}-D: {after} instead of {before}"
            );
        }
    }
}
