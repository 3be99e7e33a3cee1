//! Columns as a host sees them: slices of one value per row. A host may read all of them and may add to accelerations;
//! only the engine changes their lengths, and no other column.

use std::ops::{Deref, DerefMut};

use glam::{Vec3, Vec4};

use super::columns::{
    Accelerations, Densities, Displacements, Positions, PredictedPositions, PressureAccelerations,
    Pressures, SENTINEL, Velocities,
};

macro_rules! reads_as_rows {
    ($($column:ident: $value:ty $(, ends with $sentinel:expr)?;)*) => {$(
        impl $column {
            /// The column of no particles. There is no public way to one: a host would empty the one of the step.
            pub(crate) fn empty() -> Self {
                Self(vec![$($sentinel)?])
            }
        }

        impl Deref for $column {
            type Target = [$value];

            fn deref(&self) -> &[$value] {
                const SENTINELS: usize = 0 $(+ { _ = $sentinel; 1 })?;
                &self.0[..self.0.len().saturating_sub(SENTINELS)]
            }
        }
    )*};
}

// Those that loops over neighbours read end with a sentinel, which is no row.
reads_as_rows! {
    Positions: Vec4, ends with SENTINEL;
    Velocities: Vec4, ends with Vec4::ZERO;
    PredictedPositions: Vec4, ends with SENTINEL;
    Densities: f32;
    Pressures: f32;
    Accelerations: Vec3;
    PressureAccelerations: Vec3;
    Displacements: Vec3;
}

impl DerefMut for Accelerations {
    fn deref_mut(&mut self) -> &mut [Vec3] {
        &mut self.0
    }
}
