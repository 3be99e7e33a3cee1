//! Periodic axes: a seam is no place. Nothing that is measured depends on where the faces are.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};
use overfall::{
    Simulation, Step, checkpoint,
    gauge::{Gauges, Snapshot},
    scene::Scene,
    state::particle::Velocity,
};

use crate::support::{Particle, measured, particles_of, scene, simulation, step};

const METHODS: [&str; 4] = [
    "Sesph(equation: Tait(stiffness: 60000))",
    "Pcisph()",
    "Iisph()",
    "Dfsph()",
];

/// Every structure, and both ways to have neighbours.
const SEARCHES: [&str; 7] = [
    "index: (structure: UniformGrid)",
    "index: (structure: IndexSort)",
    "index: (structure: ZIndexSort)",
    "index: (structure: SpatialHashing)",
    "index: (structure: CompactHashing), neighbours: Recomputed",
    "index: (structure: SpatialHashing), neighbours: Recomputed",
    "index: (structure: BruteForce)",
];

/// Particles in the order of their entities.
fn in_order(simulation: &mut Simulation) -> Vec<Particle> {
    let mut particles = particles_of(simulation);
    particles.sort_by_key(|particle| particle.entity);
    particles
}

/// Along these axes, in a box of n³ or n² particles at a spacing of 0.1 m.
fn axes(periodic: &str, n: u32) -> String {
    let length = 0.1 * f64::from(n);
    let faces = |axis| format!("{axis}: (0, {length})");
    periodic.chars().map(faces).collect::<Vec<_>>().join(", ")
}

/// A full periodic box in uniform motion is a lattice for ever, whatever its velocity is: to the rounding of
/// coordinates in single precision, 1e-6 spacings a step.
#[test]
fn a_lattice_in_any_uniform_motion_stays_one() {
    for (dimension, n, periodic, steps) in [(2, 8, "xy", 1000), (3, 7, "xyz", 150)] {
        let deep = if dimension == 2 {
            0.0
        } else {
            0.1 * f64::from(n)
        };
        let edge = 0.1 * f64::from(n);
        for method in METHODS {
            let velocity = Vec3::new(1.3, -0.7, if dimension == 2 { 0.0 } else { 0.9 });
            let Vec3 { x, y, z } = velocity;
            let mut lattice = simulation(&format!(
                "(name: \"drift\", dimension: {dimension}, spacing: 0.1, gravity: (0, 0, 0), pressure: {method},
                  periodic: ({}), time_step: Fixed(0.002),
                  bodies: [(shape: Box(min: (0, 0, 0), max: ({edge}, {edge}, {deep})), velocity: ({x}, {y}, {z}))])",
                axes(periodic, n)
            ));
            let start = in_order(&mut lattice);
            let mut density = 0.0_f32;
            for _ in 0..steps {
                density = density.max(step(&mut lattice).max_density_error);
            }
            let period = Vec3::splat(edge as f32);
            let way = lattice.time() as f32 * velocity;
            let (mut off, mut wrong) = (0.0_f32, 0.0_f32);
            for (before, now) in start.iter().zip(&in_order(&mut lattice)) {
                let mut d = now.position - before.position - way;
                d -= period * (d / period).round();
                off = off.max(d.length() / 0.1);
                wrong = wrong.max(now.velocity.distance(velocity));
                let is_inside = now.position.cmpge(Vec3::ZERO) & now.position.cmple(period);
                assert!(is_inside.all(), "{} has left the box", now.position);
            }
            let figures = format!(
                "{dimension}-D {method}: {off:.1e} spacings off, velocities {wrong:.1e} m/s, density {density:.1e}"
            );
            measured(&figures);
            assert!(off < 2e-2 && wrong < 2e-3 && density < 1e-3, "{figures}");
        }
    }
}

/// Vortices with viscosity and tension, whose faces lie elsewhere by a part of the period.
fn vortices_scene(dimension: u32, method: &str, search: &str, shift: Vec3) -> Scene {
    let Vec3 { x, y, z } = shift;
    let deep = if dimension == 2 { 0.0 } else { 0.8 };
    let third = if dimension == 2 {
        String::new()
    } else {
        format!(", z: ({z}, {})", z + 0.8)
    };
    let text = format!(
        "(name: \"vortices\", dimension: {dimension}, spacing: 0.1, gravity: (0, 0, 0), pressure: {method}, {search},
          periodic: (x: ({x}, {}), y: ({y}, {}){third}), time_step: Fixed(0.002), reorder_interval: 7,
          fluid: (viscosity: Laminar(kinematic_viscosity: 0.01), surface_tension: BeckerTeschner(kappa: 0.01)),
          bodies: [(shape: Box(min: (0, 0, 0), max: (0.8, 0.8, {deep})),
            velocity_field: TaylorGreen(speed: 1, wavelength: 0.8))])",
        x + 0.8,
        y + 0.8
    );
    scene(&text)
}

/// Steps of the vortices. In a box without a free surface the solvers can only raise pressures as the lattice distorts;
/// later than this they break down (`docs/accuracy.md`), and rounding decides.
const STEPS: usize = 11;

/// The same after some steps.
fn vortices(dimension: u32, method: &str, search: &str, shift: Vec3, threads: usize) -> Simulation {
    let scene = vortices_scene(dimension, method, search, shift);
    let mut simulation = Simulation::with_threads(&scene, threads).expect("a simulation");
    for _ in 0..STEPS {
        step(&mut simulation);
    }
    simulation
}

/// By any part of the period, with every method and both dimensions: velocities and pressures are the same.
#[test]
fn nothing_depends_on_where_the_faces_are() {
    for (dimension, methods) in [(2, &METHODS[..]), (3, &METHODS[3..])] {
        for method in methods {
            let mut here = vortices(dimension, method, SEARCHES[4], Vec3::ZERO, 2);
            let here = in_order(&mut here);
            let shift = Vec3::new(0.37, -0.21, if dimension == 2 { 0.0 } else { 0.55 });
            let mut there = vortices(dimension, method, SEARCHES[4], shift, 2);
            let (mut off, mut pressure) = (0.0_f32, 0.0_f32);
            let most = here.iter().map(|p| p.pressure).fold(1.0, f32::max);
            let there = in_order(&mut there);
            assert_eq!(here.len(), there.len());
            for a in &here {
                // Rows start along the Z-curve of the box, which is another.
                let away = |b: &&Particle| {
                    let d = (b.position - a.position) / 0.8;
                    (d - d.round()).length()
                };
                let b = (there.iter()).min_by(|b, c| away(b).total_cmp(&away(c)));
                let b = b.expect("a particle");
                assert!(away(&b) < 0.02, "{a:?} {b:?}");
                off = off.max(a.velocity.distance(b.velocity));
                pressure = pressure.max((a.pressure - b.pressure).abs() / most);
            }
            let figures = format!("{dimension}-D {method}: {off:.1e} m/s, pressure {pressure:.1e}");
            measured(&figures);
            assert!(off < 2e-3 && pressure < 2e-2, "{figures}");
        }
    }
}

/// Momentum is that of the start, to rounding.
#[test]
fn the_seams_keep_momentum() {
    for method in METHODS {
        let mut flow = vortices(2, method, SEARCHES[2], Vec3::ZERO, 2);
        let sum: DVec3 = (particles_of(&mut flow).iter())
            .map(|p| p.velocity.as_dvec3())
            .sum();
        let off = sum.length() / 64.0;
        measured(&format!("{method}: {off:.1e} m/s"));
        assert!(off < 1e-6, "{method}: {off:e}");
    }
}

/// Every structure, stored lists or not, and any number of threads: structures agree to rounding, threads to the bit.
#[test]
fn searches_and_threads_agree_across_seams() {
    let mut reference = vortices(2, "Dfsph()", SEARCHES[6], Vec3::ZERO, 2);
    let reference = in_order(&mut reference);
    for search in SEARCHES {
        let mut one = vortices(2, "Dfsph()", search, Vec3::ZERO, 1);
        let mut three = vortices(2, "Dfsph()", search, Vec3::ZERO, 3);
        let (one, three) = (in_order(&mut one), in_order(&mut three));
        for ((a, b), known) in one.iter().zip(&three).zip(&reference) {
            assert_eq!(
                a.position.to_array().map(f32::to_bits),
                b.position.to_array().map(f32::to_bits)
            );
            assert_eq!(a.pressure.to_bits(), b.pressure.to_bits(), "{search}");
            assert!(a.velocity.distance(known.velocity) < 1e-3, "{search}");
        }
    }
}

/// Water stands in a channel whose floor goes round: as still as in a tank, and the density is right at the seam.
#[test]
fn water_is_at_rest_in_a_channel_without_ends() {
    for (dimension, walls) in [
        (2, "Tank(min: (0, 0, 0), max: (1, 1.2, 0))"),
        (2, "Box(min: (-0.3, -0.3, 0), max: (1.7, 0, 0))"),
        (
            2,
            "Plane(center: (0.2, 0, 0), normal: (0, 1, 0), half_size: 3)",
        ),
        (3, "Tank(min: (0, 0, 0), max: (1, 1.2, 1))"),
        (
            3,
            "Plane(center: (0.2, 0, 0.1), normal: (0, 1, 0), half_size: 3)",
        ),
    ] {
        let deep = if dimension == 2 { 0.0 } else { 1.0 };
        let across = if dimension == 2 { "" } else { ", z: (0, 1)" };
        let text = format!(
            "(name: \"channel\", dimension: {dimension}, spacing: 0.1, periodic: (x: (0, 1){across}),
              bodies: [(shape: Box(min: (0, 0, 0), max: (1, 0.6, {deep})))], boundaries: [{walls}])"
        );
        let plan = overfall::plan(&scene(&text)).unwrap_or_else(|error| panic!("{error}"));
        let start = plan.start_density.expect("a density");
        assert!(start.max_error < 5e-3, "{walls}: {start:?}");
        let mut channel = simulation(&text);
        let (mut fastest, mut lowest) = (0.0_f32, f32::INFINITY);
        for _ in 0..60 {
            step(&mut channel);
        }
        for particle in particles_of(&mut channel) {
            fastest = fastest.max(particle.velocity.length());
            lowest = lowest.min(particle.position.y);
        }
        let figures = format!("{dimension}-D {walls}: {fastest:.1e} m/s, lowest {lowest:.3} m");
        measured(&figures);
        assert!(fastest < 0.1 && lowest > 0.03, "{figures}");
    }
}

/// What gauges and snapshots say of a point does not depend on whether its surroundings lie across a seam.
#[test]
fn instruments_look_across_the_seam() {
    let text = |low: f64| {
        format!(
            "(name: \"stream\", dimension: 2, spacing: 0.1, gravity: (0, -9.81, 0), time_step: Fixed(0.001),
              periodic: (x: ({low}, {})), boundaries: [Plane(center: (0, 0, 0), normal: (0, 1, 0), half_size: 9)],
              bodies: [(shape: Box(min: (0, 0, 0), max: (1.6, 0.6, 0)), velocity: (0.5, 0, 0))],
              gauges: [(name: \"p\", kind: Pressure(at: (0.03, 0.2, 0), radius: 0.3)),
                (name: \"v\", kind: Velocity(at: (0, 0.3, 0), radius: 0.3)),
                (name: \"level\", kind: Height(at: (0.01, 0, 0), radius: 0.25)),
                (name: \"flux\", kind: Flux(corner: (0.02, 0, 0), along: (0, 2, 0)))])",
            low + 1.6
        )
    };
    let read = |low: f64| {
        let mut stream = simulation(&text(low));
        for _ in 0..30 {
            step(&mut stream);
        }
        let gauges = stream.world().resource::<Gauges>();
        let mut values = Vec::new();
        for name in ["p", "v", "level", "flux"] {
            let gauge = gauges.get(name).expect("a gauge");
            let last = gauge.readings().last().expect("a reading");
            values.extend(last.values.iter().map(|value| value.unwrap_or(f64::NAN)));
        }
        let snapshot = Snapshot::of(stream.world()).expect("a snapshot");
        // Images of one point.
        for x in [0.0, 1.6, -1.6] {
            let at = Vec3::new(x, 0.3, 0.0);
            values.push(snapshot.neighbours_of(at).len() as f64);
            let found = snapshot.interpolate::<Velocity>(&[at]);
            values.push(found[0].value.expect("fluid").0.x.into());
        }
        values
    };
    // A face through the instruments, and none near them.
    let (at_face, inside) = (read(0.0), read(-0.8));
    for (a, b) in at_face.iter().zip(&inside) {
        assert!(
            (a - b).abs() <= 1e-3 * b.abs().max(1e-2),
            "{at_face:?} and {inside:?}"
        );
    }
}

/// A run goes on from a checkpoint to the bit, across seams.
#[test]
fn a_checkpoint_resumes_across_seams() {
    let mut whole = vortices(2, "Dfsph()", SEARCHES[4], Vec3::ZERO, 2);
    let mut saved = Vec::new();
    checkpoint::write(whole.world_mut(), &mut saved).expect("a checkpoint");
    let scene = vortices_scene(2, "Dfsph()", SEARCHES[4], Vec3::ZERO);
    let mut resumed = Simulation::with_threads(&scene, 2).expect("a simulation");
    checkpoint::restore(resumed.world_mut(), &mut &saved[..]).expect("a resumed run");
    for _ in 0..STEPS {
        step(&mut whole);
        step(&mut resumed);
    }
    let sorted = |simulation: &mut Simulation| {
        let mut places: Vec<[u32; 3]> = (particles_of(simulation).iter())
            .map(|p| p.position.to_array().map(f32::to_bits))
            .collect();
        places.sort_unstable();
        places
    };
    assert_eq!(sorted(&mut whole), sorted(&mut resumed));
}

/// Names of the systems of a step.
fn systems(text: &str) -> BTreeSet<String> {
    let mut simulation = simulation(text);
    step(&mut simulation);
    simulation.world_mut().schedule_scope(Step, |_, step| {
        let systems = step.systems().expect("a schedule that has run");
        let names = systems.map(|(_, system)| system.name().to_string());
        names.collect()
    })
}

/// What a scene does not ask for is not in its step: periodic axes and walls in motion come with systems of their own,
/// and one without them has none of these.
#[test]
fn scenes_without_seams_and_motion_have_no_systems_of_them() {
    let scene = |motion: &str, more: &str| {
        format!(
            "(name: \"plain\", dimension: 2, spacing: 0.1, {more}
              bodies: [(shape: Box(min: (0, 0, 0), max: (1, 0.5, 0)))],
              boundaries: [Tank(min: (0, 0, 0), max: (1, 1, 0) {motion})])"
        )
    };
    let plain = systems(&scene("", ""));
    let moving = systems(&scene(", motion: Velocity(velocity: (0.1, 0, 0))", ""));
    let periodic = systems(&scene("", "periodic: (x: (-1, 2)),"));
    let more = |than: &BTreeSet<String>| than.difference(&plain).cloned().collect::<Vec<_>>();
    let (of_motion, of_seams) = (more(&moving), more(&periodic));
    let named = |names: &[String], parts: &[&str]| {
        let known = |name: &String| parts.iter().any(|part| name.contains(part));
        !names.is_empty() && names.iter().all(known)
    };
    assert!(named(&of_motion, &["wall", "room"]), "{of_motion:?}");
    assert!(named(&of_seams, &["wrap"]), "{of_seams:?}");
    assert!(plain.is_subset(&moving) && plain.is_subset(&periodic));
}
