//! Which particle is in which row of the columns.

use bevy_ecs::{change_detection::Tick, prelude::*};

/// Which particle is in which row: the entities, in the order in which the columns were gathered last.
#[derive(Resource, Debug, Clone)]
pub struct Rows {
    /// The entity of every row.
    pub(crate) entities: Vec<Entity>,
    /// Whether rows named other particles before. What earlier steps left behind by row is of no use then.
    pub(crate) changed: bool,
    /// How often the columns were gathered.
    pub(crate) generation: u64,
    /// When the columns were gathered: what changes in the tables between then and their new state would be lost.
    pub(crate) gathered: Tick,
}

impl Default for Rows {
    fn default() -> Self {
        Self {
            entities: Vec::new(),
            changed: false,
            generation: 0,
            gathered: Tick::new(0),
        }
    }
}

impl Rows {
    /// The particles in the order of the rows.
    pub fn entities(&self) -> &[Entity] {
        &self.entities
    }

    /// The particle of a row.
    pub fn entity_of(&self, row: usize) -> Option<Entity> {
        self.entities.get(row).copied()
    }

    /// The row of a particle in the columns of the step at hand, or of the last one. Rows are looked through: of many
    /// particles make a map, once a step.
    pub fn row_of(&self, particle: Entity) -> Option<usize> {
        self.entities.iter().position(|&entity| entity == particle)
    }
}
