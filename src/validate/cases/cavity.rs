//! The lid-driven cavity (Ghia, Ghia & Shin 1982).

use glam::Vec3;

use super::{reference, texts};
use crate::{
    gauge::Snapshot,
    scene::Scene,
    state::particle::Velocity,
    validate::{Case, Comparison, Figure, Findings, Runner, Stopped},
};

pub(in crate::validate) const CASE: Case = Case {
    name: "lid_driven_cavity",
    title: "A cavity whose lid moves",
    texts: texts!("lid_driven_cavity"),
    across: "side",
    resolution: 40,
    resolutions: [20, 40, 80],
    sound_speed: 10.0,
    measure,
};

const UPRIGHT: &str = include_str!("../../../assets/reference/ghia_1982_cavity_u_centreline.csv");
const LEVEL: &str = include_str!("../../../assets/reference/ghia_1982_cavity_v_centreline.csv");
/// Over how long before the end velocities are averaged \[s].
const WINDOW: f64 = 2.0;
/// Steps between two readings.
const EVERY: u32 = 5;

/// Means of one component at the points of a table.
struct Line {
    name: &'static str,
    axis: &'static str,
    component: &'static str,
    known: crate::measure::Curve,
    points: Vec<Vec3>,
    sums: Vec<f64>,
    /// Whether the component is x.
    is_along: bool,
}

impl Line {
    fn new(spacing: f64, is_along: bool) -> Result<Self, Stopped> {
        let (text, columns) = if is_along {
            (UPRIGHT, ["y", "u_Re100"])
        } else {
            (LEVEL, ["x", "v_Re100"])
        };
        let mut known = reference(text, columns, |[at, velocity]| (at, velocity))?;
        known.points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_inside = |at: &&(f64, f64)| at.0 > spacing && at.0 < 1.0 - spacing;
        let place = |&(at, _): &(f64, f64)| {
            if is_along {
                Vec3::new(0.5, at as f32, 0.0)
            } else {
                Vec3::new(at as f32, 0.5, 0.0)
            }
        };
        let points: Vec<Vec3> = known.points.iter().filter(is_inside).map(place).collect();
        let (name, axis, component) = if is_along {
            ("upright", "y [m]", "u at x = 0.5 m [m/s]")
        } else {
            ("level", "x [m]", "v at y = 0.5 m [m/s]")
        };
        Ok(Self {
            name,
            axis,
            component,
            known,
            sums: vec![0.0; points.len()],
            points,
            is_along,
        })
    }

    fn add(&mut self, fluid: &Snapshot) {
        let found = fluid.interpolate::<Velocity>(&self.points);
        for (sum, found) in self.sums.iter_mut().zip(found) {
            let velocity = found.value.map_or(Vec3::NAN, |velocity| velocity.0);
            *sum += f64::from(if self.is_along {
                velocity.x
            } else {
                velocity.y
            });
        }
    }

    /// Means of so many readings, and the root mean square of their distances from the table.
    fn end(self, readings: f64) -> (f64, Comparison) {
        let at = |place: &Vec3| f64::from(if self.is_along { place.y } else { place.x });
        let means = self.points.iter().zip(&self.sums);
        let measured: Vec<(f64, f64)> = means.map(|(x, sum)| (at(x), sum / readings)).collect();
        let known = |place: f64| super::at(&self.known.points, place);
        let squares = measured.iter().map(|&(x, u)| (u - known(x)).powi(2));
        let error = (squares.sum::<f64>() / measured.len() as f64).sqrt();
        let comparison = Comparison {
            name: self.name,
            x: self.axis,
            y: self.component,
            measured,
            known: self.known,
        };
        (error, comparison)
    }
}

fn measure(scene: &Scene, cavity: &mut Runner) -> Result<Findings, Stopped> {
    let spacing = f64::from(scene.spacing);
    let (mut upright, mut level) = (Line::new(spacing, true)?, Line::new(spacing, false)?);
    let end = f64::from(scene.duration);
    let (mut readings, mut steps, mut failed) = (0.0, 0, None);
    cavity.steps(end, |world, report| {
        steps += 1;
        if report.time < end - WINDOW || steps % EVERY != 0 {
            return;
        }
        match Snapshot::of(world) {
            Ok(fluid) => {
                upright.add(&fluid);
                level.add(&fluid);
                readings += 1.0;
            }
            Err(error) => failed = Some(error.to_string()),
        }
    })?;
    if let Some(error) = failed {
        return Err(Stopped::Refused(error));
    }
    let (of_upright, first) = upright.end(readings);
    let (of_level, second) = level.end(readings);
    let values = |of: &Comparison| of.measured.iter().map(|point| point.1).collect::<Vec<_>>();
    let least = values(&first).into_iter().fold(f64::INFINITY, f64::min);
    let most = values(&second)
        .into_iter()
        .fold(f64::NEG_INFINITY, f64::max);
    Ok(Findings {
        figures: vec![
            Figure::residual("error of u on the upright line [lid]", of_upright),
            Figure::residual("error of v on the level line [lid]", of_level),
            Figure::exact("least u on the upright line [m/s]", least, -0.2109),
            Figure::exact("greatest v on the level line [m/s]", most, 0.17527),
        ],
        comparisons: vec![first, second],
    })
}
