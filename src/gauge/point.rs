//! Pressure and velocity at a point: means over the particles around it, weighted by a cubic spline.
//!
//! `f(x) = Σ_j f_j W(x − x_j) / Σ_j W(x − x_j)` (Shepard 1968): exact for a constant field wherever there is a
//! particle, also beside surfaces and walls. Inside the fluid it is of second order in the radius. Beside a wall, where
//! all particles are on one side, it is of first order: a linear pressure is that about 0.4 radii in front of the face.

use glam::{DVec3, Vec3};

use super::{
    moment::{Moment, Probe},
    near::Crowd,
};
use crate::kernel::Kernel;

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
        let (speak, mean) = self.mean(moment.crowd(), rows, value);
        // A dry wall has no pressure; inside the fluid there is no value without fluid.
        let dry = self.side.map(|_| 0.0);
        values.extend([mean.map(|mean| mean.x).or(dry), Some(speak.into())]);
    }

    /// Number of particles that contribute, and the mean of their values.
    pub(super) fn mean(
        &self,
        crowd: Crowd,
        rows: &mut Vec<u32>,
        value: impl Fn(usize) -> DVec3,
    ) -> (u32, Option<DVec3>) {
        let reach = crowd.reach(self.kernel.support_radius);
        crowd.near.rows_in(self.at - reach, self.at + reach, rows);
        let behind = -BEHIND * crowd.spacing;
        let (mut speak, mut sum, mut weights) = (0, DVec3::ZERO, 0.0);
        for &row in &*rows {
            let x = crowd
                .period
                .nearest(crowd.places[row as usize].truncate() - self.at);
            let weight = f64::from(self.kernel.value(x.length()));
            let counts = self.side.is_none_or(|side| x.dot(side) >= behind);
            if counts && weight > 0.0 {
                speak += 1;
                sum += weight * value(row as usize);
                weights += weight;
            }
        }
        (speak, (speak > 0).then(|| sum / weights))
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
        let (speak, mean) = self.0.mean(moment.crowd(), rows, value);
        values.extend([0, 1, 2].map(|axis| mean.map(|mean| mean[axis])));
        values.push(Some(speak.into()));
    }
}
