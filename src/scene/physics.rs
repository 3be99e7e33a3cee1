//! What the fluid is and how it is computed: material, time step, neighbours, limits.

use serde::{Deserialize, Serialize};

use super::Dimension;

/// Material of the fluid; the defaults are water.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Fluid {
    /// Density at rest \[kg/m³].
    pub rest_density: f32,
    /// Friction within the fluid.
    pub viscosity: Viscosity,
    /// Cohesion of the fluid.
    pub surface_tension: SurfaceTension,
}

/// Viscosity model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum Viscosity {
    /// None: no system, no pass.
    None,
    /// Laminar viscosity (Morris et al. 1997, in the form of Weiler et al. 2018).
    Laminar {
        /// Kinematic viscosity ν \[m²/s].
        kinematic_viscosity: f32,
        /// α of a numerical viscosity beside it, `α h c/(2 (d + 2))` with `c = sqrt(p/ρ)` of each pair, the speed of
        /// the waves of a lattice under pressure \[-]. It damps those and fades with the spacing; 0: none.
        /// If absent 0.3, but none with δ-SPH.
        #[serde(default)]
        numerical: Option<f32>,
    },
    /// Artificial viscosity (Monaghan 1992; Becker & Teschner 2007).
    Artificial {
        /// α \[-].
        alpha: f32,
        /// Speed of sound that scales it \[m/s].
        sound_speed: f32,
    },
}

/// Surface tension model.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum SurfaceTension {
    /// None: no system, no pass.
    #[default]
    None,
    /// Pairwise cohesion (Becker & Teschner 2007).
    BeckerTeschner {
        /// Strength κ in `a_i = −κ Σ_j (m_j / m_i) W(x_ij) x_ij` \[m³/s²; m²/s² in 2-D].
        kappa: f32,
    },
}

/// How walls keep the fluid off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum BoundaryHandling {
    /// By pressure alone, with volumes that follow the sampling (Akinci et al. 2012).
    Akinci,
    /// By pressure of frozen particles, and by putting back what comes nearer than a distance (Becker, Tessendorf &
    /// Teschner 2009; Ihmsen et al. 2010): what the paper's glass and river scenes use.
    DirectForcing(DirectForcing),
    /// By pressure of as many layers of samples as the kernel reaches into the wall, each of the volume of a fluid
    /// particle, with the pressure that the fluid has there if it is continued hydrostatically (Adami, Hu & Adams
    /// 2012). For supports wider than the defaults.
    Layers,
    /// As with `Akinci`, and the pressure of a sample is that of the particle, continued hydrostatically as far as the
    /// fluid beside it bears gravity, and not below zero (after Adami, Hu & Adams 2012). One layer of samples.
    Extrapolated,
}

/// Parameters of direct forcing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct DirectForcing {
    /// Distance r0 from a boundary particle within which fluid is put back, in spacings \[-]. The particles lie half a
    /// spacing behind the wall's face, so at 1 fluid is left alone up to half a spacing before it.
    pub rest_distance: f32,
    /// Part of its velocity along the wall that a particle put back keeps, each step \[-]: 1 slips freely, 0 sticks.
    pub slip: f32,
}

/// Control of the time step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum TimeStep {
    /// Always the same \[s].
    Fixed(f32),
    /// From the speeds, forces and viscosity of the last step.
    Cfl(Cfl),
    /// From the speeds, forces and density errors of the last step, a little at a time; a step that meets a shock is
    /// taken back and the one before it, too (Ihmsen et al. 2010).
    Adaptive(Adaptive),
}

impl TimeStep {
    /// The longest step that it ever takes \[s].
    pub fn longest(&self) -> f32 {
        match self {
            Self::Fixed(dt) => *dt,
            Self::Cfl(cfl) => cfl.max,
            Self::Adaptive(scheme) => scheme.max,
        }
    }
}

/// Limits of a time step that follows the motion (see `time_step`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Cfl {
    /// λ in dt ≤ λ h / v_max \[-].
    pub factor: f32,
    /// Never below \[s].
    pub min: f32,
    /// Never above \[s].
    pub max: f32,
}

/// Limits of the time step that goes back from a shock (see `time_step::adaptive`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Adaptive {
    /// Never below \[s]. A step that goes wrong in spite of it fails.
    pub min: f32,
    /// Never above \[s].
    pub max: f32,
    /// The first time step \[s]; if absent, what the speeds and gravity at the start allow.
    pub initial: Option<f32>,
    /// η, the mean density error `(ρ − ρ0)/ρ0` up to which the time step grows \[-]; a largest error that jumps by
    /// more than 8 η is a shock. It is the scheme's own, whatever the pressure method limits.
    pub density_error: f32,
    /// A largest density error above it is a shock \[-].
    pub max_density_error: f32,
}

/// Function of the smoothing kernel (see [`kernel`](crate::kernel)).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum KernelFunction {
    /// Cubic spline (Monaghan 1992).
    CubicSpline,
    /// Wendland's function with two continuous derivatives (Wendland 1995).
    WendlandC2,
    /// Wendland's function with four.
    WendlandC4,
    /// Quintic spline (Morris et al. 1997).
    QuinticSpline,
}

impl KernelFunction {
    /// Every function.
    pub const ALL: [Self; 4] = [
        Self::CubicSpline,
        Self::WendlandC2,
        Self::WendlandC4,
        Self::QuinticSpline,
    ];

    /// Support radius that a scene has if it names none, in spacings \[-]. Measured: `docs/decisions/kernels.md`.
    pub fn support(self, dimension: Dimension) -> f32 {
        let [plane, space] = match self {
            Self::CubicSpline => [2.0, 2.0],
            Self::WendlandC2 => [3.0, 3.0],
            Self::WendlandC4 => [3.5, 3.5],
            Self::QuinticSpline => [2.6, 2.6],
        };
        match dimension {
            Dimension::Two => plane,
            Dimension::Three => space,
        }
    }
}

/// Structure that finds neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Index {
    /// Which structure.
    pub structure: IndexStructure,
    /// Cell edge d in support radii \[-], in (0, 1] (paper 6.2).
    pub cell_size: f32,
}

/// The structures of the paper's section 4. All find the same neighbours. The first three cover a box around all
/// particles and need memory for every cell in it, at most [`MAX_CELLS`](crate::state::MAX_CELLS) cells; a step that
/// would need more fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum IndexStructure {
    /// Basic uniform grid (paper 4.1): filled serially.
    UniformGrid,
    /// Index sort (paper 4.2): sorted anew every step by row-major cell index.
    IndexSort,
    /// Z-index sort (paper 4.3): kept sorted along the Z-curve.
    ZIndexSort,
    /// Spatial hashing (paper 4.4): filled anew every step, with memory reserved in every hash cell.
    SpatialHashing,
    /// Compact hashing (paper 4.5): only what changes its cell is moved, only cells in use have memory.
    #[default]
    CompactHashing,
    /// Every particle against every other; the reference for tests.
    BruteForce,
}

impl IndexStructure {
    /// Every structure, in the order of the paper.
    pub const ALL: [Self; 6] = [
        Self::UniformGrid,
        Self::IndexSort,
        Self::ZIndexSort,
        Self::SpatialHashing,
        Self::CompactHashing,
        Self::BruteForce,
    ];
}

/// Neighbour lists, or none (paper 5.3.1).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum Neighbours {
    /// Found once a step and stored.
    #[default]
    Stored,
    /// Found again by every loop: slower, but without the memory of the lists.
    Recomputed,
    /// Stored, and kept over several steps (Verlet 1967; paper section 2): lists are of all pairs within (1 + skin) h,
    /// and are found again when something has moved skin h/2.
    Verlet {
        /// Distance beyond the support radius within which pairs are listed, in support radii \[-].
        #[serde(default = "skin")]
        skin: f32,
    },
}

fn skin() -> f32 {
    0.1
}

/// Limits of the failure guard.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Largest tolerated compression `(ρ − ρ0)/ρ0` \[-].
    pub compression: f32,
    /// Largest tolerated work of pressure over the last steps \[-], in the energies that they can draw on (see
    /// [`guard`](crate::integrate::guard)).
    pub energy: f32,
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
            numerical: None,
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

impl Default for Adaptive {
    fn default() -> Self {
        let Cfl { min, max, .. } = Cfl::default();
        Self {
            min,
            max,
            initial: None,
            density_error: 0.01,
            max_density_error: 0.2,
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
        Self {
            compression: 0.5,
            energy: 0.5,
        }
    }
}

/// How the systems of a step are run. The loops inside them are parallel either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Executor {
    /// The faster one: one system at a time, at every size.
    #[default]
    Auto,
    /// Systems that touch different data run side by side: a host's own beside the engine's, which are one chain. Every
    /// loop has to wake the pool then: a step of PCISPH takes 2.3 times as long with 1 000 particles, 1.25 times with
    /// 8 000 and 1.025 times with 130 000.
    Parallel,
    /// One system at a time, in the pool of the loops (see [`take_step`](crate::take_step)).
    SingleThreaded,
}

/// The order of the rows after a reordering.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum RowOrder {
    /// Along a Z-curve through the cells: what is near in space is near in memory (paper 4.5.4).
    #[default]
    ZCurve,
    /// By the index of the cells, which is their hash (paper eq. 3). Cells side by side are far apart in memory:
    /// slower, and there for comparison with it (Figure 4).
    CellIndex,
}
