//! The same water on any number of ranks, bit for bit.

use std::{
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
    thread,
};

use bevy_ecs::prelude::*;
use overfall::{
    Execution, StepError, StepReport,
    checkpoint::{self, Checkpoint},
    communicator::Local,
    install_on_rank,
    scene::{
        BoundaryHandling, Dfsph, DirectForcing, Executor, IndexStructure, Neighbours,
        PressureMethod, Scene,
    },
    state::{
        FailureCause,
        particle::{Density, Fluid, ParticleId, Position, Pressure, Velocity},
    },
    step::InstallError,
    take_step,
};

use crate::common::{methods, pcisph, sesph};

/// A column of four chunks of particles that collapses in a tank.
fn dam(dimension: u8, pressure: PressureMethod) -> Scene {
    let (body, tank) = match dimension {
        2 => ("(1.12, 1.12, 0)", "(2, 1.6, 0)"),
        _ => ("(0.3, 0.3, 0.28)", "(0.6, 0.6, 0.3)"),
    };
    let scene = format!(
        r#"(
            name: "dam",
            dimension: {dimension},
            spacing: 0.02,
            fluid: (viscosity: Laminar(kinematic_viscosity: 1e-4)),
            bodies: [(
                shape: Box(min: (0, 0, 0), max: {body}),
                velocity: (1.5, 0.3, 0),
                jitter: (amplitude: 0.05, seed: 1),
            )],
            boundaries: [Tank(min: (-0.02, -0.02, -0.02), max: {tank})],
            reorder_interval: 3,
        )"#
    );
    Scene {
        pressure,
        ..parsed(&scene)
    }
}

/// A drop that falls so fast into a pool that steps are taken back. Particles cross the faces of both axes.
fn splash() -> Scene {
    parsed(
        r#"(
            name: "splash",
            dimension: 2,
            spacing: 0.02,
            pressure: Pcisph(),
            bodies: [
                (shape: Box(min: (0, 0, 0), max: (1, 0.6, 0)), velocity: (2, 0, 0)),
                (shape: Sphere(center: (0.5, 0.9, 0), radius: 0.2), velocity: (2, -6, 0)),
            ],
            boundaries: [Plane(center: (0.5, 0, 0), normal: (0, 1, 0), half_size: 1)],
            periodic: (x: (0, 1)),
            time_step: Adaptive(max: 5e-3, initial: 2.9e-3, density_error: 0.001),
            reorder_interval: 1,
        )"#,
    )
}

fn parsed(scene: &str) -> Scene {
    Scene::parse(scene, "scene.ron", &[]).expect("a scene")
}

/// Number, position, velocity, density and pressure of a particle.
type Bits = (u32, [u32; 8]);

fn bits(world: &mut World) -> Vec<Bits> {
    type Parts<'a> = (
        &'a ParticleId,
        &'a Position,
        &'a Velocity,
        &'a Density,
        &'a Pressure,
    );
    let mut fluid = world.query_filtered::<Parts, With<Fluid>>();
    let bits = |(id, x, v, rho, p): Parts| {
        let ([x, y, z], [u, v, w]) = (x.0.to_array(), v.0.to_array());
        (id.get(), [x, y, z, u, v, w, rho.0, p.0].map(f32::to_bits))
    };
    fluid.iter(world).map(bits).collect()
}

/// Takes steps, and returns their reports up to an error.
fn run(world: &mut World, steps: usize) -> (Vec<StepReport>, Option<StepError>) {
    let mut reports = Vec::new();
    let mut taken = (0..steps).map(|_| take_step(world));
    let error = taken.find_map(|taken| {
        let taken = taken.map(|mut report| {
            report.phase_seconds = Default::default();
            reports.push(report);
        });
        taken.err()
    });
    (reports, error)
}

fn on_rank<T>(scene: &Scene, rank: Local, work: impl FnOnce(&mut World) -> T) -> T {
    let mut world = World::new();
    world.insert_resource(Execution::new(1).expect("a thread"));
    install_on_rank(&mut world, scene, Arc::new(rank)).expect("a scene that runs");
    work(&mut world)
}

/// What all ranks return, in their order.
fn on_ranks<T: Send>(scene: &Scene, ranks: usize, work: impl Fn(&mut World) -> T + Sync) -> Vec<T> {
    thread::scope(|scope| {
        let threads: Vec<_> = (Local::team(ranks).into_iter())
            .map(|rank| scope.spawn(|| on_rank(scene, rank, &work)))
            .collect();
        let join = |thread: thread::ScopedJoinHandle<T>| thread.join().expect("no panic");
        threads.into_iter().map(join).collect()
    })
}

/// What a rank has after some steps: its particles in the order of their rows, and its reports.
type End = (Vec<Bits>, Vec<StepReport>, Option<StepError>);

fn ends(scene: &Scene, ranks: usize, steps: usize) -> Vec<End> {
    on_ranks(scene, ranks, |world| {
        let (reports, error) = run(world, steps);
        (bits(world), reports, error)
    })
}

/// Several ranks give the bits and the reports of one, which are returned.
fn assert_same(scene: &Scene, numbers: &[usize], steps: usize) -> Vec<StepReport> {
    let alone = ends(scene, 1, steps).remove(0);
    assert_eq!(alone.2, None);
    for ranks in numbers {
        let ends = ends(scene, *ranks, steps);
        let name = format!("{ranks} ranks, {scene:?}");
        let mut all = Vec::new();
        for (bits, reports, error) in ends {
            assert_eq!(error, None, "{name}");
            for (report, expected) in reports.iter().zip(&alone.1) {
                let steps = |report: &StepReport| report.taken_back.as_ref().map(|back| back.steps);
                assert_eq!(steps(report), steps(expected), "{name}");
                let mut report = report.clone();
                report.taken_back.clone_from(&expected.taken_back);
                assert_eq!(report, *expected, "{name}");
            }
            all.push(bits);
        }
        // After every other reordering rows lie against the curve, and the last rank has the first of them.
        let differing = |all: &[Vec<Bits>]| {
            let all = all.concat();
            assert_eq!(all.len(), alone.0.len(), "{name}");
            all.iter().zip(&alone.0).filter(|(a, b)| a != b).count()
        };
        let forwards = differing(&all);
        all.reverse();
        assert_eq!(forwards.min(differing(&all)), 0, "{name}");
    }
    alone.1
}

#[test]
fn the_number_of_ranks_changes_no_bit() {
    for pressure in &methods()[..4] {
        for dimension in [2, 3] {
            assert_same(&dam(dimension, *pressure), &[2, 3, 4], 8);
        }
    }
    // Particles have gone to other ranks meanwhile: the first of two began with the first two chunks.
    let first = ends(&dam(2, sesph()), 2, 8).swap_remove(0).0;
    assert!(first.iter().any(|(number, _)| *number >= 2048));
}

#[test]
fn the_number_of_ranks_changes_no_bit_of_any_structure_and_any_lists() {
    let dam = dam(3, sesph());
    for structure in IndexStructure::ALL {
        let mut scene = dam.clone();
        scene.index.structure = structure;
        if structure != IndexStructure::SpatialHashing {
            assert_same(&scene, &[3], 4);
        }
    }
    for neighbours in [Neighbours::Recomputed, Neighbours::Verlet { skin: 0.2 }] {
        let scene = Scene {
            neighbours,
            reorder_interval: 5,
            ..dam.clone()
        };
        assert_same(&scene, &[3], 8);
    }
}

#[test]
fn the_number_of_ranks_changes_no_bit_beside_walls_of_any_kind() {
    for handling in [
        BoundaryHandling::DirectForcing(DirectForcing::default()),
        BoundaryHandling::Extrapolated,
        BoundaryHandling::Layers,
    ] {
        let mut scene = Scene {
            boundary_handling: Some(handling),
            ..dam(2, pcisph())
        };
        scene.fluid = crate::common::dam().fluid;
        assert_same(&scene, &[3], 5);
    }
}

#[test]
fn steps_are_taken_back_on_all_ranks_and_across_periodic_faces() {
    let reports = assert_same(&splash(), &[2, 3], 25);
    let back = reports.iter().filter(|report| report.taken_back.is_some());
    assert!(back.count() > 0);
}

#[test]
fn a_checkpoint_goes_on_with_any_number_of_ranks() {
    let scene = dam(2, PressureMethod::Dfsph(Dfsph::default()));
    let alone = ends(&scene, 1, 8).remove(0).0;
    let write = |world: &mut World| Checkpoint::of(world).expect("a checkpoint").to_bytes();
    let first = on_ranks(&scene, 2, |world| {
        run(world, 5);
        write(world)
    });
    assert_eq!(first[0], first[1]);
    for ranks in [1, 3] {
        let last = on_ranks(&scene, ranks, |world| {
            checkpoint::restore(world, &mut &first[0][..]).expect("the same run");
            run(world, 3);
            bits(world)
        });
        let mut all = last.concat();
        all.sort_unstable();
        let mut alone = alone.clone();
        alone.sort_unstable();
        assert!(all == alone, "{ranks} ranks");
    }
}

#[test]
fn a_failure_on_one_rank_is_told_on_all() {
    let scene = Scene {
        domain: Some(overfall::scene::Bounds {
            min: glam::Vec3::splat(-0.1),
            max: glam::Vec3::new(0.43, 0.5, 0.5),
        }),
        ..dam(3, sesph())
    };
    let [(_, reports, Some(alone))] = &ends(&scene, 1, 100)[..] else {
        panic!("it does not leave the domain");
    };
    let ends = ends(&scene, 3, 100);
    let own: Vec<_> = (ends.iter())
        .filter(|end| matches!(&end.2, Some(error) if error.cause == FailureCause::LeftDomain))
        .collect();
    let [(.., Some(own))] = &own[..] else {
        panic!("one rank has the particle");
    };
    assert_eq!(
        (own.step, own.particle.map(|at| at.1)),
        (alone.step, alone.particle.map(|at| at.1))
    );
    for (_, of_rank, error) in &ends {
        assert_eq!(of_rank, reports);
        let error = error.as_ref().expect("all fail").to_string();
        assert!(error.contains("left the domain"), "{error}");
    }
}

#[test]
fn the_end_of_a_rank_ends_the_others() {
    let scene = dam(2, pcisph());
    let steps = AtomicUsize::new(3);
    let mut errors = on_ranks(&scene, 2, |world| {
        // One takes two steps more than the other.
        run(world, steps.fetch_add(2, Relaxed)).1
    });
    errors.sort_by_key(Option::is_some);
    assert_eq!(errors[0], None);
    let error = errors[1].as_ref().expect("it cannot go on");
    assert!(matches!(error.cause, FailureCause::RanksLost(_)), "{error}");
    assert_eq!(error.step, 4);
}

#[test]
fn a_scene_that_does_not_run_on_ranks_is_refused_by_name() {
    let scene = Scene {
        executor: Executor::Parallel,
        ..dam(2, sesph())
    };
    for rank in Local::team(2) {
        let mut world = World::new();
        let refused = install_on_rank(&mut world, &scene, Arc::new(rank));
        let Err(InstallError::Unsupported(unsupported)) = refused else {
            panic!("{refused:?}");
        };
        assert_eq!(unsupported.what, "executor: Parallel");
        assert!(!world.contains_resource::<Execution>());
    }
}
