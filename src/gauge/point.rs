//! Pressure and velocity at a point: a linear function is fitted to the particles around it, weighted by a cubic spline
//! (moving least squares: Lancaster & Salkauskas 1981, *Math. Comput.* 37, 141).
//!
//! It is exact for a linear field, also beside walls and surfaces, where all particles are on one side. In spray and
//! films, where particles are too few or too flat for a slope, and in gaps between particles it is the mean
//! `Σ_j f_j W(x − x_j) / Σ_j W(x − x_j)` (Shepard 1968); a pressure then has the slope of fluid at rest, `ρ0 g`. Points
//! off the fluid have no value.

use glam::{DMat3, DVec3, Vec3};
use smallvec::SmallVec;

use super::{
    moment::{Moment, Probe},
    near::Crowd,
};
use crate::{kernel::Kernel, scene::Dimension};

/// The particles around a point.
#[derive(Clone, Copy)]
pub(super) struct Around {
    pub(super) at: Vec3,
    /// Unit vector to the side that counts; both sides if absent.
    pub(super) side: Option<Vec3>,
    pub(super) kernel: Kernel,
}

/// Distance behind the face of a wall up to which particles count \[spacings]: fluid may be a quarter behind it.
const BEHIND: f32 = 0.5;

impl Around {
    fn pressure(&self, moment: &Moment, rows: &mut Vec<u32>, values: &mut Vec<Option<f64>>) {
        let pressures = &moment.state.pressures.0;
        let value = |row: usize| DVec3::splat(pressures[row].into());
        let material = &moment.state.material;
        let clock = &moment.state.clock;
        let part = material.part_of_gravity(clock.time, 0.0);
        let gravity = f64::from(part) * material.gravity.as_dvec3();
        let up = -gravity.normalize_or_zero();
        let (speak, found) = self.fitted(moment.crowd(), up, rows, value);
        let weight = f64::from(material.spacing * material.rest_density) * gravity;
        let mean = found.map(|found| found.value.x + found.below(weight));
        // A dry wall has no pressure; inside the fluid there is no value without fluid.
        let dry = self.side.map(|_| 0.0);
        values.extend([mean.or(dry), Some(speak.into())]);
    }

    /// Number of particles that contribute, and the value at the point of a linear function fitted to theirs. None at a
    /// point that is off the fluid.
    pub(super) fn fit(
        &self,
        crowd: Crowd,
        rows: &mut Vec<u32>,
        value: impl Fn(usize) -> DVec3,
    ) -> (u32, Option<DVec3>) {
        let (speak, found) = self.fitted(crowd, DVec3::ZERO, rows, value);
        (speak, found.map(|found| found.value))
    }

    /// The same, with the direction from which fluid falls onto a wall, if there is one.
    fn fitted(
        &self,
        crowd: Crowd,
        up: DVec3,
        rows: &mut Vec<u32>,
        value: impl Fn(usize) -> DVec3,
    ) -> (u32, Option<Fitted>) {
        let reach = crowd.reach(self.kernel.support_radius);
        let (low, high) = (self.at - reach, self.at + reach);
        // A little more than the kernel: it decides.
        let square = 1.0001 * self.kernel.support_radius.powi(2);
        let arm = |row: u32| {
            let place = crowd.places.get(row as usize)?;
            Some(crowd.period.nearest(place.truncate() - self.at))
        };
        let is_near = |row: u32| arm(row).is_some_and(|x| x.length_squared() < square);
        crowd.near.rows_that(low, high, rows, is_near);
        let behind = -BEHIND * crowd.spacing;
        let mut samples: SmallVec<[Sample; 32]> = SmallVec::new();
        for &row in &*rows {
            let Some(x) = arm(row) else { continue };
            let weight = f64::from(self.kernel.value(x.length()));
            let counts = self.side.is_none_or(|side| x.dot(side) >= behind);
            if counts && weight > 0.0 {
                samples.push(Sample {
                    weight,
                    x: x.as_dvec3() / f64::from(crowd.spacing),
                    value: value(row as usize),
                });
            }
        }
        let up = self.side.map_or(DVec3::ZERO, |_| up);
        let found = if is_off(&samples, up, crowd) {
            None
        } else {
            fit(&samples, crowd.dimension)
        };
        (samples.len() as u32, found)
    }
}

/// A particle near a point.
struct Sample {
    weight: f64,
    /// From the point, in spacings.
    x: DVec3,
    value: DVec3,
}

/// Least variance of the particles along any direction for which there is a slope \[spacings²].
const LEAST_VARIANCE: f64 = 0.06;

/// Distance of the nearest particle up to which a point is in the fluid \[spacings].
const IN_FLUID: f64 = 1.0;

/// Distance of the nearest particle beyond which a point is off the fluid \[spacings], unless it is a gap in it: the
/// particles around it then cover [`GAP`] of the kernel at least.
const OFF_FLUID: f64 = 1.25;
const GAP: f64 = 0.25;

/// The same for a point of a wall that is no higher than the surface of a row there: the first particle of a shallow
/// layer may keep away from a corner or a wall. The surface is half a spacing above the row, and may be rough.
const OFF_BESIDE: f64 = 1.75;
const ABOVE: f64 = 0.75;

/// Whether a point is off the fluid, and particles are near it all the same.
fn is_off(samples: &[Sample], up: DVec3, crowd: Crowd) -> bool {
    let weights: f64 = samples.iter().map(|sample| sample.weight).sum();
    let volume = match crowd.dimension {
        Dimension::Two => f64::from(crowd.spacing).powi(2),
        Dimension::Three => f64::from(crowd.spacing).powi(3),
    };
    let is_far = |sample: &Sample| {
        let is_beside = up != DVec3::ZERO && sample.x.dot(up) >= -ABOVE;
        let off = if is_beside { OFF_BESIDE } else { OFF_FLUID };
        sample.x.length_squared() > off * off
    };
    weights * volume < GAP && samples.iter().all(is_far)
}

/// What was found at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Fitted {
    value: DVec3,
    /// Mean place of the particles from the point \[spacings], where the value is their mean alone.
    mean_of: Option<DVec3>,
}

impl Fitted {
    /// What fluid at rest has more at the point than on average at the particles \[Pa], for the weight of a spacing of
    /// it \[Pa]. Nothing where there is a slope. At the surface of a film pressure is zero, so that below its middle it
    /// is at most twice the mean; spray has none.
    fn below(&self, weight: DVec3) -> f64 {
        let most = self.value.x.max(0.0);
        self.mean_of
            .map_or(0.0, |x| (-weight.dot(x)).clamp(-most, most))
    }
}

/// The linear function fitted to samples, at the origin; their mean where they have no certain slope.
fn fit(samples: &[Sample], dimension: Dimension) -> Option<Fitted> {
    let weights: f64 = samples.iter().map(|sample| sample.weight).sum();
    if samples.is_empty() {
        return None;
    }
    let (mut x, mut value) = (DVec3::ZERO, DVec3::ZERO);
    for sample in samples {
        x += sample.weight * sample.x;
        value += sample.weight * sample.value;
    }
    (x, value) = (x / weights, value / weights);
    // The diagonal, and the entries yz, zx and xy.
    let (mut diagonal, mut mixed) = (DVec3::ZERO, DVec3::ZERO);
    for sample in samples {
        let arm = sample.x - x;
        let weighted = sample.weight * arm;
        diagonal += weighted * arm;
        mixed += DVec3::new(weighted.y * arm.z, weighted.z * arm.x, weighted.x * arm.y);
    }
    (diagonal, mixed) = (diagonal / weights, mixed / weights);
    let mut variance = DMat3::from_cols(
        DVec3::new(diagonal.x, mixed.z, mixed.y),
        DVec3::new(mixed.z, diagonal.y, mixed.x),
        DVec3::new(mixed.y, mixed.x, diagonal.z),
    );
    if dimension == Dimension::Two {
        variance.z_axis.z = 1.0;
    }
    // The product of the others is at most the square of half the trace.
    let trace = variance.x_axis.x + variance.y_axis.y + variance.z_axis.z;
    let least = match dimension {
        Dimension::Two => variance.determinant() / (trace - 1.0),
        Dimension::Three => variance.determinant() / (0.25 * trace * trace),
    };
    let nearest = samples.iter().map(|sample| sample.x.length_squared());
    let is_inside = nearest.fold(f64::INFINITY, f64::min) <= IN_FLUID * IN_FLUID;
    if is_inside && least >= LEAST_VARIANCE {
        // What the slope makes of the way from the mean place to the point.
        let along = variance.inverse() * x;
        let change =
            |sample: &Sample| sample.weight * (sample.x - x).dot(along) * (sample.value - value);
        let change: DVec3 = samples.iter().map(change).sum();
        Some(Fitted {
            value: value - change / weights,
            mean_of: None,
        })
    } else {
        Some(Fitted {
            value,
            mean_of: Some(x),
        })
    }
}

/// Pressure at a point of the fluid.
pub(super) struct Pressure(pub(super) Around);

impl Probe for Pressure {
    fn read(&self, moment: &Moment, rows: &mut Vec<u32>, values: &mut Vec<Option<f64>>) {
        self.0.pressure(moment, rows, values);
    }
}

/// Pressure at a point of a wall.
pub(super) struct WallPressure {
    pub(super) around: Around,
    /// Number of the boundary that the point moves with.
    pub(super) boundary: Option<u32>,
}

impl Probe for WallPressure {
    fn read(&self, moment: &Moment, rows: &mut Vec<u32>, values: &mut Vec<Option<f64>>) {
        let moving = moment.state.moving.as_deref();
        let pose = self.boundary.and_then(|boundary| {
            let course = moving?.course_of(boundary)?;
            Some(course.pose(moment.state.clock.time))
        });
        let around = match pose {
            None => self.around,
            Some(pose) => Around {
                at: pose.place(self.around.at).as_vec3(),
                side: self.around.side.map(|side| pose.turn(side)),
                ..self.around
            },
        };
        around.pressure(moment, rows, values);
    }
}

/// Velocity at a point.
pub(super) struct Velocity(pub(super) Around);

impl Probe for Velocity {
    fn read(&self, moment: &Moment, rows: &mut Vec<u32>, values: &mut Vec<Option<f64>>) {
        let velocities = &moment.state.velocities.0;
        let value = |row: usize| velocities[row].truncate().as_dvec3();
        let (speak, mean) = self.0.fit(moment.crowd(), rows, value);
        values.extend([0, 1, 2].map(|axis| mean.map(|mean| mean[axis])));
        values.push(Some(speak.into()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes::split_mix;

    fn samples(count: usize, over: f64, dimension: Dimension) -> Vec<Sample> {
        let mut state = 3;
        let mut unit = || (split_mix(&mut state) >> 11) as f64 / (1u64 << 53) as f64;
        let mut samples = Vec::new();
        for _ in 0..count {
            let [x, y, z] = [0, 1, 2].map(|_| 4.0 * unit() - 2.0);
            let flat = if dimension == Dimension::Two { 0.0 } else { z };
            let x = DVec3::new(x, 0.5 * over + over * (y + 2.0), flat);
            samples.push(Sample {
                weight: 0.1 + unit(),
                x,
                value: DVec3::new(3.0 - 2.0 * x.x + 5.0 * x.y, x.y, 7.0 + x.z),
            });
        }
        samples
    }

    #[test]
    fn a_film_has_the_slope_of_fluid_at_rest_and_spray_has_none() {
        let weight = DVec3::new(0.0, -200.0, 0.0);
        let film = |pressure: f64, height: f64| Fitted {
            value: DVec3::splat(pressure),
            mean_of: Some(DVec3::new(0.3, height, 0.0)),
        };
        // Half a spacing below the middle of one row at rest; at the middle; above it; at its surface and beyond.
        for (height, expected) in [
            (0.5, 100.0),
            (0.0, 0.0),
            (-0.25, -50.0),
            (-0.5, -100.0),
            (-0.9, -100.0),
        ] {
            assert!((film(100.0, height).below(weight) - expected).abs() < 1e-9);
        }
        for pressure in [0.0, -100.0] {
            assert_eq!(film(pressure, 0.5).below(weight), 0.0);
        }
        let deep = Fitted {
            mean_of: None,
            ..film(100.0, 0.5)
        };
        assert_eq!(deep.below(weight), 0.0);
    }

    #[test]
    fn a_linear_field_is_exact_at_a_wall_and_a_film_has_its_mean() {
        for dimension in [Dimension::Two, Dimension::Three] {
            // One particle at the point's side, the others above it.
            let above = samples(40, 0.5, dimension);
            let found = fit(&above, dimension).expect("a value").value;
            assert!(found.distance(DVec3::new(3.0, 0.0, 7.0)) < 1e-9, "{found}");
            let film = samples(40, 1e-3, dimension);
            let mean: f64 = film.iter().map(|s| s.weight * s.value.x).sum::<f64>()
                / film.iter().map(|s| s.weight).sum::<f64>();
            let film = fit(&film, dimension).expect("a value");
            assert_eq!(film.value.x, mean);
            assert!(film.mean_of.is_some());
        }
        assert!(fit(&[], Dimension::Three).is_none());
        let alone = samples(1, 0.5, Dimension::Three);
        let spray = fit(&alone, Dimension::Three).expect("a value");
        let place = spray.mean_of.expect("no slope");
        // A weight is multiplied and divided by.
        assert!(place.distance(alone[0].x) < 1e-12);
        assert!(spray.value.distance(alone[0].value) < 1e-12);
    }
}
