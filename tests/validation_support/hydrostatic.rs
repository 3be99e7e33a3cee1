//! Still water in a tank: `p = ρ0 g (H − y)`, and nothing moves.
//!
//! Pressures and speeds are taken over the last half of the run, weighted with the time steps. Left out are particles
//! nearer than two spacings to the floor or the surface: there a kernel does not see a full neighbourhood. Energy is
//! watched from the start, when the water falls onto pressure that is not there yet.

use overfall::{
    Simulation,
    measure::LineFit,
    scene::{Scene, Shape},
};

use super::{Case, Figure};
use crate::support::{particles_of, run};

pub(crate) const IN_THE_PLANE: Case = Case {
    scene: "hydrostatic_2d",
    sound_speed: 30.0,
    measure,
};

pub(crate) const IN_SPACE: Case = Case {
    scene: "hydrostatic_3d",
    sound_speed: 20.0,
    measure,
};

fn measure(scene: &Scene, tank: &mut Simulation) -> Vec<Figure> {
    let Shape::Box { max, .. } = scene.bodies[0].shape else {
        panic!("the water is no box");
    };
    let (depth, dx, g) = (max.y, scene.spacing, f64::from(-scene.gravity.y));
    let end = f64::from(scene.duration);
    let mut fit = LineFit::default();
    let layers = (depth / (2.0 * dx)) as usize;
    // Sums of weight and of p − ρ0 g (H − y), a layer of two spacings each.
    let mut misfit = vec![[0.0_f64; 2]; layers + 1];
    let (mut squares, mut weights, mut largest) = (0.0, 0.0, 0.0_f32);
    let (mut energy, mut most_energy) = (None, 0.0_f64);
    // Density and pressure belong to the positions at the start of a step.
    let mut before = particles_of(tank);
    run(tank, end, |tank, report| {
        let after = particles_of(tank);
        let now = report.kinetic_energy + report.potential_energy;
        most_energy = most_energy.max(now / *energy.get_or_insert(now) - 1.0);
        if report.time > 0.5 * end {
            let dt = f64::from(report.dt);
            largest = largest.max(report.max_speed);
            for (start, particle) in before.iter().zip(&after) {
                squares += dt * f64::from(particle.velocity.length_squared());
                weights += dt;
                let (y, p) = (start.position.y, f64::from(particle.pressure));
                // A reordering moves rows.
                if start.entity == particle.entity && y > 2.0 * dx && y < depth - 2.0 * dx {
                    fit.add(f64::from(y), p, dt);
                    let layer = &mut misfit[(y / (2.0 * dx)) as usize];
                    layer[0] += dt;
                    layer[1] += dt * (p - 1000.0 * g * f64::from(depth - y));
                }
            }
        }
        before = after;
    });
    let depth = f64::from(depth);
    let weight_of_all = 1000.0 * g * depth;
    let worst = misfit.iter().filter(|layer| layer[0] > 0.0);
    let worst = worst.map(|layer| layer[1] / layer[0] / weight_of_all);
    let worst = worst.fold(0.0, |worst: f64, layer| {
        if layer.abs() > worst.abs() {
            layer
        } else {
            worst
        }
    });
    let speed = (g * depth).sqrt();
    vec![
        Figure::new("-dp/dy [Pa/m]", -fit.slope(), 1000.0 * g),
        Figure::new(
            "p at half depth [Pa]",
            fit.at(0.5 * depth),
            0.5 * weight_of_all,
        ),
        Figure::residual("worst layer [rho g H]", worst),
        Figure::residual("energy gained [its energy]", most_energy),
        Figure::residual("rms speed [sqrt(g H)]", (squares / weights).sqrt() / speed),
        Figure::residual("largest speed [sqrt(g H)]", f64::from(largest) / speed),
    ]
}
