//! What a scene would run, without running it.

use glam::Vec4;

use super::{
    install::{InstallError, order_of},
    phase::Phase,
    schedule::planned,
    start::{self, StartDensity},
};
use crate::{
    boundary::{self, BoundarySamples},
    execution::Execution,
    index,
    material::Material,
    pressure::warm_start,
    scene::{IndexStructure, Neighbours, PressureMethod, Scene, TimeStep, shapes},
    time_step::{self, adaptive, roll_back::KEPT_BYTES},
};

/// The plan of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Fluid particles.
    pub particles: usize,
    /// Boundary particles.
    pub boundary_particles: usize,
    /// Support radius h [m].
    pub support_radius: f32,
    /// Mass of a particle [kg; kg/m in 2-D].
    pub particle_mass: f32,
    /// Phases with their stages, in order.
    pub phases: Vec<(Phase, Vec<String>)>,
    /// Memory by what it holds [bytes a fluid particle].
    pub bytes_per_particle: Vec<(String, f64)>,
    /// The same [bytes a boundary particle].
    pub bytes_per_boundary_particle: Vec<(String, f64)>,
    /// What the time step may be at most by each cause [s].
    pub time_step_limits: Vec<(String, f32)>,
    /// Neighbours of a particle within the fluid.
    pub expected_neighbours: f32,
    /// How dense the fluid is at the start, unless there are too many particles to ask.
    pub start_density: Option<StartDensity>,
}

/// Plans a scene.
pub fn plan(scene: &Scene) -> Result<Plan, InstallError> {
    let order = order_of(scene)?;
    let material = Material::new(scene);
    let seeds = shapes::fluid_particles(scene);
    let samples = boundary::sample(scene)?;
    // What a run would refuse, a plan refuses.
    let execution = Execution::new(1)?;
    let index = |positions: Vec<Vec4>| index::build(scene).rebuild(&positions, &execution);
    index(seeds.iter().map(|seed| seed.position.extend(0.0)).collect())
        .map_err(InstallError::Fluid)?;
    let walls =
        BoundarySamples::new(scene, &samples, &execution).map_err(InstallError::Boundary)?;
    let walls = (!samples.is_empty()).then_some(&walls);
    let start_density = start::density(scene, walls, &execution)?;
    let expected_neighbours = material
        .kernel
        .lattice(scene.dimension, scene.spacing)
        .count() as f32
        - 1.0;
    Ok(Plan {
        particles: seeds.len(),
        boundary_particles: samples.len(),
        support_radius: scene.support_radius(),
        particle_mass: material.particle_mass,
        phases: planned(&order, scene),
        bytes_per_particle: bytes_per_particle(scene, expected_neighbours),
        bytes_per_boundary_particle: bytes_per_boundary_particle(scene),
        time_step_limits: time_step_limits(
            scene,
            seeds.iter().map(|seed| seed.position.to_array()),
        ),
        expected_neighbours,
        start_density,
    })
}

fn bytes_per_particle(scene: &Scene, neighbours: f32) -> Vec<(String, f64)> {
    let mut bytes = vec![
        // Four columns of 32 bytes, 8 bytes of change ticks each, and the entity's own entries.
        (
            "tables: position, velocity, density, pressure".to_owned(),
            32.0 + 4.0 * 8.0 + 24.0,
        ),
        (
            "packed columns and accelerations".to_owned(),
            2.0 * 16.0 + 2.0 * 4.0 + 2.0 * 12.0,
        ),
        ("spatial index".to_owned(), index_bytes(scene)),
    ];
    if scene.neighbours == Neighbours::Stored {
        let lists = if scene.boundaries.is_empty() {
            1.0
        } else {
            2.0
        };
        bytes.push((
            "neighbour lists".to_owned(),
            f64::from(neighbours) * 4.0 * 1.01 + 6.0 * lists,
        ));
        // Filled up to whole vectors, half of one on average.
        bytes.push((
            "slopes of the kernel".to_owned(),
            (f64::from(neighbours) + 4.0) * 4.0 * 9.0 / 8.0,
        ));
    }
    if !scene.boundaries.is_empty() {
        bytes.push(("sums over the walls".to_owned(), 16.0));
    }
    if let TimeStep::Adaptive(_) = scene.time_step {
        bytes.push(("state to go back to".to_owned(), KEPT_BYTES as f64));
    }
    if warm_start::starts_from_means(scene) {
        // A column with its change ticks, packed once; and once more to go back to.
        let kept = if let TimeStep::Adaptive(_) = scene.time_step {
            4.0
        } else {
            0.0
        };
        bytes.push(("mean pressures".to_owned(), 4.0 + 8.0 + 4.0 + kept));
    }
    match scene.pressure {
        PressureMethod::Sesph(_) => {}
        PressureMethod::Pcisph(_) => {
            bytes.push((
                "predicted positions and densities, responses".to_owned(),
                24.0,
            ));
        }
        PressureMethod::Iisph(_) => {
            bytes.push((
                "predicted velocities, rates, responses, terms".to_owned(),
                32.0,
            ));
        }
        PressureMethod::Dfsph(_) => bytes.push((
            "predicted velocities, rates, responses, terms, impulses, numbers of neighbours"
                .to_owned(),
            44.0,
        )),
    }
    bytes
}

/// What the scene's spatial index takes, measured with eight particles a cell [bytes a particle]; the dense structures
/// take 4 bytes more for every empty cell of the box, spatial hashing two hash cells of 1.5 times a full cell.
fn index_bytes(scene: &Scene) -> f64 {
    match scene.index.structure {
        IndexStructure::UniformGrid => 25.0,
        IndexStructure::IndexSort => 37.0,
        IndexStructure::ZIndexSort => 33.0,
        IndexStructure::SpatialHashing => 216.0,
        IndexStructure::CompactHashing => 77.0,
        IndexStructure::BruteForce => 16.0,
    }
}

fn bytes_per_boundary_particle(scene: &Scene) -> Vec<(String, f64)> {
    vec![
        // Three columns of 28 bytes, 8 bytes of change ticks each, and the entity's own entries.
        (
            "tables: position, normal, volume".to_owned(),
            28.0 + 3.0 * 8.0 + 24.0,
        ),
        ("packed positions and normals".to_owned(), 16.0 + 12.0),
        ("spatial index".to_owned(), index_bytes(scene)),
    ]
}

/// Limits at the fastest that this scene's water can get by falling through its whole height.
fn time_step_limits(
    scene: &Scene,
    positions: impl Iterator<Item = [f32; 3]>,
) -> Vec<(String, f32)> {
    let along = scene.gravity.normalize_or_zero();
    let heights = positions.map(|x| -along.dot(x.into()));
    let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    let gravity = scene.gravity.length();
    let start = scene.max_initial_speed();
    let fall = (2.0 * gravity * (high - low).max(0.0) + start * start).sqrt();
    let h = scene.support_radius();
    let [speed, force] = match scene.time_step {
        TimeStep::Cfl(cfl) => time_step::motion_limits(cfl.factor, h, fall, gravity),
        // The hard limit: nothing moves more than h/2.
        TimeStep::Fixed(_) => time_step::motion_limits(0.5, h, fall, gravity),
        TimeStep::Adaptive(_) => adaptive::motion_limits(h, fall, gravity),
    };
    let mut limits = vec![
        (
            format!(
                "{} at {fall:.2} m/s, the fall through the fluid's height",
                speed.0
            ),
            speed.1,
        ),
        (format!("{} of gravity", force.0), force.1),
    ];
    limits.extend(
        time_step::constant_limits(scene)
            .into_iter()
            .map(|(name, dt)| (name.to_owned(), dt)),
    );
    limits.retain(|limit| limit.1.is_finite());
    limits
}
