//! Waves of a piston, against linear theory.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2};

use super::texts;
use crate::{
    scene::Scene,
    validate::{Case, Comparison, Figure, Findings, Runner, Stopped, figure::exact_curve},
};

pub(in crate::validate) const CASE: Case = Case {
    name: "wave_maker",
    title: "Waves that a piston makes",
    texts: texts!("wave_maker"),
    across: "depth",
    resolution: 20,
    resolutions: [10, 20, 40],
    sound_speed: 31.0, // 10 sqrt(g h)
    measure,
};

/// Wave number \[1/m] for a depth of 1 m.
const K: f64 = 2.0;
/// Stroke of the piston \[m].
const STROKE: f64 = 0.06;
/// Heights of the gauges above the floor \[m].
const HEIGHTS: [f64; 2] = [0.7, 0.3];
/// Since when waves are measured \[s].
const ARRIVED: f64 = 4.7;

/// ω \[rad/s].
fn frequency() -> f64 {
    (9.81 * K * K.tanh()).sqrt()
}

/// Amplitude and phase of a cosine of ωt, and a constant, by least squares over the times.
fn mode(readings: &[(f64, f64)]) -> DVec2 {
    let omega = frequency();
    let count = readings.len() as f64;
    let mean = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        readings.iter().map(|&(t, u)| of(t, u)).sum::<f64>() / count
    };
    let (cos, sin) = (|t: f64| (omega * t).cos(), |t: f64| (omega * t).sin());
    let (c, s, u) = (mean(&|t, _| cos(t)), mean(&|t, _| sin(t)), mean(&|_, u| u));
    let matrix = DMat2::from_cols(
        DVec2::new(
            mean(&|t, _| cos(t) * cos(t)) - c * c,
            mean(&|t, _| cos(t) * sin(t)) - c * s,
        ),
        DVec2::new(
            mean(&|t, _| cos(t) * sin(t)) - c * s,
            mean(&|t, _| sin(t) * sin(t)) - s * s,
        ),
    );
    let right = DVec2::new(
        mean(&|t, u| u * cos(t)) - u * c,
        mean(&|t, u| u * sin(t)) - u * s,
    );
    matrix.inverse() * right
}

fn measure(scene: &Scene, tank: &mut Runner) -> Result<Findings, Stopped> {
    tank.steps(f64::from(scene.duration), |_, _| {})?;
    let late = |gauge: &str| -> Vec<(f64, f64)> {
        let all = tank.readings(gauge, "velocity_x_m_per_s");
        all.into_iter()
            .filter(|reading| reading.0 >= ARRIVED)
            .collect()
    };
    let (upper, lower) = (late("upper"), late("lower"));
    let amplitudes = [mode(&upper).length(), mode(&lower).length()];
    let height =
        |amplitude: f64, y: f64| 2.0 * amplitude * K.sinh() / (frequency() * (K * y).cosh());
    let heights = [0, 1].map(|k| height(amplitudes[k], HEIGHTS[k]) / STROKE);
    let known = 2.0 * ((2.0 * K).cosh() - 1.0) / ((2.0 * K).sinh() + 2.0 * K);
    let ratio = (K * HEIGHTS[0]).cosh() / (K * HEIGHTS[1]).cosh();
    // With the phase of the piston's own waves: u follows its velocity, 2.5 m behind.
    let speed = 0.5 * known * STROKE * frequency() * (K * HEIGHTS[0]).cosh() / K.sinh();
    let period = TAU / frequency();
    let times = (0..=80).map(|k| ARRIVED + 2.0 * period * f64::from(k) / 80.0);
    let wave = times.map(|t| (t, speed * (frequency() * t - 2.5 * K).cos()));
    Ok(Findings {
        figures: vec![
            Figure::exact(
                "height of the waves, from 0.7 m [stroke]",
                heights[0],
                known,
            ),
            Figure::exact(
                "height of the waves, from 0.3 m [stroke]",
                heights[1],
                known,
            ),
            Figure::exact(
                "velocity at 0.7 over that at 0.3 m [-]",
                amplitudes[0] / amplitudes[1],
                ratio,
            ),
        ],
        comparisons: vec![Comparison {
            name: "velocity",
            x: "t [s]",
            y: "horizontal velocity 0.7 m above the floor [m/s]",
            measured: upper,
            known: exact_curve("linear theory", wave),
        }],
    })
}
