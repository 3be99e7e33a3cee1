//! Structures of particles that would be larger than they may be.

/// Most cells of a dense structure: a table of 4 bytes per cell is then 512 MiB, and writing it takes a tenth of a
/// second a step. A box that needs more is refused.
pub const MAX_CELLS: u64 = 1 << 27;

/// A dense structure would need more cells than [`MAX_CELLS`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the box around all particles has {} × {} × {} cells of {cell_size:.4} m, and the spatial index needs memory for \
     each of them, at most {MAX_CELLS}; the structures CompactHashing and SpatialHashing need none for empty cells, \
     and a `domain` in the scene stops particles that fly away", .cells[0], .cells[1], .cells[2]
)]
pub struct DomainTooLarge {
    /// Cells along x, y and z.
    pub cells: [u64; 3],
    /// Their edge \[m].
    pub cell_size: f64,
    /// The point furthest from the middle of all others.
    pub row: usize,
}

/// Lists that would be longer than their spans can say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ListsTooLong {
    /// One of them.
    #[error(
        "a particle has {count} neighbours, and a list holds {max}; particles lie on top of each other",
        max = u16::MAX
    )]
    OfRow {
        /// The particle's row.
        row: usize,
        /// Its neighbours.
        count: usize,
    },
    /// All together.
    #[error(
        "there are {pairs} pairs of neighbours, and lists hold {most} in the memory of this machine; particles lie on \
         top of each other, or there are too many: with `neighbours: Recomputed` there is no limit"
    )]
    Together {
        /// Pairs of a row and a neighbour.
        pairs: usize,
        /// Pairs that lists can hold.
        most: usize,
    },
}
