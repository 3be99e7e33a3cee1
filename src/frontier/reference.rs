//! The fine run that others are compared with, and its file.

use std::io;
use std::ops::ControlFlow;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{FrontierPlan, Subject, curves::curves};
use crate::study::stability::{key_of, scene_text};

/// Curves of a fine run, by the study's gauges; none for a case with known values.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reference {
    /// Times \[s] and values.
    pub curves: Vec<Vec<(f64, f64)>>,
    /// What they depend on, program included, as a checksum.
    pub key: String,
}

/// A line of the file.
#[derive(Serialize, Deserialize)]
struct Line {
    gauge: usize,
    t: f64,
    value: f64,
    key: String,
}

impl Reference {
    /// Reads the file of an older run of the study.
    pub fn read(path: &Path) -> io::Result<Self> {
        let mut reader = csv::Reader::from_path(path).map_err(io::Error::from)?;
        let mut found = Self::default();
        for line in reader.deserialize::<Line>() {
            let line = line.map_err(io::Error::from)?;
            if line.gauge > found.curves.len() {
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    "a gauge is missing",
                ));
            }
            if line.gauge == found.curves.len() {
                found.curves.push(Vec::new());
            }
            found.curves[line.gauge].push((line.t, line.value));
            found.key = line.key;
        }
        Ok(found)
    }

    /// The curves as CSV.
    pub fn csv(&self) -> io::Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for (gauge, curve) in self.curves.iter().enumerate() {
            for &(t, value) in curve {
                let key = self.key.clone();
                let line = Line {
                    gauge,
                    t,
                    value,
                    key,
                };
                writer.serialize(line).map_err(io::Error::from)?;
            }
        }
        writer
            .into_inner()
            .map_err(|error| io::Error::other(error.to_string()))
    }

    /// The reference of a study: that of an older run if nothing has changed, or a new one, on `threads` threads.
    /// `tell` gets the completed fraction and may stop it. The error says why there is none.
    pub fn of(
        plan: &FrontierPlan,
        older: Option<Self>,
        (threads, version): (usize, &str),
        tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Self, String> {
        let Subject::Scene { fine, gauges, .. } = &plan.subject else {
            return Ok(Self::default());
        };
        let scene = plan.scene(fine).map_err(|error| error.to_string())?;
        let key = key_of(&[version, &scene_text(&scene), &format!("{gauges:?}")]);
        if let Some(older) =
            older.filter(|older| older.key == key && older.curves.len() == gauges.len())
        {
            return Ok(older);
        }
        let (_, ended) = curves(plan, &scene, threads, tell);
        let curves = ended.map_err(|error| format!("the fine run failed: {error}"))?;
        if let Some(k) = curves.iter().position(|curve| curve.len() < 2) {
            return Err(format!(
                "the fine run has fewer than two readings of `{}`; give the gauge a higher rate, or the scene a longer \
                 `duration`",
                gauges[k].label()
            ));
        }
        Ok(Self { curves, key })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_is_read_as_it_was_written() {
        let reference = Reference {
            curves: vec![vec![(0.0, 1.0), (0.1, 1.0 / 3.0)], vec![(0.0, -2e-30)]],
            key: "k".into(),
        };
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("r.csv");
        std::fs::write(&path, reference.csv().expect("CSV")).expect("a file");
        assert_eq!(Reference::read(&path).expect("CSV"), reference);
        std::fs::write(&path, "gauge,t,value,key\n2,0,0,k\n").expect("a file");
        assert!(Reference::read(&path).is_err());
    }
}
