//! A wave of acceleration: a force that varies in space and time.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// An acceleration `amplitude cos(k·x − 2π f t + phase)`. Several add up to any field that repeats, a product of two
/// waves for example is half the sum of the waves with `k₁ + k₂` and `k₁ − k₂`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ForceWave {
    /// Acceleration at the crests \[m/s²].
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub amplitude: Vec3,
    /// k, along which it goes: 2π over the wavelength \[rad/m]. Along a periodic axis a multiple of 2π over the period.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub wave_number: Vec3,
    /// f, crests per second that pass a point; 0 for a force that stands \[1/s].
    #[serde(default)]
    pub frequency: f32,
    /// Phase at the origin at time 0; −π/2 makes a sine of the cosine \[rad].
    #[serde(default)]
    pub phase: f32,
}

impl ForceWave {
    /// Mean acceleration at a point from a time on over a step \[s]: what it changes velocities by does not depend on
    /// the steps.
    #[inline]
    pub fn mean(&self, point: Vec3, time: f64, dt: f64) -> Vec3 {
        let omega = TAU * f64::from(self.frequency);
        let half = 0.5 * omega * dt;
        let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
        let place: DVec3 = point.as_dvec3();
        let phase = self.wave_number.as_dvec3().dot(place) - omega * (time + 0.5 * dt)
            + f64::from(self.phase);
        (sinc * phase.cos()) as f32 * self.amplitude
    }

    /// Its period \[s] if it oscillates and moves the fluid by more than `least` \[m] there and back.
    pub(crate) fn period(&self, least: f64) -> Option<f64> {
        let period = f64::from(self.frequency.abs()).recip();
        let way = 2.0 * f64::from(self.amplitude.length()) * (period / TAU).powi(2);
        (period.is_finite() && way > least).then_some(period)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the mean of the formula in small steps, at places and times without a pattern.
    #[test]
    fn a_step_gets_the_mean_of_the_wave() {
        let wave = ForceWave {
            amplitude: Vec3::new(1.0, -2.0, 0.5),
            wave_number: Vec3::new(3.0, 1.0, -2.0),
            frequency: 0.7,
            phase: 0.4,
        };
        let still = ForceWave {
            frequency: 0.0,
            ..wave
        };
        for wave in [wave, still] {
            for k in 0..20 {
                let k = f64::from(k);
                let x = DVec3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k).sin()).as_vec3();
                let (time, dt) = (0.37 * k, 0.05 + 0.1 * k);
                let count = 2000;
                let value = |part: u32| {
                    let t = time + dt * (f64::from(part) + 0.5) / f64::from(count);
                    let along = wave.wave_number.as_dvec3().dot(x.as_dvec3());
                    (along - TAU * f64::from(wave.frequency) * t + f64::from(wave.phase)).cos()
                };
                let fine = (0..count).map(value).sum::<f64>() / f64::from(count);
                let expected = fine as f32 * wave.amplitude;
                let found = wave.mean(x, time, dt);
                assert!(found.distance(expected) < 1e-5, "{found}, not {expected}");
            }
        }
        assert_eq!(still.period(0.0), None);
        // Of an oscillation `a cos ωt` the way is 2 a/ω².
        let way = 2.0 * f64::from(wave.amplitude.length()) / (TAU * 0.7_f32 as f64).powi(2);
        assert!(wave.period(0.99 * way).is_some() && wave.period(1.01 * way).is_none());
    }
}
