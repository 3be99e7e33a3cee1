//! Alternating pressure: the residual of each particle's pressure from a plane fitted to its neighbours.

use std::collections::HashMap;

use glam::{DMat4, DVec4, IVec3, Vec3};

use crate::support::Particle;

/// Sums over frames of deep fluid.
#[derive(Debug, Default)]
pub(crate) struct Residual {
    /// Number of frames; per frame the ratio to the mean pressure, and the correlation at one spacing.
    frames: f64,
    share: f64,
    correlation: f64,
}

/// Number of particles within three spacings above which a particle is in deep fluid; a lattice has 28 and 122.
fn deep_from(volume: bool) -> usize {
    if volume { 105 } else { 24 }
}

impl Residual {
    /// Residual over the mean pressure, and correlation between particles a spacing apart \[-].
    pub(crate) fn figures(&self) -> [f64; 2] {
        [self.share, self.correlation].map(|sum| sum / self.frames)
    }

    /// Adds the pressures of a step, in 3-D if `volume`. Frames with fewer than 50 particles in deep fluid are ignored.
    pub(crate) fn add(&mut self, particles: &[Particle], spacing: f32, volume: bool) {
        let reach = 3.0 * spacing;
        let cell = |x: Vec3| (x / reach).floor().as_ivec3();
        let mut cells: HashMap<IVec3, Vec<usize>> = HashMap::new();
        for (i, particle) in particles.iter().enumerate() {
            cells.entry(cell(particle.position)).or_default().push(i);
        }
        let near =
            |i: usize| {
                let (own, at) = (particles[i].position, cell(particles[i].position));
                let deep = i32::from(volume);
                let mut near = Vec::new();
                for z in -deep..=deep {
                    for y in -1..=1 {
                        for x in -1..=1 {
                            let found = cells.get(&(at + IVec3::new(x, y, z)));
                            near.extend(found.into_iter().flatten().filter(|&&j| {
                                j != i && particles[j].position.distance(own) < reach
                            }));
                        }
                    }
                }
                near
            };
        let neighbours: Vec<Vec<usize>> = (0..particles.len()).map(near).collect();
        let residuals: Vec<Option<f64>> = (neighbours.iter().enumerate())
            .map(|(i, near)| {
                (near.len() >= deep_from(volume)).then(|| beside_plane(particles, i, near, volume))
            })
            .collect();
        let deep: Vec<f64> = residuals.iter().flatten().copied().collect();
        if deep.len() < 50 {
            return;
        }
        let count = deep.len() as f64;
        let mean = deep.iter().sum::<f64>() / count;
        let variance = deep.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / count;
        let pressure = (particles.iter().zip(&residuals))
            .filter_map(|(particle, residual)| residual.map(|_| f64::from(particle.pressure)))
            .sum::<f64>()
            / count;
        let (mut products, mut pairs) = (0.0, 0.0);
        for (i, near) in neighbours.iter().enumerate() {
            for &j in near {
                let distance = particles[i].position.distance(particles[j].position) / spacing;
                if let ([Some(a), Some(b)], true) =
                    ([residuals[i], residuals[j]], (distance - 1.0).abs() < 0.15)
                {
                    products += a * b;
                    pairs += 1.0;
                }
            }
        }
        self.frames += 1.0;
        self.share += variance.sqrt() / pressure;
        self.correlation += products / pairs / variance;
    }
}

/// Pressure of a particle minus that of the plane through its neighbours \[Pa].
fn beside_plane(particles: &[Particle], i: usize, near: &[usize], volume: bool) -> f64 {
    let own = particles[i];
    let (mut matrix, mut right) = (DMat4::ZERO, DVec4::ZERO);
    for &j in near {
        let x = (particles[j].position - own.position).as_dvec3();
        let row = DVec4::new(1.0, x.x, x.y, x.z);
        matrix += DMat4::from_cols(row * row.x, row * row.y, row * row.z, row * row.w);
        right += row * f64::from(particles[j].pressure);
    }
    if !volume {
        matrix.w_axis.w = 1.0;
    }
    f64::from(own.pressure) - (matrix.inverse() * right).x
}
