//! Resources of the engine that a host's system replaces within a step: by their defaults where there are any, and
//! constants by others. The step may fail, in words; it does not panic, and constants that last are named.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy_ecs::{component::Mutable, prelude::*};
use overfall::{
    Phase, Step,
    boundary::{friction::WallFriction, owners::Owners},
    gauge::EnergyAccount,
    integrate::Motion,
    neighbours::{BoundaryNeighbours, FluidNeighbours},
    pairs::KernelGradients,
    pressure::{
        SolverState,
        density_rate::{DensityRates, PredictedVelocities},
        dfsph::DivergenceTerms,
        diagonal::InverseDiagonals,
        implicit::Iterates,
        neighbour_count::NeighbourCounts,
        pcisph::PredictedDensities,
    },
    reorder::ReorderState,
    scene::{Adaptive, Executor, Scene, TimeStep},
    state::BodyForces,
    step::{Accelerations, Clock, Failure, FailureCause, Material, Positions, Rows},
    time_step::roll_back::KeptState,
};

use crate::common::{PLACES, bits, dam, methods, run, simulation};

type Change = fn(&mut World);

/// A change of the world in the middle of a step, executed once.
#[derive(Resource)]
struct Deed(Option<Change>);

fn interfere(world: &mut World) {
    if let Some(deed) = world.resource_mut::<Deed>().0.take() {
        deed(world);
    }
}

/// Replaces a resource, where there is one, as a system with `ResMut` does.
fn reset<R: Resource<Mutability = Mutable> + Default>(world: &mut World) {
    if let Some(mut resource) = world.get_resource_mut::<R>() {
        *resource = R::default();
    }
}

const RESETS: [(&str, Change); 18] = [
    ("BodyForces", reset::<BodyForces>),
    ("BoundaryNeighbours", reset::<BoundaryNeighbours>),
    ("DensityRates", reset::<DensityRates>),
    ("DivergenceTerms", reset::<DivergenceTerms>),
    ("EnergyAccount", reset::<EnergyAccount>),
    ("Failure", reset::<Failure>),
    ("FluidNeighbours", reset::<FluidNeighbours>),
    ("InverseDiagonals", reset::<InverseDiagonals>),
    ("Iterates", reset::<Iterates>),
    ("KeptState", reset::<KeptState>),
    ("KernelGradients", reset::<KernelGradients>),
    ("Motion", reset::<Motion>),
    ("NeighbourCounts", reset::<NeighbourCounts>),
    ("Owners", reset::<Owners>),
    ("PredictedDensities", reset::<PredictedDensities>),
    ("PredictedVelocities", reset::<PredictedVelocities>),
    ("Rows", reset::<Rows>),
    ("SolverState", reset::<SolverState>),
];

fn scenes() -> Vec<Scene> {
    let mut scenes: Vec<Scene> = methods()
        .into_iter()
        .map(|pressure| Scene { pressure, ..dam() })
        .collect();
    scenes.push(Scene {
        executor: Executor::Parallel,
        time_step: TimeStep::Adaptive(Adaptive::default()),
        ..dam()
    });
    scenes
}

#[test]
fn a_resource_that_a_host_resets_within_a_step_panics_nothing() {
    let more: [(&str, Change); 2] = [
        ("WallFriction", reset::<WallFriction>),
        ("ReorderState", |world| {
            world.insert_resource(ReorderState::new(0));
        }),
    ];
    let mut panics = Vec::new();
    for scene in scenes() {
        for (after, before) in PLACES {
            let mut simulation = simulation(&scene);
            let world = simulation.world_mut();
            world.insert_resource(Deed(None));
            world.schedule_scope(Step, |_, step| {
                step.add_systems(interfere.after(after).before(before));
            });
            run(&mut simulation, 1);
            for (name, deed) in RESETS.into_iter().chain(more) {
                let deed = Some(deed);
                simulation.world_mut().resource_mut::<Deed>().0 = deed;
                let step = catch_unwind(AssertUnwindSafe(|| simulation.step()));
                if step.is_err() {
                    panics.push(format!("{name} after {after:?}, {:?}", scene.pressure));
                }
            }
        }
    }
    assert!(panics.is_empty(), "{panics:#?}");
}

#[test]
fn a_constant_that_a_host_writes_within_a_step_is_named() {
    let writes: [(&str, Change); 7] = [
        ("Material", |world| {
            world.resource_mut::<Material>().spacing = 0.0
        }),
        ("Material", |world| {
            world.resource_mut::<Material>().gravity.y = 5.0
        }),
        ("Material", |world| {
            world.resource_mut::<Material>().rest_density = f32::NAN
        }),
        ("Clock", |world| world.resource_mut::<Clock>().dt *= 2.0),
        ("Clock", |world| world.resource_mut::<Clock>().dt = f32::NAN),
        ("Clock", |world| world.resource_mut::<Clock>().time += 1.0),
        ("Clock", |world| world.resource_mut::<Clock>().step = 0),
    ];
    for scene in scenes() {
        for (after, before) in PLACES.into_iter().take(5) {
            let mut simulation = simulation(&scene);
            simulation.world_mut().insert_resource(Deed(None));
            simulation.world_mut().schedule_scope(Step, |_, step| {
                step.add_systems(interfere.after(after).before(before));
            });
            run(&mut simulation, 2);
            for (name, deed) in writes {
                let world = simulation.world_mut();
                let good = (*world.resource::<Material>(), *world.resource::<Clock>());
                let expected = bits(world);
                world.resource_mut::<Deed>().0 = Some(deed);
                let error = simulation.step().expect_err("a constant was written");
                let FailureCause::ConstantsWritten { resource } = error.cause else {
                    panic!("{name} after {after:?}: {error}");
                };
                assert_eq!(resource, name, "after {after:?}");
                let world = simulation.world_mut();
                assert!(bits(world) == expected, "{name} after {after:?}");
                *world.resource_mut::<Material>() = good.0;
                *world.resource_mut::<Clock>() = good.1;
            }
            run(&mut simulation, 1);
        }
    }
}

/// Accelerations are the only column that a host may write, and no host can change its length.
#[test]
fn a_hosts_system_may_add_to_accelerations_by_row() {
    let mut simulation = simulation(&Scene {
        gravity: glam::Vec3::ZERO,
        ..dam()
    });
    let world = simulation.world_mut();
    let lift = |mut a: ResMut<Accelerations>, x: Res<Positions>, rows: Res<Rows>| {
        assert!(a.len() == x.len() && a.len() == rows.entities().len());
        for (a, _) in a.iter_mut().zip(x.iter()) {
            a.y += 7.0;
        }
    };
    world.schedule_scope(Step, |_, step| {
        step.add_systems(lift.after(Phase::Forces).before(Phase::Pressure));
    });
    run(&mut simulation, 1);
    let accelerations = simulation.world().resource::<Accelerations>();
    let mean = accelerations.iter().map(|a| a.y).sum::<f32>() / accelerations.len() as f32;
    assert!((mean - 7.0).abs() < 0.1, "{mean}");
}
