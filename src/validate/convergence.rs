//! Order of convergence: error over resolution.

use super::{Case, Figure, Method, Outcome, Source};

/// The order of a figure: `error ~ spacing^order`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Slope of the least-squares line through the logarithms; for an experiment, order of the differences.
    pub fitted: f64,
    /// Least and greatest order between consecutive resolutions.
    pub range: [f64; 2],
}

/// A figure of a case with a method at several resolutions.
#[derive(Debug, Clone)]
pub struct Convergence {
    /// The case.
    pub case: &'static Case,
    /// The method.
    pub method: &'static Method,
    /// The quantity.
    pub quantity: String,
    /// Ascending resolutions, and absolute errors there \[-]: relative to the exact value, or to the finest run if the
    /// reference is an experiment.
    pub errors: Vec<(u32, f64)>,
    /// The order, if the errors have one.
    pub order: Option<Order>,
}

/// The convergence of all figures of a case with a method, from its outcomes at several resolutions.
pub fn convergence(outcomes: &[&Outcome]) -> Vec<Convergence> {
    let mut found: Vec<(u32, &[Figure])> = (outcomes.iter())
        .filter_map(|outcome| {
            Some((
                outcome.job.resolution,
                &outcome.result.as_ref().ok()?.figures[..],
            ))
        })
        .collect();
    found.sort_by_key(|run| run.0);
    let (Some(&(_, finest)), Some(first)) = (found.last(), outcomes.first()) else {
        return Vec::new();
    };
    let of_figure = |figure: &Figure| {
        let values = found.iter().filter_map(|(resolution, figures)| {
            let same = figures
                .iter()
                .find(|other| other.quantity == figure.quantity);
            Some((*resolution, same?))
        });
        let errors: Vec<(u32, f64)> = match figure.source {
            Source::Exact => values
                .map(|(n, figure)| (n, figure.error().abs()))
                .collect(),
            Source::Experiment => values
                .filter(|(n, _)| Some(*n) != found.last().map(|run| run.0))
                .map(|(n, of)| (n, ((of.measured - figure.measured) / figure.scale).abs()))
                .collect(),
        };
        let order = match figure.source {
            Source::Exact => order(&errors),
            Source::Experiment => order_of_differences(&errors),
        };
        Convergence {
            case: first.job.case,
            method: first.job.method,
            quantity: figure.quantity.clone(),
            errors,
            order,
        }
    };
    finest.iter().map(of_figure).collect()
}

fn is_usable(&(_, error): &(u32, f64)) -> bool {
    error.is_finite() && error > 0.0
}

/// The order of errors from exact values; `None` with fewer than two.
fn order(errors: &[(u32, f64)]) -> Option<Order> {
    let usable = errors.iter().filter(|run| is_usable(run));
    let points: Vec<(f64, f64)> = usable
        .map(|&(n, error)| (-f64::from(n).ln(), error.ln()))
        .collect();
    if points.len() < 2 {
        return None;
    }
    let mut fit = crate::measure::LineFit::default();
    for &(x, y) in &points {
        fit.add(x, y, 1.0);
    }
    let slopes = points
        .windows(2)
        .map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0));
    let range = slopes.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], slope| {
        [low.min(slope), high.max(slope)]
    });
    Some(Order {
        fitted: fit.slope(),
        range,
    })
}

/// The order of a figure without an exact value, from three resolutions, each twice the one before: with `d1` and `d2`
/// the distances to the finest of the coarsest and the middle one, errors that go as `C dx^p` have `(d1 − d2)/d2 = 2^p`
/// if all have one sign. The range is that number alone.
fn order_of_differences(errors: &[(u32, f64)]) -> Option<Order> {
    let &[coarse, middle] = errors else {
        return None;
    };
    let ratio = f64::from(middle.0) / f64::from(coarse.0);
    let step = coarse.1 - middle.1;
    if !(is_usable(&middle) && step > 0.0 && step.is_finite()) {
        return None;
    }
    let fitted = (step / middle.1).ln() / ratio.ln();
    Some(Order {
        fitted,
        range: [fitted; 2],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_a_power_is_its_exponent() {
        for power in [0.5, 1.0, 2.3] {
            let error = |n: u32| 3.0 * (1.0 / f64::from(n)).powf(power);
            let errors = [10, 20, 40].map(|n| (n, error(n)));
            let found = order(&errors).expect("an order");
            for value in [found.fitted, found.range[0], found.range[1]] {
                assert!((value - power).abs() < 1e-9, "{power}: {found:?}");
            }
            let to_the_finest = [10, 20].map(|n| (n, error(n) - error(40)));
            let found = order_of_differences(&to_the_finest).expect("an order");
            assert!((found.fitted - power).abs() < 1e-9, "{power}: {found:?}");
        }
    }

    #[test]
    fn errors_without_an_order_have_none() {
        assert_eq!(order(&[(10, 0.0), (20, 0.1)]), None);
        assert_eq!(order(&[(10, f64::NAN), (20, 0.1)]), None);
        assert_eq!(order_of_differences(&[(10, 0.1), (20, 0.2)]), None);
        let uneven = order(&[(10, 0.4), (20, 0.1), (40, 0.1)]).expect("an order");
        assert!(uneven.range[0].abs() < 1e-9 && (uneven.range[1] - 2.0).abs() < 1e-9);
        assert!((uneven.fitted - 1.0).abs() < 1e-9);
    }
}
