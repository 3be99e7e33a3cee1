//! Pressure methods and their parameters.

use serde::{Deserialize, Serialize};

/// Pressure method with its own parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum PressureMethod {
    /// Equation of state (paper 5.1, SESPH).
    Sesph(Sesph),
    /// Weakly compressible SPH with a diffusion of the density (δ-SPH, Antuono et al. 2010).
    DeltaSph(DeltaSph),
    /// Predictive-corrective incompressible SPH (paper 5.2; Solenthaler & Pajarola 2009).
    Pcisph(Pcisph),
    /// Implicit incompressible SPH (Ihmsen et al. 2014).
    Iisph(Iisph),
    /// Divergence-free SPH (Bender & Koschier 2015).
    Dfsph(Dfsph),
}

/// Parameters of SESPH.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Sesph {
    /// The equation of state.
    pub equation: StateEquation,
}

/// Equation of state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum StateEquation {
    /// `p = k ((ρ/ρ0)^7 − 1)` (paper eq. 4).
    Tait {
        /// Stiffness k \[Pa]; `k = ρ0 c²/7` with c ten times the largest speed allows about 1 % of compression.
        stiffness: f32,
    },
    /// `p = k (ρ − ρ0)` (paper eq. 5).
    Gas {
        /// Stiffness k \[Pa·m³/kg = m²/s²].
        stiffness: f32,
    },
}

/// Parameters of δ-SPH.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct DeltaSph {
    /// Speed of sound c \[m/s]: ten times the largest speed expected allows about 1 % of compression. If absent it is
    /// ten times the speed of the start, or of the front of a column as high as the fluid stands.
    pub sound_speed: Option<f32>,
    /// Diffusion δ of the pressure \[-], at most 0.3: with 0.4 still water does not stay at rest; 0: none.
    pub diffusion: f32,
    /// Strength K of the shifting of particles \[-]; 0: none.
    pub shifting: f32,
    /// Largest tension, as a part of ρ0 c² \[-]; 0: none, and voids open instead.
    pub tension: f32,
}

impl Default for DeltaSph {
    fn default() -> Self {
        Self {
            sound_speed: None,
            diffusion: 0.1,
            shifting: 20.0,
            tension: 0.01,
        }
    }
}

impl PressureMethod {
    /// The method with its default parameters; those without a default stay.
    pub(crate) fn with_defaults(&self) -> Self {
        match self {
            Self::Sesph(_) => *self,
            Self::DeltaSph(_) => Self::DeltaSph(DeltaSph::default()),
            Self::Pcisph(_) => Self::Pcisph(Pcisph::default()),
            Self::Iisph(_) => Self::Iisph(Iisph::default()),
            Self::Dfsph(_) => Self::Dfsph(Dfsph::default()),
        }
    }

    /// Whether it reaches its accuracy only with sums over many neighbours, also within walls.
    pub(super) fn wants_full_sums(&self) -> bool {
        matches!(self, Self::DeltaSph(_))
    }
}

/// Parameters of PCISPH.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Pcisph {
    /// Limit η on the density error `(ρ − ρ0)/ρ0` \[-]. With `recovery` below 1 it limits what a step leaves of the
    /// compression that it has to remove; compression that is left for later steps comes on top.
    pub max_density_error: f32,
    /// Whether η limits the largest or the mean error.
    pub criterion: Criterion,
    /// Limit on the mean error beside that on the largest \[-], if there is one (the paper has none): a body whose
    /// particles are all compressed by a little less than η has fallen by that part of its height.
    pub mean_density_error: Option<f32>,
    /// At least so many iterations (paper 5.2: 3).
    pub min_iterations: u32,
    /// The step fails, or goes on, after so many. Still water of 90 layers takes 600, once, when its weight arrives at
    /// the floor.
    pub max_iterations: u32,
    /// What happens when `max_iterations` do not reach η.
    pub not_converged: NotConverged,
    /// Share of the pressures before that the iterations start from \[-].
    pub warm_start: f32,
    /// Steps whose pressures these are the mean of: 1, the last step's; n, each step counts 1/n, and what was before it
    /// the rest (see [`warm_start`](crate::pressure::warm_start)).
    pub warm_start_steps: u32,
    /// Whether corrections have momentum (see [`implicit`](crate::pressure::implicit)). The paper's have none.
    pub momentum: bool,
    /// Part of the compression found at the start of a step that the step removes at most \[-]; the paper's 1 removes
    /// all (see
    /// `recovery`). Not more than 1 less `warm_start` is stable however few the iterations.
    pub recovery: f32,
    /// Whether pressures are corrected once more after the prediction that met η, and the step is taken with their
    /// force: the paper's Algorithm 2 to the letter. Without it the step goes to the prediction itself.
    pub last_correction: bool,
    /// Share κ of the compact Laplacian in the system \[-], which keeps pressure from alternating between particles
    /// (see [`stabilisation`](crate::pressure::stabilisation)); the paper's is 0.
    pub stabilisation: f32,
}

/// Parameters of IISPH. Those that it shares with [`Pcisph`] mean the same.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Iisph {
    /// Limit η on the density error `(ρ − ρ0)/ρ0` \[-].
    pub max_density_error: f32,
    /// Whether η limits the largest or the mean error.
    pub criterion: Criterion,
    /// At least so many iterations (the paper's 2).
    pub min_iterations: u32,
    /// The step fails, or goes on, after so many. Still water of 90 layers takes 120, and without
    /// momentum 600, once, when its weight arrives at the floor.
    pub max_iterations: u32,
    /// What happens when `max_iterations` do not reach η.
    pub not_converged: NotConverged,
    /// Share of the pressures before that the iterations start from \[-].
    pub warm_start: f32,
    /// Steps whose pressures these are the mean of.
    pub warm_start_steps: u32,
    /// Relaxation ω of the Jacobi iteration \[-]; with momentum a lattice of the default support is stable up to 0.54.
    pub relaxation: f32,
    /// Part of the compression found at the start of a step that the step removes at most \[-]; the paper's is 1.
    pub recovery: f32,
    /// Whether corrections have momentum: fewer iterations, most of all in deep water (see
    /// [`implicit`](crate::pressure::implicit)). The paper's have none.
    pub momentum: bool,
    /// Share κ of the compact Laplacian in the system \[-], which keeps pressure from alternating between particles
    /// (see [`stabilisation`](crate::pressure::stabilisation)); the paper's is 0.
    pub stabilisation: f32,
}

/// Parameters of DFSPH. Those that it shares with [`Pcisph`] and [`Iisph`] mean the same, for the solve that keeps the
/// density.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Dfsph {
    /// Limit η on the density error `(ρ − ρ0)/ρ0` \[-].
    pub max_density_error: f32,
    /// Whether η, and the limit on the divergence, are on the largest or the mean error.
    pub criterion: Criterion,
    /// At least so many iterations (the paper's 2): of one, nothing but the last step's pressures has a force.
    pub min_iterations: u32,
    /// The step fails, or goes on, after so many. Still water of 90 layers takes 120, and without
    /// momentum 600, once, when its weight arrives at the floor.
    pub max_iterations: u32,
    /// What happens when `max_iterations` do not reach η.
    pub not_converged: NotConverged,
    /// Share of the pressures before that the iterations start from \[-].
    pub warm_start: f32,
    /// Steps whose pressures these are the mean of.
    pub warm_start_steps: u32,
    /// Relaxation ω of the Jacobi iterations of both solves \[-].
    pub relaxation: f32,
    /// Whether their corrections have momentum.
    pub momentum: bool,
    /// Part of the compression found at the start of a step that the step removes at most \[-]; the paper's is 1.
    pub recovery: f32,
    /// Limit on the compression that the velocities would cause in a step, `dt max(0, Dρ/Dt)/ρ0` \[-].
    pub max_divergence_error: f32,
    /// At least so many iterations of the solve that removes the divergence. The paper's 1 finds out how much there is;
    /// here the density pass has, and velocities that are within the limit cost nothing more.
    pub min_divergence_iterations: u32,
    /// After so many the divergence that is left is left: the density solve has the last word.
    pub max_divergence_iterations: u32,
    /// Share κ of the compact Laplacian in the system \[-], which keeps pressure from alternating between particles
    /// (see [`stabilisation`](crate::pressure::stabilisation)); the paper's is 0.
    pub stabilisation: f32,
}

/// What a limit on the density error is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Criterion {
    /// The largest error of all particles (the paper's).
    #[default]
    Largest,
    /// The mean over all particles of the error, compression only.
    Mean,
}

/// What happens when an iterative method does not reach its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum NotConverged {
    /// The run stops with an error.
    #[default]
    Stop,
    /// The step is taken as it is; the report shows the error that remains.
    Accept,
}

impl Default for PressureMethod {
    fn default() -> Self {
        Self::Dfsph(Dfsph::default())
    }
}

/// Of IISPH and DFSPH: share of the last pressures that a step starts from \[-], share of the compression found that a
/// step removes, and share of the compact Laplacian. Measured on tanks of 10 to 240 rows, waves, drops and dam breaks
/// in 2-D and 3-D: `docs/decisions/stabilisation.md`.
const WARM_START: f32 = 0.9;
const RECOVERY: f32 = 0.1;
const STABILISATION: f32 = 0.1;

impl Default for Pcisph {
    fn default() -> Self {
        Self {
            max_density_error: 0.01,
            criterion: Criterion::Largest,
            mean_density_error: Some(1e-4),
            min_iterations: 3,
            max_iterations: 1000,
            not_converged: NotConverged::Stop,
            // Its deep tanks fail with more, and with stabilisation.
            warm_start: 0.8,
            warm_start_steps: 1,
            momentum: true,
            recovery: 0.3,
            stabilisation: 0.0,
            last_correction: false,
        }
    }
}

impl Default for Iisph {
    fn default() -> Self {
        Self {
            max_density_error: 1e-4,
            criterion: Criterion::Mean,
            min_iterations: 2,
            max_iterations: 1000,
            not_converged: NotConverged::Stop,
            warm_start: WARM_START,
            warm_start_steps: 1,
            relaxation: 0.4,
            momentum: true,
            recovery: RECOVERY,
            stabilisation: STABILISATION,
        }
    }
}

impl Default for Dfsph {
    fn default() -> Self {
        Self {
            max_density_error: 1e-4,
            criterion: Criterion::Mean,
            min_iterations: 2,
            max_iterations: 1000,
            not_converged: NotConverged::Stop,
            warm_start: WARM_START,
            warm_start_steps: 1,
            relaxation: 0.4,
            momentum: true,
            recovery: RECOVERY,
            stabilisation: STABILISATION,
            max_divergence_error: 1e-3,
            min_divergence_iterations: 0,
            max_divergence_iterations: 100,
        }
    }
}
