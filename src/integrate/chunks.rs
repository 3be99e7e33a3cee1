//! Rows in the results of chunks, by their names on other ranks.

use super::{ChunkEnd, ChunkMotion};
use crate::state::ChunkResult;

impl ChunkResult for ChunkMotion {
    fn rename(&mut self, name: impl Fn(usize) -> usize) {
        self.speed_squared.1 = name(self.speed_squared.1);
        self.compression.1 = name(self.compression.1);
        if let Some((_, row)) = &mut self.not_finite {
            *row = name(*row);
        }
    }
}

impl ChunkResult for ChunkEnd {
    fn rename(&mut self, name: impl Fn(usize) -> usize) {
        self.outside = self.outside.map(name);
    }
}
