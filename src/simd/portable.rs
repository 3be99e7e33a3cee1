//! The path for every machine: arrays of eight numbers, vectorised by the compiler.

use std::array::from_fn;

use glam::Vec4;

use super::{
    candidates::{Candidates, Near, Probe, Run},
    vector::{Cube, LANES, Lanes, Simd},
};

/// Plain Rust.
#[derive(Debug, Clone, Copy)]
pub struct Portable;

type F = [f32; LANES];

/// Whether the build target has fused multiply-add; a library call instead would be far too slow.
const FUSED: bool = cfg!(any(target_feature = "fma", target_arch = "aarch64"));

/// The lanes for which a condition holds, one bit each.
#[inline(always)]
fn mask(holds: impl Fn(usize) -> bool) -> u32 {
    (0..LANES).map(|lane| u32::from(holds(lane)) << lane).sum()
}

/// Moves the lanes of `mask` to the front, in their order.
#[inline(always)]
fn compress<T: Copy>(lanes: [T; LANES], mask: u32) -> [T; LANES] {
    let (mut compressed, mut count) = (lanes, 0);
    for (lane, x) in lanes.into_iter().enumerate() {
        compressed[count.min(LANES - 1)] = x;
        count += (mask as usize >> lane) & 1;
    }
    compressed
}

impl Simd for Portable {
    type F = F;
    type Rows = [u32; LANES];

    #[inline(always)]
    fn splat(self, x: f32) -> F {
        [x; LANES]
    }

    #[inline(always)]
    fn load(self, lanes: &Lanes) -> F {
        lanes.0
    }

    #[inline(always)]
    fn store(self, a: F, lanes: &mut Lanes) {
        lanes.0 = a;
    }

    #[inline(always)]
    fn bits(self, a: F) -> [u32; LANES] {
        a.map(f32::to_bits)
    }

    #[inline(always)]
    fn add(self, a: F, b: F) -> F {
        from_fn(|k| a[k] + b[k])
    }

    #[inline(always)]
    fn sub(self, a: F, b: F) -> F {
        from_fn(|k| a[k] - b[k])
    }

    #[inline(always)]
    fn mul(self, a: F, b: F) -> F {
        from_fn(|k| a[k] * b[k])
    }

    #[inline(always)]
    fn div(self, a: F, b: F) -> F {
        from_fn(|k| a[k] / b[k])
    }

    #[inline(always)]
    fn mul_add(self, a: F, b: F, c: F) -> F {
        if FUSED {
            from_fn(|k| a[k].mul_add(b[k], c[k]))
        } else {
            from_fn(|k| a[k] * b[k] + c[k])
        }
    }

    #[inline(always)]
    fn max(self, a: F, b: F) -> F {
        from_fn(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn min(self, a: F, b: F) -> F {
        from_fn(|k| if a[k] < b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn sqrt(self, a: F) -> F {
        a.map(f32::sqrt)
    }

    #[inline(always)]
    fn sum(self, a: F) -> f32 {
        ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]))
    }

    #[inline(always)]
    fn rows(self, list: &[u32]) -> [u32; LANES] {
        from_fn(|k| list.get(k).copied().unwrap_or(u32::MAX))
    }

    #[inline(always)]
    fn below(self, rows: [u32; LANES], limit: u32) -> u32 {
        mask(|lane| rows[lane] < limit)
    }

    #[inline(always)]
    fn inside(self, point: [F; 3], cube: Cube) -> u32 {
        mask(|lane| (0..3).all(|axis| (point[axis][lane] - cube.center[axis]).abs() < cube.half))
    }

    #[inline(always)]
    fn compress(self, a: F, mask: u32) -> F {
        compress(a, mask)
    }

    #[inline(always)]
    fn compress_rows(self, rows: [u32; LANES], mask: u32) -> [u32; LANES] {
        compress(rows, mask)
    }

    #[inline(always)]
    fn insert(self, block: &mut [u32], place: usize, entry: [u32; 4]) {
        let pitch = block.len() / 4;
        for (column, word) in block.chunks_exact_mut(pitch).zip(entry) {
            column.copy_within(place..pitch - 1, place + 1);
            column[place] = word;
        }
    }

    #[inline(always)]
    fn gather(self, table: &[Vec4], rows: [u32; LANES]) -> [F; 4] {
        let last = table.len() - 1;
        let entries: [[f32; 4]; LANES] =
            from_fn(|k| table[(rows[k] as usize).min(last)].to_array());
        from_fn(|column| from_fn(|k| entries[k][column]))
    }

    #[inline(always)]
    fn splat_vector(self, x: Vec4) -> F {
        from_fn(|lane| x[lane % 4])
    }

    #[inline(always)]
    fn add_products(
        self,
        [a, b]: [&[Vec4]; 2],
        own: [F; 2],
        rows: [u32; LANES],
        factor: F,
        mut sum: F,
    ) -> F {
        let last = a.len().min(b.len()) - 1;
        for k in 0..4 {
            // Lane `l` uses row k of the lower four rows or row k of the upper four.
            let of_lane = |lane: usize| k + lane / 4 * 4;
            let entry = |table: &[Vec4]| -> F {
                from_fn(|lane| table[(rows[of_lane(lane)] as usize).min(last)][lane % 4])
            };
            let factor = from_fn(|lane| factor[of_lane(lane)]);
            let [x, y] = [self.sub(own[0], entry(a)), self.sub(own[1], entry(b))];
            sum = self.mul_add(factor, self.mul(x, y), sum);
        }
        sum
    }

    #[inline(always)]
    fn sum_vectors(self, a: F) -> f32 {
        ((a[0] + a[4]) + (a[1] + a[5])) + (a[2] + a[6])
    }

    #[inline(always)]
    fn take_near(
        self,
        candidates: &mut Candidates,
        near: Near,
        (words, pitch): (&[u32], usize),
        runs: &[Run],
    ) {
        let (to, to_rows) = candidates.room(runs);
        let mut count = 0;
        let place = |run: &Run| run.start as usize..run.start as usize + run.len as usize;
        for k in runs.iter().flat_map(place) {
            let point = [0, 1, 2].map(|axis| f32::from_bits(words[k + axis * pitch]));
            let [dx, dy, dz]: [f32; 3] = from_fn(|axis| {
                let below = near.low[axis] - point[axis];
                below.max(point[axis] - near.high[axis]).max(0.0)
            });
            for axis in 0..3 {
                to[axis][count] = point[axis];
            }
            to_rows[count] = words[k + 3 * pitch];
            count += usize::from(dx * dx + dy * dy + dz * dz <= near.radius_squared);
        }
        candidates.len += count;
    }

    #[inline(always)]
    fn collect_hits(self, candidates: &Candidates, probe: Probe, hits: &mut [u32]) -> usize {
        let ([x, y, z], rows) = candidates.columns();
        let mut count = 0;
        for (((x, y), z), &row) in x.iter().zip(y).zip(z).zip(rows) {
            let (dx, dy, dz) = (
                x - probe.center[0],
                y - probe.center[1],
                z - probe.center[2],
            );
            // Not fused, here and in every other path: all must find the same pairs.
            let inside = dx * dx + dy * dy + dz * dz <= probe.radius_squared;
            hits[count] = row;
            count += usize::from(inside & (row != probe.own_row));
        }
        count
    }
}
