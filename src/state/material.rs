//! Constants of a run that every loop reads.

use std::f64::consts::TAU;

use bevy_ecs::prelude::*;
use glam::Vec3;

use crate::{
    kernel::Kernel,
    scene::{Dimension, Period, Scene},
};

/// What the fluid and its discretisation are made of.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// 2 or 3.
    pub dimension: Dimension,
    /// Distance of the particles at rest \[m].
    pub spacing: f32,
    /// The kernel, of support radius h.
    pub kernel: Kernel,
    /// Density at rest ρ0 \[kg/m³; kg/m² in 2-D].
    pub rest_density: f32,
    /// Mass m of a particle \[kg], such that the lattice at rest has density ρ0 exactly: `m = ρ0 / Σ_lattice W`. It
    /// differs from `ρ0 spacing^d` by under two per cent at the default support.
    pub particle_mass: f32,
    /// Acceleration of every particle \[m/s²].
    pub gravity: Vec3,
    /// Time over which gravity grows from nothing; 0 for all of it from the start on \[s].
    pub gravity_ramp: f32,
    /// The box that repeats.
    pub period: Period,
}

impl Material {
    /// The constants of a scene.
    pub fn new(scene: &Scene) -> Self {
        let kernel = Kernel::of(scene);
        let lattice: f64 = kernel
            .lattice(scene.dimension, scene.spacing)
            .map(|x| f64::from(kernel.value(x.length())))
            .sum();
        let rest_density = scene.fluid.rest_density;
        Self {
            dimension: scene.dimension,
            spacing: scene.spacing,
            kernel,
            rest_density,
            particle_mass: (f64::from(rest_density) / lattice) as f32,
            gravity: scene.gravity,
            gravity_ramp: scene.gravity_ramp,
            period: scene.period(),
        }
    }

    /// The part of gravity that acts on the mean of a step, from a time on \[-]: `t/T − sin(2πt/T)/2π` within the ramp.
    pub fn part_of_gravity(&self, time: f64, dt: f64) -> f32 {
        let ramp = f64::from(self.gravity_ramp);
        if time >= ramp {
            return 1.0;
        }
        // Its integral over t/T.
        let integral = |time: f64| {
            let part = (time / ramp).min(1.0);
            let rest = time / ramp - part;
            0.5 * part * part + ((TAU * part).cos() - 1.0) / (TAU * TAU) + rest
        };
        if dt > 0.0 {
            (ramp * (integral(time + dt) - integral(time)) / dt) as f32
        } else {
            (time / ramp - (TAU * time / ramp).sin() / TAU) as f32
        }
    }

    /// The part of gravity that has a potential \[m/s²]: along a periodic axis a particle falls for ever.
    pub fn gravity_with_potential(&self) -> Vec3 {
        self.period.open_part(self.gravity)
    }
}
