//! The drop that oscillates under a central force (Monaghan & Rafiee 2013).

use super::{reference, texts};
use crate::{
    measure::semi_axes,
    scene::Scene,
    validate::{Case, Comparison, Figure, Findings, Runner, Stopped, figure::at, particles_of},
};

pub(in crate::validate) const CASE: Case = Case {
    name: "oscillating_drop",
    title: "A drop that oscillates under a central force",
    texts: texts!("oscillating_drop"),
    across: "radius",
    resolution: 20,
    resolutions: [10, 20, 40],
    // Ten times the largest speeds, those of the surface.
    sound_speed: 10.0,
    measure,
};

const KNOWN: &str =
    include_str!("../../../assets/reference/oscillating_drop_central_force_analytic.csv");
/// Period \[s].
const PERIOD: f64 = 4.567_375;

/// The second time after the start at which the points pass the value 1 upwards, half a period later at the earliest.
fn returns(points: &[(f64, f64)]) -> f64 {
    let passes = points
        .windows(2)
        .filter(|pair| pair[1].0 > 0.5 * PERIOD && pair[0].1 < 1.0 && pair[1].1 >= 1.0);
    let times: Vec<f64> = passes
        .map(|pair| {
            let [(t0, a0), (t1, a1)] = [pair[0], pair[1]];
            t0 + (t1 - t0) * (1.0 - a0) / (a1 - a0)
        })
        .collect();
    times.first().copied().unwrap_or(f64::NAN)
}

/// Half the distance between extremes since `from` \[s].
fn amplitude(points: &[(f64, f64)], from: f64) -> f64 {
    let late = points
        .iter()
        .filter(|point| point.0 >= from)
        .map(|point| point.1);
    let (low, high) = late.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), a| {
        (low.min(a), high.max(a))
    });
    0.5 * (high - low)
}

fn measure(scene: &Scene, drop: &mut Runner) -> Result<Findings, Stopped> {
    let known = reference(KNOWN, ["t", "A"], |[t, a]| (t, a))?;
    let mut axes = vec![(0.0, 1.0)];
    let mut area = f64::NAN;
    drop.steps(f64::from(scene.duration), |world, report| {
        let [a, b] = semi_axes(particles_of(world).iter().map(|p| p.position));
        axes.push((report.time, a));
        area = a * b;
    })?;
    let end = f64::from(scene.duration);
    let within: Vec<(f64, f64)> = known
        .points
        .iter()
        .copied()
        .filter(|p| p.0 <= end)
        .collect();
    let squares = within.iter().map(|&(t, a)| (at(&axes, t) - a).powi(2));
    let off = (squares.sum::<f64>() / within.len() as f64).sqrt();
    Ok(Findings {
        figures: vec![
            Figure::exact("period [s]", returns(&axes), PERIOD),
            Figure::exact(
                "amplitude of A in the second period [m]",
                amplitude(&axes, PERIOD),
                amplitude(&within, PERIOD),
            ),
            Figure::residual("rms distance of A [m]", off),
            Figure::exact("area at the end [pi R^2]", area, 1.0),
        ],
        comparisons: vec![Comparison {
            name: "axis",
            x: "t [s]",
            y: "semi-axis A [m]",
            measured: axes,
            known,
        }],
    })
}
