//! A straight line through many points.

/// Weighted least-squares line `y = slope · x + intercept`, a point at a time; sums in f64.
///
/// Through the pressures \[Pa] over the heights \[m] of still water it gives both things that are known: the slope is
/// `−ρ0 g`, and the line's zero is the surface.
#[derive(Debug, Clone, Copy, Default)]
pub struct LineFit {
    weight: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl LineFit {
    /// Adds a point with a weight above zero.
    pub fn add(&mut self, x: f64, y: f64, weight: f64) {
        // Deviations from the running mean: no digits are lost far from the origin.
        self.weight += weight;
        let share = weight / self.weight;
        let (dx, dy) = (x - self.x, y - self.y);
        self.x += share * dx;
        self.y += share * dy;
        self.xx += weight * dx * (x - self.x);
        self.xy += weight * dx * (y - self.y);
    }

    /// dy/dx; not a number with fewer than two different x.
    pub fn slope(&self) -> f64 {
        self.xy / self.xx
    }

    /// The line's y at an x.
    pub fn at(&self, x: f64) -> f64 {
        self.y + self.slope() * (x - self.x)
    }

    /// The x where the line is zero.
    pub fn zero(&self) -> f64 {
        self.x - self.y / self.slope()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_a_line_and_weighs_its_points() {
        let mut fit = LineFit::default();
        for x in [1e6, 1e6 + 1.0, 1e6 + 5.0] {
            fit.add(x, 3.0 - 2.0 * (x - 1e6), x);
        }
        // A million from the origin ten digits are left.
        assert!((fit.slope() + 2.0).abs() < 1e-9);
        assert!((fit.at(1e6) - 3.0).abs() < 1e-9 && (fit.zero() - 1e6 - 1.5).abs() < 1e-9);
        let mut fit = LineFit::default();
        for (x, y, weight) in [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 4.0, 3.0)] {
            fit.add(x, y, weight);
        }
        assert!((fit.slope() - 3.0).abs() < 1e-12);
    }
}
