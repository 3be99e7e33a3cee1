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
pub struct Stabilisation(pub f32);

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

impl Stabilised<'_> {
    /// The velocity v of a row and û, from u.
    #[inline(always)]
    pub(super) fn own(&self, row: usize, u: Vec4, rest_density: f32) -> (Vec4, Vec4) {
        let change = (self.factor * self.accelerations[row]).extend(0.0);
        let of_terms = Vec4::W * (2.0 * rest_density * self.factor);
        (u + change, u + 2.0 * change + of_terms)
    }
}
