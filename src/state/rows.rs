//! Which particle is in which row of the columns.

use bevy_ecs::{change_detection::Tick, prelude::*};

/// Which particle is in which row: the entities, in the order in which the columns were gathered last.
///
/// On several ranks columns have rows of other ranks' particles before and after those of the world's own.
#[derive(Resource, Debug, Clone)]
pub struct Rows {
    /// The entity of every own row.
    pub(crate) entities: Vec<Entity>,
    /// The first own row.
    pub(crate) first: usize,
    /// Number of rows.
    pub(crate) all: usize,
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
            first: 0,
            all: 0,
            changed: false,
            generation: 0,
            gathered: Tick::new(0),
        }
    }
}

impl Rows {
    /// The particles of the world in the order of the rows, from [`first`](Self::first) on.
    pub fn entities(&self) -> &[Entity] {
        &self.entities
    }

    /// The row of the world's first particle: 0 but on several ranks.
    pub fn first(&self) -> usize {
        self.first
    }

    /// The particle of a row; none for one of another rank.
    pub fn entity_of(&self, row: usize) -> Option<Entity> {
        let place = row.checked_sub(self.first)?;
        self.entities.get(place).copied()
    }

    /// The row of a particle in the columns of the step at hand, or of the last one. Rows are looked through: of many
    /// particles make a map, once a step.
    pub fn row_of(&self, particle: Entity) -> Option<usize> {
        let place = self
            .entities
            .iter()
            .position(|&entity| entity == particle)?;
        Some(self.first + place)
    }
}
