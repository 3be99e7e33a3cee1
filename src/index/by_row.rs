//! Queries that iterate over particles instead of cells, as the paper's basic uniform grid does. A block holds
//! consecutive rows; consecutive rows of one cell share their candidates.

/// Rows per partition.
const BLOCK: usize = 64;

/// The cell of every row.
#[derive(Debug, Default)]
pub(super) struct ByRow<K> {
    /// The cell of every row, in the structure's own representation.
    pub(super) cells: Vec<K>,
    /// 0, 1, 2, …
    rows: Vec<u32>,
}

impl<K: Copy + PartialEq> ByRow<K> {
    /// Adapts to a new length of `cells`.
    pub(super) fn count_rows(&mut self) {
        self.rows.truncate(self.cells.len());
        self.rows
            .extend(self.rows.len() as u32..self.cells.len() as u32);
    }

    pub(super) fn partitions(&self) -> usize {
        self.rows.len().div_ceil(BLOCK)
    }

    pub(super) fn partition(&self, partition: usize) -> std::ops::Range<usize> {
        partition * BLOCK..self.rows.len().min((partition + 1) * BLOCK)
    }

    pub(super) fn next_cell(&self, partition: usize, from: usize) -> Option<(K, &[u32])> {
        let range = self.partition(partition);
        let cells = &self.cells[range.clone()][from..];
        let &cell = cells.first()?;
        let len = cells.iter().take_while(|&&other| other == cell).count();
        Some((cell, &self.rows[range][from..from + len]))
    }

    pub(super) fn bytes(&self) -> usize {
        self.cells.capacity() * size_of::<K>() + self.rows.capacity() * size_of::<u32>()
    }
}
