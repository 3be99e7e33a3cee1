//! How fast a quantity goes back and forth.

/// Shortest time \[s] between two reversals of a quantity over time, given as points with ascending times. Movements of
/// less than `least` from one reversal to the next are taken for noise. None without two reversals.
pub fn shortest_half_period(
    points: impl IntoIterator<Item = (f64, f64)>,
    least: f64,
) -> Option<f64> {
    let mut points = points.into_iter();
    let first = points.next()?;
    let (mut low, mut high) = (first, first);
    // The way that the quantity goes, once it has gone `least`, and the last reversal.
    let mut rises = None;
    let mut last: Option<f64> = None;
    let mut shortest: Option<f64> = None;
    for point in points {
        // Of equal values the latest: a quantity may rest before it turns.
        if point.1 <= low.1 {
            low = point;
        }
        if point.1 >= high.1 {
            high = point;
        }
        let turn = match rises {
            None => {
                rises = match (point.1 - low.1 >= least, high.1 - point.1 >= least) {
                    (true, _) => Some(true),
                    (_, true) => Some(false),
                    _ => None,
                };
                None
            }
            Some(true) if high.1 - point.1 >= least => Some(high.0),
            Some(false) if point.1 - low.1 >= least => Some(low.0),
            Some(_) => None,
        };
        if let Some(turn) = turn {
            if let Some(before) = last {
                let half = turn - before;
                shortest = Some(shortest.map_or(half, |other| other.min(half)));
            }
            last = Some(turn);
            rises = rises.map(|rises| !rises);
            (low, high) = (point, point);
        } else if rises == Some(true) && high.0 == point.0 {
            low = point;
        } else if rises == Some(false) && low.0 == point.0 {
            high = point;
        }
    }
    shortest
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn sine(period: f64, amplitude: f64, dt: f64) -> Vec<(f64, f64)> {
        let count = (3.0 * period / dt) as u32;
        let at = |k: u32| f64::from(k) * dt;
        (0..=count)
            .map(|k| (at(k), amplitude * (TAU * at(k) / period + 0.3).sin()))
            .collect()
    }

    #[test]
    fn half_a_period_of_a_sine_is_found_at_any_rate_of_its_rows() {
        for period in [1e-3, 1.0, 40.0] {
            for rows in [4.1, 10.0, 333.0] {
                let half = shortest_half_period(sine(period, 2.0, period / rows), 0.1);
                let error = (half.expect("reversals") - 0.5 * period).abs();
                assert!(error <= 1.01 * period / rows, "{period}, {rows}: {error}");
            }
        }
    }

    #[test]
    fn noise_ramps_and_one_turn_are_no_oscillation() {
        assert_eq!(shortest_half_period(sine(1.0, 0.04, 0.01), 0.1), None);
        assert_eq!(shortest_half_period([], 0.0), None);
        assert_eq!(shortest_half_period([(0.0, 1.0)], 0.0), None);
        let ramp = (0..100).map(|k| (f64::from(k), 2.0 * f64::from(k)));
        assert_eq!(shortest_half_period(ramp, 0.1), None);
        let hat = [(0.0, 0.0), (1.0, 5.0), (2.0, 0.0)];
        assert_eq!(shortest_half_period(hat, 0.1), None);
        // A slow sine with noise upon it is a slow sine.
        let noisy = sine(1.0, 2.0, 0.001).into_iter().enumerate();
        let noisy = noisy.map(|(k, (t, x))| (t, x + [0.01, -0.01][k % 2]));
        let half = shortest_half_period(noisy, 0.1).expect("reversals");
        assert!((half - 0.5).abs() < 0.06, "{half}");
        // Rest, one jerk there and back, rest.
        let jerks = [
            (0.0, 0.0),
            (1.0, 0.0),
            (1.01, 1.0),
            (1.02, 0.0),
            (1.03, 1.0),
            (2.0, 1.0),
        ];
        let half = shortest_half_period(jerks, 0.1).expect("reversals");
        assert!((half - 0.01).abs() < 1e-9, "{half}");
    }
}
