//! Runs of a frontier study: in memory, and as a CSV file from which a study goes on.

use std::collections::HashSet;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::FrontierPlan;
use crate::study::stability::Class;

/// A run of a point and the error of one figure: a line of the CSV file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name of the variant.
    pub variant: String,
    /// Its swept values.
    pub settings: String,
    /// Number of the run of this point, from 1.
    pub repeat: u32,
    /// What the error is of.
    pub figure: String,
    /// Its error \[-]; none if the run failed.
    pub error: Option<f64>,
    /// How the run ended.
    pub class: Class,
    /// Steps taken.
    pub steps: u64,
    /// Simulated time \[s].
    pub time_s: f64,
    /// Wall time of its steps \[s], one thread.
    pub wall_s: f64,
    /// Wall time per simulated time \[s/s]; none if no time passed.
    pub cost: Option<f64>,
    /// Mean density error, averaged over the steps \[-].
    pub mean_density_error: f64,
    /// Largest density error \[-].
    pub largest_density_error: f64,
    /// Mean pressure iterations of a step.
    pub iterations: f64,
    /// Why the run failed.
    pub reason: String,
    /// The command that runs the scene with these settings.
    pub command: String,
    /// What the run depends on, program included, as a checksum.
    pub key: String,
}

/// A point of the chart: the runs of one setting, for one figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of the variant.
    pub variant: String,
    /// Its swept values.
    pub settings: String,
    /// Error \[-].
    pub error: f64,
    /// Wall time per simulated time \[s/s]: median, least and greatest of the runs.
    pub cost: [f64; 3],
}

/// A setting whose runs failed.
#[derive(Debug, Clone, PartialEq)]
pub struct Failed {
    /// Name of the variant.
    pub variant: String,
    /// Its swept values.
    pub settings: String,
    /// How they ended.
    pub class: Class,
    /// Wall time per simulated time until then \[s/s], if time passed.
    pub cost: Option<f64>,
    /// Why.
    pub reason: String,
}

/// The runs of all points so far, those of older runs of the study included.
#[derive(Debug, Clone, Default)]
pub struct Runs(pub Vec<Run>);

impl Runs {
    /// Reads a CSV file that a study wrote. Lines that are no runs, such as the last one of a program that was killed,
    /// are left out.
    pub fn read(path: &Path) -> io::Result<Self> {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .from_path(path)
            .map_err(io::Error::from)?;
        Ok(Self(reader.deserialize().flatten().collect()))
    }

    /// The runs as CSV, in the order of the study, below lines of remarks.
    pub fn csv(&self, remarks: &[String]) -> io::Result<Vec<u8>> {
        let mut text = Vec::new();
        for remark in remarks {
            text.extend(format!("# {}\n", remark.replace(['\n', '\r'], " ")).bytes());
        }
        let mut writer = csv::Writer::from_writer(&mut text);
        for run in &self.0 {
            writer.serialize(run).map_err(io::Error::from)?;
        }
        writer.flush()?;
        drop(writer);
        Ok(text)
    }

    /// Lines of runs that are not among others: a study that is not finished keeps them.
    pub fn beside(&self, others: &Self) -> Vec<Run> {
        let of = |run: &Run| (run.variant.clone(), run.settings.clone(), run.repeat);
        let taken: HashSet<_> = others.0.iter().map(of).collect();
        self.0
            .iter()
            .filter(|run| !taken.contains(&of(run)))
            .cloned()
            .collect()
    }

    /// The lines of one run, if they are all there: one for each figure.
    pub(super) fn of(
        &self,
        name: (&str, &str),
        repeat: u32,
        key: &str,
        figures: &[String],
    ) -> Option<Vec<Run>> {
        let is_of = |run: &&Run| {
            (run.variant.as_str(), run.settings.as_str()) == name
                && run.repeat == repeat
                && run.key == key
        };
        let lines: Vec<Run> = self.0.iter().filter(is_of).cloned().collect();
        lines
            .iter()
            .map(|run| &run.figure)
            .eq(figures)
            .then_some(lines)
    }

    /// Orders the lines as the study has its points.
    pub fn sort(&mut self, plan: &FrontierPlan) {
        let place = |run: &Run| {
            let of = |point: &super::PlannedPoint| {
                point.variant == run.variant && point.settings == run.settings
            };
            plan.points.iter().position(of)
        };
        // A stable sort: figures of a run keep their order.
        self.0.sort_by_key(|run| (place(run), run.repeat));
    }

    /// The points of a figure, and the settings that failed, in the order of the lines.
    pub fn points(&self, figure: &str) -> (Vec<Point>, Vec<Failed>) {
        let (mut points, mut failed) = (Vec::new(), Vec::new());
        let lines: Vec<&Run> = self.0.iter().filter(|run| run.figure == figure).collect();
        let same = |a: &&Run, b: &&Run| a.variant == b.variant && a.settings == b.settings;
        for runs in lines.chunk_by(same) {
            let first = runs[0];
            let (variant, settings) = (first.variant.clone(), first.settings.clone());
            let mut costs: Vec<f64> = runs.iter().filter_map(|run| run.cost).collect();
            costs.sort_by(f64::total_cmp);
            let good = runs
                .iter()
                .find(|run| run.error.is_some_and(f64::is_finite));
            match (good.and_then(|run| run.error), &costs[..]) {
                (Some(error), [low, .., high]) | (Some(error), [low @ high]) => {
                    points.push(Point {
                        variant,
                        settings,
                        error,
                        cost: [median(&costs), *low, *high],
                    })
                }
                _ => failed.push(Failed {
                    variant,
                    settings,
                    class: first.class,
                    cost: costs.first().copied(),
                    reason: first.reason.clone(),
                }),
            }
        }
        (points, failed)
    }
}

/// Median of ascending values, of which there is one at least.
fn median(ascending: &[f64]) -> f64 {
    let middle = ascending.len() / 2;
    match ascending.len() % 2 {
        1 => ascending[middle],
        _ => 0.5 * (ascending[middle - 1] + ascending[middle]),
    }
}

/// Numbers of the points that no other one beats: going from the cheapest, each has a smaller error than all before.
pub fn pareto_front(points: &[Point]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |k: &usize| (points[*k].cost[0], points[*k].error);
    order.sort_by(|a, b| {
        key(a)
            .0
            .total_cmp(&key(b).0)
            .then(key(a).1.total_cmp(&key(b).1))
    });
    let mut least = f64::INFINITY;
    order.retain(|&k| {
        let better = points[k].error < least;
        least = least.min(points[k].error);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(cost: f64, error: f64) -> Point {
        Point {
            variant: "v".into(),
            settings: String::new(),
            error,
            cost: [cost; 3],
        }
    }

    #[test]
    fn the_front_has_what_nothing_beats() {
        let points = [
            (3.0, 0.1),
            (1.0, 0.5),
            (2.0, 0.5),
            (2.5, 0.6),
            (9.0, 0.09),
            (1.0, 0.4),
        ];
        let points = points.map(|(cost, error)| point(cost, error));
        assert_eq!(pareto_front(&points), [5, 0, 4]);
        assert!(pareto_front(&[]).is_empty());
    }

    fn run(settings: &str, repeat: u32, error: Option<f64>, cost: f64) -> Run {
        Run {
            variant: "v".into(),
            settings: settings.into(),
            repeat,
            figure: "f".into(),
            error,
            class: if error.is_some() {
                Class::Stable
            } else {
                Class::Exploded
            },
            steps: 1,
            time_s: 1.0,
            wall_s: cost,
            cost: Some(cost),
            mean_density_error: 0.0,
            largest_density_error: 0.0,
            iterations: 0.0,
            reason: String::new(),
            command: String::new(),
            key: "k".into(),
        }
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(
            [&[1.0][..], &[1.0, 2.0], &[1.0, 2.0, 9.0]].map(median),
            [1.0, 1.5, 2.0]
        );
    }

    #[test]
    fn runs_of_a_setting_are_a_point_and_found_again() {
        let runs = Runs(vec![
            run("a", 1, Some(0.1), 3.0),
            run("a", 2, Some(0.1), 1.0),
            run("a", 3, Some(0.1), 2.0),
            run("b", 1, None, 5.0),
        ]);
        let (points, failed) = runs.points("f");
        assert_eq!((points.len(), points[0].cost), (1, [2.0, 1.0, 3.0]));
        assert_eq!((failed.len(), failed[0].class), (1, Class::Exploded));
        let figures = ["f".to_owned()];
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("runs.csv");
        std::fs::write(&path, runs.csv(&["remark".into()]).expect("CSV")).expect("a file");
        let read = Runs::read(&path).expect("CSV");
        assert_eq!(read.0, runs.0);
        assert!(read.of(("v", "a"), 2, "k", &figures).is_some());
        assert!(read.of(("v", "a"), 4, "k", &figures).is_none());
        assert!(read.of(("v", "a"), 2, "other", &figures).is_none());
        assert!(
            read.of(("v", "a"), 2, "k", &["f".to_owned(), "g".to_owned()])
                .is_none()
        );
    }
}
