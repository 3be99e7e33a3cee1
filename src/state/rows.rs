//! Which particle is in which row of the columns.

use bevy_ecs::prelude::*;

/// Which particle is in which row: the entities, in the order in which the columns were gathered last.
#[derive(Resource, Debug, Clone, Default)]
pub struct Rows {
    /// The entity of every row.
    pub entities: Vec<Entity>,
    /// Whether rows named other particles before. What earlier steps left behind by row is of no use then.
    pub changed: bool,
    /// How often the columns were gathered.
    pub(crate) generation: u64,
}
