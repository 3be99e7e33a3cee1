//! Still water in a tank: `p = ρ0 g (H − y)`, and nothing moves.
//!
//! Pressures and speeds are measured over the second half of the run, weighted with the time steps. The pressure
//! profile excludes particles within two spacings of the floor or the surface, where the neighbourhood is incomplete.
//! Energy is measured from the start, when the water falls onto a pressure that has not built up yet.

use super::texts;
use crate::{
    measure::LineFit,
    scene::{Scene, Shape},
    validate::{
        Case, Comparison, Figure, Findings, Runner, Stopped, figure::exact_curve, particles_of,
    },
};

pub(in crate::validate) const IN_THE_PLANE: Case = Case {
    name: "hydrostatic_2d",
    title: "Still water in the plane",
    texts: texts!("hydrostatic_2d"),
    across: "depth",
    resolution: 30,
    resolutions: [15, 30, 60],
    sound_speed: 30.0,
    measure,
};

pub(in crate::validate) const IN_SPACE: Case = Case {
    name: "hydrostatic_3d",
    title: "Still water in space",
    texts: texts!("hydrostatic_3d"),
    across: "depth",
    resolution: 16,
    resolutions: [8, 16, 32],
    sound_speed: 20.0,
    measure,
};

/// Sums over the particles of a layer: of weights, of heights and of pressures.
type Layer = [f64; 3];

fn measure(scene: &Scene, tank: &mut Runner) -> Result<Findings, Stopped> {
    let Shape::Box { max, .. } = scene.bodies[0].shape else {
        return Err(Stopped::Refused("the water is no box".to_owned()));
    };
    let (depth, dx, g) = (max.y, scene.spacing, f64::from(-scene.gravity.y));
    let end = f64::from(scene.duration);
    let mut fit = LineFit::default();
    let mut layers: Vec<Layer> = vec![[0.0; 3]; (depth / (2.0 * dx)) as usize + 1];
    let (mut squares, mut weights, mut largest) = (0.0, 0.0, 0.0_f32);
    let (mut energy, mut most_energy) = (None, 0.0_f64);
    // Density and pressure belong to the positions at the start of a step.
    let mut before = particles_of(tank.world());
    tank.steps(end, |world, report| {
        let after = particles_of(world);
        let now = report.kinetic_energy + report.potential_energy;
        most_energy = most_energy.max(now / *energy.get_or_insert(now) - 1.0);
        if report.time > 0.5 * end {
            let dt = f64::from(report.dt);
            largest = largest.max(report.max_speed);
            for (start, particle) in before.iter().zip(&after) {
                squares += dt * f64::from(particle.velocity.length_squared());
                weights += dt;
                let (y, p) = (start.position.y, f64::from(particle.pressure));
                // A reordering changes rows.
                if start.entity == particle.entity && y > 2.0 * dx && y < depth - 2.0 * dx {
                    fit.add(f64::from(y), p, dt);
                    let layer = &mut layers[(y / (2.0 * dx)) as usize];
                    layer[0] += dt;
                    layer[1] += dt * f64::from(y);
                    layer[2] += dt * p;
                }
            }
        }
        before = after;
    })?;
    let depth = f64::from(depth);
    let weight = 1000.0 * g * depth;
    let known = |y: f64| 1000.0 * g * (depth - y);
    let means = layers.iter().filter(|layer| layer[0] > 0.0);
    let means: Vec<_> = means.map(|[w, y, p]| (y / w, p / w)).collect();
    let misfits = means.iter().map(|&(y, p)| (p - known(y)) / weight);
    let worst = misfits.max_by(|a, b| a.abs().total_cmp(&b.abs()));
    let floor = tank.readings("floor", "mean_pressure_Pa");
    let speed = (g * depth).sqrt();
    Ok(Findings {
        figures: vec![
            Figure::exact(
                "floor pressure [Pa]",
                floor.last().map_or(f64::NAN, |floor| floor.1),
                weight,
            ),
            Figure::exact("-dp/dy [Pa/m]", -fit.slope(), 1000.0 * g),
            Figure::exact("p at half depth [Pa]", fit.at(0.5 * depth), 0.5 * weight),
            Figure::residual("worst layer [rho g H]", worst.unwrap_or(f64::NAN)),
            Figure::residual("energy gained [its energy]", most_energy),
            Figure::residual("rms speed [sqrt(g H)]", (squares / weights).sqrt() / speed),
            Figure::residual("largest speed [sqrt(g H)]", f64::from(largest) / speed),
        ],
        comparisons: vec![Comparison {
            name: "pressure",
            x: "height above the floor [m]",
            y: "mean pressure [Pa]",
            measured: means,
            known: exact_curve(
                "ρ g (H − y)",
                (0..=20)
                    .map(|k| depth * f64::from(k) / 20.0)
                    .map(|y| (y, known(y))),
            ),
        }],
    })
}
