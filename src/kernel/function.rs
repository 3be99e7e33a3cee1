//! The functions of q = r/h that a scene chooses its kernel from. All are 1 at q = 0 and end at q = 1.
//!
//! | function | W/σ | σ h² (2-D) | σ h³ (3-D) | source |
//! | --- | --- | --- | --- | --- |
//! | cubic spline | `2 a³ − b³`, b = (1 − 2q)₊ | 40/(7π) | 8/π | Monaghan 1992 |
//! | Wendland C2 | `a⁴ (1 + 4q)` | 7/π | 21/(2π) | Wendland 1995 |
//! | Wendland C4 | `a⁶ (1 + 6q + 35/3 q²)` | 9/π | 495/(32π) | Wendland 1995 |
//! | quintic spline | `(81 a⁵ − 64 b⁵ + 5 c⁵)/22` | 2079/(239π) | 297/(20π) | Morris et al. 1997 |
//!
//! with a = (1 − q)₊, of the quintic b = (1 − 3/2 q)₊ and c = (1 − 3q)₊; the factors of Wendland's as in Dehnen & Aly
//! 2012, table 1. The quintic's knots are a third of the support apart.

use std::f32::consts::PI;

use crate::scene::{Dimension, KernelFunction};

/// Numerators and denominators of `π σ h^d`, in 2-D and in 3-D: exact numbers in single precision.
type Factors = [[f32; 2]; 2];

impl KernelFunction {
    /// σ \[m⁻³; m⁻² in 2-D] that makes the integral 1 at a support radius `h` \[m].
    pub(super) fn normalisation(self, dimension: Dimension, h: f32) -> f32 {
        let [plane, space]: Factors = match self {
            Self::CubicSpline => [[40.0, 7.0], [8.0, 1.0]],
            Self::WendlandC2 => [[7.0, 1.0], [21.0, 2.0]],
            Self::WendlandC4 => [[9.0, 1.0], [495.0, 32.0]],
            Self::QuinticSpline => [[2079.0, 239.0], [297.0, 20.0]],
        };
        match dimension {
            Dimension::Two => plane[0] / (plane[1] * PI * h * h),
            Dimension::Three => space[0] / (space[1] * PI * h * h * h),
        }
    }

    /// Factor of the derivative by q that [`Kernel::grad_factor`](super::Kernel::grad_factor) leaves out \[-].
    pub(super) fn gradient_scale(self) -> f32 {
        match self {
            Self::CubicSpline => 6.0,
            Self::WendlandC2 => 20.0,
            Self::WendlandC4 => 56.0 / 3.0,
            Self::QuinticSpline => 15.0 / 22.0,
        }
    }

    /// `W/σ` and its first two derivatives by q \[-].
    pub fn derivatives(self, q: f64) -> [f64; 3] {
        let hat = |knot: f64| (1.0 - knot * q).max(0.0);
        let a = hat(1.0);
        match self {
            Self::CubicSpline => {
                let b = hat(2.0);
                [
                    2.0 * a.powi(3) - b.powi(3),
                    6.0 * (b * b - a * a),
                    12.0 * (a - 2.0 * b),
                ]
            }
            Self::WendlandC2 => [
                a.powi(4) * (1.0 + 4.0 * q),
                -20.0 * q * a.powi(3),
                -20.0 * a * a * (1.0 - 4.0 * q),
            ],
            Self::WendlandC4 => [
                a.powi(6) * (1.0 + 6.0 * q + 35.0 / 3.0 * q * q),
                -56.0 / 3.0 * q * (1.0 + 5.0 * q) * a.powi(5),
                -56.0 / 3.0 * a.powi(4) * (1.0 + 4.0 * q - 35.0 * q * q),
            ],
            Self::QuinticSpline => {
                let (b, c) = (hat(1.5), hat(3.0));
                let sum = |power: i32, factors: [f64; 3]| {
                    let hats = [a, b, c].into_iter().zip(factors);
                    hats.map(|(hat, factor)| factor * hat.powi(power))
                        .sum::<f64>()
                        / 22.0
                };
                [
                    sum(5, [81.0, -64.0, 5.0]),
                    sum(4, [-405.0, 480.0, -75.0]),
                    sum(3, [1620.0, -2880.0, 900.0]),
                ]
            }
        }
    }
}
