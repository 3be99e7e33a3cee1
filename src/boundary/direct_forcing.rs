//! Direct forcing (Becker, Tessendorf & Teschner 2009) with frozen boundary particles as in Ihmsen et al. 2010: the
//! method of the paper's glass and river scenes. [`DirectForcing`] has the equations.
//!
//! Frozen particles contribute to density and pressure like fluid particles that do not move. They lie half a spacing
//! behind the face with the volume m/ρ0, which at the default support gives a lattice at the wall exactly its rest
//! density. Where samples are denser than a lattice, at edges and in thin walls, the volume is proportionally smaller.
//! The pressure that pushes back is the fluid particle's own, as in
//! [`pressure_force`](crate::pressure::pressure_force).
//!
//! Deviations. Only boundary particles in front of which a particle was at the start of the step act on it: those of
//! the far side of a thin wall would pull it through. A corrected particle loses its velocity into the wall and keeps
//! that away from it; with the tangential part alone, as published, fluid sticks to ceilings.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::{
    index::BoundarySamples,
    pairs::Pairs,
    scene,
    state::{Material, PredictedPositions, Velocities},
};

/// Parameters in SI units.
///
/// A particle i nearer than r0 to boundary particles b is moved back along their mean normal, `x_i += (Σ_b w_ib (r0 −
/// |x_i − x_b|) / Σ_b w_ib) n_i/|n_i|`, with `w_ib = max(0, (r0 − |x_i − x_b|)/r0)` and `n_i = Σ_b w_ib n_b`. This is
/// applied to the predicted positions in every iteration of PCISPH, so that pressure is solved for positions that
/// particles can take, and with every method to the positions after integration.
///
/// It does not replace [`contact`](super::contact), which follows it: the correction is an average over samples and
/// vanishes at a distance r0 behind them, so that water 10 spacings deep pressed particles through it.
#[derive(Resource, Debug, Clone, Copy)]
pub struct DirectForcing {
    /// r0 \[m].
    rest_distance: f32,
    slip: f32,
    period: scene::Period,
}

impl DirectForcing {
    /// From the scene's, for its spacing.
    pub fn new(parameters: scene::DirectForcing, material: &Material) -> Self {
        Self {
            rest_distance: parameters.rest_distance * material.spacing,
            slip: parameters.slip,
            period: material.period,
        }
    }

    /// Distance by which a particle at `x` that came from `start` is moved back \[m], the unit normal along which it
    /// moves, and the velocity of the wall there \[m/s]; `None` if it is not moved.
    fn correction(
        &self,
        boundary: &BoundarySamples,
        samples: &[u32],
        (start, x): (Vec3, Vec3),
    ) -> Option<(f32, Vec3, Vec3)> {
        let (mut weights, mut way) = (0.0, 0.0);
        let (mut normals, mut velocities) = (Vec3::ZERO, Vec3::ZERO);
        for &sample in samples {
            // A stale list may contain samples that no longer exist.
            let Some(&normal) = boundary.normals.get(sample as usize) else {
                continue;
            };
            let place = boundary.packed[sample as usize].truncate();
            let ahead = boundary.place_ahead(sample as usize);
            let missing = self.rest_distance - self.period.nearest(x - ahead).length();
            if missing > 0.0 && self.period.nearest(start - place).dot(normal) >= 0.0 {
                let weight = missing / self.rest_distance;
                weights += weight;
                way += weight * missing;
                normals += weight * normal;
                velocities += weight * boundary.velocity(sample as usize);
            }
        }
        let normal = normals.try_normalize()?;
        Some((way / weights, normal, velocities / weights))
    }
}

/// Corrects predicted positions (in every pressure iteration of PCISPH).
pub fn correct_prediction(
    mut predicted: ResMut<PredictedPositions>,
    boundary: Res<BoundarySamples>,
    direct: Res<DirectForcing>,
    pairs: Pairs,
) {
    let rows = pairs.positions().rows();
    let start = &pairs.positions().0;
    // Velocities are predicted again in every iteration, so they need no correction.
    let columns = (&mut predicted.0[..rows], &mut vec![(); rows][..]);
    pairs.update_near_boundary(columns, |row, samples, x: &mut Vec4, ()| {
        let places = (start[row].truncate(), x.truncate());
        if let Some((way, normal, _)) = direct.correction(&boundary, samples, places) {
            *x += (way * normal).extend(0.0);
        }
    });
}

/// Corrects positions and turns velocities along the wall (phase `Integrate`).
pub fn correct_motion(
    mut predicted: ResMut<PredictedPositions>,
    mut velocities: ResMut<Velocities>,
    boundary: Res<BoundarySamples>,
    direct: Res<DirectForcing>,
    pairs: Pairs,
) {
    let rows = pairs.positions().rows();
    let start = &pairs.positions().0;
    let columns = (&mut predicted.0[..rows], &mut velocities.0[..rows]);
    pairs.update_near_boundary(columns, |row, samples, x: &mut Vec4, v: &mut Vec4| {
        let places = (start[row].truncate(), x.truncate());
        if let Some((way, normal, of_wall)) = direct.correction(&boundary, samples, places) {
            *x += (way * normal).extend(0.0);
            let seen = v.truncate() - of_wall;
            let across = seen.dot(normal);
            let along = seen - across * normal;
            *v = (of_wall + direct.slip * along + across.max(0.0) * normal).extend(v.w);
        }
    });
}
