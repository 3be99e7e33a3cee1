//! The elliptic drop (Monaghan 1994).

use super::{reference, texts};
use crate::{
    measure::semi_axes,
    scene::Scene,
    validate::{Case, Comparison, Figure, Findings, Runner, Stopped, figure::at, particles_of},
};

pub(in crate::validate) const CASE: Case = Case {
    name: "elliptic_drop",
    title: "A drop that is drawn out",
    texts: texts!("elliptic_drop"),
    across: "radius",
    resolution: 40,
    resolutions: [20, 40, 80],
    // As in Monaghan's paper.
    sound_speed: 1400.0,
    measure,
};

const KNOWN: &str = include_str!("../../../assets/reference/elliptic_drop_analytic.csv");
/// Time until which pressures are compared \[s]: later SESPH and PCISPH have no pressure left.
const PRESSURE_UNTIL: f64 = 0.0038;

/// Semi-major axis at the published times, the area at the end, and the mean pressure in the centre up to the second of
/// these times. A mean is used because pressure waves run through the drop.
fn measure(scene: &Scene, drop: &mut Runner) -> Result<Findings, Stopped> {
    let axis = reference(KNOWN, ["t_s", "b"], |[t, b]| (t, b))?;
    // For a density of 1 kg/m³.
    let centre = reference(KNOWN, ["t_s", "p_centre"], |[t, p]| (t, 1000.0 * p))?;
    let mut axes = vec![(0.0, 1.0)];
    let mut area = f64::NAN;
    drop.steps(f64::from(scene.duration), |world, report| {
        let [a, b] = semi_axes(particles_of(world).iter().map(|p| p.position));
        axes.push((report.time, b));
        area = a * b;
    })?;
    let pressures = drop.readings("centre", "pressure_Pa");
    let (mut measured, mut expected, mut before) = (0.0, 0.0, 0.0);
    for &(time, pressure) in pressures
        .iter()
        .filter(|reading| reading.0 < PRESSURE_UNTIL)
    {
        let dt = time - before;
        measured += dt * pressure;
        expected += dt * at(&centre.points, time - 0.5 * dt);
        before = time;
    }
    let mut figures: Vec<Figure> = [0.0008, 0.0038, 0.0076]
        .iter()
        .map(|&time| {
            let name = format!("semi-major axis at {time} s [m]");
            Figure::exact(name, at(&axes, time), at(&axis.points, time))
        })
        .collect();
    figures.push(Figure::exact("area at the end [pi R^2]", area, 1.0));
    let name = format!("centre pressure to {PRESSURE_UNTIL} s [Pa]");
    figures.push(Figure::exact(name, measured / before, expected / before));
    Ok(Findings {
        figures,
        comparisons: vec![
            Comparison {
                name: "axis",
                x: "t [s]",
                y: "semi-major axis [m]",
                measured: axes,
                known: axis,
            },
            Comparison {
                name: "centre_pressure",
                x: "t [s]",
                y: "pressure in the centre [Pa]",
                measured: pressures,
                known: centre,
            },
        ],
    })
}
