//! The transport of particles between tables and rows alone, for the bench that measures what the ECS costs.

use bevy_ecs::prelude::*;

use super::{columns::lasting, gather};
use crate::{
    scene::Scene,
    state::{Systems, chain, transfer},
};

/// The systems that copy the state from the tables into rows, at the start of a step.
pub fn gathering(scene: &Scene) -> Systems {
    (gather::STAGE.systems)(scene)
}

/// The systems that check the tables and copy the rows back, at the end of a step.
pub fn scattering(scene: &Scene) -> Systems {
    let lasting = lasting(scene);
    let mut systems: Vec<Systems> = vec![transfer::check_rows.into_configs()];
    systems.extend(lasting.iter().map(|column| (column.check_unwritten)()));
    systems.extend(lasting.iter().map(|column| (column.scatter)()));
    chain(systems)
}
