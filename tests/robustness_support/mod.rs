//! Runs that have to end with water at rest, with energy that does not rise, or with a known answer: for
//! `benches/robustness.rs`, which prints them all, and for the tests, which run what they can afford.
#![allow(
    dead_code,
    reason = "every test file is a crate of its own and uses a part of this one"
)]

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Simulation, StepReport,
    loading::Override,
    measure::semi_axes,
    scene::Scene,
    state::particle::{Fluid, Position, Velocity},
};

use crate::support::{METHODS, Method, particles_of, reference};

const GRAVITY: f64 = 9.81;

/// What is run.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    /// Water at rest in a tank, for a time [s].
    Tank { depth: f64, time: f64 },
    /// A column that collapses, for a time [s].
    Column { height: f64, time: f64 },
    /// The elliptic drop of Monaghan 1994.
    Drop,
    /// A free standing wave of depth 1 m and wavelength 2 m.
    Wave,
}

/// A run.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) method: Method,
    pub(crate) kind: Kind,
    /// The scene, without its pressure method.
    scene: String,
    sound_speed: f64,
}

/// What came of it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outcome {
    pub(crate) steps: u32,
    pub(crate) iterations: u64,
    /// Why it ended early.
    pub(crate) failure: Option<String>,
    /// Figures by name.
    pub(crate) figures: Vec<(&'static str, f64)>,
}

impl Outcome {
    /// A figure by its name; not a number if it was not measured.
    pub(crate) fn figure(&self, name: &str) -> f64 {
        let found = self.figures.iter().find(|(found, _)| *found == name);
        found.map_or(f64::NAN, |(_, value)| *value)
    }

    /// One line.
    pub(crate) fn text(&self) -> String {
        let figures: Vec<String> = (self.figures.iter())
            .map(|(name, value)| format!("{name} {value:.4}"))
            .collect();
        let failure = self.failure.as_deref().map(|why| format!("FAILED {why} "));
        failure.unwrap_or_default() + &figures.join("  ")
    }
}

fn tank_scene(name: &str, counts: [u32; 3], spacing: f64, extra: &str) -> String {
    let [x, y, z] = counts.map(|count| f64::from(count) * spacing);
    let dimension = if counts[2] == 0 { 2 } else { 3 };
    let top = 1.3 * y + 4.0 * spacing;
    format!(
        "(name: \"{name}\", dimension: {dimension}, spacing: {spacing}, {extra}
          bodies: [(shape: Box(min: (0, 0, 0), max: ({x}, {y}, {z})))],
          boundaries: [Tank(min: (0, 0, 0), max: ({x}, {top}, {z}))],"
    )
}

/// A tank of water at rest of so many spacings.
pub(crate) fn tank(method: Method, counts: [u32; 3], time: f64) -> Case {
    let [x, y, z] = counts;
    let spacing = 0.02;
    let depth = f64::from(y) * spacing;
    let name = if z == 0 {
        format!("tank {x}x{y}")
    } else {
        format!("tank {x}x{y}x{z}")
    };
    Case {
        scene: tank_scene("tank", counts, spacing, ""),
        name,
        method,
        kind: Kind::Tank { depth, time },
        sound_speed: 10.0 * (2.0 * GRAVITY * depth).sqrt(),
    }
}

/// Half a metre of water with all defaults, 0.025 m of spacing in 3-D and so many rows in 2-D.
pub(crate) fn pond(method: Method, rows: u32, volume: bool) -> Case {
    let spacing = 0.5 / f64::from(rows);
    let counts = if volume {
        [rows / 2, rows, rows / 2]
    } else {
        [rows, rows, 0]
    };
    Case {
        name: format!("pond {rows}{}", if volume { " 3-D" } else { "" }),
        scene: tank_scene("pond", counts, spacing, ""),
        method,
        kind: Kind::Tank {
            depth: 0.5,
            time: 3.5,
        },
        sound_speed: 10.0 * (2.0 * GRAVITY * 0.5f64).sqrt(),
    }
}

/// The dam break of Koshizuka & Oka: a column of so many rows and a height of twice its width.
pub(crate) fn column(method: Method, rows: u32, step: &str, time: f64) -> Case {
    let height = 0.292;
    let spacing = height / f64::from(rows);
    let width = 0.5 * height;
    let long = (4.0 * width / spacing).round() * spacing;
    let scene = format!(
        "(name: \"column\", dimension: 2, spacing: {spacing}, {}
          bodies: [(shape: Box(min: (0, 0, 0), max: ({width}, {height}, 0)))],
          boundaries: [Tank(min: (0, 0, 0), max: ({long}, {}, 0))],",
        if step.is_empty() {
            String::new()
        } else {
            format!("time_step: {step},")
        },
        3.0 * height
    );
    Case {
        name: format!("column {rows} {step}"),
        scene,
        method,
        kind: Kind::Column { height, time },
        sound_speed: 10.0 * (2.0 * GRAVITY * height).sqrt(),
    }
}

/// The elliptic drop with so many particles along a radius.
pub(crate) fn drop(method: Method, radius: u32) -> Case {
    let spacing = 1.0 / f64::from(radius);
    let scene = format!(
        "(name: \"drop\", dimension: 2, spacing: {spacing}, gravity: (0, 0, 0), time_step: Cfl(max: {}),
          fluid: (viscosity: None),
          bodies: [(shape: Sphere(center: (0, 0, 0), radius: 1))],",
        0.002 * spacing
    );
    Case {
        name: format!("drop {radius}"),
        scene,
        method,
        kind: Kind::Drop,
        sound_speed: 1400.0,
    }
}

/// A standing wave with so many rows.
pub(crate) fn wave(method: Method, rows: u32) -> Case {
    let spacing = 1.0 / f64::from(rows);
    Case {
        name: format!("wave {rows}"),
        scene: tank_scene("wave", [2 * rows, rows, 0], spacing, ""),
        method,
        kind: Kind::Wave,
        sound_speed: 10.0 * (2.0 * GRAVITY).sqrt(),
    }
}

/// Every case, the longest left out if it is to be quick.
pub(crate) fn cases(quick: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    // Of the equations of state Tait's.
    for method in METHODS.into_iter().skip(1) {
        for y in [10, 40, 60, 120, 240] {
            for x in [8, 18, 30, 100] {
                if !quick || x * y <= 5000 {
                    cases.push(tank(method, [x, y, 0], 0.5));
                }
            }
        }
        for y in [10, 40, 60, 100, 140] {
            for x in [8, 18, 30] {
                if !quick || x * y <= 1100 {
                    cases.push(tank(method, [x, y, 10], 0.5));
                }
            }
        }
        cases.push(pond(method, 20, false));
        cases.push(pond(method, 40, false));
        cases.push(pond(method, 20, true));
        for rows in [40, 80, 160] {
            for step in ["", "Fixed(2e-4)", "Adaptive()"] {
                if !quick || rows < 160 {
                    cases.push(column(method, rows, step, 1.0));
                }
            }
        }
        for radius in [20, 40, 80, 160] {
            if !quick || radius < 160 {
                cases.push(drop(method, radius));
            }
        }
        for rows in [20, 40] {
            cases.push(wave(method, rows));
        }
    }
    cases
}

impl Case {
    /// The scene with overrides `path=value`.
    pub(crate) fn scene(&self, overrides: &[String]) -> Scene {
        let text = format!(
            "{} pressure: {})",
            self.scene,
            (self.method.pressure)(self.sound_speed as f32)
        );
        let overrides: Vec<Override> = overrides
            .iter()
            .map(|text| {
                let (path, value) = text.split_once('=').unwrap_or((text, ""));
                Override {
                    path: path.to_owned(),
                    value: value.to_owned(),
                }
            })
            .collect();
        Scene::parse(&text, "robustness.ron", &overrides)
            .unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    /// Runs it.
    pub(crate) fn run(&self, overrides: &[String]) -> Outcome {
        let scene = self.scene(overrides);
        let mut simulation =
            Simulation::with_threads(&scene, 2).unwrap_or_else(|error| panic!("{error}"));
        match self.kind {
            Kind::Tank { depth, time } => at_rest(&mut simulation, depth, time),
            Kind::Column { height, time } => collapse(&mut simulation, height, time),
            Kind::Drop => elliptic_drop(&mut simulation),
            Kind::Wave => standing_wave(&mut simulation),
        }
    }
}

/// Steps to a time; ends with what went wrong.
fn run(
    simulation: &mut Simulation,
    time: f64,
    mut observe: impl FnMut(&mut Simulation, &StepReport),
) -> Outcome {
    let mut outcome = Outcome::default();
    while simulation.time() < time {
        match simulation.step() {
            Ok(report) => {
                outcome.steps += 1;
                outcome.iterations +=
                    u64::from(report.iterations) + u64::from(report.divergence_iterations);
                observe(simulation, &report);
            }
            Err(error) => {
                outcome.failure = Some(error.to_string());
                break;
            }
        }
    }
    outcome
}

/// Largest speed at any time and at the end, root mean square at the end, in sqrt(g H); energy gained in m g H.
fn at_rest(simulation: &mut Simulation, depth: f64, time: f64) -> Outcome {
    let scale = (GRAVITY * depth).sqrt();
    let (mut fastest, mut last, mut rms, mut early) = (0.0f64, 0.0, 0.0, f64::NAN);
    let (mut energy, mut gained, mut error) = (None, 0.0f64, 0.0f64);
    let mut outcome = run(simulation, time, |_, report| {
        last = f64::from(report.max_speed) / scale;
        fastest = fastest.max(last);
        error = error.max(f64::from(report.max_density_error));
        let total = report.kinetic_energy + report.potential_energy;
        // The centre is half as high as the surface.
        let start = *energy.get_or_insert(total);
        gained = gained.max((total - start) / start.abs());
        let mass = report.particles as f64;
        rms = (2.0 * report.kinetic_energy / mass).sqrt() / scale;
        if report.time <= 2.0 {
            early = rms;
        }
    });
    // Of a particle's mass: the mean speed does not depend on how it is counted.
    let mass = particle_mass(simulation).sqrt();
    outcome.figures = vec![
        ("fastest", fastest),
        ("at end", last),
        ("rms 2 s", early / mass),
        ("rms", rms / mass),
        ("gained", gained),
        ("compressed", error),
    ];
    outcome
}

fn particle_mass(simulation: &Simulation) -> f64 {
    f64::from(
        simulation
            .world()
            .resource::<overfall::state::Material>()
            .particle_mass,
    )
}

/// Rise of energy from its least, and the front at 0.2 s.
fn collapse(simulation: &mut Simulation, height: f64, time: f64) -> Outcome {
    let (mut least, mut rise, mut step_rise, mut start) = (f64::INFINITY, 0.0f64, 0.0f64, None);
    let (mut front, mut before, mut error) = (f64::NAN, f64::NAN, 0.0f64);
    let mut mean = 0.0;
    let mut outcome = run(simulation, time, |simulation, report| {
        let energy = report.kinetic_energy + report.potential_energy;
        let scale = *start.get_or_insert(energy);
        least = least.min(energy);
        rise = rise.max((energy - least) / scale);
        if before.is_finite() {
            step_rise = step_rise.max((energy - before) / scale);
        }
        before = energy;
        error = error.max(f64::from(report.max_density_error));
        mean += f64::from(report.mean_density_error) * f64::from(report.dt);
        if front.is_nan() && report.time >= 0.2 {
            let x = particles_of(simulation).into_iter().map(|p| p.position.x);
            front = f64::from(x.fold(0.0, f32::max)) / (0.5 * height);
        }
    });
    outcome.figures = vec![
        ("rise", rise),
        ("step rise", step_rise),
        ("energy", before / start.unwrap_or(f64::NAN)),
        ("front 0.2 s", front),
        ("compressed", error),
        ("mean", mean / simulation.time().max(1e-9)),
    ];
    outcome
}

/// Semi-major axis at 7.6 ms over the known, and the energy's change.
fn elliptic_drop(simulation: &mut Simulation) -> Outcome {
    let world = simulation.world_mut();
    let mut particles = world.query_filtered::<(&Position, &mut Velocity), With<Fluid>>();
    for (x, mut v) in particles.iter_mut(world) {
        v.0 = Vec3::new(-100.0 * x.0.x, 100.0 * x.0.y, 0.0);
    }
    let rows = reference("elliptic_drop_analytic.csv", ["t_s", "b"]);
    let known = rows
        .windows(2)
        .find(|pair| pair[1][0] >= 0.0076)
        .map_or(f64::NAN, |pair| {
            let part = (0.0076 - pair[0][0]) / (pair[1][0] - pair[0][0]);
            pair[0][1] + part * (pair[1][1] - pair[0][1])
        });
    let (mut start, mut low, mut high) = (None, 0.0f64, 0.0f64);
    let mut ends = [[f64::NAN; 2]; 2];
    let mut outcome = run(simulation, 0.0076, |simulation, report| {
        let energy = report.kinetic_energy;
        let change = energy / *start.get_or_insert(energy) - 1.0;
        (low, high) = (low.min(change), high.max(change));
        if report.time > 0.0074 {
            let [_, b] = semi_axes(particles_of(simulation).iter().map(|p| p.position));
            ends = [ends[1], [report.time, b]];
        }
    });
    let [[t0, b0], [t1, b1]] = ends;
    let axis = b0 + (0.0076 - t0) / (t1 - t0) * (b1 - b0);
    outcome.figures = vec![
        ("axis error %", 100.0 * (axis / known - 1.0)),
        ("energy least %", 100.0 * low),
        ("energy most %", 100.0 * high),
    ];
    outcome
}

/// Part of the mode's energy lost per period.
///
/// The mode is the displacement of linear theory; its amplitude is the projection of the particles' displacement from
/// the lattice on the surface's cosine, its energy the square of the peaks.
fn standing_wave(simulation: &mut Simulation) -> Outcome {
    let k = std::f64::consts::PI;
    let amplitude = 0.05;
    let world = simulation.world_mut();
    let mut particles = world.query_filtered::<&mut Position, With<Fluid>>();
    for mut x in particles.iter_mut(world) {
        let [px, py] = [f64::from(x.0.x), f64::from(x.0.y)];
        let scale = amplitude / k.sinh();
        x.0.x -= (scale * (k * px).sin() * (k * py).cosh()) as f32;
        x.0.y += (scale * (k * px).cos() * (k * py).sinh()) as f32;
    }
    let period = std::f64::consts::TAU / (GRAVITY * k * k.tanh()).sqrt();
    let mut series: Vec<(f64, f64)> = Vec::new();
    let mut outcome = run(simulation, 3.2 * period, |simulation, report| {
        let particles = particles_of(simulation);
        let count = particles.len() as f64;
        let mode: f64 = particles
            .iter()
            .map(|p| f64::from(p.position.y) * (k * f64::from(p.position.x)).cos())
            .sum();
        series.push((report.time, 2.0 * mode / count));
    });
    // Peaks of either sign, half a period apart.
    let peak = |from: f64, to: f64| {
        let within = series.iter().filter(|(t, _)| (from..to).contains(t));
        within.fold((0.0, 0.0f64), |best, &(t, a)| {
            if a.abs() > best.1 { (t, a.abs()) } else { best }
        })
    };
    let at = |n: f64| peak((n - 0.2) * period, (n + 0.2) * period);
    let (half, first, third) = (at(0.5), at(1.0), at(3.0));
    let lost = |ratio: f64, periods: f64| 1.0 - ratio.powf(2.0 / periods);
    outcome.figures = vec![
        ("lost per period %", 100.0 * lost(third.1 / first.1, 2.0)),
        ("in the first %", 100.0 * lost(first.1 / half.1, 0.5)),
        ("period", (third.0 - first.0) / (2.0 * period)),
    ];
    outcome
}
