//! Where the wall time of a run went.

use std::collections::BTreeMap;
use std::time::Duration;

/// Wall time by what took it.
#[derive(Debug, Default)]
pub(super) struct Spent {
    /// Reading the scene, sampling, and preparing the folder.
    pub(super) set_up: Duration,
    /// Steps of this process, those before a checkpoint excluded.
    pub(super) stepping: Duration,
    /// Rows of the history and of gauges.
    pub(super) rows: Duration,
    /// Copying frames and waiting for the writer.
    pub(super) waiting: Duration,
}

impl Spent {
    /// By name \[s].
    pub(super) fn by_part(
        &self,
        [frames, pictures, checkpoints]: [Duration; 3],
        sheet: Duration,
    ) -> BTreeMap<String, f64> {
        let parts = [
            ("setting up", self.set_up),
            ("steps", self.stepping),
            ("history and gauges", self.rows),
            ("waiting for the writer", self.waiting),
            ("contact sheet", sheet),
            ("writer: frames", frames),
            ("writer: pictures", pictures),
            ("writer: checkpoints", checkpoints),
        ];
        let parts = parts.into_iter().filter(|part| !part.1.is_zero());
        parts
            .map(|(name, time)| (name.to_owned(), time.as_secs_f64()))
            .collect()
    }
}
