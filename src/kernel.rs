//! The smoothing kernel: cubic spline with support radius h, in 2-D and 3-D.
//!
//! With q = r/h, `W = σ (6 (q³ − q²) + 1)` for q ≤ ½ and `σ 2 (1 − q)³` for ½ < q ≤ 1 (Monaghan 1992, scaled so that
//! the kernel ends at h). Loops use the same function without a branch: with a = max(0, 1 − q) and
//! b = max(0, 1 − 2q), `W = σ (2 a³ − b³)` and `∇W = 6 σ/h · (b² − a²)/r · x`.

use std::f32::consts::PI;

use glam::Vec3;

use crate::{scene::Dimension, simd::Simd};

/// Cubic spline of one support radius and dimension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CubicSpline {
    /// Support radius h [m]: the kernel is zero from here on.
    pub support_radius: f32,
    inverse_radius: f32,
    /// `σ` [m⁻³; m⁻² in 2-D]: [`shape`](Self::shape) times this is W.
    pub normalisation: f32,
    /// `6 σ/h`: [`slope`](Self::slope) times this and the distance vector is ∇W.
    pub slope_factor: f32,
}

/// Squares of distances are not taken below this [m²]: two particles in one place have no direction.
const TINY: f32 = 1e-30;

/// r for both functions, so that a pass which wants both takes one root.
#[inline(always)]
fn radius<S: Simd>(simd: S, distance_squared: S::F) -> S::F {
    // In this order what is not a number stays so, and is zero in the shape.
    simd.sqrt(simd.max(simd.splat(TINY), distance_squared))
}

impl CubicSpline {
    /// The kernel of support radius `h` [m].
    pub fn new(dimension: Dimension, h: f32) -> Self {
        let normalisation = match dimension {
            Dimension::Two => 40.0 / (7.0 * PI * h * h),
            Dimension::Three => 8.0 / (PI * h * h * h),
        };
        Self {
            support_radius: h,
            inverse_radius: 1.0 / h,
            normalisation,
            slope_factor: 6.0 * normalisation / h,
        }
    }

    /// W [m⁻³; m⁻² in 2-D] at distance `r` [m].
    pub fn value(&self, r: f32) -> f32 {
        let q = r * self.inverse_radius;
        let (a, b) = ((1.0 - q).max(0.0), (1.0 - 2.0 * q).max(0.0));
        self.normalisation * (2.0 * a * a * a - b * b * b)
    }

    /// ∇W [m⁻⁴; m⁻³ in 2-D] at `x` [m], the first particle's position minus the second's.
    pub fn gradient(&self, x: Vec3) -> Vec3 {
        let r = x.length_squared().max(TINY).sqrt();
        let q = r * self.inverse_radius;
        let (a, b) = ((1.0 - q).max(0.0), (1.0 - 2.0 * q).max(0.0));
        x * (self.slope_factor * (b - a) * (b + a) / r)
    }

    /// `W/σ` at eight squared distances [m²].
    #[inline(always)]
    pub fn shape<S: Simd>(&self, simd: S, distance_squared: S::F) -> S::F {
        let (a, b) = self.hats(simd, radius(simd, distance_squared));
        let a_cubed = simd.mul(simd.mul(a, a), a);
        let b_squared = simd.mul(b, b);
        simd.sub(simd.add(a_cubed, a_cubed), simd.mul(b_squared, b))
    }

    /// `(b² − a²)/r` [m⁻¹] at eight squared distances [m²].
    #[inline(always)]
    pub fn slope<S: Simd>(&self, simd: S, distance_squared: S::F) -> S::F {
        let r = radius(simd, distance_squared);
        let (a, b) = self.hats(simd, r);
        simd.div(simd.mul(simd.sub(b, a), simd.add(b, a)), r)
    }

    #[inline(always)]
    fn hats<S: Simd>(&self, simd: S, r: S::F) -> (S::F, S::F) {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let a = simd.mul_add(r, simd.splat(-self.inverse_radius), one);
        let b = simd.mul_add(r, simd.splat(-2.0 * self.inverse_radius), one);
        (simd.max(a, zero), simd.max(b, zero))
    }

    /// Every point of the lattice of `spacing` [m] within the support of the origin, the origin included.
    pub fn lattice(&self, dimension: Dimension, spacing: f32) -> impl Iterator<Item = Vec3> {
        let reach = (self.support_radius / spacing).ceil() as i32;
        let depth = match dimension {
            Dimension::Two => 0,
            Dimension::Three => reach,
        };
        let h = self.support_radius;
        (-depth..=depth)
            .flat_map(move |z| {
                (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| (x, y, z)))
            })
            .map(move |(x, y, z)| Vec3::new(x as f32, y as f32, z as f32) * spacing)
            .filter(move |x| x.length() <= h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{InstructionSet, Vectorised};

    const BOTH: [Dimension; 2] = [Dimension::Two, Dimension::Three];

    #[test]
    fn integral_is_one() {
        for dimension in BOTH {
            let kernel = CubicSpline::new(dimension, 0.7);
            let steps = 20_000;
            let dr = 0.7 / f64::from(steps);
            let integral: f64 = (0..steps)
                .map(|k| {
                    let r = (f64::from(k) + 0.5) * dr;
                    let shell = match dimension {
                        Dimension::Two => 2.0 * std::f64::consts::PI * r,
                        Dimension::Three => 4.0 * std::f64::consts::PI * r * r,
                    };
                    shell * f64::from(kernel.value(r as f32)) * dr
                })
                .sum();
            assert!((integral - 1.0).abs() < 1e-5, "{dimension:?}: {integral}");
        }
    }

    #[test]
    fn is_the_published_piecewise_polynomial_and_ends_at_the_support() {
        for dimension in BOTH {
            let kernel = CubicSpline::new(dimension, 2.0);
            for k in 0..=100 {
                let q = k as f32 / 100.0;
                let expected = if q <= 0.5 {
                    6.0 * (q * q * q - q * q) + 1.0
                } else {
                    2.0 * (1.0 - q).powi(3)
                };
                let value = kernel.value(2.0 * q) / kernel.normalisation;
                assert!(
                    (value - expected).abs() < 1e-6,
                    "q = {q}: {value} for {expected}"
                );
            }
            assert_eq!(kernel.value(2.0), 0.0);
            assert_eq!(kernel.value(9.0), 0.0);
            assert_eq!(kernel.gradient(Vec3::new(0.0, 2.0, 0.0)), Vec3::ZERO);
        }
    }

    #[test]
    fn gradient_agrees_with_finite_differences() {
        for dimension in BOTH {
            let kernel = CubicSpline::new(dimension, 1.0);
            let value = |x: Vec3| f64::from(kernel.value(x.length()));
            for k in 1..20 {
                let x = Vec3::new(0.6, 0.5, 0.3).normalize() * (k as f32 / 20.0);
                let step = 1e-3;
                let difference = Vec3::from_array([Vec3::X, Vec3::Y, Vec3::Z].map(|e| {
                    ((value(x + step * e) - value(x - step * e)) / f64::from(2.0 * step)) as f32
                }));
                let gradient = kernel.gradient(x);
                assert!(
                    (gradient - difference).length() < 2e-3 * kernel.slope_factor,
                    "{gradient} for {difference}"
                );
            }
            assert_eq!(kernel.gradient(Vec3::ZERO), Vec3::ZERO);
        }
    }

    struct Lanes(CubicSpline, [f32; 8]);

    impl Vectorised for Lanes {
        type Output = (f32, f32);

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> (f32, f32) {
            let table = self.1.map(|r| glam::Vec4::new(r * r, 0.0, 0.0, 0.0));
            let [r, ..] = simd.gather(&table, simd.rows(&[0, 1, 2, 3, 4, 5, 6, 7]));
            (
                simd.sum(self.0.shape(simd, r)),
                simd.sum(self.0.slope(simd, r)),
            )
        }
    }

    #[test]
    fn lanes_agree_with_the_scalar_kernel() {
        let kernel = CubicSpline::new(Dimension::Three, 0.5);
        let r = [0.0, 0.01, 0.1, 0.2, 0.25, 0.3, 0.5, 1e9];
        let values: f32 = r.iter().map(|&r| kernel.value(r)).sum();
        let slopes: f32 = r
            .iter()
            .skip(1)
            .map(|&r| kernel.gradient(Vec3::X * r).x / r)
            .sum();
        for set in InstructionSet::available() {
            let (shape, slope) = set.dispatch(Lanes(kernel, r));
            assert!(
                (shape * kernel.normalisation / values - 1.0).abs() < 1e-5,
                "{set:?}"
            );
            // At r = 0 the slope is finite and meets a zero vector.
            assert!(slope.is_finite(), "{set:?}");
            let (_, rest) = set.dispatch(Lanes(kernel, [1e9, 0.01, 0.1, 0.2, 0.25, 0.3, 0.5, 1e9]));
            assert!(
                (rest * kernel.slope_factor / slopes - 1.0).abs() < 1e-4,
                "{set:?}"
            );
        }
    }

    #[test]
    fn lattice_of_twice_the_spacing_has_the_known_number_of_points() {
        let count = |dimension| {
            CubicSpline::new(dimension, 2.0)
                .lattice(dimension, 1.0)
                .count()
        };
        assert_eq!((count(Dimension::Two), count(Dimension::Three)), (13, 33));
    }
}
