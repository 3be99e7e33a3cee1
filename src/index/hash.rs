//! The hash function of the paper's equation 3.

use glam::IVec3;

/// The primes of equation 3.
const PRIMES: [u32; 3] = [73_856_093, 19_349_663, 83_492_791];
/// Size of the smallest table; also used for a single particle.
pub(super) const MIN_TABLE: usize = 16;

/// Equation 3 before the modulo operation.
#[inline(always)]
pub(super) fn mix(cell: IVec3) -> u32 {
    let [x, y, z] = cell.to_array().map(|c| c as u32);
    x.wrapping_mul(PRIMES[0]) ^ y.wrapping_mul(PRIMES[1]) ^ z.wrapping_mul(PRIMES[2])
}

/// Maps cells to positions in a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellHash {
    /// Number of positions.
    pub(super) size: usize,
    /// ⌈2⁶⁴ / size⌉: the remainder by the size is computed by multiplication (Lemire, Kaser & Kurz 2019).
    reciprocal: u64,
}

impl CellHash {
    pub(super) fn new(size: usize) -> Self {
        let size = size.clamp(MIN_TABLE, u32::MAX as usize);
        Self {
            size,
            reciprocal: u64::MAX / size as u64 + 1,
        }
    }

    /// A table with `places_per_point` positions per point.
    pub(super) fn for_points(points: usize, places_per_point: f32) -> Self {
        Self::new((points as f64 * f64::from(places_per_point)) as usize)
    }

    /// A table with `places_per_point` positions per point. The present table is kept if its size is between half and
    /// four times of that.
    pub(super) fn resized(self, points: usize, places_per_point: f32) -> Self {
        let wanted = (points as f64 * f64::from(places_per_point)) as usize;
        let wanted = wanted.max(MIN_TABLE);
        if wanted > 2 * self.size || 4 * wanted < self.size {
            Self::new(wanted)
        } else {
            self
        }
    }

    #[inline(always)]
    pub(super) fn of(&self, cell: IVec3) -> u32 {
        let fraction = self.reciprocal.wrapping_mul(u64::from(mix(cell)));
        ((u128::from(fraction) * self.size as u128) >> 64) as u32
    }
}
