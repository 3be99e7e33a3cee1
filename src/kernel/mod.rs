//! The smoothing kernel, with support radius h, in 2-D and 3-D: one of four functions ([`function`]), for one particle
//! or for eight pairs at a time ([`lanes`]).

mod function;
mod lanes;
#[cfg(test)]
mod tests;

use glam::Vec3;

use crate::scene::{Dimension, KernelFunction, Scene};

/// The kernel of one function, support radius and dimension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    /// W/σ over r/h.
    pub function: KernelFunction,
    /// Support radius h \[m]: the kernel is zero from here on.
    pub support_radius: f32,
    inverse_radius: f32,
    /// `σ` \[m⁻³; m⁻² in 2-D]: [`w`](Self::w) times this is W.
    pub normalisation: f32,
    /// Scale of the gradient \[m⁻⁴; m⁻³ in 2-D]: ∇W is this times [`grad_factor`](Self::grad_factor) times the distance
    /// vector; `6 σ/h` for the cubic spline.
    pub gradient_scale: f32,
}

/// Squares of distances are not taken below this \[m²]: two particles in one place have no direction.
const TINY: f32 = 1e-30;

/// Spacings that a lattice reaches at most: scenes have supports of 4 spacings and less.
const MOST_REACH: i32 = 16;

impl Kernel {
    /// The kernel of support radius `h` \[m].
    pub fn new(function: KernelFunction, dimension: Dimension, h: f32) -> Self {
        let normalisation = function.normalisation(dimension, h);
        Self {
            function,
            support_radius: h,
            inverse_radius: 1.0 / h,
            normalisation,
            gradient_scale: function.gradient_scale() * normalisation / h,
        }
    }

    /// That of a scene.
    pub fn of(scene: &Scene) -> Self {
        Self::new(scene.kernel(), scene.dimension, scene.support_radius())
    }

    /// W \[m⁻³; m⁻² in 2-D] at distance `r` \[m].
    pub fn value(&self, r: f32) -> f32 {
        let q = r * self.inverse_radius;
        self.normalisation
            * match self.function {
                KernelFunction::CubicSpline => {
                    let (a, b) = ((1.0 - q).max(0.0), (1.0 - 2.0 * q).max(0.0));
                    2.0 * a * a * a - b * b * b
                }
                function => function.derivatives(f64::from(q))[0] as f32,
            }
    }

    /// ∇W \[m⁻⁴; m⁻³ in 2-D] at `x` \[m], the first particle's position minus the second's.
    pub fn gradient(&self, x: Vec3) -> Vec3 {
        let r = x.length_squared().max(TINY).sqrt();
        let q = r * self.inverse_radius;
        x * match self.function {
            KernelFunction::CubicSpline => {
                let (a, b) = ((1.0 - q).max(0.0), (1.0 - 2.0 * q).max(0.0));
                self.gradient_scale * (b - a) * (b + a) / r
            }
            function => {
                let derivative = function.derivatives(f64::from(q))[1] as f32;
                self.normalisation * self.inverse_radius * derivative / r
            }
        }
    }

    /// Every point of the lattice of `spacing` \[m] within the support of the origin, the origin included.
    pub fn lattice(&self, dimension: Dimension, spacing: f32) -> impl Iterator<Item = Vec3> {
        let reach = (self.support_radius / spacing).ceil() as i32;
        // A host may spoil the spacing in the middle of a step, which is refused at its end: it has to come.
        let reach = reach.clamp(0, MOST_REACH);
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
