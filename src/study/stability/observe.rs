//! Runs the scene of a point and watches what its class depends on.

use std::time::Instant;

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{End, Observed, Rules};
use crate::{
    Simulation, StepReport,
    scene::{BodyForce, PressureMethod, Scene},
    state::{
        BodyForces, Material,
        particle::{Boundary, Fluid, Position, Velocity},
    },
};

/// Steps between two looks at where the particles are.
const LOOK: u64 = 50;

/// How far beyond the walls a particle has leaked \[spacings].
const MARGIN: f32 = 2.0;

/// What was seen of a run after each of the numbers of steps; all after the end of a run that ends early are as that.
/// `None` if `stop` says so in between.
pub(super) fn observe(
    scene: &Scene,
    after: &[u64],
    rules: &Rules,
    stop: &dyn Fn() -> bool,
) -> Option<Vec<Observed>> {
    let mut simulation = match Simulation::with_threads(scene, 1) {
        Ok(simulation) => simulation,
        Err(error) => {
            let seen = Observed {
                end: Some(End::Refused(error.to_string())),
                ..Observed::default()
            };
            return Some(vec![seen; after.len()]);
        }
    };
    let mut watch = Watch::start(scene, simulation.world_mut());
    let mut found = Vec::new();
    for &steps in after {
        while watch.seen.steps < steps && watch.seen.end.is_none() {
            if stop() {
                return None;
            }
            let started = Instant::now();
            let taken = simulation.step();
            watch.seen.wall += started.elapsed().as_secs_f64();
            match taken {
                Ok(report) => watch.see(&report),
                Err(error) => watch.seen.end = Some(End::of(&error.cause)),
            }
            if watch.seen.end.is_none() && watch.seen.wall > rules.seconds {
                watch.seen.end = Some(End::OutOfTime);
            }
            if watch.seen.steps.is_multiple_of(LOOK) || watch.seen.steps == steps {
                watch.look(simulation.world_mut());
            }
        }
        found.push(watch.seen.clone());
    }
    Some(found)
}

struct Watch {
    seen: Observed,
    /// Energy at the start, and what there was to lose: motion, and height above the lowest place \[J].
    energy: Option<(f64, f64)>,
    /// Particles at the start.
    particles: usize,
    /// The box that particles have leaked from beyond which; `None` without walls.
    walls: Option<(Vec3, Vec3)>,
    /// Whether particles that are removed have leaked.
    removal_is_leak: bool,
    removed: u64,
    emitted: u64,
    most_iterations: u32,
}

impl Watch {
    fn start(scene: &Scene, world: &mut World) -> Self {
        let mut fluid = world.query_filtered::<&Position, With<Fluid>>();
        let particles = fluid.iter(world).count();
        let most_iterations = match scene.pressure {
            PressureMethod::Sesph(_) | PressureMethod::DeltaSph(_) => u32::MAX,
            PressureMethod::Pcisph(method) => method.max_iterations,
            PressureMethod::Iisph(method) => method.max_iterations,
            PressureMethod::Dfsph(method) => method.max_iterations,
        };
        Self {
            seen: Observed::default(),
            energy: is_closed(scene)
                .then(|| energy(world))
                .filter(|energy| energy.1 > 0.0),
            particles,
            walls: room(scene, world),
            removal_is_leak: scene.outflow.is_empty(),
            removed: 0,
            emitted: 0,
            most_iterations,
        }
    }

    fn see(&mut self, report: &StepReport) {
        let seen = &mut self.seen;
        // The step of a report that was taken back is that of the state before.
        (seen.steps, seen.time) = (report.step, report.time);
        seen.iterations += u64::from(report.iterations);
        if report.taken_back.is_some() {
            return;
        }
        (self.removed, self.emitted) = (report.removed, report.emitted);
        seen.not_converged += u64::from(report.iterations >= self.most_iterations);
        let largest = |old: f64, new: f64| if new.is_nan() { new } else { old.max(new) };
        seen.mean_density_error =
            largest(seen.mean_density_error, report.mean_density_error.into());
        seen.largest_density_error =
            largest(seen.largest_density_error, report.max_density_error.into());
        if let Some((start, scale)) = self.energy {
            let now = report.kinetic_energy + report.potential_energy;
            seen.energy_gain = largest(seen.energy_gain, (now - start) / scale);
        }
    }

    /// Counts the particles beyond the walls.
    fn look(&mut self, world: &mut World) {
        let mut fluid = world.query_filtered::<&Position, With<Fluid>>();
        let beyond = self.walls.map_or(0, |(low, high)| {
            let is_beyond = |x: &&Position| x.0.cmplt(low).any() || x.0.cmpgt(high).any();
            fluid.iter(world).filter(is_beyond).count()
        });
        let removed = if self.removal_is_leak {
            self.removed
        } else {
            0
        };
        let all = self.particles as f64 + self.emitted as f64;
        let leaked = (beyond as f64 + removed as f64) / all.max(1.0);
        self.seen.leaked = self.seen.leaked.max(leaked);
    }
}

/// Whether nothing outside the fluid does work on it, gravity and central forces aside.
fn is_closed(scene: &Scene) -> bool {
    let stands = scene.boundaries.iter().all(|wall| wall.motion().is_none());
    let constant = (scene.body_forces.iter()).all(|force| matches!(force, BodyForce::Central(_)));
    stands && constant && scene.emitters.is_empty() && scene.outflow.is_empty()
}

/// Kinetic and potential energy of the fluid, and the part of it that can be turned into heat: motion, and height above
/// the lowest particle of fluid and walls \[J; J/m in 2-D].
fn energy(world: &mut World) -> (f64, f64) {
    let material = *world.resource::<Material>();
    let forces = world.get_resource::<BodyForces>().cloned();
    let gravity = material.gravity_with_potential();
    let mut places = world.query_filtered::<&Position, Or<(With<Fluid>, With<Boundary>)>>();
    let lowest = places.iter(world).map(|x| f64::from(gravity.dot(x.0)));
    let lowest = lowest.fold(f64::NEG_INFINITY, f64::max);
    let mut fluid = world.query_filtered::<(&Position, &Velocity), With<Fluid>>();
    let (mut squares, mut heights, mut above) = (0.0, 0.0, 0.0);
    for (x, v) in fluid.iter(world) {
        squares += f64::from(v.0.length_squared());
        let height = f64::from(gravity.dot(x.0));
        above += lowest - height;
        heights += height;
        if let Some(forces) = &forces {
            heights -= f64::from(forces.potential(x.0));
        }
    }
    let mass = f64::from(material.particle_mass);
    (
        mass * (0.5 * squares - heights),
        mass * (0.5 * squares + above),
    )
}

/// The box around walls and fluid at the start, open against gravity and along periodic axes, and a little wider;
/// `None` without walls.
fn room(scene: &Scene, world: &mut World) -> Option<(Vec3, Vec3)> {
    if scene.boundaries.is_empty() {
        return None;
    }
    let mut places = world.query_filtered::<&Position, Or<(With<Fluid>, With<Boundary>)>>();
    let far = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = places
        .iter(world)
        .fold(far, |(low, high), x| (low.min(x.0), high.max(x.0)));
    let margin = Vec3::splat(MARGIN * scene.spacing);
    let (mut low, mut high) = (low - margin, high + margin);
    let periodic = scene.periodic.axes().map(|axis| axis.is_some());
    for axis in 0..3 {
        if periodic[axis] || scene.gravity[axis] > 0.0 {
            low[axis] = f32::NEG_INFINITY;
        }
        if periodic[axis] || scene.gravity[axis] < 0.0 {
            high[axis] = f32::INFINITY;
        }
    }
    Some((low, high))
}
