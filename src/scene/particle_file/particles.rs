//! Particles of a file, whatever its format.

use glam::DVec3;

/// More particles than any machine this is meant for holds; a larger number is a header that is wrong.
const MOST: usize = 200_000_000;

/// Particles of a file, in its order.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Particles {
    /// In units of the file.
    pub(crate) positions: Vec<DVec3>,
    /// \[m/s]; none if the file has none.
    pub(crate) velocities: Option<Vec<DVec3>>,
}

/// Refuses a number of particles that a header claims, before memory is taken for them.
pub(super) fn possible(count: usize, bytes: usize, least_bytes: usize) -> Result<(), String> {
    if count > MOST {
        return Err(format!(
            "its header says {count} particles; at most {} million are possible",
            MOST / 1_000_000
        ));
    }
    if count.saturating_mul(least_bytes) > bytes {
        return Err(format!(
            "its header says {count} particles, for which the file of {bytes} bytes is too short; write it again"
        ));
    }
    Ok(())
}
