//! What the fluid is and how it is computed: material, pressure, time step, neighbours, limits.

use serde::{Deserialize, Serialize};

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
        /// Strength κ in `a_i = −κ Σ_j (m_j / m_i) W(x_ij) x_ij` [m³/s²; m²/s² in 2-D].
        kappa: f32,
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

/// How walls keep the fluid off.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum BoundaryHandling {
    /// By pressure alone, with volumes that follow the sampling (Akinci et al. 2012).
    #[default]
    Akinci,
    /// By pressure of frozen particles, and by putting back what comes nearer than a distance (Becker, Tessendorf &
    /// Teschner 2009; Ihmsen et al. 2010): what the paper's glass and river scenes use.
    DirectForcing(DirectForcing),
}

/// Parameters of direct forcing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DirectForcing {
    /// Distance r0 from a boundary particle within which fluid is put back, in spacings [-]. The particles lie half a
    /// spacing behind the wall's face, so at 1 fluid is left alone up to half a spacing before it.
    pub rest_distance: f32,
    /// Part of its velocity along the wall that a particle put back keeps, each step [-]: 1 slips freely, 0 sticks.
    pub slip: f32,
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

impl Default for DirectForcing {
    fn default() -> Self {
        Self {
            rest_distance: 1.0,
            slip: 1.0,
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
            factor: 0.2,
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

/// How the systems of a step are run. The loops inside them are parallel either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Executor {
    /// In parallel from a few thousand particles on.
    #[default]
    Auto,
    /// Systems that touch different data run side by side.
    Parallel,
    /// One system at a time.
    SingleThreaded,
}
