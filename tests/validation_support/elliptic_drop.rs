//! The elliptic drop (Monaghan 1994).

use overfall::{Simulation, measure::semi_axes, scene::Scene};

use super::{Case, Figure, at};
use crate::support::{particles_of, reference, run};

pub(crate) const CASE: Case = Case {
    scene: "elliptic_drop",
    // As Monaghan's.
    sound_speed: 1400.0,
    measure,
};

/// Semi-major axis at the published times, and the pressure within 0.2 m of the centre, by the mean of both up to the
/// second of them: pressure waves run through the drop, and a step of an incompressible method is no instant.
fn measure(_: &Scene, drop: &mut Simulation) -> Vec<Figure> {
    let file = "elliptic_drop_analytic.csv";
    let axis = reference(file, ["t_s", "b"]);
    // Of a density of 1 kg/m³.
    let centre = reference(file, ["t_s", "p_centre"]);
    let mut measured_axis = vec![[0.0, 1.0]];
    let (mut measured, mut expected, mut weight) = (0.0, 0.0, 0.0);
    run(drop, 0.0076, |drop, report| {
        let particles = particles_of(drop);
        let [_, b] = semi_axes(particles.iter().map(|p| p.position));
        measured_axis.push([report.time, b]);
        if report.time < 0.0038 {
            let near = particles.iter().filter(|p| p.position.length() < 0.2);
            let (sum, count) = near.fold((0.0, 0.0), |(sum, count), p| {
                (sum + f64::from(p.pressure), count + 1.0)
            });
            let dt = f64::from(report.dt);
            measured += dt * sum / count;
            expected += dt * 1000.0 * at(&centre, report.time - 0.5 * dt);
            weight += dt;
        }
    });
    let mut figures: Vec<Figure> = [0.0008, 0.0038, 0.0076]
        .iter()
        .map(|&time| {
            let name = format!("semi-major axis at {time} s [m]");
            Figure::new(name, at(&measured_axis, time), at(&axis, time))
        })
        .collect();
    let name = "centre pressure to 0.0038 s [Pa]";
    figures.push(Figure::new(name, measured / weight, expected / weight));
    figures
}
