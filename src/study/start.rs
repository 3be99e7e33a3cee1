//! The state in which the variants of a case start.
//!
//! Option 1: every variant is simulated from the beginning of the scene. Option 2: one simulation runs up to the start,
//! and its positions and velocities are given to all variants. We use 2: the variants then measure the same motion,
//! whereas different methods would have drifted apart, and a case costs one simulation instead of one per variant. The
//! history is not transferred: indices are rebuilt and warm starts begin at zero; a study's `warm_up` compensates for
//! that.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::Rows;
use crate::{
    reorder::{ReorderState, reorder},
    scene::{Period, shapes::split_mix},
    state::{
        particle::{Fluid, ParticleId, Position, Velocity},
        seal::reseal,
    },
};

/// Positions \[m] and velocities \[m/s], in the order in which the particles were created.
#[derive(Debug, Clone, Default)]
pub(super) struct State(Vec<(Vec3, Vec3)>);

impl State {
    /// The state of a world's fluid.
    pub(super) fn of(world: &mut World) -> Self {
        let mut fluid = world.query_filtered::<(&ParticleId, &Position, &Velocity), With<Fluid>>();
        let mut particles: Vec<_> = fluid
            .iter(world)
            .map(|(id, x, v)| (*id, (x.0, v.0)))
            .collect();
        particles.sort_unstable_by_key(|particle| particle.0);
        Self(particles.into_iter().map(|particle| particle.1).collect())
    }

    /// Root mean square distance of the particles from those of another state \[m]; none if there are others, or none.
    pub(super) fn distance(&self, other: &Self, period: &Period) -> Option<f64> {
        let pairs = self.0.iter().zip(&other.0);
        let squares = pairs.map(|(a, b)| f64::from(period.nearest(a.0 - b.0).length_squared()));
        let sum: f64 = squares.sum();
        let count = self.0.len();
        (count > 0 && count == other.0.len()).then(|| (sum / count as f64).sqrt())
    }

    /// Copies the state into a new world with as many particles, row by row.
    pub(super) fn hand_over(&self, world: &mut World, rows: Rows) {
        let mut order: Vec<usize> = (0..self.0.len()).collect();
        if rows == Rows::Shuffled {
            let mut random = 1;
            order.sort_by_cached_key(|_| split_mix(&mut random));
        }
        let mut fluid = world.query_filtered::<(&mut Position, &mut Velocity), With<Fluid>>();
        for ((mut x, mut v), row) in fluid.iter_mut(world).zip(order) {
            (x.0, v.0) = self.0[row];
        }
        if world.contains_resource::<ReorderState>() {
            reorder(world);
        }
        reseal(world);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Simulation, scene::Scene};

    const SCENE: &str = r#"(
        name: "block",
        spacing: 0.1,
        bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.4, 0.3)))],
        boundaries: [],
        reorder_interval: 0,
        limits: (),
    )"#;

    fn simulation(reorder_interval: u32) -> Simulation {
        let mut scene = Scene::parse(SCENE, "block.ron", &[]).expect("a scene");
        scene.reorder_interval = reorder_interval;
        Simulation::with_threads(&scene, 1).expect("a scene that runs")
    }

    fn rows(world: &mut World) -> Vec<(Vec3, Vec3)> {
        let mut fluid = world.query_filtered::<(&Position, &Velocity), With<Fluid>>();
        fluid.iter(world).map(|(x, v)| (x.0, v.0)).collect()
    }

    fn sorted(mut rows: Vec<(Vec3, Vec3)>) -> Vec<[u32; 6]> {
        rows.sort_by_key(|(x, _)| x.to_array().map(f32::to_bits));
        rows.iter()
            .map(|(x, v)| [x.x, x.y, x.z, v.x, v.y, v.z].map(f32::to_bits))
            .collect()
    }

    #[test]
    fn every_particle_arrives_once_whatever_the_order_of_the_rows() {
        let mut first = simulation(0);
        for _ in 0..3 {
            first.step().expect("a step");
        }
        let state = State::of(first.world_mut());
        let kept = rows(first.world_mut());
        let hand_over = |interval, order| {
            let mut simulation = simulation(interval);
            state.hand_over(simulation.world_mut(), order);
            rows(simulation.world_mut())
        };
        assert_eq!(hand_over(0, Rows::Kept), kept);
        let shuffled = hand_over(0, Rows::Shuffled);
        let reordered = hand_over(100, Rows::Kept);
        for other in [&shuffled, &reordered] {
            assert_ne!(other, &kept);
            assert_eq!(sorted(other.clone()), sorted(kept.clone()));
        }
        assert_ne!(shuffled, reordered);
    }
}
