//! Runs that end with their test.

use std::ops::{Deref, DerefMut};
use std::process::Child;
use std::time::Duration;

/// Long enough for a loaded machine; a passing test does not wait this long.
pub(crate) const PATIENCE: Duration = Duration::from_secs(600);

/// A run that is killed at the end of its test at the latest.
pub(crate) struct Running(pub(crate) Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Killing a finished process fails, which is fine.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Deref for Running {
    type Target = Child;

    fn deref(&self) -> &Child {
        &self.0
    }
}

impl DerefMut for Running {
    fn deref_mut(&mut self) -> &mut Child {
        &mut self.0
    }
}
