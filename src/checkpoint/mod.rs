//! Checkpoints: the state of a run in a file, from which it goes on as if nothing had happened, bit for bit.
//!
//! ```
//! use overfall::{Simulation, scene::Scene};
//!
//! let scene = r#"(
//!     name: "drop",
//!     spacing: 0.1,
//!     bodies: [(shape: Sphere(center: (0, 1, 0), radius: 0.3))],
//! )"#;
//! let scene = Scene::parse(scene, "drop.ron", &[]).expect("a scene");
//! let mut simulation = Simulation::new(&scene).expect("threads");
//! simulation.step().expect("a step");
//! let file = std::env::temp_dir().join(format!("drop_{}.checkpoint", std::process::id()));
//! simulation.checkpoint(&file).expect("a checkpoint");
//! let mut resumed = Simulation::resume(&file).expect("the same run");
//! let [a, b] = [&mut simulation, &mut resumed].map(|run| run.step().expect("a step"));
//! assert_eq!((a.step, a.kinetic_energy), (b.step, b.kinetic_energy));
//! # std::fs::remove_file(file).expect("a file of our own");
//! ```
//!
//! A host that keeps the fluid in a world of its own calls [`write()`] and [`restore`].
//!
//! What is in a checkpoint: the scene; of every particle its number, its row and the columns that last from step to
//! step; the clock, the control of the time step, and whatever else a step leaves behind for the next. A column or a
//! resource that lasts says so beside its code, and is in checkpoints by that. Walls, spatial indices and neighbour
//! lists are made anew: they follow from the scene and the positions alone, the order of lists included. A sum over the
//! walls tells whether they are the same.

mod error;
mod file;
mod restore;
mod save;
mod simulation;

pub use error::CheckpointError;
pub use error::FORMAT_VERSION;
pub use file::Checkpoint;
pub use restore::restore;
pub use save::{steps_until_possible, write};
