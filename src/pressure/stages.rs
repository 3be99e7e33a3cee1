//! The stages of a step that a pressure method decides: densities, divergence, pressure.

use bevy_ecs::{prelude::*, schedule::ScheduleLabel};

use super::{
    initial::{self, InitialIteration},
    warm_start,
};
use crate::{
    boundary::sums,
    flow,
    scene::Scene,
    state::{Phase, Product, SolverState, Stage},
    time_step::RecoveryTime,
};

/// Densities, and the sums of the pairs that the method needs with them.
pub(crate) const DENSITY: Stage = Stage {
    needs: &[
        Product::Columns,
        Product::Index,
        Product::Walls,
        Product::Neighbours,
    ],
    makes: &[Product::Density],
    bytes: |scene, _| {
        let walls = (!scene.boundaries.is_empty()).then_some(("sums over the walls", 16.0));
        walls.into_iter().collect()
    },
    ..Stage::new("density", Phase::Density, |scene| {
        let density = scene.pressure.solver().density();
        let density = if scene.boundaries.is_empty() {
            density
        } else {
            (sums::sum_walls, density).chain()
        };
        flow::after_density(scene, density)
    })
};

/// Velocities without compression, with methods that free them of it before forces act.
pub(crate) const DIVERGENCE: Stage = Stage {
    needs: &[
        Product::Columns,
        Product::Index,
        Product::Neighbours,
        Product::Density,
    ],
    makes: &[Product::Divergence],
    wanted: |scene| scene.pressure.solver().divergence().is_some(),
    ..Stage::new("divergence", Phase::Forces, |scene| {
        let systems = scene.pressure.solver().divergence();
        systems.unwrap_or_else(|| (|| {}).into_configs())
    })
};

/// Pressures and their forces.
pub(crate) const PRESSURE: Stage = Stage {
    needs: &[
        Product::Columns,
        Product::Index,
        Product::Neighbours,
        Product::Density,
        Product::Divergence,
        Product::Forces,
    ],
    makes: &[Product::Pressure],
    limits: |scene| scene.pressure.solver().limits(scene),
    install: |world, scene| {
        world.init_resource::<SolverState>();
        scene.pressure.solver().install(world, scene);
        if let Some(iterations) = scene.pressure.iterations() {
            world.insert_resource(iterations.convergence);
            warm_start::install(world, iterations.warm_start);
            if let Some(recovery) =
                RecoveryTime::new(iterations.recovery, iterations.is_linear, scene)
            {
                world.insert_resource(recovery);
            }
        }
    },
    schedules: |scene| {
        let mut schedules = scene.pressure.solver().schedules(scene);
        if initial::is_solved_for(scene) {
            let iteration = initial::iteration(is_linear(scene));
            schedules.push((InitialIteration.intern(), iteration));
        }
        schedules
    },
    ..Stage::new("pressure", Phase::Pressure, |scene| {
        let solve = scene.pressure.solver().solve(scene);
        let solve = if initial::is_solved_for(scene) {
            let is_linear = is_linear(scene);
            let first = move |world: &mut World| initial::solve_initial_pressure(world, is_linear);
            (first.run_if(initial::is_first_step), solve).chain()
        } else {
            solve
        };
        let solve = flow::around_solve(scene, solve);
        if warm_start::starts_from_means(scene) {
            (solve, warm_start::average_pressures).chain()
        } else {
            solve
        }
    })
};

/// Whether the method's density is linear in its pressures.
fn is_linear(scene: &Scene) -> bool {
    let iterations = scene.pressure.iterations();
    iterations.is_none_or(|iterations| iterations.is_linear)
}
