use super::*;
use crate::simd::{InstructionSet, Simd, Vectorised};

const BOTH: [Dimension; 2] = [Dimension::Two, Dimension::Three];

fn all() -> impl Iterator<Item = (KernelFunction, Dimension)> {
    let functions = KernelFunction::ALL.into_iter();
    functions.flat_map(|function| BOTH.map(|dimension| (function, dimension)))
}

#[test]
fn integral_is_one() {
    for (function, dimension) in all() {
        let kernel = Kernel::new(function, dimension, 0.7);
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
        assert!(
            (integral - 1.0).abs() < 1e-5,
            "{function:?} {dimension:?}: {integral}"
        );
    }
}

/// As published, over r/h with h the support radius and 1 at the origin.
fn published(function: KernelFunction, q: f64) -> f64 {
    match function {
        KernelFunction::CubicSpline if q <= 0.5 => 6.0 * (q.powi(3) - q.powi(2)) + 1.0,
        KernelFunction::CubicSpline => 2.0 * (1.0 - q).powi(3),
        KernelFunction::WendlandC2 => (1.0 - q).powi(4) * (1.0 + 4.0 * q),
        KernelFunction::WendlandC4 => (1.0 - q).powi(6) * (1.0 + 6.0 * q + 35.0 / 3.0 * q.powi(2)),
        KernelFunction::QuinticSpline => {
            let s = 3.0 * q;
            let mut sum = (3.0 - s).powi(5);
            if s < 2.0 {
                sum -= 6.0 * (2.0 - s).powi(5);
            }
            if s < 1.0 {
                sum += 15.0 * (1.0 - s).powi(5);
            }
            sum / 66.0
        }
    }
}

#[test]
fn is_the_published_function_and_ends_at_the_support() {
    for (function, dimension) in all() {
        let kernel = Kernel::new(function, dimension, 2.0);
        for k in 0..=100 {
            let q = f64::from(k) / 100.0;
            let value = f64::from(kernel.value(2.0 * q as f32) / kernel.normalisation);
            let expected = published(function, q);
            assert!(
                (value - expected).abs() < 1e-6,
                "{function:?}, q = {q}: {value} for {expected}"
            );
        }
        assert_eq!(kernel.value(2.0), 0.0);
        assert_eq!(kernel.value(9.0), 0.0);
        assert_eq!(kernel.gradient(Vec3::new(0.0, 2.0, 0.0)), Vec3::ZERO);
    }
}

/// The published factors, with h the support radius.
#[test]
fn is_as_high_as_published() {
    let pi = std::f64::consts::PI;
    for (function, plane, space) in [
        (KernelFunction::CubicSpline, 40.0 / (7.0 * pi), 8.0 / pi),
        (KernelFunction::WendlandC2, 7.0 / pi, 21.0 / (2.0 * pi)),
        (KernelFunction::WendlandC4, 9.0 / pi, 495.0 / (32.0 * pi)),
        (
            KernelFunction::QuinticSpline,
            66.0 * 7.0 / 478.0 * 9.0 / pi,
            66.0 / 120.0 * 27.0 / pi,
        ),
    ] {
        for (dimension, factor) in BOTH.into_iter().zip([plane, space]) {
            let found = f64::from(Kernel::new(function, dimension, 1.0).value(0.0));
            assert!(
                (found / factor - 1.0).abs() < 1e-6,
                "{function:?} {dimension:?}: {found} for {factor}"
            );
        }
    }
}

#[test]
fn gradient_and_derivatives_agree_with_finite_differences() {
    for (function, dimension) in all() {
        let kernel = Kernel::new(function, dimension, 1.0);
        let step = 1e-5;
        for k in 1..20 {
            // Off the knots, where the third derivative jumps.
            let q = (f64::from(k) + 0.3) / 20.0;
            let [above, here, below] = [q + step, q, q - step].map(|q| function.derivatives(q));
            for order in [1, 2] {
                let difference = (above[order - 1] - below[order - 1]) / (2.0 * step);
                assert!(
                    (difference - here[order]).abs() < 1e-6,
                    "{function:?}, derivative {order} at {q}: {} for {difference}",
                    here[order]
                );
            }
            let direction = Vec3::new(0.6, 0.5, 0.3).normalize();
            let expected = direction * (f64::from(kernel.normalisation) * here[1]) as f32;
            let gradient = kernel.gradient(direction * q as f32);
            assert!(
                (gradient - expected).length() < 1e-5 * kernel.normalisation,
                "{function:?}: {gradient} for {expected}"
            );
        }
        assert_eq!(kernel.gradient(Vec3::ZERO), Vec3::ZERO);
    }
}

/// The sum over a lattice comes nearer to the integral, 1, the wider the support.
#[test]
fn sums_over_a_lattice_approach_the_integral() {
    for (function, dimension) in all() {
        let error = |support: f32| {
            let kernel = Kernel::new(function, dimension, support);
            let lattice = kernel.lattice(dimension, 1.0);
            let sum: f64 = lattice.map(|x| f64::from(kernel.value(x.length()))).sum();
            (sum - 1.0).abs()
        };
        let (advised, wide) = (error(function.support(dimension)), error(6.0));
        assert!(
            advised < 0.05 && wide < 2e-3,
            "{function:?} {dimension:?}: {advised}, {wide}"
        );
    }
}

struct Lanes(Kernel, [f32; 8]);

impl Vectorised for Lanes {
    type Output = (f32, f32);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> (f32, f32) {
        let table = self.1.map(|r| glam::Vec4::new(r * r, 0.0, 0.0, 0.0));
        let [r, ..] = simd.gather(&table, simd.rows(&[0, 1, 2, 3, 4, 5, 6, 7]));
        (
            simd.sum(self.0.w(simd, r)),
            simd.sum(self.0.grad_factor(simd, r)),
        )
    }
}

#[test]
fn lanes_agree_with_the_scalar_kernel() {
    for (function, dimension) in all() {
        let kernel = Kernel::new(function, dimension, 0.5);
        let r = [0.0, 0.01, 0.1, 0.2, 0.25, 0.3, 0.5, 1e9];
        let values: f32 = r.iter().map(|&r| kernel.value(r)).sum();
        let slope_of = |r: f32| kernel.gradient(Vec3::X * r).x / r;
        let slopes: f32 = r.iter().skip(1).map(|&r| slope_of(r)).sum();
        for set in InstructionSet::available() {
            let (shape, slope) = set.dispatch(Lanes(kernel, r));
            assert!(
                (shape * kernel.normalisation / values - 1.0).abs() < 1e-5,
                "{function:?} {set:?}"
            );
            // At r = 0 the slope is finite and meets a zero vector.
            assert!(slope.is_finite(), "{function:?} {set:?}");
            let (_, rest) = set.dispatch(Lanes(kernel, [1e9, 0.01, 0.1, 0.2, 0.25, 0.3, 0.5, 1e9]));
            assert!(
                (rest * kernel.gradient_scale / slopes - 1.0).abs() < 1e-4,
                "{function:?} {set:?}"
            );
            // Absent neighbours, however far away, add nothing.
            for far in [1e9, 1e15, 1e18, f32::MAX] {
                assert_eq!(set.dispatch(Lanes(kernel, [far; 8])), (0.0, 0.0));
            }
            // One pair at a time, so that none hides another.
            for r in (1..50).map(|k| 0.01 * k as f32) {
                let mut lanes = [1e9; 8];
                lanes[0] = r;
                let (shape, slope) = set.dispatch(Lanes(kernel, lanes));
                let (value, gradient) = (kernel.value(r), slope_of(r));
                let [value_error, slope_error] = [
                    shape - value / kernel.normalisation,
                    (slope - gradient / kernel.gradient_scale) * kernel.support_radius,
                ];
                // Of the slope at the origin, where it is steepest.
                let steepest = function.derivatives(0.0)[2] as f32 * kernel.normalisation
                    / (kernel.gradient_scale * kernel.support_radius);
                assert!(
                    value_error.abs() < 2e-6 && (slope_error / steepest).abs() < 1e-5,
                    "{function:?} {set:?} at {r}: {value_error}, {slope_error}"
                );
            }
        }
    }
}

#[test]
fn lattice_of_twice_the_spacing_has_the_known_number_of_points() {
    let count = |dimension| {
        Kernel::new(KernelFunction::CubicSpline, dimension, 2.0)
            .lattice(dimension, 1.0)
            .count()
    };
    assert_eq!((count(Dimension::Two), count(Dimension::Three)), (13, 33));
}
