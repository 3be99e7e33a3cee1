//! Output of a run's gauges: one CSV file each, and a chart of those with reference data.

use std::io::Write as _;
use std::path::PathBuf;

use bevy_ecs::prelude::World;
use overfall::gauge::{self, Gauges, Reading};
use overfall::measure::Curve;
use overfall::output::{GaugeFile, OutputError, write_atomically};
use overfall::scene::Scene;
use overfall::study::chart::draw_beside_known;

use super::claims::Claims;
use super::exit::{Failure, cannot_write};
use super::folder::{self, RunFolder};
use super::manifest::create_folder;

/// The files of all gauges, in the order of the scene.
pub(super) struct GaugeFiles(Vec<Files>);

struct Files {
    rows: GaugeFile,
    comparison: Option<Comparison>,
}

/// A gauge that is drawn beside its reference curve.
struct Comparison {
    path: PathBuf,
    title: String,
    /// Name of the column, and its index among the gauge's columns.
    column: (String, usize),
    known: Curve,
    measured: Vec<(f64, f64)>,
}

impl GaugeFiles {
    /// Creates the files. In a run that resumes, each file keeps its number of rows in `kept`.
    pub(super) fn start(
        folder: &RunFolder,
        claims: &Claims,
        scene: &Scene,
        kept: &[u64],
    ) -> Result<Self, Failure> {
        if !scene.gauges.is_empty() {
            create_folder(&folder.gauges())?;
        }
        let kept = kept.iter().copied().chain(std::iter::repeat(0));
        let files = scene.gauges.iter().zip(kept).map(|(gauge, kept)| {
            let columns = gauge.columns();
            let file = claims.claim(&folder::gauge(&gauge.name));
            let rows = file.and_then(|path| GaugeFile::resume(&path, &columns, kept));
            let (rows, old) = rows.map_err(cannot_write)?;
            let comparison = gauge.reference.as_ref().map(|reference| {
                let known = reference
                    .load()
                    .map_err(|error| Failure::Refused(error.to_string()))?;
                let wanted = reference.quantity.as_ref().unwrap_or(&columns[0]);
                let place = columns.iter().position(|name| name == wanted);
                let chart = claims.claim(&folder::gauge_chart(&gauge.name));
                Ok(Comparison {
                    path: chart.map_err(cannot_write)?,
                    title: format!("{}: {}", scene.name, gauge.name),
                    column: (wanted.clone(), place.unwrap_or(0)),
                    known,
                    measured: (old.iter())
                        .filter_map(|row| reading(row, place.unwrap_or(0)))
                        .collect(),
                })
            });
            Ok(Files {
                rows,
                comparison: comparison.transpose()?,
            })
        });
        files.collect::<Result<_, _>>().map(Self)
    }

    /// Takes the readings that can no longer be rolled back; at the end of the run, all of them.
    pub(super) fn take(&mut self, world: &mut World, is_end: bool) -> Result<(), OutputError> {
        let settled = if is_end {
            u64::MAX
        } else {
            gauge::settled_step(world)
        };
        let Some(mut gauges) = world.get_resource_mut::<Gauges>() else {
            return Ok(());
        };
        for (files, readings) in self.0.iter_mut().zip(gauges.take_readings(settled)) {
            readings
                .iter()
                .try_for_each(|reading| files.push(reading))?;
        }
        Ok(())
    }

    /// Writes the buffered rows, and returns the number of rows of each file.
    pub(super) fn flush(&mut self) -> Result<Vec<u64>, OutputError> {
        let rows = self.0.iter_mut().map(|files| {
            files.rows.flush()?;
            Ok(files.rows.rows())
        });
        rows.collect()
    }

    /// Writes the remaining rows and draws the charts. Returns the errors.
    pub(super) fn finish(mut self, world: &mut World) -> Vec<String> {
        let mut failures = Vec::new();
        let mut note = |result: Result<(), OutputError>| {
            failures.extend(result.err().map(|error| cannot_write(error).into_text()));
        };
        note(self.take(world, true));
        for mut files in self.0 {
            note(files.rows.flush());
            if let Some(comparison) = files.comparison {
                note(comparison.draw());
            }
        }
        failures
    }
}

/// Time \[s] and figure of a row, if it has a figure.
fn reading(row: &str, place: usize) -> Option<(f64, f64)> {
    let mut cells = row.trim_end().split(',').skip(1);
    let time = cells.next()?.parse().ok()?;
    Some((time, cells.nth(place)?.parse().ok()?))
}

impl Files {
    fn push(&mut self, reading: &Reading) -> Result<(), OutputError> {
        if let Some(comparison) = &mut self.comparison
            && let Some(Some(value)) = reading.values.get(comparison.column.1)
        {
            comparison.measured.push((reading.time, *value));
        }
        self.rows.push(reading)
    }
}

impl Comparison {
    fn draw(&self) -> Result<(), OutputError> {
        match draw_beside_known(&self.title, &self.column.0, &self.measured, &self.known) {
            Ok(svg) => write_atomically(&self.path, |out| out.write_all(svg.as_bytes())),
            // An interrupted run may have nothing to draw; its rows are still useful.
            Err(_) => Ok(()),
        }
    }
}
