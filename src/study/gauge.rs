//! A measure that shows gauges of the scene: one figure per block, from the readings within it.

use serde::{Deserialize, Serialize};

use crate::scene::{self, Scene};

/// A column of a gauge, and the statistic of its readings that represents a block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeMeasure {
    /// Name of the gauge.
    pub gauge: String,
    /// The column of the gauge; its first if absent.
    #[serde(default)]
    pub column: Option<String>,
    /// The statistic that represents the block.
    #[serde(default)]
    pub statistic: Statistic,
}

/// Statistic of the readings in a block. Readings without a figure are ignored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Statistic {
    /// Their mean.
    #[default]
    Mean,
    /// The least.
    Least,
    /// The greatest.
    Greatest,
    /// The last.
    Last,
    /// Root mean square of their differences from the gauge's reference, at the times that the reference covers.
    Error,
}

/// Gauge and column.
pub(super) type Key = (String, Option<String>);

/// Suffixes of column names and their units.
const UNITS: [(&str, &str); 7] = [
    ("_m3_per_s", "m³/s"),
    ("_m_per_s", "m/s"),
    ("_N_m", "N m"),
    ("_N", "N"),
    ("_Pa", "Pa"),
    ("_J", "J"),
    ("_m", "m"),
];

impl GaugeMeasure {
    pub(super) fn key(&self) -> Key {
        (self.gauge.clone(), self.column.clone())
    }

    /// Unit of the column.
    pub(super) fn unit(&self) -> &'static str {
        let column = self.column.as_deref().unwrap_or_default();
        let end = UNITS.iter().find(|(end, _)| column.ends_with(end));
        end.map_or("", |(_, unit)| unit)
    }

    /// Sets the column to the gauge's first if none is named.
    pub(super) fn name_its_column(&mut self, scene: &Scene) {
        let gauge = scene.gauges.iter().find(|gauge| gauge.name == self.gauge);
        let first = || gauge?.columns().into_iter().next();
        self.column = self.column.take().or_else(first);
    }

    /// The mistake in a scene and the remedy, if there is one.
    pub(super) fn check(&self, scene: &Scene) -> Result<(), String> {
        let unknown = scene::unknown_name;
        let names: Vec<&str> = scene
            .gauges
            .iter()
            .map(|gauge| gauge.name.as_str())
            .collect();
        let gauge = scene.gauges.iter().find(|gauge| gauge.name == self.gauge);
        let Some(gauge) = gauge else {
            return Err(unknown("gauge", &self.gauge, None, &names));
        };
        let columns = gauge.columns();
        if let Some(column) = &self.column
            && !columns.contains(column)
        {
            let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
            return Err(unknown("column", column, Some(&self.gauge), &columns));
        }
        if self.statistic == Statistic::Error && gauge.reference.is_none() {
            return Err(format!(
                "the gauge `{}` has no `reference` in the scene to be compared with; give it one, or choose another \
                 statistic",
                self.gauge
            ));
        }
        Ok(())
    }
}

/// Sums over readings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Tally {
    count: f64,
    sum: f64,
    /// The least, the greatest and the last figure.
    figures: Option<(f64, f64, f64)>,
    compared: f64,
    squares: f64,
}

impl Tally {
    pub(super) fn add(&mut self, value: f64, known: Option<f64>) {
        let (low, high, _) = self.figures.unwrap_or((value, value, value));
        self.figures = Some((low.min(value), high.max(value), value));
        self.count += 1.0;
        self.sum += value;
        if let Some(known) = known {
            self.compared += 1.0;
            self.squares += (value - known).powi(2);
        }
    }

    /// Adds the sums of a later block.
    pub(super) fn join(&mut self, later: &Self) {
        self.count += later.count;
        self.sum += later.sum;
        self.compared += later.compared;
        self.squares += later.squares;
        self.figures = match (self.figures, later.figures) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1), b.2)),
            (a, b) => b.or(a),
        };
    }

    pub(super) fn figure(&self, statistic: Statistic) -> Option<f64> {
        let (low, high, last) = self.figures?;
        match statistic {
            Statistic::Mean => Some(self.sum / self.count),
            Statistic::Least => Some(low),
            Statistic::Greatest => Some(high),
            Statistic::Last => Some(last),
            Statistic::Error => {
                (self.compared > 0.0).then(|| (self.squares / self.compared).sqrt())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_together_are_as_one() {
        let mut all = Tally::default();
        let mut parts = [Tally::default(), Tally::default(), Tally::default()];
        for (k, value) in [3.0, -1.0, 4.0, 1.0].into_iter().enumerate() {
            let known = (k > 0).then_some(1.0);
            all.add(value, known);
            parts[2 * (k / 2)].add(value, known);
        }
        let mut joined = Tally::default();
        parts.iter().for_each(|part| joined.join(part));
        assert_eq!(joined, all);
        let figure = |statistic| joined.figure(statistic).expect("readings");
        let expected = [1.75, -1.0, 4.0, 1.0, (13.0_f64 / 3.0).sqrt()];
        let statistics = [
            Statistic::Mean,
            Statistic::Least,
            Statistic::Greatest,
            Statistic::Last,
            Statistic::Error,
        ];
        assert_eq!(statistics.map(figure), expected);
        assert_eq!(Tally::default().figure(Statistic::Mean), None);
    }
}
