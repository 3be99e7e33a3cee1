//! Random displacements of particles, reproducible from a seed.

use glam::DVec3;

use crate::scene::{Dimension, Jitter};

/// The random displacements of a body's particles, in their order: the upper 24 bits of a draw of [`split_mix`] for
/// each coordinate, even in `[-amplitude, amplitude) × spacing`.
pub(super) struct Displacement {
    state: u64,
    /// Largest displacement of a coordinate \[m]; 0 without jitter.
    size: f64,
    dimension: Dimension,
}

impl Displacement {
    pub(super) fn new(jitter: Option<Jitter>, spacing: f64, dimension: Dimension) -> Self {
        let (amplitude, seed) = jitter.map_or((0.0, 0), |jitter| (jitter.amplitude, jitter.seed));
        Self {
            state: seed,
            size: f64::from(amplitude) * spacing,
            dimension,
        }
    }

    pub(super) fn next(&mut self) -> DVec3 {
        if self.size == 0.0 {
            return DVec3::ZERO;
        }
        let (x, y) = (self.coordinate(), self.coordinate());
        let z = match self.dimension {
            Dimension::Two => 0.0,
            Dimension::Three => self.coordinate(),
        };
        DVec3::new(x, y, z)
    }

    fn coordinate(&mut self) -> f64 {
        let unit = (split_mix(&mut self.state) >> 40) as f64 / f64::from(1 << 24);
        (2.0 * unit - 1.0) * self.size
    }
}

/// The next 64 random bits of SplitMix64 (Steele, Lea & Flood 2014).
pub(crate) fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut bits = *state;
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}
