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
//! To learn it, page by page: [the step](guide::step), [the data](guide::data), [embedding](guide::embedding),
//! [orders](guide::orders), [accuracy](guide::accuracy), [limits](guide::limits).
//!
//! # In a host
//!
//! [`Simulation`] has a world of its own. A host with a [`World`](bevy_ecs::world::World) calls [`install`], then
//! [`take_step`] or, once per frame of a game, [`advance`]; [`uninstall`] removes the scene again. In a bevy `App`,
//! `FluidPlugin` does this (feature `bevy_app`). A [`Snapshot`](gauge::Snapshot) answers queries of the fluid at any
//! point. Several worlds may share one fluid ([`install_on_rank`]).
//!
//! Systems of a host join the schedule [`Step`], ordered relative to [`Phase`]s, or are stages of their own
//! ([`Stages`](step::Stages)), which an order file may name. A host may write:
//!
//! - Between steps: the constants in [`Material`](step::Material), and [`Clock`](step::Clock).
//! - Between steps, before `Phase::RebuildIndex` and after `Phase::Reorder`: all components of particles. It may also
//!   spawn, despawn and tag particles, with commands too. After moving boundary particles it calls
//!   [`boundary::refresh_boundary`].
//! - After `Phase::Forces` and before `Phase::Pressure`: it may add to [`Accelerations`](step::Accelerations), by row;
//!   [`Rows`](step::Rows) maps rows to particles. What it adds before is lost, because `Phase::Forces` begins at zero;
//!   what it adds later moves particles, and no pressure answers.
//! - After `Phase::RebuildIndex` and before `Phase::Integrate`: nothing of the particles, because the step has read
//!   them and will write them.
//! - After `Phase::Integrate` and before `Phase::Reorder`: components of particles, from which the next step starts. It
//!   may not spawn, despawn or tag.
//!
//! All other columns, lists and indexes can only be read: there is no public way to write them, and a step in which one
//! is exchanged with another world's fails with [`ResourceWritten`](step::FailureCause::ResourceWritten). If the fluid
//! had its new state by then, the next one fails. Other writes to components and constants are refused and never lost
//! silently: the step fails with [`FailureCause::Overwritten`](step::FailureCause::Overwritten) or
//! [`ParticlesChanged`](step::FailureCause::ParticlesChanged), which name the component and the particle, and the world
//! keeps the state before the step. If a host's system conflicts with one of the engine's and has no order relative to
//! it, the step fails with [`FailureCause::Schedule`](step::FailureCause::Schedule), which names both systems.
//!
//! Modules that are missing in this documentation (`pub` for benches and tests) are internal and change without notice.
//!
//! # The map
//!
//! The parts of a run:
//!
//! | module | content |
//! | --- | --- |
//! | [`scene`] | the RON scene: types, lattices in shapes |
//! | [`particle`] | the components of a particle |
//! | [`loading`] | from a text to a checked scene: fragments, overrides, errors with their places |
//! | [`state`] | columns, clock, constants, failure, threads: plain data that all systems share |
//! | [`kernel`], [`lattice`] | the smoothing kernel; stability of a lattice, also beside walls |
//! | [`registry`] | the lists of all stages and columns, each declared beside its code |
//! | [`step`] | phases, stages, the order as data, the schedule; [`Simulation`] and [`install`] |
//!
//! A step, phase by phase ([`Phase`]):
//!
//! | phase | module | paper |
//! | --- | --- | --- |
//! | `RebuildIndex` | [`registry`]: tables into columns; [`index`]: which particles are in which cell | 4.1–4.5 |
//! | `FindNeighbours` | [`neighbours`]: lists, or recomputed neighbours | 5.3.1 |
//! | `Density` | [`density`] | eq. 1 |
//! | `Forces` | [`force`]: gravity, viscosity, tension; before them DFSPH's [divergence](pressure::dfsph) | 5 |
//! | `Pressure` | [`pressure`]: [SESPH](pressure::sesph), [PCISPH](pressure::pcisph) | 5.1, 5.2 |
//! | | [IISPH](pressure::iisph), [DFSPH](pressure::dfsph) | |
//! | `Integrate` | [`integrate`](mod@integrate): motion, guard; [`boundary::contact`]; [`time_step`] | 5 |
//! | `Reorder` | [`reorder`](mod@reorder): rows along the Z-curve; `flow`: fluid that enters and leaves | 4.5.4 |
//! | `Observe` | [`step::StepReport`]: what the step did | 6 |
//!
//! The modules below them:
//!
//! | module | content |
//! | --- | --- |
//! | [`pairs`] | sums over neighbours: the only loop of the physics; kernel gradients stored for a step |
//! | [`sampling`] | surfaces of walls sampled with particles |
//! | [`filling`] | bodies of fluid filled with particles |
//! | [`boundary`] | walls in a step: volumes, their sums for the fluid, contact, direct forcing |
//! | `flow` | fluid that enters and leaves: emitters, outflow |
//! | [`mesh`] | triangle meshes: files, distances, rays |
//! | [`communicator`], [`ranks`] | worlds that share the particles of a scene |
//! | [`simd`] | vectors of eight lanes, chosen at run time; the only `unsafe` code |
//! | [`input`] | reading a user's files with a size limit |
//! | [`measure`] | quantities of experiments and analytic solutions: front, height, semi-axes, pressure profile |
//! | [`gauge`] | instruments of a scene: pressure, velocity, height, front, flux, force, energies |
//! | [`output`] | frames, boundary particles, series, history, summary, pictures, surfaces |
//! | [`checkpoint`] | the state of a run in a file, from which it resumes bit for bit |
//! | [`study`] | variants of a scene measured side by side: the paper's tables, speed over accuracy |
//! | [`validate`] | cases with known answers, run with every pressure method |
//! | [`guide`] | the pages that teach |
//! | `frontier` | speed against the error of a case (feature `cli`) |
//! | [`trial`] | a few steps of a scene: what its parts cost, what it could do without |
//!
//! # The paper in the code
//!
//! | paper | file in `src` | | paper | file in `src` |
//! | --- | --- | --- | --- | --- |
//! | eq. 1 | `density.rs` | | 4.3, 4.3.1 | `index/z_index_sort.rs`, `index/z_curve.rs` |
//! | eq. 2 | `index/grid.rs`, `index/domain.rs` | | 4.4 | `index/spatial_hashing.rs` |
//! | eq. 3 | `index/hash.rs` | | 4.5 | `index/compact_hashing/mod.rs` |
//! | eqs. 4, 5 | `pressure/sesph.rs` | | 4.5.1 | `index/compact_hashing/moves.rs` |
//! | Algorithm 1 | `pressure/sesph.rs` | | 4.5.2, 5.3.1 | `neighbours/mod.rs` |
//! | Algorithm 2 | `pressure/pcisph.rs` | | 4.5.4 | `reorder.rs` |
//! | 2 | `neighbours/verlet.rs` | | | |
//! | 4.1 | `index/uniform_grid.rs` | | 5.1, 5.2 | `pressure/sesph.rs`, `pressure/pcisph.rs` |
//! | 4.2, 4.2.1 | `index/index_sort.rs`, `index/table.rs` | | Tables 1 to 6 | `study/mod.rs`, `assets/studies` |

// What is hidden from the documentation is internal: benches and tests use it.
pub mod boundary;
pub mod checkpoint;
pub mod communicator;
#[doc(hidden)]
pub mod density;
pub mod filling;
mod flow;
#[doc(hidden)]
pub mod force;
#[cfg(feature = "cli")]
pub mod frontier;
pub mod gauge;
pub mod guide;
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
pub mod ranks;
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
pub mod trial;
pub mod validate;

pub use loading::Override;
#[cfg(feature = "bevy_app")]
pub use plugin::{FluidPlugin, FluidStatus, FluidStopped, Pace};
#[doc(inline)]
pub use state::{Execution, particle};
pub use step::{
    Advance, ApplyError, Phase, Plan, Simulation, Step, StepError, StepOutcome, StepReport,
    advance, apply, install, install_on_rank, plan, take_step, uninstall,
};

/// The README's commands and code, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
