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
//! A host with a [`World`](bevy_ecs::world::World) of its own calls [`install`] and then [`take_step`], or runs the
//! schedule
//! [`Step`]; see `examples/embed.rs`.
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
//! | [`study`] | variants of a scene measured side by side: the paper's tables, speed against error |

pub mod boundary;
pub mod density;
pub mod force;
pub mod gauge;
pub mod index;
pub mod input;
pub mod integrate;
pub mod kernel;
pub mod lattice;
pub mod loading;
pub mod measure;
mod memory;
pub mod mesh;
pub mod neighbours;
pub mod output;
pub mod pairs;
pub mod pressure;
pub mod registry;
pub mod reorder;
pub mod sampling;
pub mod scene;
pub mod simd;
pub mod state;
pub mod step;
pub mod study;
pub mod time_step;

pub use loading::Override;
pub use state::particle;
pub use step::{
    Phase, Plan, Simulation, Step, StepError, StepOutcome, StepReport, install, plan, take_step,
};

/// The README's commands and code, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
