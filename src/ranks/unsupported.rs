//! What a scene may ask for that does not run on several ranks yet.

use bevy_ecs::prelude::*;

use crate::{
    boundary::{friction, moving},
    flow,
    scene::{Executor, IndexStructure, PressureMethod, RowOrder, Scene, TimeStep},
    state::Execution,
};

/// Something that a scene asks for and that does not run on several ranks yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[error("{what} does not run on several ranks yet: {why}; run the scene on one rank")]
pub struct Unsupported {
    /// As the scene names it.
    pub what: &'static str,
    /// Why not.
    pub why: &'static str,
}

/// Refuses checkpoints of a scene on several ranks that has what they cannot hold.
pub(crate) fn check_checkpoints(world: &World, scene: &Scene) -> Result<(), Unsupported> {
    let execution = world.get_resource::<Execution>();
    if execution.and_then(Execution::team).is_none() {
        return Ok(());
    }
    let why = "what it keeps by row is of each rank's rows";
    let what = match (scene.time_step, scene.skin()) {
        (TimeStep::Adaptive(_), _) => "a checkpoint with time_step: Adaptive",
        (_, Some(_)) => "a checkpoint with neighbours: Verlet",
        _ => return Ok(()),
    };
    Err(Unsupported { what, why })
}

/// The first thing of a scene that does not run on several ranks.
pub(crate) fn unsupported(scene: &Scene) -> Option<Unsupported> {
    let structure = scene.index.structure;
    let all = [
        (
            scene.executor == Executor::Parallel,
            "executor: Parallel",
            "systems that wait for other ranks would hold up threads that those need",
        ),
        (
            matches!(scene.pressure, PressureMethod::DeltaSph(_)),
            "pressure: DeltaSph",
            "its gradients and shifts are not shared",
        ),
        (
            structure == IndexStructure::SpatialHashing,
            "index: SpatialHashing",
            "the size of its table, and with it the order of sums, follows the number of all particles",
        ),
        (
            scene.reorder_by == RowOrder::CellIndex,
            "reorder_by: CellIndex",
            "rows of a rank would be all over the scene",
        ),
        (
            scene.order.is_some(),
            "order",
            "what is shared, and where, is known for the default order",
        ),
        (
            flow::has_emitters(scene),
            "emitters",
            "rows come in the middle of the run's",
        ),
        (
            flow::removes(scene),
            "outflow",
            "rows go in the middle of the run's",
        ),
        (
            moving::is_wanted(scene),
            "walls in motion",
            "the check for room looks at the fluid of all ranks",
        ),
        (
            friction::is_wanted(scene),
            "slip of walls",
            "the velocity of a wall's sample follows from fluid beyond the halo",
        ),
        (
            !scene.gauges.is_empty(),
            "gauges",
            "each rank would read its own particles alone",
        ),
    ];
    let asked = all.into_iter().find(|(asked, ..)| *asked);
    asked.map(|(_, what, why)| Unsupported { what, why })
}
