//! Checkpoints: a resumed run has the same bits as an uninterrupted one, and no other file is accepted as a checkpoint.

use std::fs;

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Simulation, StepReport,
    checkpoint::{self, Checkpoint, CheckpointError},
    index::BoundarySamples,
    scene::{IndexStructure, PressureMethod, Scene, TimeStep},
    state::particle::{Fluid, ParticleId, Position, Velocity},
    time_step::AdaptiveTimeStep,
};

use crate::common::{methods, pcisph, run};

/// 15 × 20 particles in 2-D that fall into the corner of a tank, with viscosity and surface tension.
pub(super) fn scene(pressure: PressureMethod, structure: IndexStructure, time_step: &str) -> Scene {
    let text = format!(
        r#"(
            name: "corner",
            dimension: 2,
            spacing: 0.02,
            fluid: (
                viscosity: Artificial(alpha: 0.05, sound_speed: 20),
                surface_tension: BeckerTeschner(kappa: 0.01),
            ),
            bodies: [(
                shape: Box(min: (0, 0, 0), max: (0.3, 0.4, 0)),
                velocity: (0.5, -1, 0),
                jitter: (amplitude: 0.05, seed: 1),
            )],
            boundaries: [Tank(min: (-0.02, -0.02, 0), max: (0.6, 0.6, 0))],
            gauges: [
                (name: "level", kind: Height(at: (0.1, 0, 0)), every: Seconds(0.003), window: 0.004),
                (name: "energy", kind: Energy),
            ],
            time_step: {time_step},
            reorder_interval: 7,
        )"#
    );
    let mut scene = Scene::parse(&text, "corner.ron", &[]).expect("a scene");
    scene.pressure = pressure;
    scene.index.structure = structure;
    scene
}

/// The parts of a report that do not depend on the machine.
fn figures(mut report: StepReport) -> StepReport {
    report.phase_seconds = Default::default();
    report
}

/// Numbers and bits of positions and velocities in the order of the rows, and the readings of the gauges.
fn bits(world: &mut World) -> (Vec<[u32; 7]>, String) {
    let mut fluid = world.query_filtered::<(&ParticleId, &Position, &Velocity), With<Fluid>>();
    let of = |(id, x, v): (&ParticleId, &Position, &Velocity)| {
        let [x, v] = [x.0, v.0].map(|x| x.to_array().map(f32::to_bits));
        [id.get(), x[0], x[1], x[2], v[0], v[1], v[2]]
    };
    let rows = fluid.iter(world).map(of).collect();
    let gauges = world.resource::<overfall::gauge::Gauges>();
    let readings: Vec<_> = gauges
        .iter()
        .map(|gauge| gauge.readings().collect::<Vec<_>>())
        .collect();
    (rows, format!("{readings:?}"))
}

pub(super) fn reports(simulation: &mut Simulation, steps: usize) -> Vec<StepReport> {
    (0..steps)
        .map(|_| figures(simulation.step().unwrap_or_else(|error| panic!("{error}"))))
        .collect()
}

/// A new simulation from the checkpoint of another, through its bytes, with this number of threads.
fn resumed(simulation: &mut Simulation, threads: usize) -> Simulation {
    let bytes = Checkpoint::of(simulation.world_mut())
        .expect("a checkpoint")
        .to_bytes();
    let checkpoint = Checkpoint::read(&mut &bytes[..]).expect("the same");
    let scene = checkpoint.scene().expect("its scene");
    let mut resumed = Simulation::with_threads(&scene, threads).expect("a scene that runs");
    checkpoint.restore(resumed.world_mut()).expect("its state");
    resumed
}

/// Stops after some steps and compares the following steps. Returns whether one of them was rolled back.
#[track_caller]
fn assert_goes_on(scene: &Scene, before: usize, after: usize) -> bool {
    let mut whole = Simulation::with_threads(scene, 1).expect("a scene that runs");
    reports(&mut whole, before);
    let mut part = resumed(&mut whole, 2);
    let what = format!(
        "{:?} {:?} {:?}",
        scene.pressure, scene.index.structure, scene.time_step
    );
    assert!(
        bits(part.world_mut()) == bits(whole.world_mut()),
        "at once: {what}"
    );
    let [expected, found] = [&mut whole, &mut part].map(|run| reports(run, after));
    assert_eq!(found, expected, "{what}");
    assert!(bits(part.world_mut()) == bits(whole.world_mut()), "{what}");
    expected.iter().any(|report| report.taken_back.is_some())
}

pub(super) const STEP_CONTROLS: [&str; 3] = [
    "Fixed(0.0005)",
    "Cfl(factor: 0.3, min: 1e-5, max: 0.002)",
    "Adaptive(density_error: 0.01)",
];

#[test]
fn a_resumed_run_has_the_bits_of_the_uninterrupted_one() {
    for method in methods() {
        for structure in IndexStructure::ALL {
            for control in STEP_CONTROLS {
                let scene = scene(method, structure, control);
                // One step that is no multiple of the reorder interval 7, and one that is.
                assert_goes_on(&scene, 10, 12);
            }
        }
        let scene = scene(method, IndexStructure::CompactHashing, STEP_CONTROLS[1]);
        assert_goes_on(&scene, 14, 12);
        assert_goes_on(&scene, 0, 8);
    }
}

#[test]
fn steps_that_are_taken_back_go_back_past_the_checkpoint() {
    let scene = scene(
        pcisph(),
        IndexStructure::CompactHashing,
        "Adaptive(density_error: 0.001, max_density_error: 0.02, initial: 0.004)",
    );
    let mut whole = Simulation::with_threads(&scene, 1).expect("a scene that runs");
    let back = (1..200).find(|_| whole.step().is_ok_and(|report| report.taken_back.is_some()));
    let back = back.expect("a step that is taken back");
    for before in [back - 1, back] {
        let was_back = assert_goes_on(&scene, before, 4);
        assert!(was_back || before == back);
    }
    assert!(whole.world().contains_resource::<AdaptiveTimeStep>());
}

#[test]
fn particles_that_came_and_went_are_those_of_the_checkpoint() {
    for structure in IndexStructure::ALL {
        let scene = scene(pcisph(), structure, STEP_CONTROLS[1]);
        let mut whole = Simulation::with_threads(&scene, 1).expect("a scene that runs");
        run(&mut whole, 5);
        let world = whole.world_mut();
        let mut fluid = world.query_filtered::<Entity, With<Fluid>>();
        let some: Vec<Entity> = fluid.iter(world).step_by(2).collect();
        some.into_iter().for_each(|particle| {
            world.despawn(particle);
        });
        for k in 0..3 {
            let place = glam::Vec3::new(0.4 + 0.02 * k as f32, 0.4, 0.0);
            world.spawn((Fluid, Position(place)));
        }
        run(&mut whole, 4);
        let mut part = resumed(&mut whole, 2);
        let [expected, found] = [&mut whole, &mut part].map(|run| reports(run, 12));
        assert_eq!(found, expected, "{structure:?}");
        assert!(
            bits(part.world_mut()) == bits(whole.world_mut()),
            "{structure:?}"
        );
        let [a, b] = [&mut whole, &mut part].map(|run| {
            let particle = run.world_mut().spawn(Fluid).id();
            run.world().get::<ParticleId>(particle).map(|id| id.get())
        });
        assert_eq!(a, b, "the next number");
    }
}

#[test]
fn a_hosts_particle_keeps_what_the_host_gave_it() {
    #[derive(Component)]
    struct Mine;
    let scene = scene(pcisph(), IndexStructure::UniformGrid, STEP_CONTROLS[0]);
    let mut simulation = Simulation::with_threads(&scene, 1).expect("a scene that runs");
    run(&mut simulation, 3);
    let world = simulation.world_mut();
    let mut saved = Vec::new();
    checkpoint::write(world, &mut saved).expect("a checkpoint");
    let mut fluid = world.query_filtered::<(Entity, &ParticleId), With<Fluid>>();
    let marked = fluid
        .iter(world)
        .find(|(_, id)| id.get() == 17)
        .expect("a particle")
        .0;
    world.entity_mut(marked).insert(Mine);
    run(&mut simulation, 9);
    checkpoint::restore(simulation.world_mut(), &mut &saved[..]).expect("the state before");
    assert!(simulation.world().get::<Mine>(marked).is_some());
    assert_eq!(
        simulation
            .world()
            .get::<ParticleId>(marked)
            .map(|id| id.get()),
        Some(17)
    );
    assert!((simulation.time() - 3.0 * 0.0005).abs() < 1e-9);
}

#[test]
fn between_two_runs_of_a_rare_stage_there_is_no_checkpoint() {
    let folder = tempfile::tempdir().expect("a folder");
    let order = folder.path().join("order.ron");
    fs::write(
        &order,
        r#"(stages: [Run("gather"), Run("rebuild_index"), Every(3, [Run("find_neighbours")]), Run("density"),
            Run("clear_forces"), Run("gravity"), Run("wall_pressure"), Run("viscosity"), Run("surface_tension"),
            Run("pressure"), Run("integrate"), Run("reorder")], allow_stale: true)"#,
    )
    .expect("a file");
    let mut scene = scene(pcisph(), IndexStructure::CompactHashing, STEP_CONTROLS[1]);
    scene.order = Some(order.display().to_string());
    // Rows keep their particles between two searches.
    scene.reorder_interval = 6;
    let mut simulation = Simulation::with_threads(&scene, 1).expect("a scene that runs");
    run(&mut simulation, 4);
    assert_eq!(checkpoint::steps_until_possible(simulation.world_mut()), 2);
    let error = Checkpoint::of(simulation.world_mut()).expect_err("no checkpoint");
    assert!(
        matches!(error, CheckpointError::BetweenRuns { steps: 2 }),
        "{error}"
    );
    for before in [6, 9] {
        assert_goes_on(&scene, before, 8);
    }
}

#[test]
fn a_checkpoint_of_another_run_is_refused_and_changes_nothing() {
    let scene = scene(pcisph(), IndexStructure::CompactHashing, STEP_CONTROLS[1]);
    let mut simulation = Simulation::with_threads(&scene, 1).expect("a scene that runs");
    run(&mut simulation, 3);
    let checkpoint = Checkpoint::of(simulation.world_mut()).expect("a checkpoint");
    let other = Scene {
        gravity: glam::Vec3::new(0.0, -1.6, 0.0),
        ..scene.clone()
    };
    let mut other = Simulation::with_threads(&other, 1).expect("a scene that runs");
    let before = bits(other.world_mut());
    let error = checkpoint
        .restore(other.world_mut())
        .expect_err("another scene");
    assert!(error.to_string().contains("gravity"), "{error}");
    assert!(bits(other.world_mut()) == before && other.time() == 0.0);
    // Its duration and its output may differ.
    let mut longer = scene;
    longer.duration = 7.0;
    longer.output.pictures = !longer.output.pictures;
    let mut longer = Simulation::with_threads(&longer, 1).expect("a scene that runs");
    checkpoint
        .restore(longer.world_mut())
        .expect("the same run");
    assert_eq!(longer.time(), simulation.time());
    let error = checkpoint.restore(&mut World::new()).expect_err("no scene");
    assert!(matches!(error, CheckpointError::NotInstalled), "{error}");
}

#[test]
fn a_file_is_written_whole_and_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.checkpoint");
    let scene = scene(pcisph(), IndexStructure::CompactHashing, STEP_CONTROLS[1]);
    let mut simulation = Simulation::with_threads(&scene, 1).expect("a scene that runs");
    run(&mut simulation, 2);
    simulation.checkpoint(&file).expect("a checkpoint");
    run(&mut simulation, 2);
    simulation.checkpoint(&file).expect("a newer one");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    let mut resumed = Simulation::resume_with_threads(&file, 2).expect("a run");
    assert!(matches!(scene.time_step, TimeStep::Cfl(_)));
    let [expected, found] = [&mut simulation, &mut resumed].map(|run| reports(run, 3));
    assert_eq!(found, expected);
    assert!(Simulation::resume(&folder.path().join("nothing")).is_err());
    let error = simulation
        .checkpoint(&folder.path().join("no/folder"))
        .expect_err("no folder");
    assert!(error.to_string().contains("no/folder"), "{error}");
}

/// The same, shaken, drawn to a point, and pushed by a piston from a table and a box that turns.
fn driven(pressure: PressureMethod, time_step: &str, folder: &std::path::Path) -> Scene {
    let file = |name: &str, text: &str| {
        let file = folder.join(name);
        fs::write(&file, text).expect("a file");
        format!("{:?}", file.display().to_string())
    };
    let piston = file("piston.csv", "t,x,v\n0,0,0\n0.02,0.01,0.5\n1,0.2,0.1\n");
    let shake = file("shake.csv", "t,ax,ay\n0,0,0\n0.01,3,1\n0.02,-3,0\n");
    let text = format!(
        r#"(
            name: "driven",
            dimension: 2,
            spacing: 0.02,
            fluid: (viscosity: Laminar(kinematic_viscosity: 0.001)),
            body_forces: [Central(center: (0.2, 0.2, 0), linear: 20), Table(file: {shake})],
            bodies: [(
                shape: Box(min: (0, 0, 0), max: (0.3, 0.2, 0)),
                velocity_field: Rotation(center: (0.15, 0.1, 0), angular_velocity: (0, 0, -1)),
            )],
            boundaries: [
                Tank(min: (-0.1, 0, 0), max: (0.6, 0.5, 0)),
                Box(min: (-0.1, 0, 0), max: (0, 0.4, 0), name: "piston",
                    motion: Table(file: {piston}, direction: (1, 0, 0))),
                Box(min: (0.4, 0.1, 0), max: (0.44, 0.3, 0),
                    motion: Rotation(center: (0.42, 0.2, 0), angular_velocity: (0, 0, 5))),
            ],
            gauges: [
                (name: "push", kind: Force(boundary: "piston")),
                (name: "energy", kind: Energy),
            ],
            time_step: {time_step},
            reorder_interval: 7,
        )"#
    );
    let mut scene = Scene::parse(&text, "driven.ron", &[]).expect("a scene");
    scene.pressure = pressure;
    scene
}

/// Where walls are: as the loops see them, in their order, and the components.
fn walls(world: &mut World) -> [Vec<[u32; 3]>; 2] {
    let bits = |x: Vec3| x.to_array().map(f32::to_bits);
    let samples = world.resource::<BoundarySamples>().points().iter();
    let samples = samples.map(|x| bits(x.truncate())).collect();
    let mut walls = world.query_filtered::<&Position, With<overfall::state::particle::Boundary>>();
    // A query goes through its tables in the order of a hash map.
    let mut places: Vec<_> = walls.iter(world).map(|x| bits(x.0)).collect();
    places.sort_unstable();
    [samples, places]
}

#[test]
fn walls_and_forces_go_on_where_they_were() {
    let folder = tempfile::tempdir().expect("a folder");
    for method in methods() {
        for control in STEP_CONTROLS {
            let scene = driven(method, control, folder.path());
            assert_goes_on(&scene, 10, 12);
            assert_goes_on(&scene, 0, 3);
        }
    }
    let scene = driven(pcisph(), STEP_CONTROLS[0], folder.path());
    let mut whole = Simulation::with_threads(&scene, 1).expect("a scene that runs");
    let at_start = walls(whole.world_mut());
    reports(&mut whole, 9);
    let mut part = resumed(&mut whole, 2);
    // Samples are moved at the start of a step.
    assert_eq!(reports(&mut part, 1), reports(&mut whole, 1));
    let now = walls(whole.world_mut());
    assert_ne!(now, at_start);
    let [samples, places] = walls(part.world_mut());
    assert!(places == now[1], "components are elsewhere");
    let moved = samples.iter().zip(&now[0]).filter(|(a, b)| a != b).count();
    assert!(
        samples == now[0],
        "{moved} of {} samples are elsewhere",
        samples.len()
    );
}
