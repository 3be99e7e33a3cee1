//! SPHERIC benchmark 2 (Kleefsman et al. 2005): levels, and the pressure near the foot of the box.

use super::{reference, texts};
use crate::{
    measure::Curve,
    scene::Scene,
    validate::{Case, Comparison, Figure, Findings, Runner, Stopped, figure::at},
};

pub(in crate::validate) const CASE: Case = Case {
    name: "spheric_2",
    title: "A dam break against a box",
    texts: texts!("spheric_2"),
    across: "depth",
    resolution: 10,
    resolutions: [5, 10, 20],
    sound_speed: 33.0, // 10 sqrt(2 g H)
    measure,
};

const KNOWN: &str = include_str!("../../../assets/reference/spheric_test2_10ms.csv");

/// Gauges, columns of the file and names of charts.
const LEVELS: [(&str, &str, &str); 4] = [
    ("h4", "h_x0.582_m", "level [m] at x = 0.582 m"),
    ("h3", "h_x1.732_m", "level [m] at x = 1.732 m"),
    ("h2", "h_x2.228_m", "level [m] at x = 2.228 m"),
    ("h1", "h_x2.724_m", "level [m] at x = 2.724 m"),
];

/// A sensor is wet if its pressure is above this fraction of its peak \[-].
const WET: f64 = 0.1;

fn up_to(curve: &Curve, end: f64) -> impl Iterator<Item = (f64, f64)> {
    let points = curve.points.iter().copied();
    points.take_while(move |point| point.0 <= end)
}

/// Means over two samples of the file, 20 ms.
fn means(curve: &Curve) -> Vec<(f64, f64)> {
    let pairs = curve.points.windows(2);
    pairs
        .map(|pair| (pair[1].0, 0.5 * (pair[0].1 + pair[1].1)))
        .collect()
}

/// Peak, the time at which a tenth of it is first exceeded, and the mean from then to the end.
fn impact(pressures: &[(f64, f64)]) -> [f64; 3] {
    let peak = pressures.iter().map(|p| p.1).fold(f64::NAN, f64::max);
    let wet = pressures.iter().position(|p| p.1 > WET * peak);
    let wet = wet.map_or(&[][..], |first| &pressures[first..]);
    let start = wet.first().map_or(f64::NAN, |first| first.0);
    let sum: f64 = wet.iter().map(|p| p.1).sum();
    [peak, start, sum / wet.len() as f64]
}

fn measure(scene: &Scene, tank: &mut Runner) -> Result<Findings, Stopped> {
    let end = f64::from(scene.duration);
    tank.steps(end, |_, _| {})?;
    let mut findings = Findings::default();
    for (gauge, column, y) in LEVELS {
        let known = reference(KNOWN, ["t_s", column], |[t, h]| (t, h))?;
        let mut level = tank.readings(gauge, "height_m");
        // A column without fluid has no level because it is dry.
        if level.first().is_none_or(|first| first.0 > 0.02) {
            let wet = level.first().map_or(end, |first| first.0);
            level.splice(0..0, [(0.0, 0.0), (wet - 1e-9, 0.0)]);
        }
        let (sum, count, most) =
            up_to(&known, end).fold((0.0, 0.0, 0.0_f64), |(sum, count, most), (t, h)| {
                (sum + (at(&level, t) - h).powi(2), count + 1.0, most.max(h))
            });
        let name = format!("rms distance of the {y} [its maximum]");
        let rms = Figure::residual(name, (sum / count).sqrt() / most);
        findings.figures.push(rms.by_experiment());
        findings.comparisons.push(Comparison {
            name: gauge,
            x: "t [s]",
            y,
            measured: level,
            known: Curve {
                points: up_to(&known, end).collect(),
                notes: known.notes,
            },
        });
    }
    let known = reference(KNOWN, ["t_s", "P1_Pa"], |[t, p]| (t, p))?;
    let of_experiment = Curve {
        points: means(&known)
            .into_iter()
            .take_while(|p| p.0 <= end)
            .collect(),
        notes: known.notes,
    };
    let measured = tank.readings("p1", "mean_pressure_Pa");
    let names = [
        "P1, peak of 20 ms [Pa]",
        "P1, arrival of the water [s]",
        "P1, mean since then [Pa]",
    ];
    let (ours, theirs) = (impact(&measured), impact(&of_experiment.points));
    for (name, (ours, theirs)) in names.into_iter().zip(ours.into_iter().zip(theirs)) {
        let figure = Figure::exact(name, ours, theirs);
        findings.figures.push(figure.by_experiment());
    }
    findings.comparisons.push(Comparison {
        name: "p1",
        x: "t [s]",
        y: "pressure P1, mean of 20 ms [Pa]",
        measured,
        known: of_experiment,
    });
    Ok(findings)
}
