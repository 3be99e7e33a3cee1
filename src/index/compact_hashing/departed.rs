//! What the comparison of a chunk of blocks records for the following passes.

use glam::IVec3;

/// A point that left its cell and is not inserted in the new one yet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Departed {
    pub(super) row: u32,
    /// The used cell that it left; later the used cell at the hash of its new cell.
    pub(super) handle: u32,
    /// The only block of that used cell if the new cell is its primary cell; otherwise `NONE`.
    pub(super) block: u32,
    /// The new cell.
    pub(super) to: IVec3,
}

/// Movements of the points of one chunk of blocks.
#[derive(Debug, Default)]
pub(super) struct Moves {
    /// Points that are not inserted yet.
    pub(super) departed: Vec<Departed>,
    /// Number of points that left simple used cells.
    pub(super) left: usize,
    /// Simple used cells that lost their last point.
    pub(super) emptied: Vec<u32>,
    /// Used cells that are not simple and lost a point, each with the spatial cell that the point was in.
    pub(super) departures: Vec<(u32, IVec3)>,
}

impl Moves {
    pub(super) fn clear(&mut self) {
        self.departed.clear();
        self.left = 0;
        self.emptied.clear();
        self.departures.clear();
    }

    /// Number of points that changed their cell or were removed.
    pub(super) fn len(&self) -> usize {
        self.left + self.departures.len()
    }

    /// Memory held \[bytes].
    pub(super) fn bytes(&self) -> usize {
        self.departed.capacity() * size_of::<Departed>()
            + self.emptied.capacity() * size_of::<u32>()
            + self.departures.capacity() * size_of::<(u32, IVec3)>()
    }
}
