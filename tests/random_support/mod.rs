//! Small random scenes: bodies and solids in the cells of a grid, inside a container.
//!
//! A scene is built from a list of numbers in which zero always selects the simplest choice: proptest shrinks towards
//! it.

#![allow(dead_code, reason = "each test uses a part")]

mod maker;
pub(crate) mod solids;
pub(crate) mod sums;

use glam::DVec3;

use crate::mesh_support::Files;
use solids::Solid;

/// Numbers of choices for each part of a scene.
pub(crate) const CHOICES: usize = OF_FLUID + 10 * PART;
/// For the fluid, for the container, and for every cell.
const PART: usize = 28;
const OF_FLUID: usize = 20;

/// Choices in their order, followed by zeros.
struct Choices<'a>(std::slice::Iter<'a, u16>);

impl Choices<'_> {
    fn next(&mut self) -> u16 {
        self.0.next().copied().unwrap_or(0)
    }

    /// One entry of a list; the first is the simplest.
    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[usize::from(self.next()) % list.len()]
    }

    /// From 0 to below 1.
    fn part(&mut self) -> f64 {
        f64::from(self.next()) / 65536.0
    }

    /// From -1 to below 1, and 0 for 0.
    fn signed(&mut self) -> f64 {
        let part = self.part();
        if self.next().is_multiple_of(2) {
            part
        } else {
            -part
        }
    }

    fn vector(&mut self, flat: bool) -> DVec3 {
        let [x, y, z] = [self.signed(), self.signed(), self.signed()];
        DVec3::new(x, y, if flat { 0.0 } else { z })
    }
}

/// The text of a scene, and properties that a test needs.
#[derive(Debug)]
pub(crate) struct Draft {
    pub(crate) text: String,
    pub(crate) solids: Vec<Solid>,
    /// Whether particles start displaced from their lattices.
    pub(crate) has_jitter: bool,
    /// Fraction of the time step that the scene's limits allow, if it is fixed.
    pub(crate) fixed_part: Option<f64>,
}

struct Maker<'a> {
    files: &'a Files,
    flat: bool,
    /// Spacing \[m].
    spacing: f64,
    /// Origin of the grid of cells \[m].
    origin: DVec3,
    bodies: Vec<String>,
    boundaries: Vec<String>,
    solids: Vec<Solid>,
    has_jitter: bool,
    /// Scale of velocities \[m/s].
    speed: f64,
}

/// Edge of a cell \[spacings].
fn cell_edge(flat: bool) -> f64 {
    if flat { 9.0 } else { 6.0 }
}

fn vector(x: DVec3) -> String {
    format!("({}, {}, {})", x.x as f32, x.y as f32, x.z as f32)
}

/// Creates a random scene; meshes are written into `files`.
pub(crate) fn draw(choices: &[u16], files: &Files) -> Draft {
    let (fluid, rest) = choices.split_at(OF_FLUID.min(choices.len()));
    let mut parts = rest.chunks(PART);
    let mut part = || Choices(parts.next().unwrap_or_default().iter());
    let mut general = part();
    let flat = general.of(&[true, false]);
    let spacing = general.of(&[0.02, 0.1, 0.003, 1.0]);
    let gravity = match general.of(&[0, 1, 2, 3]) {
        0 => DVec3::NEG_Y * 9.81,
        1 => DVec3::ZERO,
        2 => general.vector(flat) * 9.81,
        _ => DVec3::NEG_Y * 100.0,
    };
    let cells = if flat {
        DVec3::new(3.0, 2.0, 0.0)
    } else {
        DVec3::new(2.0, 2.0, 1.0)
    };
    let extent = cells * cell_edge(flat) * spacing;
    // The speed of water that falls through the scene, or a tenth of that if nothing falls.
    let fall = (2.0 * gravity.length().max(0.1) * extent.y).sqrt();
    let far = general.of(&[0.0, 0.0, 1.0, -17.37, 3000.0]);
    let mut maker = Maker {
        files,
        flat,
        spacing,
        origin: DVec3::new(1.0, -0.5, if flat { 0.0 } else { 0.25 }) * far * spacing,
        bodies: Vec::new(),
        boundaries: Vec::new(),
        solids: Vec::new(),
        has_jitter: false,
        speed: fall * general.of(&[0.0, 0.3, 1.0, 2.0]),
    };
    maker.container(part(), extent);
    for z in 0..(cells.z as usize).max(1) {
        for y in 0..cells.y as usize {
            for x in 0..cells.x as usize {
                let cell = DVec3::new(x as f64, y as f64, z as f64);
                maker.fill(part(), cell);
            }
        }
    }
    let speed = (fall * fall + 4.0 * maker.speed * maker.speed).sqrt();
    let (numerics, fixed_part) = numerics(Choices(fluid.iter()), flat, spacing, speed);
    let Maker {
        bodies,
        boundaries,
        solids,
        has_jitter,
        ..
    } = maker;
    let text = format!(
        "(\n    name: \"random\", dimension: {}, spacing: {spacing}, gravity: {},\n    {numerics},\n    bodies: \
         [\n        {}\n    ],\n    boundaries: [\n        {}\n    ],\n)",
        if flat { 2 } else { 3 },
        vector(gravity),
        bodies.join(",\n        "),
        boundaries.join(",\n        ")
    );
    Draft {
        text,
        solids,
        has_jitter,
        fixed_part,
    }
}

/// Numerical settings of the fluid for a speed of up to `speed` \[m/s], and the fraction of the longest time step, if
/// it is fixed.
fn numerics(mut of: Choices, flat: bool, spacing: f64, speed: f64) -> (String, Option<f64>) {
    let support = of.of(&[2.0, 2.0, 1.7, 2.3, 2.6, 3.0]);
    let sound = 10.0 * speed;
    let variant = of.of(&[
        "",
        "",
        "",
        "momentum: false",
        "recovery: 1",
        "warm_start: 0",
        "max_density_error: 1e-3",
    ]);
    let pressure = match of.of(&[0, 1, 2, 3, 4, 5]) {
        0 => format!("Dfsph({variant})"),
        1 => format!("Iisph({variant})"),
        2 => format!("Pcisph({variant})"),
        3 => format!(
            "Sesph(equation: Tait(stiffness: {}))",
            1000.0 * sound * sound / 7.0
        ),
        4 => format!("Sesph(equation: Gas(stiffness: {}))", sound * sound),
        // The reference has the cubic spline.
        _ => format!("DeltaSph(sound_speed: {sound}), kernel: CubicSpline"),
    };
    let (time_step, fixed) = match of.of(&[0, 0, 1, 2, 3]) {
        0 => ("Cfl(min: 1e-9)".to_owned(), None),
        1 => ("Cfl(min: 1e-9, factor: 0.4)".to_owned(), None),
        2 => ("Adaptive(min: 1e-9)".to_owned(), None),
        _ => ("Fixed(1e-9)".to_owned(), Some(0.1 + 0.8 * of.part())),
    };
    let viscosity = match of.of(&[0, 0, 1, 2, 3, 4]) {
        0 => "Laminar(kinematic_viscosity: 1e-6)".to_owned(),
        1 => "None".to_owned(),
        2 => "Laminar(kinematic_viscosity: 1e-6, numerical: 0)".to_owned(),
        // The Reynolds number of a spacing is one.
        3 => format!("Laminar(kinematic_viscosity: {})", speed * spacing),
        _ => format!("Artificial(alpha: 0.1, sound_speed: {sound})"),
    };
    // The acceleration of a particle at a flat surface is about that of falling one spacing in the time of crossing
    // one.
    let pull = of.of(&[0.0, 0.0, 0.0, 0.1, 1.0]) * 0.01 * speed * speed / spacing;
    let tension = if pull > 0.0 {
        let power = if flat { 1 } else { 2 };
        format!(
            "BeckerTeschner(kappa: {})",
            pull * spacing.powi(power) / support
        )
    } else {
        "None".to_owned()
    };
    let handling = of.of(&[
        "Akinci",
        "Akinci",
        "DirectForcing()",
        "DirectForcing(rest_distance: 0.7, slip: 0)",
    ]);
    let structure = of.of(&[
        "CompactHashing",
        "UniformGrid",
        "IndexSort",
        "ZIndexSort",
        "SpatialHashing",
        "BruteForce",
    ]);
    let cell = of.of(&[1.0, 1.0, 0.5, 0.3]);
    let neighbours = of.of(&["Stored", "Recomputed"]);
    let reorder = of.of(&[25, 1, 0, 3]);
    let executor = of.of(&["Auto", "SingleThreaded", "Parallel"]);
    let text = format!(
        "support: {support}, pressure: {pressure}, time_step: {time_step},
    fluid: (viscosity: {viscosity}, surface_tension: {tension}), boundary_handling: {handling},
    index: (structure: {structure}, cell_size: {cell}), neighbours: {neighbours}, reorder_interval: {reorder},
    executor: {executor}"
    );
    (text, fixed)
}
