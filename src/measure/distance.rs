//! How far a curve is from a known one.

/// Root mean square of the difference of a curve from a known one, at the times of that which the curve covers \[unit
/// of the values]; NaN where there is nothing to compare, and for a curve that ends before 95 % of the known one.
pub fn distance(found: &[(f64, f64)], known: &[(f64, f64)]) -> f64 {
    let (Some(first), Some(last), Some(end)) = (found.first(), found.last(), known.last()) else {
        return f64::NAN;
    };
    if last.0 < 0.95 * end.0 {
        return f64::NAN;
    }
    let within = known
        .iter()
        .filter(|point| (first.0..=last.0).contains(&point.0));
    let (mut squares, mut count) = (0.0, 0.0);
    for &(time, value) in within {
        squares += (between(found, time) - value).powi(2);
        count += 1.0;
    }
    f64::sqrt(squares / count)
}

/// Greatest less least value of a curve; 0 without points.
pub fn range(curve: &[(f64, f64)]) -> f64 {
    let values = curve.iter().map(|point| point.1);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    (high - low).max(0.0)
}

/// Linear interpolation at a time that the curve covers.
fn between(curve: &[(f64, f64)], time: f64) -> f64 {
    let after = curve.partition_point(|point| point.0 < time);
    match (after.checked_sub(1).map(|k| curve[k]), curve.get(after)) {
        (Some((t0, y0)), Some(&(t1, y1))) if t1 > t0 => y0 + (y1 - y0) * (time - t0) / (t1 - t0),
        (_, Some(&(_, y1))) => y1,
        (Some((_, y0)), None) => y0,
        (None, None) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_is_that_of_the_values_at_the_known_times() {
        let known: Vec<(f64, f64)> = (0..=10)
            .map(|k| (f64::from(k), 5.0 + f64::from(k)))
            .collect();
        let off: Vec<(f64, f64)> = known.iter().map(|&(t, y)| (t, y + 0.5)).collect();
        assert!((distance(&off, &known) - 0.5).abs() < 1e-12);
        assert_eq!(range(&known), 10.0);
        // Other times of the readings do not matter.
        let sparse = [(0.0, 5.0), (10.0, 15.0)];
        assert!(distance(&sparse, &known).abs() < 1e-12);
        assert!(distance(&off[..5], &known).is_nan());
        assert!(distance(&[], &known).is_nan() && distance(&known, &[]).is_nan());
        assert_eq!(range(&[]), 0.0);
    }
}
