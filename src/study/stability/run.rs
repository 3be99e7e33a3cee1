//! Runs the points of a stability study, several at a time with one thread each.

use std::ops::ControlFlow;
use std::path::Path;

use super::{
    Class, Known, Reading, StabilityPlan, Values, observe::observe, plan::PlannedMap,
    plan::PointOf, results::Name,
};
use crate::study::pool::{Desk, Word, each};

/// Progress of a stability study.
pub enum StabilityEvent<'a> {
    /// Points are being run.
    Waiting {
        /// Completed fraction of all points, 0 to 1.
        fraction: f64,
    },
    /// A point is finished.
    Point {
        /// Its readings.
        readings: &'a [Reading],
        /// Readings of all points so far, in no order.
        all: &'a [Reading],
        /// Whether they are of an older run.
        known: bool,
        /// Completed fraction of all points, 0 to 1.
        fraction: f64,
    },
}

/// A column of points with one seed: the values of y that are known, or the search of an edge.
struct Column<'a> {
    map: &'a PlannedMap,
    x: f64,
    seed: Option<u32>,
    /// One value, or none for the search of an edge.
    y: Option<f64>,
}

/// A finished point, and whether an older run had it.
struct Done(Vec<Reading>, bool);

/// Runs the points of `plan` on `threads` threads, except those that `known` has. `version` is that of the program: a
/// point that another one ran is run again. `tell` is called for every point, and ten times a second; it may stop the
/// study. Returns the readings of all finished points, ordered by variant, x, y, seed and number of steps.
pub fn run_stability(
    plan: &StabilityPlan,
    threads: usize,
    known: &Known,
    version: &str,
    tell: &mut dyn FnMut(StabilityEvent) -> ControlFlow<()>,
) -> Vec<Reading> {
    let columns = columns(plan);
    let runs: Vec<usize> = columns.iter().map(|column| runs_of(column)).collect();
    let total: usize = runs.iter().sum();
    let mut all: Vec<Reading> = Vec::new();
    let mut done = 0;
    let work = |number: usize, desk: &Desk<Done>| {
        Worker {
            plan,
            known,
            version,
            desk,
        }
        .column(&columns[number]);
    };
    each(columns.len(), threads, work, &mut |word| {
        let fraction = |done: usize| done as f64 / total.max(1) as f64;
        match word {
            Word::Waiting => tell(StabilityEvent::Waiting {
                fraction: fraction(done),
            }),
            Word::Part(Done(readings, known)) => {
                done += 1;
                all.extend(readings.iter().cloned());
                tell(StabilityEvent::Point {
                    readings: &readings,
                    all: &all,
                    known,
                    fraction: fraction(done).min(1.0),
                })
            }
        }
    });
    sort(plan, &mut all);
    all
}

/// Orders readings by variant, x, y, seed and number of steps.
pub fn sort(plan: &StabilityPlan, readings: &mut [Reading]) {
    let place = |name: &str| plan.maps.iter().position(|map| map.name == name);
    readings.sort_by(|a, b| {
        (place(&a.variant).cmp(&place(&b.variant)))
            .then(a.x.total_cmp(&b.x))
            .then(a.y.total_cmp(&b.y))
            .then(a.seed.cmp(&b.seed))
            .then(a.after.cmp(&b.after))
    });
}

fn columns(plan: &StabilityPlan) -> Vec<Column<'_>> {
    let mut columns = Vec::new();
    for map in &plan.maps {
        let ys: Vec<Option<f64>> = match map.y.values {
            Values::Edge { .. } => vec![None],
            _ => map.y.known_values().into_iter().map(Some).collect(),
        };
        for x in map.x.known_values() {
            for &y in &ys {
                for seed in plan.seeds() {
                    columns.push(Column { map, x, seed, y });
                }
            }
        }
    }
    columns
}

/// Runs that a column takes at most.
fn runs_of(column: &Column) -> usize {
    match (column.y, &column.map.y.values) {
        (None, Values::Edge { halvings, .. }) => 2 + *halvings as usize,
        _ => 1,
    }
}

struct Worker<'a, 'b> {
    plan: &'a StabilityPlan,
    known: &'a Known,
    version: &'a str,
    desk: &'a Desk<'b, Done>,
}

impl Worker<'_, '_> {
    fn column(&self, column: &Column) {
        match (column.y, &column.map.y.values) {
            (Some(y), _) => {
                self.point(column, y);
            }
            (
                None,
                &Values::Edge {
                    stable,
                    unstable,
                    halvings,
                },
            ) => {
                self.edge(column, (stable, unstable), halvings);
            }
            (None, _) => {}
        }
    }

    /// Searches the edge between a stable and an unstable value: `None` if the study stops.
    fn edge(
        &self,
        column: &Column,
        (mut stable, mut unstable): (f64, f64),
        halvings: u32,
    ) -> Option<()> {
        let is_stable = |y: f64| Some(self.point(column, y)? == Class::Stable);
        // Beyond an end that is not as expected there is no edge to search.
        if !is_stable(stable)? || is_stable(unstable)? {
            return Some(());
        }
        for _ in 0..halvings {
            let middle = column.map.y.scale.between(stable, unstable, 0.5);
            if middle == stable || middle == unstable {
                break;
            }
            if is_stable(middle)? {
                stable = middle;
            } else {
                unstable = middle;
            }
        }
        Some(())
    }

    /// Runs a point, or takes it from an older run. The class after the most steps; `None` if the study stops.
    fn point(&self, column: &Column, y: f64) -> Option<Class> {
        let (map, x, seed) = (column.map, column.x, column.seed);
        let study = &self.plan.study;
        let of = PointOf { map, x, y, seed };
        let scene = self.plan.scene(of);
        let what = match &scene {
            Ok(scene) => scene_text(scene),
            Err(error) => error.to_string(),
        };
        let key = key(&[self.version, &what, &format!("{:?}", study.rules)]);
        let name = Name::new(&map.name, [x, y], seed, &key);
        if let Some(readings) = self.known.get(&name, &study.after) {
            let class = readings.last()?.class;
            return self
                .desk
                .put(Done(readings.to_vec(), true))
                .then_some(class);
        }
        let seen = match &scene {
            Ok(scene) => observe(scene, &study.after, &study.rules, &|| self.desk.stops())?,
            Err(error) => {
                let end = Some(super::End::Refused(error.to_string()));
                let seen = super::Observed {
                    end,
                    ..super::Observed::default()
                };
                vec![seen; study.after.len()]
            }
        };
        let empty = self.reading(of, key);
        let readings: Vec<Reading> = (study.after.iter().zip(&seen))
            .map(|(&after, seen)| empty.clone().with(after, study.rules.class(seen), seen))
            .collect();
        let class = readings.last()?.class;
        self.desk.put(Done(readings, false)).then_some(class)
    }

    fn reading(&self, of: PointOf, key: String) -> Reading {
        let set = self.plan.set(of).unwrap_or_default();
        let steps = self.plan.study.after.last().copied().unwrap_or(0);
        Reading {
            variant: of.map.name.clone(),
            x: of.x,
            y: of.y,
            seed: of.seed,
            after: 0,
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
            command: crate::study::command::of_run(&self.plan.scene_file, &set, Some(steps)),
            key,
        }
    }
}

/// A scene with what is in the files that it names.
pub(crate) fn scene_text(scene: &crate::scene::Scene) -> String {
    let mut text = scene.to_ron().unwrap_or_default();
    let mut scene = scene.clone();
    for file in scene.files_mut() {
        let content = std::fs::read(Path::new(file.as_str())).unwrap_or_default();
        text.push_str(&format!("\n{:08x}", crc32fast::hash(&content)));
    }
    text
}

/// A checksum of texts.
pub(crate) fn key(texts: &[&str]) -> String {
    let mut sum = crc32fast::Hasher::new();
    for text in texts {
        sum.update(&(text.len() as u64).to_le_bytes());
        sum.update(text.as_bytes());
    }
    format!("{:08x}", sum.finalize())
}
