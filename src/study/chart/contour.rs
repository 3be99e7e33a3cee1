//! Lines of equal value on a grid whose nodes may lack one.

/// A piece of a line.
pub(super) type Piece = [(f64, f64); 2];

/// Pieces of the line at `level` of values on a grid, by linear interpolation in the triangles of its cells. `value`
/// gives the value at a node; triangles without all three are left out.
pub(super) fn pieces(
    xs: &[f64],
    ys: &[f64],
    value: &dyn Fn(usize, usize) -> Option<f64>,
    level: f64,
) -> Vec<Piece> {
    let mut found = Vec::new();
    for i in 1..xs.len() {
        for j in 1..ys.len() {
            let corner = [(i - 1, j - 1), (i, j - 1), (i, j), (i - 1, j)];
            for triangle in [[0, 1, 2], [0, 2, 3]] {
                let nodes = triangle.map(|k| corner[k]);
                let values = nodes.map(|(i, j)| value(i, j));
                let [Some(a), Some(b), Some(c)] = values else {
                    continue;
                };
                let places = nodes.map(|(i, j)| (xs[i], ys[j]));
                found.extend(in_triangle(places, [a, b, c], level));
            }
        }
    }
    found
}

fn in_triangle(places: [(f64, f64); 3], values: [f64; 3], level: f64) -> Option<Piece> {
    let crossing = |k: usize, l: usize| {
        let (a, b) = (values[k] - level, values[l] - level);
        // A value at the level counts as above it, so that a line through a node is drawn once.
        if (a < 0.0) == (b < 0.0) {
            return None;
        }
        let part = a / (a - b);
        let mix = |from: f64, to: f64| from + part * (to - from);
        let (p, q) = (places[k], places[l]);
        Some((mix(p.0, q.0), mix(p.1, q.1)))
    };
    let found: Vec<(f64, f64)> = [(0, 1), (1, 2), (2, 0)]
        .into_iter()
        .filter_map(|(k, l)| crossing(k, l))
        .collect();
    found.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_a_plane_is_straight_and_stops_at_gaps() {
        let (xs, ys) = ([0.0, 1.0, 3.0], [0.0, 2.0, 3.0]);
        let plane = |i: usize, j: usize| Some(xs[i] + 2.0 * ys[j]);
        let found = pieces(&xs, &ys, &plane, 4.0);
        let length: f64 = found
            .iter()
            .map(|[p, q]| ((p.0 - q.0).powi(2) + (p.1 - q.1).powi(2)).sqrt())
            .sum();
        for (x, y) in found.iter().flatten() {
            assert!((x + 2.0 * y - 4.0).abs() < 1e-12, "{x} {y}");
        }
        // From (0, 2) to (3, 0.5).
        assert!((length - (9.0_f64 + 2.25).sqrt()).abs() < 1e-12, "{length}");
        let gap = |i: usize, j: usize| if i == 2 { None } else { plane(i, j) };
        assert!(
            pieces(&xs, &ys, &gap, 4.0)
                .iter()
                .flatten()
                .all(|at| at.0 <= 1.0)
        );
        assert!(pieces(&xs, &ys, &plane, 100.0).is_empty());
    }
}
