//! Flows between two plates from their start on (Morris, Fox & Zhu 1997): Poiseuille's, driven by a force, and
//! Couette's, driven by a plate that moves.

use std::f64::consts::PI;

use super::texts;
use crate::{
    scene::Scene,
    validate::{
        Case, Comparison, Figure, Findings, Particle, Runner, Stopped, figure::exact_curve,
        particles_of,
    },
};

pub(in crate::validate) const POISEUILLE: Case = Case {
    name: "poiseuille",
    title: "Flow between plates that a force drives",
    texts: texts!("poiseuille"),
    across: "gap",
    resolution: 20,
    resolutions: [10, 20, 40],
    // Ten times the largest velocity, rounded up.
    sound_speed: 1.25e-4,
    measure: |scene, flow| measure(scene, flow, poiseuille),
};

pub(in crate::validate) const COUETTE: Case = Case {
    name: "couette",
    title: "Flow between plates of which one moves",
    texts: texts!("couette"),
    across: "gap",
    resolution: 20,
    resolutions: [10, 20, 40],
    sound_speed: 1.25e-4,
    measure: |scene, flow| measure(scene, flow, couette),
};

/// Distance of the plates \[m].
const GAP: f64 = 1e-3;
/// Kinematic viscosity \[m²/s].
const NU: f64 = 1e-6;
/// Force per mass \[m/s²].
const FORCE: f64 = 1e-4;
/// Largest velocity of both flows \[m/s]: that of the plate, and of the steady parabola.
const SPEED: f64 = 1.25e-5;
/// When profiles are compared \[s]; the last one is steady to 0.3 %.
const TIMES: [f64; 3] = [0.045, 0.1125, 0.6];
/// Terms of the series; later ones are below rounding at these times.
const TERMS: u32 = 60;

fn poiseuille(y: f64, t: f64) -> f64 {
    let term = |n: u32| {
        let odd = f64::from(2 * n + 1);
        let wave = (odd * PI * y / GAP).sin() / (PI * odd).powi(3);
        wave * (-(odd * PI / GAP).powi(2) * NU * t).exp()
    };
    let rest: f64 = (0..TERMS).map(term).sum();
    FORCE / (2.0 * NU) * y * (GAP - y) - 4.0 * FORCE * GAP * GAP / NU * rest
}

fn couette(y: f64, t: f64) -> f64 {
    let term = |n: u32| {
        let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
        let n = f64::from(n);
        sign / (n * PI) * (n * PI * y / GAP).sin() * (-NU * (n * PI / GAP).powi(2) * t).exp()
    };
    SPEED * (y / GAP + 2.0 * (1..TERMS).map(term).sum::<f64>())
}

/// Root mean square of the distances from the series \[largest velocity].
fn error(particles: &[Particle], known: impl Fn(f64) -> f64) -> f64 {
    let off = |p: &Particle| {
        let u = f64::from(p.velocity.x) - known(f64::from(p.position.y));
        (u / SPEED).powi(2)
    };
    (particles.iter().map(off).sum::<f64>() / particles.len() as f64).sqrt()
}

fn measure(
    scene: &Scene,
    flow: &mut Runner,
    known: fn(f64, f64) -> f64,
) -> Result<Findings, Stopped> {
    let mut figures = Vec::new();
    let mut profile = Vec::new();
    let mut moments = Vec::new();
    flow.steps(f64::from(scene.duration), |world, report| {
        let next = TIMES.get(moments.len());
        // At the time of the step, which may be a little later.
        if next.is_some_and(|&time| report.time >= time - 1e-6) {
            moments.push((report.time, particles_of(world)));
        }
    })?;
    for (time, (now, particles)) in TIMES.into_iter().zip(moments) {
        figures.push(Figure::residual(
            format!("error of the velocities at {time} s [largest]"),
            error(&particles, |y| known(y, now)),
        ));
        if time == TIMES[1] {
            let point = |p: &Particle| (f64::from(p.position.y), f64::from(p.velocity.x));
            profile = particles.iter().map(point).collect();
            profile.sort_by(|a: &(f64, f64), b| a.0.total_cmp(&b.0));
        }
    }
    let heights = (0..=50).map(|k| GAP * f64::from(k) / 50.0);
    Ok(Findings {
        figures,
        comparisons: vec![Comparison {
            name: "profile",
            x: "y [m]",
            y: "velocity at 0.1125 s [m/s]",
            measured: profile,
            known: exact_curve("series", heights.map(|y| (y, known(y, TIMES[1])))),
        }],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against published values (`u` at the middle at 0.045 and 0.1125 s).
    #[test]
    fn the_series_are_those_of_the_paper() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-5 * b;
        assert!(near(poiseuille(5e-4, 0.045), 4.234_570_6e-6));
        assert!(near(poiseuille(5e-4, 0.1125), 8.249_913_8e-6));
        assert!(near(couette(5e-4, 0.045), 1.194_751_6e-6));
        assert!(near(couette(5e-4, 0.1125), 3.628_441e-6));
    }
}
