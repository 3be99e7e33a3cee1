//! Points with their classes: in memory, and as a CSV file from which a study goes on.

use std::collections::{HashMap, HashSet};
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Class, Observed};

/// A run of a point, after one of the study's numbers of steps: a line of the CSV file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Name of the variant.
    pub variant: String,
    /// Value on the horizontal axis.
    pub x: f64,
    /// Value on the vertical axis.
    pub y: f64,
    /// Seed; none in studies without seeds.
    pub seed: Option<u32>,
    /// Steps after which the run was classed.
    pub after: u64,
    /// Its class then.
    pub class: Class,
    /// Steps taken: fewer if the run ended before.
    pub steps: u64,
    /// Simulated time \[s].
    pub time_s: f64,
    /// Wall time of its steps \[s], one thread.
    pub wall_s: f64,
    /// Wall time per simulated time \[s/s]; none if no time passed.
    pub cost: Option<f64>,
    /// Largest growth of the energy \[energy of the start].
    pub energy_gain: f64,
    /// Largest mean density error of a step \[-].
    pub mean_density_error: f64,
    /// Largest density error \[-].
    pub largest_density_error: f64,
    /// Part of the particles beyond the walls \[-].
    pub leaked: f64,
    /// Steps that missed the pressure's tolerance.
    pub not_converged: u64,
    /// Mean pressure iterations of a step.
    pub iterations: f64,
    /// Why the run ended early.
    pub reason: String,
    /// The command that repeats the run.
    pub command: String,
    /// What the run depends on, program included, as a checksum: a reading is used again only if it is the same.
    pub key: String,
}

/// The run of a point with the same variant, values and seed.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Name(String, u64, u64, Option<u32>, String);

impl Name {
    pub(super) fn new(variant: &str, [x, y]: [f64; 2], seed: Option<u32>, key: &str) -> Self {
        Self(
            variant.to_owned(),
            x.to_bits(),
            y.to_bits(),
            seed,
            key.to_owned(),
        )
    }
}

/// Readings of an older run of the study, by point.
#[derive(Debug, Clone, Default)]
pub struct Known(HashMap<Name, Vec<Reading>>);

impl Known {
    /// Reads a CSV file that a study wrote. Lines that are no readings, such as the last one of a program that was
    /// killed, are left out.
    pub fn read(path: &Path) -> io::Result<Self> {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .from_path(path)
            .map_err(io::Error::from)?;
        let mut known = Self::default();
        for reading in reader.deserialize::<Reading>().flatten() {
            let name = Name::new(
                &reading.variant,
                [reading.x, reading.y],
                reading.seed,
                &reading.key,
            );
            known.0.entry(name).or_default().push(reading);
        }
        Ok(known)
    }

    /// Readings whose points are not among others: a study that is not finished keeps them.
    pub fn beside(&self, others: &[Reading]) -> Vec<Reading> {
        let of = |reading: &Reading| {
            (
                reading.variant.clone(),
                reading.x.to_bits(),
                reading.y.to_bits(),
                reading.seed,
            )
        };
        let taken: HashSet<_> = others.iter().map(of).collect();
        let all = self.0.values().flatten();
        all.filter(|reading| !taken.contains(&of(reading)))
            .cloned()
            .collect()
    }

    /// The readings of a point, if there is one for every number of steps.
    pub(super) fn get(&self, name: &Name, after: &[u64]) -> Option<&[Reading]> {
        let readings = self.0.get(name)?;
        readings
            .iter()
            .map(|reading| reading.after)
            .eq(after.iter().copied())
            .then_some(readings)
    }
}

impl Reading {
    /// Fills in what was seen.
    pub(super) fn with(mut self, after: u64, class: Class, seen: &Observed) -> Self {
        self.after = after;
        self.class = class;
        self.steps = seen.steps;
        self.time_s = seen.time;
        self.wall_s = seen.wall;
        self.cost = (seen.time > 0.0).then(|| seen.wall / seen.time);
        self.energy_gain = seen.energy_gain;
        self.mean_density_error = seen.mean_density_error;
        self.largest_density_error = seen.largest_density_error;
        self.leaked = seen.leaked;
        self.not_converged = seen.not_converged;
        self.iterations = seen.iterations as f64 / seen.steps.max(1) as f64;
        self.reason = seen
            .end
            .as_ref()
            .map_or_else(String::new, super::End::reason);
        self
    }
}

/// The readings as CSV, below lines of remarks.
pub fn csv_of(readings: &[Reading], remarks: &[String]) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    for remark in remarks {
        text.extend(format!("# {}\n", remark.replace(['\n', '\r'], " ")).bytes());
    }
    let mut writer = csv::Writer::from_writer(&mut text);
    for reading in readings {
        writer.serialize(reading).map_err(io::Error::from)?;
    }
    writer.flush()?;
    drop(writer);
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::stability::End;

    fn reading(after: u64, key: &str) -> Reading {
        let empty = Reading {
            variant: "a, \"b\"".into(),
            x: 0.1,
            y: 3e-5,
            seed: Some(2),
            after,
            class: Class::Stable,
            steps: 0,
            time_s: 0.0,
            wall_s: 0.0,
            cost: None,
            energy_gain: 0.0,
            mean_density_error: 0.0,
            largest_density_error: 0.0,
            leaked: 0.0,
            not_converged: 0,
            iterations: 0.0,
            reason: String::new(),
            command: "overfall run 'a b.ron' --set 'spacing=1'".into(),
            key: key.into(),
        };
        let seen = Observed {
            steps: after,
            time: 0.5,
            wall: 0.25,
            energy_gain: f64::NAN,
            end: Some(End::OutOfTime),
            ..Observed::default()
        };
        empty.with(after, Class::NotConverged, &seen)
    }

    #[test]
    fn what_is_written_is_found_again_and_only_if_nothing_changed() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("map.csv");
        let readings = [reading(10, "k"), reading(100, "k"), reading(10, "old")];
        let mut text = csv_of(&readings, &["a, b\nc".into()]).expect("CSV");
        text.extend(b"cut,0.1,");
        std::fs::write(&path, text).expect("a file");
        let known = Known::read(&path).expect("CSV");
        let name = |key: &str| Name::new("a, \"b\"", [0.1, 3e-5], Some(2), key);
        let found = known.get(&name("k"), &[10, 100]).expect("finished");
        assert_eq!(
            (found[1].class, found[1].cost),
            (Class::NotConverged, Some(0.5))
        );
        assert_eq!(found[1].command, readings[1].command);
        assert!(found[0].energy_gain.is_nan());
        // Other numbers of steps, another program, another value.
        assert!(known.get(&name("k"), &[10, 200]).is_none());
        assert!(known.get(&name("old"), &[10, 100]).is_none());
        assert!(known.get(&name("new"), &[10, 100]).is_none());
        let other = Name::new("a, \"b\"", [0.1, 4e-5], Some(2), "k");
        assert!(known.get(&other, &[10, 100]).is_none());
    }
}
