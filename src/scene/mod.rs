//! The scene: what a RON file says, typed. SI units everywhere.
//!
//! [`Scene`] and the types it holds are exactly the file's fields; [`load`](Scene::load) reads and checks one,
//! and every error names file, line and column. Nothing here knows of particles: [`shapes`] turns bodies into
//! positions.

pub mod shapes;

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A whole scene, as its RON file gives it. Every field but `name`, `spacing` and `bodies` has a default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Names the output folder and the pictures.
    pub name: String,
    /// 2 (the plane z = 0) or 3.
    #[serde(default)]
    pub dimension: Dimension,
    /// Distance of the particles at rest [m].
    pub spacing: f32,
    /// Support radius of the kernel in spacings [-]; `h = support × spacing`.
    #[serde(default = "default_support")]
    pub support: f32,
    /// Acceleration of every particle [m/s²].
    #[serde(default = "default_gravity")]
    pub gravity: Vec3,
    /// What the fluid is made of.
    #[serde(default)]
    pub fluid: Fluid,
    /// Where the fluid is at the start.
    pub bodies: Vec<FluidBody>,
    /// Solid walls and obstacles.
    #[serde(default)]
    pub boundaries: Vec<BoundaryShape>,
    /// A particle outside stops the run; unbounded if absent.
    #[serde(default)]
    pub domain: Option<Bounds>,
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
    /// Steps between two reorderings along the Z-curve; 0 never reorders (paper 4.5.4: 100).
    #[serde(default = "default_reorder_interval")]
    pub reorder_interval: u32,
    /// A RON file with the order of the stages, relative to the scene file; the default order if absent.
    #[serde(default)]
    pub order: Option<String>,
    /// When the failure guard stops the run.
    #[serde(default)]
    pub limits: Limits,
    /// Simulated time of the run [s].
    #[serde(default = "default_duration")]
    pub duration: f32,
    /// What is written, and how often.
    #[serde(default)]
    pub output: Output,
}

/// The number of space dimensions, 2 or 3 in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "u8", into = "u8")]
pub enum Dimension {
    /// The plane z = 0.
    Two,
    /// Space.
    #[default]
    Three,
}

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Lower corner [m].
    pub min: Vec3,
    /// Upper corner [m].
    pub max: Vec3,
}

/// Material of the fluid; the defaults are water.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Fluid {
    /// Density at rest [kg/m³].
    pub rest_density: f32,
    /// Friction within the fluid.
    pub viscosity: Viscosity,
    /// Cohesion of the fluid.
    pub surface_tension: SurfaceTension,
}

/// Viscosity model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Viscosity {
    /// None: no system, no pass.
    None,
    /// Laminar viscosity (Morris et al. 1997, in the form of Weiler et al. 2018).
    Laminar {
        /// Kinematic viscosity ν [m²/s].
        kinematic_viscosity: f32,
    },
    /// Artificial viscosity (Monaghan 1992; Becker & Teschner 2007).
    Artificial {
        /// α [-].
        alpha: f32,
        /// Speed of sound that scales it [m/s].
        sound_speed: f32,
    },
}

/// Surface tension model.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum SurfaceTension {
    /// None: no system, no pass.
    #[default]
    None,
    /// Pairwise cohesion (Becker & Teschner 2007).
    BeckerTeschner {
        /// Strength κ [N·m/kg = m³/s² per metre of distance; see `force::surface_tension`].
        kappa: f32,
    },
}

/// One body of fluid: a shape filled with particles on a lattice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluidBody {
    /// Where.
    pub shape: Shape,
    /// Velocity at the start [m/s].
    #[serde(default)]
    pub velocity: Vec3,
    /// Random displacement of the particles; none if absent.
    #[serde(default)]
    pub jitter: Option<Jitter>,
}

/// Random displacement of a lattice: the same seed gives the same particles everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Jitter {
    /// Largest displacement a coordinate, in spacings [-], under 0.5.
    pub amplitude: f32,
    /// Seed of the generator.
    #[serde(default)]
    pub seed: u64,
}

/// A solid body of fluid at the start. In 2-D a sphere is a disc; a cylinder needs 3-D.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Shape {
    /// Axis-aligned box.
    Box {
        /// Lower corner [m].
        min: Vec3,
        /// Upper corner [m].
        max: Vec3,
    },
    /// Ball.
    Sphere {
        /// Centre [m].
        center: Vec3,
        /// Radius [m].
        radius: f32,
    },
    /// Cylinder between two points.
    Cylinder {
        /// Centre of one end [m].
        start: Vec3,
        /// Centre of the other end [m].
        end: Vec3,
        /// Radius [m].
        radius: f32,
    },
}

/// A solid boundary, sampled with one layer of particles at the spacing, half a spacing inside the solid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum BoundaryShape {
    /// A tank that holds fluid inside the box `min`–`max`.
    Tank {
        /// Lower inner corner [m].
        min: Vec3,
        /// Upper inner corner [m].
        max: Vec3,
        /// Whether the side towards +y is missing.
        #[serde(default)]
        open: bool,
    },
    /// A solid box.
    Box {
        /// Lower corner [m].
        min: Vec3,
        /// Upper corner [m].
        max: Vec3,
    },
    /// A solid sphere (a disc in 2-D).
    Sphere {
        /// Centre [m].
        center: Vec3,
        /// Radius [m].
        radius: f32,
    },
    /// A flat rectangular wall (a line in 2-D) that is solid on the far side of its normal.
    Plane {
        /// Centre of the wall [m].
        center: Vec3,
        /// Direction from the solid into the fluid; any length but zero.
        normal: Vec3,
        /// Half the edge of the square [m].
        half_size: f32,
    },
}

/// Pressure method with its own parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum PressureMethod {
    /// Equation of state (paper 5.1, SESPH).
    Sesph(Sesph),
    /// Predictive-corrective incompressible SPH (paper 5.2; Solenthaler & Pajarola 2009).
    Pcisph(Pcisph),
}

/// Parameters of SESPH.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sesph {
    /// The equation of state.
    pub equation: StateEquation,
}

/// Equation of state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum StateEquation {
    /// `p = k ((ρ/ρ0)^7 − 1)` (paper eq. 4).
    Tait {
        /// Stiffness k [Pa]; `k = ρ0 c²/7` with c ten times the largest speed allows about 1 % of compression.
        stiffness: f32,
    },
    /// `p = k (ρ − ρ0)` (paper eq. 5).
    Gas {
        /// Stiffness k [Pa·m³/kg = m²/s²].
        stiffness: f32,
    },
}

/// Parameters of PCISPH.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pcisph {
    /// Limit η on the density error `(ρ − ρ0)/ρ0` [-].
    pub max_density_error: f32,
    /// Whether η limits the largest or the mean error.
    pub criterion: Criterion,
    /// At least so many iterations (paper 5.2: 3).
    pub min_iterations: u32,
    /// The step fails, or goes on, after so many.
    pub max_iterations: u32,
    /// What happens when `max_iterations` do not reach η.
    pub not_converged: NotConverged,
}

/// What a limit on the density error is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Criterion {
    /// The largest error of all particles (the paper's).
    #[default]
    Largest,
    /// The mean over all particles of the error, compression only.
    Mean,
}

/// What happens when an iterative method does not reach its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum NotConverged {
    /// The run stops with an error.
    #[default]
    Stop,
    /// The step is taken as it is; the report shows the error that remains.
    Accept,
}

/// Control of the time step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum TimeStep {
    /// Always the same [s].
    Fixed(f32),
    /// From the speeds, forces and viscosity of the last step.
    Cfl(Cfl),
}

/// Limits of an adaptive time step (see `time_step`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Cfl {
    /// λ in dt ≤ λ h / v_max [-].
    pub factor: f32,
    /// Never below [s].
    pub min: f32,
    /// Never above [s].
    pub max: f32,
}

/// Structure that finds neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Index {
    /// Which structure.
    pub structure: IndexStructure,
    /// Cell edge d in support radii [-], in (0, 1] (paper 6.2).
    pub cell_size: f32,
}

/// The structures of the paper's section 4 that exist here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum IndexStructure {
    /// Compact hashing (paper 4.5).
    #[default]
    CompactHashing,
    /// Every particle against every other; the reference for tests.
    BruteForce,
}

/// Neighbour lists, or none (paper 5.3.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Neighbours {
    /// Found once a step and stored.
    #[default]
    Stored,
    /// Found again by every loop: slower, but without the memory of the lists.
    Recomputed,
}

/// Limits of the failure guard.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Largest tolerated compression `(ρ − ρ0)/ρ0` [-].
    pub compression: f32,
}

/// What a run writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Frames per simulated second [1/s]; 0 writes none but the first and the last.
    pub frames_per_second: f32,
    /// File formats of the frames.
    pub formats: Vec<FrameFormat>,
    /// Whether a picture of every frame is drawn.
    pub pictures: bool,
    /// Where the picture is seen from; chosen from the scene if absent.
    pub camera: Option<Camera>,
}

/// File format of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum FrameFormat {
    /// VTK XML unstructured grid, binary; ParaView opens it.
    Vtu,
    /// Stanford PLY, binary little endian.
    Ply,
}

/// A pinhole camera; y is up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Where the eye is [m].
    pub position: Vec3,
    /// Where it looks [m].
    pub target: Vec3,
    /// Vertical angle of view [degrees].
    #[serde(default = "default_field_of_view")]
    pub field_of_view: f32,
}

fn default_support() -> f32 {
    2.0
}
fn default_gravity() -> Vec3 {
    Vec3::new(0.0, -9.81, 0.0)
}
fn default_reorder_interval() -> u32 {
    100
}
fn default_duration() -> f32 {
    1.0
}
fn default_field_of_view() -> f32 {
    40.0
}

impl Default for Fluid {
    fn default() -> Self {
        Self {
            rest_density: 1000.0,
            viscosity: Viscosity::default(),
            surface_tension: SurfaceTension::default(),
        }
    }
}

impl Default for Viscosity {
    fn default() -> Self {
        Self::Laminar {
            kinematic_viscosity: 1e-6,
        }
    }
}

impl Default for PressureMethod {
    fn default() -> Self {
        Self::Pcisph(Pcisph::default())
    }
}

impl Default for Pcisph {
    fn default() -> Self {
        Self {
            max_density_error: 0.01,
            criterion: Criterion::Largest,
            min_iterations: 3,
            max_iterations: 200,
            not_converged: NotConverged::Stop,
        }
    }
}

impl Default for TimeStep {
    fn default() -> Self {
        Self::Cfl(Cfl::default())
    }
}

impl Default for Cfl {
    fn default() -> Self {
        Self {
            factor: 0.4,
            min: 1e-6,
            max: 5e-3,
        }
    }
}

impl Default for Index {
    fn default() -> Self {
        Self {
            structure: IndexStructure::default(),
            cell_size: 1.0,
        }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self { compression: 0.5 }
    }
}

impl Default for Output {
    fn default() -> Self {
        Self {
            frames_per_second: 25.0,
            formats: vec![FrameFormat::Vtu],
            pictures: true,
            camera: None,
        }
    }
}

impl TryFrom<u8> for Dimension {
    type Error = String;

    fn try_from(value: u8) -> Result<Self, Self::Error> {
        match value {
            2 => Ok(Self::Two),
            3 => Ok(Self::Three),
            other => Err(format!("dimension is {other}; it must be 2 or 3")),
        }
    }
}

impl From<Dimension> for u8 {
    fn from(value: Dimension) -> Self {
        match value {
            Dimension::Two => 2,
            Dimension::Three => 3,
        }
    }
}

impl Scene {
    /// Support radius h [m].
    pub fn support_radius(&self) -> f32 {
        self.support * self.spacing
    }
}
