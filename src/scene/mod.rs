//! The scene: what a RON file says, typed. SI units everywhere.
//!
//! [`Scene`] and the types it holds are exactly the file's fields; [`load`](Scene::load) reads one, applies the
//! [`Override`](crate::Override)s and checks the result. [`shapes`] turns bodies into particles; nothing here knows of
//! the world they are spawned into.
//!
//! In a file `Some(…)` around a value, the names of structs, and the second bracket of `Pcisph((…))` may be left out;
//! a variant whose fields all have defaults may stand alone, `Pcisph`.

mod body_force;
mod boundary_motion;
mod build;
mod emitter;
mod error;
mod force_wave;
mod gauge;
mod geometry;
mod output;
mod particle_file;
mod periodic;
mod physics;
mod placed;
mod pressure;
mod rotation;
#[cfg(feature = "schema")]
mod schema;
pub mod shapes;
mod sound_speed;
mod surfaces;
mod velocity_field;
mod velocity_grid;
mod wall_motion;
mod wall_slip;

pub use crate::mesh::{Channel, MeshSide, Rolling};
pub use body_force::*;
pub(crate) use boundary_motion::LEAST_WAY;
pub use emitter::*;
pub use error::{Place, SceneError};
pub(crate) use error::{elsewhere, known_as, unknown_name};
pub use force_wave::ForceWave;
pub use gauge::*;
pub use geometry::*;
pub use output::*;
pub(crate) use particle_file::Particles;
pub use periodic::{Period, Periodic};
pub use physics::*;
pub use pressure::*;
pub(crate) use rotation::Frame;
pub use surfaces::*;
pub use velocity_field::*;
pub use velocity_grid::VelocityGrid;
pub use wall_motion::*;
pub use wall_slip::WallSlip;

use std::path::Path;

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A whole scene, as its RON file gives it. Every field but `name`, `spacing` and `bodies` has a default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Names the output folder and the pictures.
    pub name: String,
    /// 2 (the plane z = 0) or 3.
    #[serde(default)]
    pub dimension: Dimension,
    /// Distance of the particles at rest \[m].
    pub spacing: f32,
    /// Function of the smoothing kernel. If absent the quintic spline in 2-D and the cubic in 3-D; the cubic, too, for
    /// a `support` that is written; with δ-SPH Wendland's C2.
    #[serde(default)]
    pub kernel: Option<KernelFunction>,
    /// Support radius of the kernel in spacings \[-]; `h = support × spacing`. If absent what is advised for the kernel
    /// and the dimension ([`KernelFunction::support`]).
    #[serde(default)]
    pub support: Option<f32>,
    /// Acceleration of every particle \[m/s²].
    #[serde(default = "default_gravity")]
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub gravity: Vec3,
    /// Time over which gravity grows from nothing, as `t/T − sin(2πt/T)/2π`; 0 for all of it from the start on \[s].
    /// With an equation of state water then comes to rest without the sound of a sudden start.
    #[serde(default)]
    pub gravity_ramp: f32,
    /// Forces on the fluid beside gravity.
    #[serde(default)]
    pub body_forces: Vec<BodyForce>,
    /// What the fluid is made of.
    #[serde(default)]
    pub fluid: Fluid,
    /// Where the fluid is at the start; may be empty where there are `emitters`.
    pub bodies: Vec<FluidBody>,
    /// Where fluid enters during the run.
    #[serde(default)]
    pub emitters: Vec<Emitter>,
    /// Boxes that remove the fluid that gets into them.
    #[serde(default)]
    pub outflow: Vec<Bounds>,
    /// Solid walls and obstacles.
    #[serde(default)]
    pub boundaries: Vec<BoundaryShape>,
    /// How boundaries keep the fluid off. If absent, `Extrapolated` with methods that solve for the pressure, `Layers`
    /// with δ-SPH, and `Akinci` with SESPH.
    #[serde(default)]
    pub boundary_handling: Option<BoundaryHandling>,
    /// Axes along which space repeats: what leaves at one face comes in at the other.
    #[serde(default)]
    pub periodic: Periodic,
    /// The part of space that fluid may be in; unbounded if absent.
    #[serde(default)]
    pub domain: Option<Bounds>,
    /// What happens to a particle outside `domain`.
    #[serde(default)]
    pub outside: Outside,
    /// How pressure is computed.
    #[serde(default)]
    pub pressure: PressureMethod,
    /// How far one step goes.
    #[serde(default)]
    pub time_step: TimeStep,
    /// How neighbours are found.
    #[serde(default)]
    pub index: Index,
    /// Whether neighbour lists are kept for the step.
    #[serde(default)]
    pub neighbours: Neighbours,
    /// Steps between two reorderings along the Z-curve; 0 never reorders. The paper's 100 (4.5.4): in the corner dam
    /// break of 130 000 particles, 0.45 s of PCISPH, intervals of 25, 50 and 100 differ by less than the noise.
    #[serde(default = "default_reorder_interval")]
    pub reorder_interval: u32,
    /// The order that a reordering gives the rows.
    #[serde(default)]
    pub reorder_by: RowOrder,
    /// A RON file with the order of the stages, relative to the scene file's folder (after
    /// [`load`](Scene::load): to the working directory); the default order if absent.
    #[serde(default)]
    pub order: Option<String>,
    /// How the systems of a step are run.
    #[serde(default)]
    pub executor: Executor,
    /// When the failure guard stops the run.
    #[serde(default)]
    pub limits: Limits,
    /// Memory that a run may take \[GB], 10⁹ bytes; all of the machine's if absent. A scene that needs more is refused
    /// before anything is allocated.
    #[serde(default)]
    pub memory_limit: Option<f32>,
    /// Simulated time of the run \[s].
    #[serde(default = "default_duration")]
    pub duration: f32,
    /// What is measured on the way.
    #[serde(default)]
    pub gauges: Vec<Gauge>,
    /// What is written, and how often.
    #[serde(default)]
    pub output: Output,
}

/// α of the numerical viscosity. Measured on still water, dam breaks and standing waves:
/// `docs/decisions/still_water.md`.
const NUMERICAL_VISCOSITY: f32 = 0.3;

fn default_gravity() -> Vec3 {
    Vec3::new(0.0, -9.81, 0.0)
}
fn default_reorder_interval() -> u32 {
    100
}
fn default_duration() -> f32 {
    1.0
}

impl Scene {
    /// A scene without fluid, with the defaults of a file, of particles at a `spacing` \[m].
    ///
    /// ```
    /// use overfall::scene::{BoundaryShape, FluidBody, Scene, Shape};
    ///
    /// let scene = Scene {
    ///     bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.4, 0.8, 0.4]))],
    ///     boundaries: vec![BoundaryShape::tank([0.0; 3], [1.6, 1.2, 0.4])],
    ///     duration: 2.0,
    ///     ..Scene::new("pond", 0.05)
    /// };
    /// scene.check().expect("a scene without contradictions");
    /// let text = scene.to_ron().expect("RON");
    /// assert_eq!(Scene::parse(&text, "pond.ron", &[]).expect("the same"), scene);
    /// ```
    pub fn new(name: impl Into<String>, spacing: f32) -> Self {
        Self {
            name: name.into(),
            dimension: Dimension::default(),
            spacing,
            kernel: None,
            support: None,
            gravity: default_gravity(),
            gravity_ramp: 0.0,
            body_forces: Vec::new(),
            fluid: Fluid::default(),
            bodies: Vec::new(),
            emitters: Vec::new(),
            outflow: Vec::new(),
            boundaries: Vec::new(),
            boundary_handling: None,
            periodic: Periodic::default(),
            domain: None,
            outside: Outside::default(),
            pressure: PressureMethod::default(),
            time_step: TimeStep::default(),
            index: Index::default(),
            neighbours: Neighbours::default(),
            reorder_interval: default_reorder_interval(),
            reorder_by: RowOrder::default(),
            order: None,
            executor: Executor::default(),
            limits: Limits::default(),
            memory_limit: None,
            duration: default_duration(),
            gauges: Vec::new(),
            output: Output::default(),
        }
    }

    /// The box that repeats.
    pub fn period(&self) -> Period {
        self.periodic.into()
    }

    /// Function of the kernel, as written or as advised (`docs/decisions/kernels.md`).
    pub fn kernel(&self) -> KernelFunction {
        if self.pressure.wants_full_sums() {
            return self.kernel.unwrap_or(KernelFunction::WendlandC2);
        }
        self.kernel.unwrap_or(match (self.dimension, self.support) {
            (Dimension::Two, None) => KernelFunction::QuinticSpline,
            (Dimension::Two, Some(_)) | (Dimension::Three, _) => KernelFunction::CubicSpline,
        })
    }

    /// Support radius in spacings \[-], as written or as advised.
    pub fn support(&self) -> f32 {
        self.support.unwrap_or_else(|| {
            let kernel = self.kernel();
            if self.pressure.wants_full_sums() && kernel == KernelFunction::WendlandC2 {
                return match self.dimension {
                    Dimension::Two => 4.0,
                    Dimension::Three => 3.5,
                };
            }
            kernel.support(self.dimension)
        })
    }

    /// How boundaries keep the fluid off, as written or as advised.
    pub fn boundary_handling(&self) -> BoundaryHandling {
        self.boundary_handling
            .unwrap_or(if self.pressure.wants_full_sums() {
                BoundaryHandling::Layers
            } else if self.pressure.iterations().is_some() {
                BoundaryHandling::Extrapolated
            } else {
                BoundaryHandling::Akinci
            })
    }

    /// Whether the pressure of walls is continued hydrostatically.
    pub(crate) fn continues_pressure(&self) -> bool {
        matches!(
            self.boundary_handling(),
            BoundaryHandling::Layers | BoundaryHandling::Extrapolated
        )
    }

    /// α of the numerical viscosity beside a laminar one, as written or as advised \[-].
    pub fn numerical_viscosity(&self) -> f32 {
        match self.fluid.viscosity {
            Viscosity::Laminar { numerical, .. } => {
                let advised = if self.pressure.wants_full_sums() {
                    0.0
                } else {
                    NUMERICAL_VISCOSITY
                };
                numerical.unwrap_or(advised)
            }
            Viscosity::None | Viscosity::Artificial { .. } => 0.0,
        }
    }

    /// Support radius h \[m].
    pub fn support_radius(&self) -> f32 {
        self.support() * self.spacing
    }

    /// Radius within which neighbours are listed \[m]: h, or more where lists are kept.
    pub fn search_radius(&self) -> f32 {
        self.support_radius() * (1.0 + self.skin().unwrap_or(0.0))
    }

    /// Skin of lists that are kept, in support radii \[-]; none where they are found in every step.
    pub fn skin(&self) -> Option<f32> {
        match self.neighbours {
            Neighbours::Verlet { skin } => Some(skin),
            Neighbours::Stored | Neighbours::Recomputed => None,
        }
    }

    /// Whether neighbour lists are stored.
    pub fn stores_neighbours(&self) -> bool {
        self.neighbours != Neighbours::Recomputed
    }

    /// Entries of lists per neighbour within the support radius \[-].
    pub(crate) fn listed_per_neighbour(&self) -> f64 {
        let ratio = f64::from(1.0 + self.skin().unwrap_or(0.0));
        ratio.powi(u8::from(self.dimension).into())
    }

    /// Whether there are boundaries, and direct forcing keeps the fluid off them.
    pub fn forces_directly(&self) -> bool {
        matches!(self.boundary_handling(), BoundaryHandling::DirectForcing(_))
            && !self.boundaries.is_empty()
    }

    /// A bound on the acceleration by all forces on the fluid as a whole \[m/s²]: at the start for central forces, at
    /// any time for gravity and tables. A file that cannot be read counts for nothing: the scene's check names it.
    pub fn greatest_acceleration(&self) -> f32 {
        let forces = self.body_forces.iter();
        let forces = forces.map(|force| self.greatest_acceleration_of(force));
        self.gravity.length() + forces.sum::<f32>()
    }

    /// The same of one of its forces.
    pub(crate) fn greatest_acceleration_of(&self, force: &BodyForce) -> f32 {
        match force {
            BodyForce::Central(central) => {
                let shapes = self.bodies.iter().map(|body| &body.shape);
                let distances = shapes
                    .map(|shape| shape.center().as_vec3().distance(central.center) + shape.reach());
                let faces = self.emitters.iter().map(|emitter| emitter.shape.center());
                let faces = faces.map(|face| face.distance(central.center));
                let distance = distances.chain(faces).fold(0.0, f32::max);
                (central.linear * distance).abs() + central.constant.abs()
            }
            BodyForce::Table(table) => AccelerationTable::load(Path::new(&table.file))
                .map_or(0.0, |table| table.greatest() as f32),
            BodyForce::Wave(wave) => wave.amplitude.length(),
        }
    }

    /// Shortest period of the forces on the fluid as a whole \[s], infinite if they do not oscillate. A file that
    /// cannot be read counts for nothing.
    pub(crate) fn shortest_period_of_forces(&self) -> f32 {
        let least = f64::from(LEAST_WAY * self.spacing);
        let of_force = |force: &BodyForce| match force {
            BodyForce::Central(_) => None,
            BodyForce::Table(table) => {
                let table = AccelerationTable::load(Path::new(&table.file)).ok()?;
                table.shortest_period(least)
            }
            BodyForce::Wave(wave) => wave.period(least),
        };
        let periods = self.body_forces.iter().filter_map(of_force);
        periods.fold(f64::INFINITY, f64::min) as f32
    }

    /// Largest speed that a particle starts with, in a body or from an emitter \[m/s].
    pub fn max_initial_speed(&self) -> f32 {
        let speeds = self.bodies.iter().map(FluidBody::greatest_speed);
        let emitted = self.emitters.iter().map(|emitter| emitter.speed);
        speeds.chain(emitted).fold(0.0, f32::max)
    }
}
