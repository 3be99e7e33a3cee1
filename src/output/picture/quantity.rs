//! What the colours of a picture show.

use std::collections::HashMap;

use crate::output::Frame;

/// A quantity of particles that colours show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Quantity {
    /// Speed \[m/s].
    #[default]
    Speed,
    /// Change of the velocity since the frame before, over the time between them \[m/s²]; 0 without one.
    Acceleration,
    /// Pressure \[Pa].
    Pressure,
    /// Density \[kg/m³].
    Density,
    /// Permanent number \[-].
    Id,
    /// Place in memory, from 0 for the first row \[-]. Neighbours in space of like colour are neighbours in memory.
    Row,
}

impl Quantity {
    /// Unit in ASCII; empty for numbers.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Speed => "m/s",
            Self::Acceleration => "m/s^2",
            Self::Pressure => "Pa",
            Self::Density => "kg/m^3",
            Self::Id | Self::Row => "",
        }
    }

    /// Whether its values need the frame before.
    pub fn needs_the_frame_before(self) -> bool {
        self == Self::Acceleration
    }

    /// Its value for every particle of a frame; `before` is the frame before, which accelerations need.
    pub fn values(self, frame: &Frame, before: Option<&Frame>) -> Vec<f32> {
        match self {
            Self::Speed => frame.velocities.iter().map(|v| v.length()).collect(),
            Self::Acceleration => accelerations(frame, before),
            Self::Pressure => frame.pressures.clone(),
            Self::Density => frame.densities.clone(),
            Self::Id => frame.ids.iter().map(|id| *id as f32).collect(),
            Self::Row => (0..frame.len()).map(|row| row as f32).collect(),
        }
    }
}

fn accelerations(frame: &Frame, before: Option<&Frame>) -> Vec<f32> {
    let none = || vec![0.0; frame.len()];
    let Some(before) = before else {
        return none();
    };
    let time = (frame.time - before.time) as f32;
    if time <= 0.0 {
        return none();
    }
    let known = before
        .ids
        .iter()
        .copied()
        .zip(before.velocities.iter().copied());
    let known: HashMap<u32, glam::Vec3> = known.collect();
    let of = |(id, now): (&u32, &glam::Vec3)| {
        let then = known.get(id);
        then.map_or(0.0, |then| (*now - *then).length() / time)
    };
    frame.ids.iter().zip(&frame.velocities).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn accelerations_follow_particles_through_rows() {
        let before = Frame {
            time: 1.0,
            ids: vec![7, 3],
            velocities: vec![Vec3::X, Vec3::ZERO],
            positions: vec![Vec3::ZERO; 2],
            ..Frame::default()
        };
        let now = Frame {
            time: 1.5,
            ids: vec![3, 9, 7],
            velocities: vec![Vec3::Y, Vec3::ONE, Vec3::X],
            positions: vec![Vec3::ZERO; 3],
            ..Frame::default()
        };
        let of = |before| Quantity::Acceleration.values(&now, before);
        assert_eq!(of(Some(&before)), [2.0, 0.0, 0.0]);
        assert_eq!(of(None), [0.0; 3]);
        assert_eq!(of(Some(&now)), [0.0; 3]);
        assert_eq!(Quantity::Row.values(&now, None), [0.0, 1.0, 2.0]);
    }
}
