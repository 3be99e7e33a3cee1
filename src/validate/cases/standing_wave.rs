//! A standing wave, by the amplitude of its mode.
//!
//! In every step the velocities are projected on the field of linear theory, `v = ∇(cos kx cosh ky)` up to a factor.
//! The amplitude starts at 1 and follows `cos ωt exp(−2 ν k² t)`. Noise of single particles and the sound of the start
//! are not part of the mode and hardly affect it.

use std::f64::consts::PI;

use glam::{DVec2, Vec3};

use super::{reference, texts};
use crate::{
    measure::Curve,
    scene::Scene,
    validate::{
        Case, Comparison, Figure, Findings, Particle, Runner, Stopped,
        figure::exact_curve,
        particles::{particles_of, set_velocities},
    },
};

pub(in crate::validate) const INVISCID: Case = Case {
    name: "standing_wave_inviscid",
    title: "A standing wave without viscosity",
    texts: texts!("standing_wave_inviscid"),
    across: "depth",
    resolution: 20,
    resolutions: [10, 20, 40],
    sound_speed: 10.0, // 10 sqrt(g H)
    measure: inviscid,
};

pub(in crate::validate) const VISCOUS: Case = Case {
    name: "standing_wave_viscous",
    title: "A standing wave that viscosity damps",
    texts: texts!("standing_wave_viscous"),
    across: "depth",
    resolution: 20,
    resolutions: [10, 20, 40],
    sound_speed: 10.0,
    measure: viscous,
};

const KNOWN: &str = include_str!("../../../assets/reference/standing_wave_viscous_decay.csv");

/// Wave number \[1/m], for a depth of 1 m and a length of 2 m.
const K: f64 = PI;
/// Kinematic viscosity of the viscous case \[m²/s].
const NU: f64 = 0.004;
/// Amplitude \[m].
const AMPLITUDE: f64 = 0.05;

/// ω \[rad/s] for g = 1 m/s².
fn frequency() -> f64 {
    (K * K.tanh()).sqrt()
}

/// Velocity of the mode at the start \[m/s].
fn mode(x: Vec3) -> DVec2 {
    let (x, y) = (K * f64::from(x.x), K * f64::from(x.y));
    let scale = AMPLITUDE * K / frequency() / K.cosh();
    scale * DVec2::new(x.sin() * y.cosh(), -x.cos() * y.sinh())
}

/// Amplitude of the mode in the velocities \[-].
fn share(particles: &[Particle]) -> f64 {
    let (mut along, mut whole) = (0.0, 0.0);
    for particle in particles {
        let field = mode(particle.position);
        along += field.dot(particle.velocity.as_dvec3().truncate());
        whole += field.length_squared();
    }
    along / whole
}

/// The mode over time.
struct Wave {
    share: Vec<(f64, f64)>,
    /// Period, from the times at which the amplitude is zero \[s].
    period: f64,
    /// Extremes of the amplitude between these times, half a period apart: times and absolute values.
    extremes: Vec<(f64, f64)>,
}

fn watch(scene: &Scene, tank: &mut Runner) -> Result<Wave, Stopped> {
    set_velocities(tank.world(), |x| mode(x).as_vec2().extend(0.0));
    let mut share_of = vec![(0.0, 1.0)];
    tank.steps(f64::from(scene.duration), |world, report| {
        share_of.push((report.time, share(&particles_of(world))));
    })?;
    let mut zeros = Vec::new();
    let mut extremes: Vec<(f64, f64)> = Vec::new();
    let mut largest = (0.0, 0.0);
    for pair in share_of.windows(2) {
        let [(t0, a0), (t1, a1)] = [pair[0], pair[1]];
        if a0 * a1 <= 0.0 && a0 != 0.0 {
            // Noise may cross zero again at once; a wave cannot within a quarter of its period.
            let zero = t0 + (t1 - t0) * a0 / (a0 - a1);
            let quarter = 0.5 * PI / frequency();
            if zeros.last().is_none_or(|last| zero - last > quarter) {
                if !zeros.is_empty() {
                    extremes.push(largest);
                }
                zeros.push(zero);
                largest = (0.0, 0.0);
            }
        }
        if a1.abs() > largest.1 {
            largest = (t1, a1.abs());
        }
    }
    let period = match zeros[..] {
        [first, .., last] => 2.0 * (last - first) / (zeros.len() - 1) as f64,
        _ => f64::NAN,
    };
    Ok(Wave {
        share: share_of,
        period,
        extremes,
    })
}

/// Decay rate of the mode's energy \[1/s], from its extremes one period apart.
fn decay(wave: &Wave) -> f64 {
    match wave.extremes[..] {
        [first, _, third, ..] => 2.0 * (first.1 / third.1).ln() / (third.0 - first.0),
        _ => f64::NAN,
    }
}

fn findings(wave: Wave, decay: Figure, known: Curve) -> Findings {
    let period = 2.0 * PI / frequency();
    Findings {
        figures: vec![Figure::exact("period [s]", wave.period, period), decay],
        comparisons: vec![Comparison {
            name: "mode",
            x: "t [s]",
            y: "share of the mode [-]",
            measured: wave.share,
            known,
        }],
    }
}

fn inviscid(scene: &Scene, tank: &mut Runner) -> Result<Findings, Stopped> {
    let wave = watch(scene, tank)?;
    let period = 2.0 * PI / frequency();
    let lost = 1.0 - (-decay(&wave) * period).exp();
    let lost = Figure::residual("energy that the mode loses in a period [its energy]", lost);
    let times = (0..=64).map(|k| f64::from(k) / 10.0);
    let known = times.map(|t| (t, (frequency() * t).cos()));
    Ok(findings(
        wave,
        lost,
        exact_curve("cos ωt, ω² = g k tanh(k H)", known),
    ))
}

fn viscous(scene: &Scene, tank: &mut Runner) -> Result<Findings, Stopped> {
    let known = reference(KNOWN, ["t", "Ek_envelope_rel"], |[t, envelope]| {
        (t, (frequency() * t).cos() * envelope.sqrt())
    })?;
    let wave = watch(scene, tank)?;
    let rate = Figure::exact("decay of the energy [1/s]", decay(&wave), 4.0 * NU * K * K);
    Ok(findings(wave, rate, known))
}
