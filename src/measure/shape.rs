//! Where the fluid is: front, height, semi-axes.

use glam::{DVec3, Vec3};

/// Front \[m] of fluid that runs along a floor at y = 0 towards +x: the outer side, half a spacing from the centre, of
/// the foremost particle of the connected fluid. `None` without particles near the floor.
///
/// Counted is what is less than `4 spacing` above the floor; the fluid ends where the next particle is more than a
/// support radius of `2 spacing` ahead. Option 1 was the foremost particle of all: a drop thrown ahead is then the
/// front.
pub fn front(positions: impl IntoIterator<Item = Vec3>, spacing: f32) -> Option<f32> {
    let near_floor = |x: &Vec3| x.y < 4.0 * spacing;
    let mut along: Vec<f32> = positions
        .into_iter()
        .filter(near_floor)
        .map(|x| x.x)
        .collect();
    along.sort_by(f32::total_cmp);
    let gap = along.windows(2).position(|x| x[1] - x[0] > 2.0 * spacing);
    let last = gap.map_or(along.last(), |gap| along.get(gap));
    last.map(|x| x + 0.5 * spacing)
}

/// Height \[m] of the fluid over `from`–`to` \[m] along x: the upper side, half a spacing from the centre, of its
/// highest particle. `None` without particles there.
pub fn height(
    positions: impl IntoIterator<Item = Vec3>,
    [from, to]: [f32; 2],
    spacing: f32,
) -> Option<f32> {
    let above = positions.into_iter().filter(|x| x.x >= from && x.x <= to);
    above.map(|x| x.y + 0.5 * spacing).max_by(f32::total_cmp)
}

/// Semi-axes along x and y \[m] of a filled ellipse in the plane, from the second moments about its centre: `a² =
/// 4⟨x²⟩`.
///
/// Option 1 was the outermost particles: a single one that leaves the surface is then the axis. All particles have a
/// say in the moments.
pub fn semi_axes(positions: impl IntoIterator<Item = Vec3>) -> [f64; 2] {
    let (mut count, mut sum, mut squares) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for x in positions.into_iter().map(|x| x.as_dvec3()) {
        count += 1.0;
        sum += x;
        squares += x * x;
    }
    let variance = squares / count - (sum / count) * (sum / count);
    [variance.x, variance.y].map(|moment| 2.0 * moment.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor(count: u32) -> impl Iterator<Item = Vec3> {
        (0..count).map(|k| Vec3::new(0.05 + 0.1 * k as f32, 0.05, 0.0))
    }

    #[test]
    fn front_is_that_of_the_connected_fluid() {
        assert!(front([], 0.1).is_none());
        assert!((front(floor(10), 0.1).unwrap() - 1.0).abs() < 1e-6);
        let drops = [Vec3::new(1.3, 0.05, 0.0), Vec3::new(1.0, 2.0, 0.0)];
        assert!((front(floor(10).chain(drops), 0.1).unwrap() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn height_is_the_upper_side_of_the_highest_particle() {
        let top = Vec3::new(0.02, 0.55, 0.0);
        let positions = || floor(10).chain([top]);
        assert!((height(positions(), [0.0, 0.1], 0.1).unwrap() - 0.6).abs() < 1e-6);
        assert!((height(positions(), [0.1, 0.2], 0.1).unwrap() - 0.1).abs() < 1e-6);
        assert!(height(positions(), [2.0, 3.0], 0.1).is_none());
    }

    #[test]
    fn semi_axes_of_an_ellipse_anywhere() {
        let grid = |k: i32| (k as f32 + 0.5) * 0.02;
        let points = (-100..100)
            .flat_map(|i| (-100..100).map(move |j| Vec3::new(grid(i), grid(j), 0.0)))
            .filter(|x| (x.x / 1.5).powi(2) + (x.y / 0.5).powi(2) <= 1.0)
            .map(|x| x + Vec3::new(3.0, -2.0, 0.0));
        let [a, b] = semi_axes(points);
        assert!(
            (a / 1.5 - 1.0).abs() < 2e-3 && (b / 0.5 - 1.0).abs() < 2e-3,
            "{a} {b}"
        );
    }
}
