//! Random displacements of particles, reproducible from a seed.

use glam::DVec3;

use crate::mesh::split_mix;
use crate::scene::{Dimension, Jitter};

/// The random displacements of a body's particles, in their order: the upper 24 bits of a draw of [`split_mix`] for
/// each coordinate, even in `[-amplitude, amplitude) × spacing`.
pub(crate) struct Displacement {
    state: u64,
    /// Largest displacement of a coordinate \[m]; 0 without jitter.
    size: f64,
    dimension: Dimension,
}

impl Displacement {
    pub(crate) fn new(jitter: Option<Jitter>, spacing: f64, dimension: Dimension) -> Self {
        let (amplitude, seed) = jitter.map_or((0.0, 0), |jitter| (jitter.amplitude, jitter.seed));
        Self {
            state: seed,
            size: f64::from(amplitude) * spacing,
            dimension,
        }
    }

    pub(crate) fn next(&mut self) -> DVec3 {
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
