//! The exact pressure around the centre of the elliptic drop (Monaghan 1994).
//!
//! With `u = (−A x, A y)` in an ellipse of semi-axes a and b the pressure is `p0 (1 − x²/a² − y²/b²)`,
//! `p0 = ρ A² a² b²/(a² + b²)`, and `A' = A² (a² − b²)/(a² + b²)`, `a' = −A a`, `b' = A b`.

/// Region around the centre, by `x²/a² + y²/b²`.
const CENTRE: f64 = 0.1;

/// The drop with an initial radius of 1 m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CentrePressure {
    /// A \[1/s].
    rate: f64,
    /// a and b \[m].
    axes: [f64; 2],
}

impl CentrePressure {
    /// The initial state with a rate A \[1/s].
    pub(crate) fn new(rate: f64) -> Self {
        Self {
            rate,
            axes: [1.0; 2],
        }
    }

    /// p/ρ \[m²/s²] at a point near the centre; `None` elsewhere.
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> Option<f64> {
        let [a, b] = self.axes.map(|axis| axis * axis);
        let off = x * x / a + y * y / b;
        (off < CENTRE).then(|| self.rate.powi(2) * a * b / (a + b) * (1.0 - off))
    }

    /// A step by the midpoint rule, in substeps.
    pub(crate) fn advance(&mut self, dt: f64) {
        let parts = 20;
        let dt = dt / f64::from(parts);
        for _ in 0..parts {
            let middle = self.moved(self.changes(), 0.5 * dt);
            *self = self.moved(middle.changes(), dt);
        }
    }

    fn changes(&self) -> [f64; 3] {
        let (rate, [a, b]) = (self.rate, self.axes);
        let ratio = (a * a - b * b) / (a * a + b * b);
        [rate * rate * ratio, -rate * a, rate * b]
    }

    fn moved(&self, [rate, a, b]: [f64; 3], dt: f64) -> Self {
        Self {
            rate: self.rate + dt * rate,
            axes: [self.axes[0] + dt * a, self.axes[1] + dt * b],
        }
    }
}
