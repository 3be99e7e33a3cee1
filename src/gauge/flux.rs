//! Volume flow through a parallelogram, or in 2-D a segment.
//!
//! `Q = Σ_j V v_j·n w(z_j)` over the particles beside it, with z the distance from its plane and w the one-dimensional
//! cubic spline, whose integral is 1. So a particle that passes contributes its volume V = m/ρ0 in total, whatever its
//! path. A lattice in uniform motion gives a constant flow, because the splines of a row of spacings add up to 1 at the
//! default support.

use glam::{DVec3, Vec3};

use super::moment::{Moment, Probe};

/// A parallelogram.
pub(super) struct Flux {
    pub(super) corner: Vec3,
    pub(super) along: Vec3,
    /// Along z in 2-D, of any length.
    pub(super) across: Vec3,
    /// Whether `across` is unbounded.
    pub(super) flat: bool,
}

impl Probe for Flux {
    fn read(&self, moment: &Moment, rows: &mut Vec<u32>, values: &mut Vec<Option<f64>>) {
        let material = &moment.state.material;
        let h = f64::from(material.kernel.support_radius);
        let volume = f64::from(material.particle_mass) / f64::from(material.rest_density);
        let (along, across) = (self.along.as_dvec3(), self.across.as_dvec3());
        let area = along.cross(across);
        let normal = area.normalize();
        let side = if self.flat { Vec3::ZERO } else { self.across };
        let middle = self.corner + 0.5 * (self.along + side);
        let corners = [Vec3::ZERO, self.along, side, self.along + side].map(|x| self.corner + x);
        let (low, high) = corners
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), x| {
                (low.min(*x), high.max(*x))
            });
        let reach = moment.reach(material.kernel.support_radius);
        moment.fluid().rows_in(low - reach, high + reach, rows);
        let mut flux = 0.0;
        for &row in &*rows {
            let x = moment.state.places.0[row as usize].truncate();
            let x = (material.period.nearest(x - middle) + middle - self.corner).as_dvec3();
            // Coordinates along the parallelogram's own axes, 0 to 1 inside it.
            let part = |from: DVec3, to: DVec3| from.cross(to).dot(area) / area.length_squared();
            let (a, b) = (part(x, across), part(along, x));
            let is_beside = (0.0..1.0).contains(&a) && (self.flat || (0.0..1.0).contains(&b));
            if is_beside {
                let v = moment.state.velocities.0[row as usize]
                    .truncate()
                    .as_dvec3();
                flux += volume * v.dot(normal) * spline(x.dot(normal).abs() / h) / h;
            }
        }
        values.push(Some(flux));
    }
}

/// Cubic spline of one dimension at q = |z|/h, for h = 1.
fn spline(q: f64) -> f64 {
    let (a, b) = ((1.0 - q).max(0.0), (1.0 - 2.0 * q).max(0.0));
    4.0 / 3.0 * (2.0 * a * a * a - b * b * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spline_passes_one_particle_as_one() {
        let sum: f64 = (-1000..1000)
            .map(|k| spline((f64::from(k) + 0.5).abs() / 1000.0) / 1000.0)
            .sum();
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        // A row of particles at half the support: the result is the same wherever the surface lies between them.
        for shift in [0.0, 0.1, 0.25, 0.4] {
            let sum: f64 = (-4..=4)
                .map(|k| 0.5 * spline((0.5 * f64::from(k) + shift).abs()))
                .sum();
            assert!((sum - 1.0).abs() < 1e-12, "{shift}: {sum}");
        }
    }
}
