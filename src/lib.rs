//! overfall simulates fluids by smoothed particle hydrodynamics: particles are entities of [`bevy_ecs`], a step is a
//! schedule of systems.
//!
//! It implements Ihmsen, Akinci, Becker and Teschner, *A Parallel SPH Implementation on Multi-Core CPUs*, Computer
//! Graphics Forum 30 (2011), "the paper" below. SI units everywhere.
//!
//! ```
//! use overfall::{Simulation, scene::Scene};
//!
//! let scene = r#"(
//!     name: "drop of water",
//!     spacing: 0.1,
//!     bodies: [(shape: Sphere(center: (0, 1, 0), radius: 0.3))],
//!     boundaries: [Plane(center: (0, 0, 0), normal: (0, 1, 0), half_size: 1)],
//! )"#;
//! let scene = Scene::parse(scene, "drop.ron", &[]).expect("a scene");
//! let mut simulation = Simulation::new(&scene).expect("threads");
//! let report = simulation.step().expect("a step");
//! assert!(report.time > 0.0 && report.max_density_error < 0.01);
//! ```
//!
//! # In a host
//!
//! [`Simulation`] has a world of its own. A host with a [`World`](bevy_ecs::world::World) calls [`install`], then
//! [`take_step`] or, in a game's frame, [`advance`]; [`uninstall`] takes the scene out again. In an `App` of bevy
//! `FluidPlugin` does so (feature `bevy_app`). [`Snapshot`](gauge::Snapshot) answers what the fluid is like at any point.
//!
//! A host's systems join the schedule [`Step`], ordered against [`Phase`]s, or are stages of their own
//! ([`Stages`](step::Stages)), which an order file may name. What may be written when:
//!
//! | when | what a host may write |
//! | --- | --- |
//! | between steps, or before `Phase::RebuildIndex` | all components of particles; spawn, despawn, tag, by commands too; resources; with boundary particles moved, then [`boundary::refresh_boundary`] |
//! | after `Phase::Forces`, before `Phase::Pressure` | add to [`Accelerations`](step::Accelerations), by row: [`Rows`](step::Rows) says whose |
//! | after `Phase::RebuildIndex`, before `Phase::Integrate` | nothing of the particles: the step has read them and will write them |
//! | after `Phase::Integrate`, before `Phase::Reorder` | components of particles, which the next step starts from; no spawning or tagging |
//! | after `Phase::Reorder` | all again |
//!
//! What is written elsewhere is refused, not lost: the step fails with
//! [`FailureCause::Overwritten`](step::FailureCause::Overwritten) or
//! [`ParticlesChanged`](step::FailureCause::ParticlesChanged), which name component and particle, and the world keeps the
//! state before it. A system that no order sets apart from the engine's is
//! [`FailureCause::Schedule`](step::FailureCause::Schedule), with the names of both.
//!
//! Modules that are not in this documentation (`pub` for benches and tests) are internal and change without notice.
//!
//! # The map
//!
//! What a run is made of:
//!
//! | module | what is in it |
//! | --- | --- |
//! | [`scene`] | the RON scene: types, checks, shapes into particles |
//! | [`particle`] | the components of a particle |
//! | [`loading`] | from a text to a checked scene: overrides, errors with their places |
//! | [`state`] | columns, clock, constants, failure, threads: plain data that all systems share |
//! | [`kernel`], [`lattice`] | the smoothing kernel; waves on a lattice, and walls beside it |
//! | [`registry`] | the lists of all stages and columns, each declared beside its code |
//! | [`step`] | phases, stages, the order as data, the schedule; [`Simulation`] and [`install`] |
//!
//! A step, phase by phase ([`Phase`]):
//!
//! | phase | module | paper |
//! | --- | --- | --- |
//! | `RebuildIndex` | [`registry`]: tables into columns; [`index`]: which particles are in which cell | 4.1–4.5 |
//! | `FindNeighbours` | [`neighbours`]: lists, or neighbours found on the spot | 5.3.1 |
//! | `Density` | [`density`] | eq. 1 |
//! | `Forces` | [`force`]: gravity, viscosity, tension; before them DFSPH's [divergence](pressure::dfsph) | 5 |
//! | `Pressure` | [`pressure`]: [SESPH](pressure::sesph), eqs. 4, 5 | 5.1 |
//! | | [PCISPH](pressure::pcisph), Algorithm 2; [IISPH](pressure::iisph), [DFSPH](pressure::dfsph) | 5.2 |
//! | `Integrate` | [`integrate`](mod@integrate): motion, guard; [`boundary::contact`]; [`time_step`] | 5 |
//! | `Reorder` | [`reorder`](mod@reorder): rows along the Z-curve | 4.5.4 |
//! | `Observe` | [`step::StepReport`]: what the step did | 6 |
//!
//! What they stand on:
//!
//! | module | what is in it |
//! | --- | --- |
//! | [`pairs`] | sums over neighbours: the one loop of all physics; slopes of the kernel, kept for the step |
//! | [`sampling`] | surfaces of walls into particles |
//! | [`boundary`] | walls in a step: volumes, their sums around the fluid, contact, direct forcing |
//! | [`mesh`] | triangle meshes: files, distances, rays |
//! | [`simd`] | eight lanes, chosen at run time; the only `unsafe` |
//! | [`input`] | files that a user names, read with a limit |
//! | [`measure`] | what experiments and analytic solutions give, too: front, height, semi-axes, line of pressures |
//! | [`gauge`] | instruments of a scene: pressure, velocity, height, front, flux, force, energies |
//! | [`output`] | frames, series, history, summary, pictures |
//! | [`checkpoint`] | the state of a run in a file, from which it goes on bit for bit |
//! | [`study`] | variants of a scene measured side by side: the paper's tables, speed against error |
//! | [`validate`] | cases with known answers, every pressure method against them |

// What is hidden from the documentation is internal: benches and tests use it.
pub mod boundary;
pub mod checkpoint;
#[doc(hidden)]
pub mod density;
#[doc(hidden)]
pub mod force;
pub mod gauge;
#[doc(hidden)]
pub mod index;
#[doc(hidden)]
pub mod input;
#[doc(hidden)]
pub mod integrate;
#[doc(hidden)]
pub mod kernel;
#[doc(hidden)]
pub mod lattice;
#[doc(hidden)]
pub mod loading;
pub mod measure;
mod memory;
#[doc(hidden)]
pub mod mesh;
#[doc(hidden)]
pub mod neighbours;
pub mod output;
#[doc(hidden)]
pub mod pairs;
#[cfg(feature = "bevy_app")]
mod plugin;
#[doc(hidden)]
pub mod pressure;
#[doc(hidden)]
pub mod registry;
#[doc(hidden)]
pub mod reorder;
#[doc(hidden)]
pub mod sampling;
pub mod scene;
#[doc(hidden)]
pub mod simd;
#[doc(hidden)]
pub mod state;
pub mod step;
pub mod study;
#[doc(hidden)]
pub mod time_step;
pub mod validate;

pub use loading::Override;
#[cfg(feature = "bevy_app")]
pub use plugin::{FluidPlugin, FluidStatus, FluidStopped, Pace};
#[doc(inline)]
pub use state::{Execution, particle};
pub use step::{
    Advance, Phase, Plan, Simulation, Step, StepError, StepOutcome, StepReport, advance, install,
    plan, take_step, uninstall,
};

/// The README's commands and code, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
