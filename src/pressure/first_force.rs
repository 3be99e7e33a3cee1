//! The first pressure force of a step, summed in the same pass as viscosity.
//!
//! Iterations that start from earlier pressures begin with their force, which nothing between viscosity and the solve
//! changes. One pass loads lists, kernel gradients and positions for both; the sums are bitwise the same. Corner dam
//! break of 130 000 particles, time per step: IISPH 26.9 ms apart and 24.9 ms together, DFSPH at a mean error of 1 %
//! 26.0 and 24.9 ms.
//!
//! The time is booked to the phase of viscosity. The passes stay separate if an order repeats or skips one of them, if
//! a stage between them changes more than forces, or if iterations start from zero. Changes that a host makes to
//! pressures or densities between the two phases take effect from the first correction on.

use bevy_ecs::{prelude::*, system::SystemParam};
use glam::Vec3;

use super::{
    force::PressureForce,
    implicit::Jacobi,
    warm_start::{self, WarmStart},
};
use crate::{
    boundary::sums::{BoundarySums, Walls},
    flow::Hold,
    pairs::{PairSum, PairsWithGradients, add, store, zip},
    scene::{Scene, Viscosity},
    state::{
        Densities, Execution, Material, MeanPressures, Positions, PressureAccelerations, Pressures,
        SolverState, Systems,
    },
};

/// In worlds whose scene and order let viscosity sum the first force.
#[derive(Resource, Debug)]
pub struct FirstForce {
    /// Whether the first force of this step is summed already.
    known: bool,
}

/// Lets viscosity sum the first force from now on.
pub(crate) fn install(world: &mut World) {
    world.insert_resource(FirstForce { known: false });
}

/// Whether a scene has viscosity and iterations that start with a force.
pub(crate) fn is_possible(scene: &Scene) -> bool {
    scene.fluid.viscosity != Viscosity::None
        && scene
            .pressure
            .iterations()
            .is_some_and(|iterations| iterations.warm_start.share > 0.0)
}

/// Writes the initial terms of the solve beside the positions, before viscosity (phase `Forces`). Systems of a host
/// that only read positions need no order against it: positions do not change.
pub(crate) fn start() -> Systems {
    start_solve
        .run_if(resource_exists::<FirstForce>)
        .ambiguous_with_all()
}

fn start_solve(
    mut positions: ResMut<Positions>,
    mut solve: ResMut<SolverState>,
    densities: Res<Densities>,
    pressures: Res<Pressures>,
    means: Option<Res<MeanPressures>>,
    jacobi: Option<Res<Jacobi>>,
    start: Res<WarmStart>,
    execution: Res<Execution>,
) {
    warm_start::put_terms(
        &mut positions,
        start.share,
        (&densities, &pressures),
        means.as_deref(),
        &execution,
    );
    let overshoots = jacobi.is_some_and(|jacobi| jacobi.overshoots());
    solve.begin(start.share > 0.0, overshoots);
}

/// Returns whether the force is summed already, and resets the mark.
pub(super) fn take(world: &mut World) -> bool {
    world
        .get_resource_mut::<FirstForce>()
        .is_some_and(|mut first| std::mem::take(&mut first.known))
}

/// A force over the pairs, together with the first pressure force if possible.
#[derive(SystemParam)]
pub struct WithFirstForce<'w> {
    first: Option<ResMut<'w, FirstForce>>,
    start: Option<Res<'w, WarmStart>>,
    accelerations: ResMut<'w, PressureAccelerations>,
    hold: Hold<'w>,
    walls: Option<Res<'w, BoundarySums>>,
    material: Res<'w, Material>,
    /// The pairs.
    pub pairs: PairsWithGradients<'w>,
}

impl WithFirstForce<'_> {
    /// Share of the earlier pressures whose terms are stored beside the positions \[-].
    pub fn share_of_terms(&self) -> f32 {
        warm_start::share_of_terms(self.start.as_deref())
    }

    /// Adds the sums of `pass` to `out`, which has one entry per row.
    pub fn add<P: PairSum<Output = Vec3>>(&mut self, pass: P, out: &mut [Vec3]) {
        let Some(first) = &mut self.first else {
            return self.pairs.add(&pass, out);
        };
        self.accelerations.0.resize(out.len(), Vec3::ZERO);
        let force = PressureForce::new(&self.material, Walls::of(self.walls.as_deref()));
        let sinks = zip(add(out), store(&mut self.accelerations.0));
        self.pairs.sum_into(&(pass, force), sinks);
        self.hold.reduce(&mut self.accelerations.0);
        self.pairs.execution.share(&mut self.accelerations.0);
        first.known = true;
    }
}
