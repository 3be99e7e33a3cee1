//! Speed-up over the number of threads, and the law of Amdahl (1967) that fits it best.

use std::thread::available_parallelism;

use super::{Study, Table, Variant};

/// Speed-up of one series of a case in one column.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    /// Case and series.
    pub series: String,
    /// Numbers of threads and speed-ups \[-], as measured.
    pub points: Vec<(f64, f64)>,
    /// The same of the reference.
    pub reference: Vec<(f64, f64)>,
    /// The part of the work on one thread that more threads do not share \[-], by the least squares of the inverse
    /// speed-ups; none without a point of several threads.
    pub serial_share: Option<f64>,
}

/// Amdahl's law: the speed-up \[-] by a number of threads of a work with a serial part.
pub fn amdahl(serial_share: f64, threads: f64) -> f64 {
    1.0 / (serial_share + (1.0 - serial_share) / threads)
}

/// The serial part that fits speed-ups best: `1/S − 1/n = f (1 − 1/n)` is linear in it.
fn serial_share(points: &[(f64, f64)]) -> Option<f64> {
    let (mut above, mut below) = (0.0, 0.0);
    for &(threads, speed_up) in points {
        let shared = 1.0 - 1.0 / threads;
        above += (1.0 / speed_up - 1.0 / threads) * shared;
        below += shared * shared;
    }
    (below > 0.0).then(|| (above / below).clamp(0.0, 1.0))
}

/// Whether the machine has the threads that a variant needs.
pub(super) fn fits(variant: &Variant) -> bool {
    let cores = available_parallelism().map_or(1, usize::from);
    (variant.threads).is_none_or(|threads| threads as usize <= cores)
}

/// A note on the variants that are left out.
pub(super) fn left_out(study: &Study) -> Option<String> {
    let names = study.variants.iter().filter(|variant| !fits(variant));
    let names: Vec<&str> = names.map(|variant| variant.name.as_str()).collect();
    let cores = available_parallelism().map_or(1, usize::from);
    (!names.is_empty()).then(|| {
        format!(
            "Left out, since this machine has {cores} cores: {}.",
            names.join("; ")
        )
    })
}

impl Table {
    /// The speed-ups in a column, by series; none for a column that is no speed, or rows without threads.
    pub fn scalings(&self, column: usize) -> Vec<Scaling> {
        let Some(is_rate) = self.columns[column].measure.is_rate() else {
            return Vec::new();
        };
        let faster = |own: f64, alone: f64| if is_rate { own / alone } else { alone / own };
        let mut all: Vec<Scaling> = Vec::new();
        for (k, row) in self.rows.iter().enumerate() {
            let Some(threads) = row.threads else { continue };
            let alone = self.rows.iter().position(|other| {
                let same = other.case == row.case && other.series == row.series;
                same && other.threads == Some(1)
            });
            let Some(alone) = alone else { continue };
            let series = row.series.as_deref().unwrap_or(&row.variant);
            let series = match row.case.as_str() {
                "" => series.to_owned(),
                case => format!("{case}, {series}"),
            };
            let place = all.iter().position(|known| known.series == series);
            let place = place.unwrap_or_else(|| {
                all.push(Scaling {
                    series,
                    points: Vec::new(),
                    reference: Vec::new(),
                    serial_share: None,
                });
                all.len() - 1
            });
            let threads = f64::from(threads);
            let own = self.figure(k, column).zip(self.figure(alone, column));
            let known = self.reference(k, column).zip(self.reference(alone, column));
            let scaling = &mut all[place];
            (scaling.points).extend(own.map(|(own, one)| (threads, faster(own.value, one.value))));
            (scaling.reference).extend(known.map(|(own, one)| (threads, faster(own, one))));
        }
        all.retain(|scaling| !scaling.points.is_empty());
        for scaling in &mut all {
            scaling.serial_share = serial_share(&scaling.points);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_serial_share_is_found_again() {
        for share in [0.0, 0.04, 0.3, 1.0] {
            let points = [1.0, 2.0, 4.0, 8.0, 24.0].map(|n| (n, amdahl(share, n)));
            let found = serial_share(&points).expect("points");
            assert!((found - share).abs() < 1e-12, "{found} for {share}");
        }
        assert_eq!(serial_share(&[(1.0, 1.0)]), None);
        // The paper's: 24 threads are 10 times as fast as one, 95 % of the work is parallel.
        let of_paper = serial_share(&[(24.0, 404.1 / 40.3)]).expect("a point");
        assert!((0.055..0.065).contains(&of_paper), "{of_paper}");
    }
}
