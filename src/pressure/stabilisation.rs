//! Stabilisation of the pressure after Rhie & Chow (1983), for the methods that solve for it.
//!
//! The change of density by pressure, `Dρ_i/Dt(dt a)`, is a Laplacian of twice the kernel's width: a pressure that
//! alternates from particle to particle has hardly any force, so any error of the density makes one of any size. A
//! share κ of the compact Laplacian takes its place, as the difference of the two gradients between a pair:
//!
//! `Dρ_i/Dt += κ dt Σ_j m (W′_ij/r_ij) (2 ρ0 (t_i − t_j) + (a_i + a_j)·x_ij)`, t = p/ρ², a of pressure alone.
//!
//! It vanishes where pressure is linear between neighbours and their accelerations are its gradient, at walls and at a
//! free surface too: water at rest keeps `p_i − p_j = ρ g·x_ij`. `docs/decisions/stabilisation.md` has the figures.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::state::PressureAccelerations;

/// The share κ \[-], from 0, where the system is that of the papers, to [`MOST`](Self::MOST).
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct Stabilisation(pub(crate) f32);

impl Stabilisation {
    /// None.
    pub const NONE: Self = Self(0.0);
    /// The largest share that a scene may request.
    pub const MOST: f32 = 0.5;

    /// What a sum of rates needs of it, if there is any. `dt` is the time for which the accelerations act \[s], 1 for
    /// those that are changes of velocity.
    pub(super) fn of(
        self,
        accelerations: &PressureAccelerations,
        dt: f32,
    ) -> Option<Stabilised<'_>> {
        (self.0 > 0.0).then_some(Stabilised {
            accelerations: &accelerations.0,
            factor: self.0 * dt,
        })
    }
}

/// Stabilisation in a sum over pairs.
///
/// The sum is `(û_i − u_j)·x_ij` with `u = v − κ dt a` in place of the velocity v and `û = v + κ dt a`, which takes no
/// more of a pair than the sum of v does. The difference of the terms is the product of the fourth components: the
/// terms lie beside the positions, and û carries their factor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stabilised<'a> {
    /// Of pressure \[m/s²].
    accelerations: &'a [Vec3],
    /// κ dt.
    factor: f32,
}

impl<'a> Stabilised<'a> {
    /// The sum with a time \[s] in place of κ dt.
    pub(super) fn over(factor: f32, accelerations: &'a PressureAccelerations) -> Self {
        let accelerations = &accelerations.0;
        Self {
            accelerations,
            factor,
        }
    }
}

impl Stabilised<'_> {
    /// The velocity v of a row and û, from u.
    #[inline(always)]
    pub(super) fn own(&self, row: usize, u: Vec4, rest_density: f32) -> (Vec4, Vec4) {
        let change = (self.factor * self.accelerations[row]).extend(0.0);
        let of_terms = Vec4::W * (2.0 * rest_density * self.factor);
        (u + change, u + 2.0 * change + of_terms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number in −1 to 1 that is another for every `k`.
    fn some(k: u32) -> f32 {
        (12.9898 * k as f32).sin()
    }

    fn vector(k: u32) -> Vec3 {
        Vec3::new(some(3 * k), some(3 * k + 1), some(3 * k + 2))
    }

    /// What the product of a pair adds up to.
    fn of_pair(own: Vec4, [x_i, x_j]: [Vec4; 2], u_j: Vec4) -> f32 {
        (own - u_j).dot(x_i - x_j)
    }

    #[test]
    fn the_product_of_a_pair_is_rate_and_stabilisation() {
        let (share, dt, rest_density) = (0.3, 0.5, 2.0);
        for k in 0..50 {
            let [a_i, a_j, v_i, v_j] = [0, 1, 2, 3].map(|n| vector(7 * k + n));
            let [t_i, t_j] = [some(k + 500), some(k + 600)];
            let x = [vector(k + 900).extend(t_i), vector(k + 950).extend(t_j)];
            let accelerations = PressureAccelerations(vec![a_i, a_j]);
            let stabilised = Stabilisation(share).of(&accelerations, dt).expect("some");
            let u = |v: Vec3, a: Vec3| (v - share * dt * a).extend(0.0);
            let (v, own) = stabilised.own(0, u(v_i, a_i), rest_density);
            assert!((v.truncate() - v_i).length() < 1e-6 && v.w == 0.0);
            let x_ij = (x[0] - x[1]).truncate();
            let expected = (v_i - v_j).dot(x_ij)
                + share * dt * (2.0 * rest_density * (t_i - t_j) + (a_i + a_j).dot(x_ij));
            assert!((of_pair(own, x, u(v_j, a_j)) - expected).abs() < 1e-5);
        }
        assert!(
            Stabilisation::NONE
                .of(&PressureAccelerations(Vec::new()), dt)
                .is_none()
        );
    }

    #[test]
    fn a_linear_pressure_is_left_alone() {
        let (share, dt, rest_density) = (0.5, 1e-3, 1000.0);
        let gradient = Vec3::new(300.0, -9810.0, 20.0);
        let accelerations = PressureAccelerations(vec![-gradient / rest_density; 2]);
        let stabilised = Stabilisation(share).of(&accelerations, dt).expect("some");
        let u = (-share * dt * accelerations.0[0]).extend(0.0);
        let (_, own) = stabilised.own(0, u, rest_density);
        for k in 0..50 {
            let at = |k: u32| {
                let x = 0.01 * vector(k);
                x.extend(gradient.dot(x) / (rest_density * rest_density))
            };
            // Of terms of 1e-4.
            assert!(of_pair(own, [at(k), at(k + 77)], u).abs() < 1e-10);
        }
    }
}
