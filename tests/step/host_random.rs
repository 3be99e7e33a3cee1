//! A host that does at random what a world allows to particles, between steps and within them.
//!
//! Whatever it does, a step is taken, or refused with the reason and the right particle; nothing panics, no number is
//! two particles', and after the cause is gone the next step is taken.

use std::{
    collections::HashSet,
    panic::{AssertUnwindSafe, catch_unwind},
};

use bevy_ecs::{entity_disabling::Disabled, prelude::*};
use glam::Vec3;
use overfall::{
    Simulation, Step,
    output::Frame,
    particle::{Boundary, Density, Fluid, ParticleId, Position, Pressure, Velocity},
    scene::{Adaptive, Executor, FluidBody, Scene, Shape, TimeStep},
    step::{Clock, FailureCause, Material},
};

use super::host::Tag;
use crate::common::{PLACES, dam, methods, run, simulation};

/// SplitMix64.
#[derive(Clone)]
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) % limit as u64) as usize
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }
}

/// The host's dice, how many things it does in the next step, and the particles that it has touched.
#[derive(Resource)]
struct Host {
    dice: Dice,
    within: usize,
    touched: HashSet<Entity>,
    said: Vec<String>,
}

const VALUES: [f32; 7] = [f32::NAN, f32::INFINITY, -1e20, 1e17, 3e4, 1e-40, 0.0];
const KINDS: usize = 25;

/// Does one of the first `kinds` things.
fn deed(world: &mut World, kinds: usize) {
    let mut all = world.query_filtered::<Entity, (With<Fluid>, Allow<Disabled>)>();
    let all: Vec<Entity> = all.iter(world).collect();
    let mut walls = world.query_filtered::<Entity, With<Boundary>>();
    let walls: Vec<Entity> = walls.iter(world).collect();
    if all.is_empty() || walls.is_empty() {
        return;
    }
    let mut host = world.remove_resource::<Host>().expect("the host");
    let dice = &mut host.dice;
    let (e, f, wall) = (dice.of(&all), dice.of(&all), dice.of(&walls));
    let kind = dice.below(kinds);
    let value = dice.of(&VALUES);
    let place = |dice: &mut Dice| {
        let part = [0; 3].map(|_| dice.below(1000) as f32 / 1000.0);
        Vec3::new(0.25, 0.27, 0.0) + Vec3::new(0.13, 0.1, 0.18) * Vec3::from_array(part)
    };
    host.said.push(format!("{kind} of {e}, {f}, {value}"));
    host.touched.extend([e, f, wall]);
    match kind {
        0 => _ = world.despawn(e),
        1 => {
            let at = place(dice);
            host.touched.insert(world.spawn((Fluid, Position(at))).id());
        }
        2 => _ = world.entity_mut(e).insert(Tag),
        3 => _ = world.entity_mut(e).remove::<Tag>(),
        4 => _ = world.entity_mut(e).insert(Disabled),
        5 => _ = world.entity_mut(e).remove::<Disabled>(),
        6 => _ = world.entity_mut(e).remove::<Position>(),
        7 => _ = world.entity_mut(e).remove::<Velocity>(),
        8 => _ = world.entity_mut(e).remove::<Density>(),
        9 => _ = world.entity_mut(e).remove::<Pressure>(),
        10 => _ = world.entity_mut(e).remove::<ParticleId>(),
        11 => _ = world.entity_mut(e).remove::<Fluid>(),
        12 => {
            let twin = world.entity_mut(e).clone_and_spawn();
            let at = place(dice);
            host.touched.insert(twin);
            world.entity_mut(twin).insert(Position(at));
        }
        13 => _ = world.entity_mut(e).insert(ParticleId::default()),
        14 => {
            _ = world
                .entity_mut(e)
                .insert(Velocity(Vec3::new(0.0, value, 0.0)))
        }
        15 => {
            _ = world
                .entity_mut(e)
                .insert(Position(Vec3::new(value, 0.1, 0.1)))
        }
        16 => _ = world.entity_mut(e).insert(Pressure(value)),
        17 => _ = world.entity_mut(e).insert(Density(value)),
        18 => world.resource_mut::<Clock>().next_dt = value,
        19 => world.resource_mut::<Material>().gravity.y = value,
        20 => _ = world.entity_mut(wall).insert(Fluid),
        21 => _ = world.entity_mut(e).insert(Boundary),
        22 if e != f => {
            world.entity_mut(e).insert(ChildOf(f));
            world.despawn(f);
        }
        23 => {
            let both = [e, f].map(|e| world.get::<ParticleId>(e).copied());
            if let [Some(a), Some(b)] = both {
                world.entity_mut(e).insert(b);
                world.entity_mut(f).insert(a);
            }
        }
        24 => {
            let number = world.get::<ParticleId>(f).copied();
            if let (Some(number), Some(mut id)) = (number, world.get_mut::<ParticleId>(e)) {
                *id = number;
            }
        }
        _ => {}
    }
    world.insert_resource(host);
}

fn deeds_within(world: &mut World) {
    let within = std::mem::take(&mut world.resource_mut::<Host>().within);
    // A number that is copied within a step is found by the next one.
    (0..within).for_each(|_| deed(world, KINDS - 1));
}

fn prepared(scene: &Scene, dice: &mut Dice) -> Simulation {
    let mut simulation = simulation(scene);
    let world = simulation.world_mut();
    world.insert_resource(Host {
        dice: Dice(dice.below(usize::MAX) as u64),
        within: 0,
        touched: HashSet::new(),
        said: Vec::new(),
    });
    let (after, before) = dice.of(&PLACES);
    world.schedule_scope(Step, |_, step| {
        step.add_systems(deeds_within.after(after).before(before));
    });
    run(&mut simulation, 1);
    simulation
}

/// Takes a step; removes what it is refused for, and tries again.
fn step_in_the_end(simulation: &mut Simulation, good: (Material, Clock)) -> Result<(), String> {
    let mut errors = Vec::new();
    for _ in 0..40 {
        let taken = catch_unwind(AssertUnwindSafe(|| simulation.step()));
        let Ok(taken) = taken else {
            return Err("a panic".to_owned());
        };
        let error = match taken {
            Ok(_) => return Ok(()),
            Err(error) => error,
        };
        errors.push(error.to_string());
        let world = simulation.world_mut();
        let is_hosts = matches!(
            error.cause,
            FailureCause::LacksComponent { .. }
                | FailureCause::TooLarge { .. }
                | FailureCause::NotFinite { .. }
                | FailureCause::SameNumber { .. }
        );
        let is_long = world.resource::<Clock>().next_dt > 2.0 * good.1.next_dt;
        match (error.particle, error.cause) {
            // It asks for a shorter step.
            (_, FailureCause::TooFast { .. }) if is_long => {
                world.resource_mut::<Clock>().next_dt = good.1.next_dt;
            }
            (Some((particle, _)), _) => {
                if is_hosts && !world.resource::<Host>().touched.contains(&particle) {
                    return Err(format!(
                        "{} names one that the host left alone",
                        errors.join("; ")
                    ));
                }
                _ = world.despawn(particle);
            }
            (None, FailureCause::Constant { .. } | FailureCause::TimeStep { .. }) => {
                *world.resource_mut::<Material>() = good.0;
                world.resource_mut::<Clock>().next_dt = good.1.next_dt;
            }
            (None, FailureCause::ConstantsWritten { .. }) => {
                *world.resource_mut::<Material>() = good.0;
                *world.resource_mut::<Clock>() = good.1;
            }
            (None, FailureCause::ParticlesChanged { .. } | FailureCause::Overwritten { .. }) => {}
            (None, other) => return Err(format!("a step is refused without a particle: {other}")),
        }
    }
    Err(format!("no step in the end: {}", errors.join("; ")))
}

#[test]
fn whatever_a_host_does_to_particles_is_taken_or_refused() {
    let runs: u64 = std::env::var("PROPTEST_CASES")
        .ok()
        .and_then(|cases| cases.parse().ok())
        .unwrap_or(3);
    let mut wrong = Vec::new();
    for seed in 0..runs {
        let mut dice = Dice(seed);
        let scene = Scene {
            pressure: methods()[seed as usize % methods().len()],
            executor: dice.of(&[Executor::SingleThreaded, Executor::Parallel]),
            time_step: match dice.below(3) {
                0 => TimeStep::Adaptive(Adaptive::default()),
                _ => dam().time_step,
            },
            reorder_interval: 2,
            ..dam()
        };
        // Fewer particles, as many things.
        let scene = Scene {
            bodies: vec![FluidBody {
                jitter: dam().bodies[0].jitter,
                ..FluidBody::new(Shape::cuboid([0.0; 3], [0.2, 0.08, 0.2]))
            }],
            ..scene
        };
        let mut simulation = prepared(&scene, &mut dice);
        for _ in 0..6 {
            let world = simulation.world_mut();
            let good = (*world.resource::<Material>(), *world.resource::<Clock>());
            for _ in 0..dice.below(3) {
                deed(world, KINDS);
            }
            world.resource_mut::<Host>().within = dice.below(3);
            let result = step_in_the_end(&mut simulation, good);
            let world = simulation.world_mut();
            let said = world.resource::<Host>().said.join("; ");
            let mut ids = Frame::from_world(world).ids.clone();
            let count = ids.len();
            ids.sort_unstable();
            ids.dedup();
            // What is refused may be in the world still.
            if ids.len() != count && result.is_ok() {
                wrong.push(format!(
                    "seed {seed}: {} numbers are double after {said}",
                    count - ids.len()
                ));
            }
            if let Err(error) = result {
                wrong.push(format!(
                    "seed {seed}, {:?}: {error} after {said}",
                    scene.executor
                ));
                break;
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
