//! Runs that should end with water at rest, with an energy that does not rise, or with a known answer.
//! `benches/robustness.rs` prints them all; the tests run the affordable ones.
#![allow(
    dead_code,
    reason = "every crate that has this module uses a part of it"
)]

mod centre_pressure;
mod residual;
mod runs;

use overfall::{
    Simulation,
    loading::Override,
    scene::{Scene, SceneError},
};

use crate::support::{METHODS, Method};

const GRAVITY: f64 = 9.81;

/// Kind of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    /// Water at rest in a tank, for a duration \[s].
    Tank { depth: f64, time: f64 },
    /// A collapsing column, for a duration \[s].
    Column { height: f64, time: f64 },
    /// Sloshing water after a column collapsed, from one time to another \[s].
    Slosh { from: f64, to: f64 },
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

/// Result of a run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outcome {
    pub(crate) steps: u32,
    pub(crate) iterations: u64,
    /// Reason why it ended early.
    pub(crate) failure: Option<String>,
    /// Figures by name.
    pub(crate) figures: Vec<(&'static str, f64)>,
}

impl Outcome {
    /// A figure by its name; NaN if it was not measured.
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

/// A tank of water at rest with these numbers of spacings.
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

/// Half a metre of water with all defaults: a spacing of 0.025 m in 3-D, this number of rows in 2-D.
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

/// The dam break of Koshizuka & Oka: a column with this number of columns of particles, twice as high as wide.
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

/// A column of so many rows and twice their width that collapses into a tank, of twice that width and a third of the
/// column's height deep in 3-D: 2-D 80 columns of 10 rows in the end at 40.
pub(crate) fn slosh(method: Method, rows: u32, volume: bool) -> Case {
    let height = 0.292;
    let spacing = height / f64::from(rows);
    let width = (0.5 * height / spacing).round() * spacing;
    let (times, deep) = if volume {
        (2.0, (rows / 3) as f64 * spacing)
    } else {
        (4.0, 0.0)
    };
    let dimension = if volume { 3 } else { 2 };
    Case {
        name: format!("slosh {rows}{}", if volume { " 3-D" } else { "" }),
        scene: format!(
            "(name: \"slosh\", dimension: {dimension}, spacing: {spacing},
              bodies: [(shape: Box(min: (0, 0, 0), max: ({width}, {height}, {deep})))],
              boundaries: [Tank(min: (0, 0, 0), max: ({}, {}, {deep}))],",
            times * width,
            3.0 * height
        ),
        method,
        kind: Kind::Slosh { from: 1.7, to: 2.5 },
        sound_speed: 10.0 * (2.0 * GRAVITY * height).sqrt(),
    }
}

/// The elliptic drop with this number of particles per radius.
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

/// A standing wave with this number of rows.
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

/// Every case; `quick` omits the longest.
pub(crate) fn cases(quick: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    // Tait's, among the equations of state.
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
            cases.push(slosh(method, rows, false));
        }
        cases.push(slosh(method, 24, true));
    }
    cases
}

impl Case {
    /// The scene with overrides `path=value`.
    pub(crate) fn scene(&self, overrides: &[String]) -> Scene {
        self.parse(overrides)
            .unwrap_or_else(|error| panic!("{error}\n{}", self.scene))
    }

    /// Why the scene with overrides is refused, if it is.
    pub(crate) fn refusal(&self, overrides: &[String]) -> Option<String> {
        self.parse(overrides).err().map(|error| error.to_string())
    }

    fn parse(&self, overrides: &[String]) -> Result<Scene, SceneError> {
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
    }

    /// Runs it.
    pub(crate) fn run(&self, overrides: &[String]) -> Outcome {
        let scene = self.scene(overrides);
        let mut simulation =
            Simulation::with_threads(&scene, 2).unwrap_or_else(|error| panic!("{error}"));
        match self.kind {
            Kind::Tank { depth, time } => runs::at_rest(&mut simulation, &scene, [depth, time]),
            Kind::Column { height, time } => runs::collapse(&mut simulation, height, time),
            Kind::Slosh { from, to } => runs::sloshing(&mut simulation, &scene, [from, to]),
            Kind::Drop => runs::elliptic_drop(&mut simulation),
            Kind::Wave => runs::standing_wave(&mut simulation),
        }
    }
}
