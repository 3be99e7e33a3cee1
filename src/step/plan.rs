//! What a scene would run, without running it. Memory is taken for some particles at a time, to ask how dense they
//! start.

use glam::{DVec3, Vec3};

use super::{
    error::{InstallError, StartDensity},
    limits, memory,
    order::{Flow, order_of},
    start_density, start_slabs, warnings,
};
use crate::{
    boundary, index,
    registry::Stages,
    sampling,
    scene::{Scene, TimeStep, shapes},
    state::{Execution, Material, Phase},
};

/// Candidates up to which a mesh is sampled to know how many particles it has: 30 MB.
const FEW_CANDIDATES: f64 = 5e5;

/// The plan of a scene.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Plan {
    /// Fluid particles.
    pub particles: usize,
    /// Boundary particles.
    pub boundary_particles: usize,
    /// Whether that is an estimate: meshes with many particles are not sampled for a plan.
    pub boundary_is_estimate: bool,
    /// The box around the fluid at the start \[m].
    pub fluid_box: (Vec3, Vec3),
    /// The box around fluid and boundaries \[m].
    pub whole_box: (Vec3, Vec3),
    /// Support radius h \[m].
    pub support_radius: f32,
    /// Mass of a particle \[kg; kg/m in 2-D].
    pub particle_mass: f32,
    /// Phases with their stages, in order.
    pub phases: Vec<(Phase, Vec<String>)>,
    /// The flow of data through the stages.
    pub flow: Vec<Flow>,
    /// Memory by what holds it \[bytes per fluid particle].
    pub bytes_per_particle: Vec<(&'static str, f64)>,
    /// The same \[bytes per boundary particle].
    pub bytes_per_boundary_particle: Vec<(&'static str, f64)>,
    /// What the time step may be at most by each cause \[s].
    pub time_step_limits: Vec<(String, f32)>,
    /// Neighbours of a particle within the fluid.
    pub expected_neighbours: f32,
    /// Steps until the scene's end, if all are as long as the limits at the fastest fall allow.
    pub expected_steps: f64,
    /// Memory that the run takes at most, tables of a dense index included \[bytes].
    pub memory: f64,
    /// What is allowed, but looks like a slip.
    pub warnings: Vec<String>,
    /// How dense the fluid is at the start, unless meshes have too many samples to ask.
    pub start_density: Option<StartDensity>,
}

/// Plans a scene. Refuses what [`install`](super::install) would refuse.
pub fn plan(scene: &Scene) -> Result<Plan, InstallError> {
    let size = scene.checked_size()?;
    let order = order_of(scene, &Stages::default())?;
    let need = memory::check(scene, &size)?;
    let material = Material::new(scene);
    let (mut particles, mut low, mut high) = (0, Vec3::INFINITY, Vec3::NEG_INFINITY);
    shapes::for_each_particle(scene, |seed| {
        particles += 1;
        (low, high) = (low.min(seed.position), high.max(seed.position));
    });
    index::table_bytes(scene, low.as_dvec3(), high.as_dvec3()).map_err(InstallError::Fluid)?;
    let (start_density, sampled) = if start_density::is_small(&size) {
        let (density, samples) = ask(scene)?;
        (Some(density), Some(samples))
    } else {
        let execution = Execution::new(1)?;
        let density = start_slabs::of_large(scene, &size, None, &execution)?;
        (density, None)
    };
    let is_exact = sampled.is_some() || size.boundary == 0.0 || size.candidates <= FEW_CANDIDATES;
    let mut boundary_particles = sampled.unwrap_or(size.boundary as usize);
    if is_exact && sampled.is_none() {
        boundary_particles = 0;
        sampling::for_each_sample(scene, &mut |_| boundary_particles += 1)?;
    }
    let expected_neighbours = memory::expected_neighbours(scene, &material);
    let limits = limits::of(scene, low, high);
    let single = |(low, high): (DVec3, DVec3)| (low.as_vec3(), high.as_vec3());
    Ok(Plan {
        particles,
        boundary_particles,
        boundary_is_estimate: !is_exact,
        fluid_box: (low, high),
        whole_box: single(size.whole_box),
        support_radius: scene.support_radius(),
        particle_mass: material.particle_mass,
        phases: order.lines(),
        flow: order.flow(),
        bytes_per_particle: Stages::default().bytes(scene, expected_neighbours),
        bytes_per_boundary_particle: memory::bytes_per_boundary_particle(scene),
        expected_steps: f64::from(scene.duration) / f64::from(expected_step(scene, &limits)),
        time_step_limits: limits,
        expected_neighbours,
        memory: need.most,
        warnings: warnings::of_size(scene, &size),
        start_density,
    })
}

/// How dense the fluid is at the start, and how many boundary particles there are.
fn ask(scene: &Scene) -> Result<(StartDensity, usize), InstallError> {
    let execution = Execution::new(1)?;
    let samples = sampling::sample(scene)?;
    let walls = boundary::pack(scene, &samples, &execution).map_err(InstallError::Boundary)?;
    let walls = (!samples.is_empty()).then_some(&walls);
    let seeds = shapes::fluid_particles(scene);
    let density = start_density::of(scene, &seeds, walls, &execution)?;
    Ok((density, samples.len()))
}

/// The time step at the fastest fall \[s].
fn expected_step(scene: &Scene, limits: &[(String, f32)]) -> f32 {
    let least = limits
        .iter()
        .map(|limit| limit.1)
        .fold(f32::INFINITY, f32::min);
    match scene.time_step {
        TimeStep::Fixed(dt) => dt,
        TimeStep::Cfl(cfl) => least.clamp(cfl.min, cfl.max),
        TimeStep::Adaptive(scheme) => least.clamp(scheme.min, scheme.max),
    }
}
