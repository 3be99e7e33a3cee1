//! Gauges: instruments of a scene that are read while it runs ([`crate::scene::Gauge`]), after steps that were good.
//!
//! | file | gauges |
//! | --- | --- |
//! | `point` | pressure in the fluid and on walls, velocity |
//! | `level` | height, front |
//! | `flux` | volume flow through a surface |
//! | `force` | force and torque on named boundaries |
//! | `energy` | kinetic, potential, of compression, dissipated |
//! | `window` | rates and means over time |
//! | `account` | what steps dissipate, booked step by step |
//! | `free`, `reactions` | velocities before contact; what walls do to the fluid |
//! | `state`, `moment` | what gauges read of a step |
//! | `gauges` | the resource, and the systems that read |
//! | `snapshot` | what a host asks of the fluid between steps: neighbours and quantities at any point |
//! | `near` | who is in a box, through the spatial index |
//!
//! All read the state as frames hold it: places and velocities at the end of the step, densities and pressures that the
//! step computed. They find particles through the index of the step's start, so a particle speaks where its place then
//! was within reach; weights are those of its place now. Sums go in the order of the rows: figures do not depend on the
//! number of threads, nor on the structure of the index.
//!
//! A host finds [`Gauges`] in its world, whether or not files are written:
//!
//! ```
//! use overfall::{Simulation, gauge::Gauges, scene::Scene};
//!
//! let scene = r#"(
//!     name: "pool",
//!     spacing: 0.1,
//!     bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0.5)))],
//!     boundaries: [Tank(min: (0, 0, 0), max: (0.5, 1, 0.5), name: "tank")],
//!     gauges: [
//!         (name: "load", kind: Force(boundary: "tank")),
//!         (name: "level", kind: Height(at: (0.25, 0, 0.25)), every: Seconds(0.01)),
//!     ],
//! )"#;
//! let scene = Scene::parse(scene, "pool.ron", &[]).expect("a scene");
//! let mut simulation = Simulation::new(&scene).expect("threads");
//! while simulation.time() < 0.05 {
//!     simulation.step().expect("a step");
//! }
//! let gauges = simulation.world().resource::<Gauges>();
//! for gauge in gauges.iter() {
//!     for reading in gauge.readings() {
//!         let _ = (gauge.name(), gauge.columns(), reading.time, &reading.values);
//!     }
//! }
//! let level = gauges.get("level").and_then(|gauge| gauge.value("height_m"));
//! assert!((0.4..0.6).contains(&level.expect("fluid in the column")));
//! ```

mod account;
mod energy;
mod flux;
mod force;
mod free;
mod gauges;
mod level;
mod moment;
mod near;
mod point;
mod reactions;
mod snapshot;
mod state;
mod window;

pub use account::EnergyAccount;
pub(crate) use account::{book, note_start};
pub(crate) use free::keep_velocities;
pub use gauges::{Gauge, Gauges, Reading, settled_step};
pub(crate) use gauges::{go_back, install, measures_energy, measures_forces, read_gauges};
pub use snapshot::{
    Field, Interpolated, Neighbour, Snapshot, SnapshotError, Target, neighbours_of,
};
