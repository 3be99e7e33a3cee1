//! What the comparison of a chunk of blocks notes for those who come after it.

use glam::IVec3;

/// A point that left its cell and is in none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mover {
    pub(super) row: u32,
    /// The used cell that it left; then the one at the hash of the cell that it comes to.
    pub(super) handle: u32,
    /// The only block of that, if the cell is its first; or else nobody's.
    pub(super) block: u32,
    /// The cell that it comes to.
    pub(super) to: IVec3,
}

/// What the points of a chunk of blocks did.
#[derive(Debug, Default)]
pub(super) struct Moves {
    /// Points that have no place yet.
    pub(super) movers: Vec<Mover>,
    /// Number of points that left simple used cells.
    pub(super) left: usize,
    /// Simple used cells that lost their last point.
    pub(super) emptied: Vec<u32>,
    /// The used cells that are not simple and lost a point, and the spatial cell that it was in.
    pub(super) departures: Vec<(u32, IVec3)>,
}

impl Moves {
    pub(super) fn clear(&mut self) {
        self.movers.clear();
        self.left = 0;
        self.emptied.clear();
        self.departures.clear();
    }

    /// Points that changed their cell, or are gone.
    pub(super) fn len(&self) -> usize {
        self.left + self.departures.len()
    }

    /// Memory held [bytes].
    pub(super) fn bytes(&self) -> usize {
        self.movers.capacity() * size_of::<Mover>()
            + self.emptied.capacity() * size_of::<u32>()
            + self.departures.capacity() * size_of::<(u32, IVec3)>()
    }
}
