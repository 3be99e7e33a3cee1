//! Queries that go through the particles and not through the cells, as the paper's basic uniform grid does: blocks of
//! rows, and in them rows of one cell that follow each other, which share their candidates.

/// Rows that one place stands for.
const BLOCK: usize = 64;

/// Every row with the cell that it is in.
#[derive(Debug, Default)]
pub(super) struct ByRow<K> {
    /// The cell of every row, in whatever form the structure has it.
    pub(super) cells: Vec<K>,
    /// 0, 1, 2, …
    rows: Vec<u32>,
}

impl<K: Copy + PartialEq> ByRow<K> {
    /// Takes over that `cells` has changed its length.
    pub(super) fn count_rows(&mut self) {
        self.rows.truncate(self.cells.len());
        self.rows
            .extend(self.rows.len() as u32..self.cells.len() as u32);
    }

    pub(super) fn places(&self) -> usize {
        self.rows.len().div_ceil(BLOCK)
    }

    pub(super) fn place(&self, place: usize) -> std::ops::Range<usize> {
        place * BLOCK..self.rows.len().min((place + 1) * BLOCK)
    }

    pub(super) fn group(&self, place: usize, from: usize) -> Option<(K, &[u32])> {
        let range = self.place(place);
        let cells = &self.cells[range.clone()][from..];
        let &cell = cells.first()?;
        let len = cells.iter().take_while(|&&other| other == cell).count();
        Some((cell, &self.rows[range][from..from + len]))
    }

    pub(super) fn bytes(&self) -> usize {
        self.cells.capacity() * size_of::<K>() + self.rows.capacity() * size_of::<u32>()
    }
}
