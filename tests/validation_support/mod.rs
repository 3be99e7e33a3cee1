//! Cases with known answers, each a scene of `assets/scenes/validation`, a run and the figures that are compared: for
//! the tests, which run the scenes as they are, and for `cargo bench --bench validation`, which prints all figures.
#![allow(
    dead_code,
    reason = "every crate that has this module uses a part of it"
)]

pub(crate) mod dam_break;
pub(crate) mod elliptic_drop;
pub(crate) mod free_flight;
pub(crate) mod hydrostatic;

use std::path::Path;

use overfall::{Simulation, loading::Override, scene::Scene};

use crate::support::Method;

/// One thing that was measured and is known.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    pub(crate) quantity: String,
    pub(crate) measured: f64,
    pub(crate) reference: f64,
    /// What errors are relative to.
    pub(crate) scale: f64,
}

impl Figure {
    /// A quantity whose error is relative to its reference.
    pub(crate) fn new(quantity: impl Into<String>, measured: f64, reference: f64) -> Self {
        Self {
            quantity: quantity.into(),
            measured,
            reference,
            scale: reference,
        }
    }

    /// A quantity that should be zero, in units of what it is measured by.
    pub(crate) fn residual(quantity: impl Into<String>, measured: f64) -> Self {
        Self {
            quantity: quantity.into(),
            measured,
            reference: 0.0,
            scale: 1.0,
        }
    }

    /// Signed relative error.
    pub(crate) fn error(&self) -> f64 {
        (self.measured - self.reference) / self.scale
    }
}

/// A case: its scene, and what a method makes of it.
pub(crate) struct Case {
    /// Name of the file in `assets/scenes/validation`.
    pub(crate) scene: &'static str,
    /// Speed of sound for SESPH \[m/s].
    pub(crate) sound_speed: f32,
    pub(crate) measure: fn(&Scene, &mut Simulation) -> Vec<Figure>,
}

impl Case {
    /// Runs the scene with a method, its spacing times `coarseness`.
    pub(crate) fn run(&self, method: &Method, coarseness: f32, threads: usize) -> Vec<Figure> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("assets/scenes/validation")
            .join(self.scene)
            .with_extension("ron");
        let pressure = Override {
            path: "pressure".to_owned(),
            value: (method.pressure)(self.sound_speed),
        };
        let load = |overrides: &[Override]| {
            Scene::load(&path, overrides).unwrap_or_else(|error| panic!("{error}"))
        };
        let mut scene = load(&[pressure]);
        scene.spacing *= coarseness;
        let mut simulation =
            Simulation::with_threads(&scene, threads).unwrap_or_else(|error| panic!("{error}"));
        (self.measure)(&scene, &mut simulation)
    }
}

/// Every case.
pub(crate) const CASES: [&Case; 6] = [
    &hydrostatic::IN_THE_PLANE,
    &hydrostatic::IN_SPACE,
    &elliptic_drop::CASE,
    &dam_break::KOSHIZUKA_OKA,
    &dam_break::MARTIN_MOYCE,
    &free_flight::CASE,
];

/// Linear interpolation in rows of (abscissa, ordinate).
pub(crate) fn at(rows: &[[f64; 2]], x: f64) -> f64 {
    let next = rows
        .partition_point(|row| row[0] < x)
        .clamp(1, rows.len() - 1);
    let ([x0, y0], [x1, y1]) = (rows[next - 1], rows[next]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}
