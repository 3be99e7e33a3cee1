//! Why a scene could not be set up.

use std::{fmt, path::PathBuf};

use glam::Vec3;

use super::order::OrderError;
use crate::{
    measure::CurveError,
    mesh::MeshError,
    ranks::Unsupported,
    scene::{Place, SceneError},
    state::DomainTooLarge,
};

/// Largest initial compression that is accepted. Lattices in corners have 0.008 (0.08 with a support of four spacings)
/// and fluid beside meshes has 0.02. Fluid behind half a plate of 0.8 spacings has 0.15.
pub(super) const LARGEST_ERROR: f32 = 0.1;

/// How far the initial density of the fluid exceeds the rest density.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct StartDensity {
    /// Largest `max(0, (ρ − ρ0)/ρ0)` \[-].
    pub max_error: f32,
    /// Position of the particle that has it \[m].
    pub place: Vec3,
    /// Mean of `max(0, (ρ − ρ0)/ρ0)` over all particles \[-].
    pub mean_error: f32,
    /// Mean energy that pressure makes of the errors \[J/kg]; 0 for a method without an equation of state.
    pub mean_energy: f64,
    /// Distance from that particle to the nearest other one, of the fluid or of a wall \[spacings]; infinite if there
    /// is none. In a lattice it is 1, beside a wall about as much.
    pub nearest: f32,
}

/// Fluid whose density errors an equation of state turns into motion.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Burst {
    /// Mean of `max(0, (ρ − ρ0)/ρ0)` at the start \[-].
    pub mean_error: f32,
    /// Speed of sound \[m/s].
    pub sound_speed: f32,
    /// Root mean square of the speeds that follow \[m/s].
    pub speed: f32,
    /// Largest speed that the scene expects \[m/s].
    pub expected: f32,
}

impl Burst {
    /// Speed over the expected one \[-].
    pub(super) fn ratio(&self) -> f32 {
        self.speed / self.expected
    }

    /// Whether it is worth a warning.
    pub(super) fn is_felt(&self) -> bool {
        self.ratio() > 0.3
    }
}

impl fmt::Display for Burst {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            mean_error,
            sound_speed,
            speed,
            expected,
        } = self;
        write!(
            f,
            "the fluid starts {:.1} % above its rest density on average, which with a speed of sound of \
             {sound_speed:.3} m/s throws it apart with about {speed:.3} m/s, single particles with three times as \
             much, and the scene has {expected:.3} m/s; a smaller `jitter.amplitude`, a softer fluid, or a method that \
             works density errors off (`pressure: Dfsph`)",
            100.0 * mean_error
        )
    }
}

/// Fluid that starts compressed beyond the scene's limit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Crowd {
    /// Density at the start.
    pub start: StartDensity,
    /// The limit, `limits.compression` \[-].
    pub limit: f32,
    /// Largest amplitude of the scene's jitters \[spacings].
    pub amplitude: f32,
}

impl fmt::Display for Crowd {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            start,
            limit,
            amplitude,
        } = self;
        let place = start.place;
        write!(
            f,
            "the fluid starts {:.1} % above its rest density at ({:.4}, {:.4}, {:.4}) m, more than the {:.1} % of \
             `limits.compression`: the first step would fail; ",
            100.0 * start.max_error,
            place.x,
            place.y,
            place.z,
            100.0 * limit
        )?;
        if *amplitude == 0.0 {
            let fitting = (110.0 * start.max_error).ceil() / 100.0;
            return write!(f, "{fitting} leaves room");
        }
        // Compression grows faster than the amplitude.
        let fitting = (95.0 * amplitude * limit / start.max_error).floor() / 100.0;
        write!(
            f,
            "its jitter is {amplitude} spacings, and a `jitter.amplitude` of {fitting} would do"
        )
    }
}

/// How much too near something is to the particle that is compressed most.
fn depth(start: &StartDensity) -> String {
    let nearest = start.nearest;
    if nearest < 1.0 {
        let depth = 1.0 - nearest;
        format!(
            "the nearest particle is {nearest:.2} spacings away, too near by {depth:.2} spacings"
        )
    } else {
        format!("several are as near as one may be, {nearest:.2} spacings")
    }
}

/// Why a scene could not be set up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InstallError {
    /// The world already has a scene.
    #[error("a scene is installed in this world already; a world holds one")]
    Occupied,
    /// The schedule of the step has systems already, which it would lose.
    #[error(
        "the schedule `Step` has systems already ({systems}); add them after `install`, which makes this schedule"
    )]
    StepHasSystems {
        /// Their number.
        systems: usize,
    },
    /// The scene contradicts itself.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene's spatial index cannot cover its fluid.
    #[error("fluid: {0}")]
    Fluid(DomainTooLarge),
    /// The scene's spatial index cannot cover its walls.
    #[error("boundary: {0}")]
    Boundary(DomainTooLarge),
    /// The fluid is so compressed at the start that it would explode.
    #[error(
        "the fluid starts {:.1} % above its rest density at ({:.4}, {:.4}, {:.4}) m, more than {:.0} %: a wall, or \
         other fluid, is nearer there than it may be ({}); move the fluid away from there by a part of the spacing, or \
         let walls that are thinner than 1.2 spacings be thicker",
        100.0 * .0.max_error, .0.place.x, .0.place.y, .0.place.z, 100.0 * LARGEST_ERROR, depth(.0)
    )]
    Compressed(StartDensity),
    /// The fluid is compressed by more than the failure guard allows: the first step would fail.
    #[error("{0}")]
    Crowded(Crowd),
    /// The equation of state makes a burst of the density errors at the start.
    #[error("{0}")]
    Bursts(Burst),
    /// The file of a mesh was removed or changed since the scene was checked.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The file of a table was removed or changed since the scene was checked.
    #[error(transparent)]
    Table(#[from] CurveError),
    /// The operating system refused to start threads.
    #[error("could not start threads: {0}")]
    Threads(std::io::Error),
    /// The operating system refused to start the threads for parallel systems.
    #[error("could not start threads for systems: {0}")]
    TaskThreads(std::io::Error),
    /// The machine has too little memory for the scene.
    #[error("the scene needs about {needed} of memory, and there are {machine}: {parts}; {remedy}")]
    Memory {
        /// Memory that it needs.
        needed: String,
        /// Memory that is available.
        machine: String,
        /// What the memory is needed for.
        parts: String,
        /// A spacing that fits.
        remedy: String,
    },
    /// The limit of the process on its memory leaves too little for the scene.
    #[error(
        "the scene needs about {needed} of memory beside that of its threads, more than the limit of the process \
         leaves (`ulimit -v`); raise it, or run with fewer threads (`--threads`)"
    )]
    MemoryLimit {
        /// Memory that it needs.
        needed: String,
    },
    /// The order file cannot be read.
    #[error("order file {}: {error}", .path.display())]
    OrderFile {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        error: std::io::Error,
    },
    /// The order is refused.
    #[error("{}: {error}", .place.as_ref().map_or_else(|| "default order".to_owned(), ToString::to_string))]
    Order {
        /// The place in the file, unless it is the default order.
        place: Option<Place>,
        /// Reason.
        error: OrderError,
    },
    /// The scene asks for what does not run on several ranks.
    #[error(transparent)]
    Unsupported(Unsupported),
    /// bevy refused the schedule.
    #[error("the schedule cannot be built: {0}")]
    Schedule(String),
}
