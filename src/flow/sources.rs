//! What an emitter has emitted and what it emits next, and counts of all that came and went.

use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::{
    scene::{Adaptive, Cfl, Emitter, Outside, Scene, TimeStep, shapes::Inlet},
    state::{Material, Remembers},
};

/// Whether a scene has emitters.
pub(crate) fn has_emitters(scene: &Scene) -> bool {
    !scene.emitters.is_empty()
}

/// Whether particles may leave a scene.
pub(crate) fn removes(scene: &Scene) -> bool {
    !scene.outflow.is_empty() || scene.outside == Outside::Remove
}

/// Particles that entered and left since the start.
#[derive(Resource, Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Turnover {
    /// From emitters, those behind the faces included.
    pub(crate) emitted: u64,
    /// Places of emitters that were not filled, because other fluid was there.
    pub(crate) without_place: u64,
    /// By outflow, and out of the domain.
    pub(crate) removed: u64,
}

impl Remembers for Turnover {
    type State = Self;

    fn state(&self, _: &[Entity]) -> Self {
        *self
    }

    fn set_state(&mut self, state: Self, _: &[Entity]) -> Result<(), &'static str> {
        *self = state;
        Ok(())
    }
}

/// The emitters of a scene, and how many particles each has emitted.
#[derive(Resource, Debug, Default)]
pub(crate) struct Emitters(Vec<Source>);

#[derive(Debug)]
struct Source {
    emitter: Emitter,
    inlet: Inlet,
    emitted: u64,
    /// The longest step with the first particles of this speed \[s]; later ones follow from the motion.
    longest_step: f32,
    /// How much denser than at rest its layers are where they wait, at most, by stretch and jitter \[-].
    compression: f32,
}

impl Remembers for Emitters {
    type State = Vec<u64>;

    fn state(&self, _: &[Entity]) -> Vec<u64> {
        self.0.iter().map(|source| source.emitted).collect()
    }

    fn set_state(&mut self, state: Vec<u64>, _: &[Entity]) -> Result<(), &'static str> {
        if state.len() != self.0.len() {
            return Err("it is of other emitters");
        }
        for (source, emitted) in self.0.iter_mut().zip(state) {
            source.emitted = emitted;
        }
        Ok(())
    }
}

/// A particle that enters: where, how fast, and by which emitter, from 1.
pub(super) type Entering = (Vec3, Vec3, u32);

impl Emitters {
    pub(super) fn new(scene: &Scene) -> Self {
        let (h, material) = (scene.support_radius(), Material::new(scene));
        let source = |emitter: &Emitter| {
            let speed = emitter.speed;
            let longest_step = match scene.time_step {
                TimeStep::Fixed(_) => f32::INFINITY,
                TimeStep::Cfl(Cfl { factor, min, .. }) => (factor * h / speed).max(min),
                // The factor with which the scheme begins, and goes on after a shock.
                TimeStep::Adaptive(Adaptive { min, .. }) => (0.08 * h / speed).max(min),
            };
            let inlet = Inlet::new(emitter, scene);
            Source {
                compression: compression(&inlet, emitter, &material),
                emitter: emitter.clone(),
                inlet,
                emitted: 0,
                longest_step,
            }
        };
        Self(scene.emitters.iter().map(source).collect())
    }

    /// Time until a particle of an emitter passes its face \[s], its velocity until then, and the compression of the
    /// layers there \[-]. None for an emitter that is not there.
    pub(super) fn left(&self, emitter: u32, place: Vec3) -> Option<(f32, Vec3, f32)> {
        let source = self.0.get(emitter.checked_sub(1)? as usize)?;
        let (speed, normal) = (f64::from(source.emitter.speed), source.inlet.normal);
        let way = (place.as_dvec3() - source.inlet.center).dot(normal);
        let left = (-way / speed) as f32;
        Some((left, source.velocity(), source.compression))
    }

    /// The particles that have entered by a time \[s] and are not there yet, and the longest step that the first of
    /// an emitter allow \[s].
    pub(super) fn enter(&mut self, time: f64) -> (Vec<Entering>, f32) {
        let (mut entering, mut longest) = (Vec::new(), f32::INFINITY);
        for (number, source) in (1..).zip(&mut self.0) {
            let due = source.inlet.particles(&source.emitter, time);
            if due <= source.emitted {
                continue;
            }
            if source.emitted == 0 {
                longest = longest.min(source.longest_step);
            }
            let numbers = source.emitted..due;
            source.emitted = due;
            let (emitter, velocity) = (&source.emitter, source.velocity());
            source
                .inlet
                .for_each(emitter, numbers, time, |place: DVec3| {
                    entering.push((place.as_vec3(), velocity, number));
                });
        }
        (entering, longest)
    }
}

/// Particles that are looked at to find the compression of layers.
const LOOKED_AT: u64 = 1000;

/// How much denser than at rest particles in the middle of an emitter's layers are, at most \[-].
fn compression(inlet: &Inlet, emitter: &Emitter, material: &Material) -> f32 {
    let (size, h) = (inlet.points.len() as u64, material.kernel.support_radius);
    if size == 0 {
        return 0.0;
    }
    // A layer in the middle has as many on both sides as its neighbours are in.
    let aside = (f64::from(h) / inlet.pitch).ceil() as u64 + 1;
    let middle = LOOKED_AT.div_ceil(size);
    let numbers = 0..(2 * aside + middle) * size;
    let mut places = Vec::with_capacity(numbers.end as usize);
    inlet.for_each(emitter, numbers, emitter.start.into(), |place| {
        places.push(place);
    });
    let layer = |number: u64| &places[(number * size) as usize..((number + 1) * size) as usize];
    let looked_at = (aside..aside + middle).flat_map(|number| {
        let near: Vec<&[DVec3]> = (number - aside..=number + aside).map(layer).collect();
        let of_one = move |place: &DVec3| {
            let others = near.iter().flat_map(|layer| layer.iter());
            let kernel = others.map(|other| material.kernel.value((place - other).length() as f32));
            kernel.map(f64::from).sum::<f64>()
        };
        layer(number).iter().map(of_one)
    });
    let densest = looked_at.take(LOOKED_AT as usize).fold(0.0, f64::max);
    let density = f64::from(material.particle_mass) * densest;
    (density / f64::from(material.rest_density) - 1.0).max(0.0) as f32
}

impl Source {
    fn velocity(&self) -> Vec3 {
        (f64::from(self.emitter.speed) * self.inlet.normal).as_vec3()
    }
}
