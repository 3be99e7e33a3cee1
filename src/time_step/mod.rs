//! The time step: fixed, as large as speeds, forces, viscosity and sound allow, or the scheme of [`adaptive`] that goes
//! back from a shock.
//!
//! | limit | dt at most | source |
//! | --- | --- | --- |
//! | speed | λ h/v_max, λ of the scene | Courant–Friedrichs–Lewy; paper 4.3.2: nothing moves more than h/2 |
//! | force | 0.25 sqrt(h/a_max) | Monaghan 1992 |
//! | viscosity | h²/(32 ν), 1/8 of the square of the smoothing length h/2 | Morris et al. 1997, eq. 23 |
//! | sound | 0.4 h/c | Becker & Teschner 2007, eq. 18 |
//! | pressure | half of what waves of a lattice under the largest pressure allow | [`lattice`](crate::lattice) |
//!
//! These are the limits of `Cfl`. Speeds and forces are those of the step before. Methods that iterate add a limit:
//! what an iteration costs is fixed, how many a step needs grows faster than its length, so a step that took more than
//! [`ITERATIONS`] is followed by a shorter one, and one whose error does not fall is halved before anything moves.

pub mod adaptive;
pub mod roll_back;

use bevy_ecs::prelude::*;

pub use adaptive::AdaptiveTimeStep;

use crate::{
    integrate::Motion,
    lattice::Lattice,
    pressure::{PressureSolve, recovery::RecoveryTime, state_equation::EquationOfState},
    scene::{Cfl, Dfsph, Iisph, Pcisph, PressureMethod, Scene, TimeStep, Viscosity},
    state::{Clock, Material},
};

const FORCE_FACTOR: f32 = 0.25;
const VISCOSITY_FACTOR: f32 = 1.0 / 32.0;
const SOUND_FACTOR: f32 = 0.4;
/// Part of the longest step in which a lattice is stable under its pressure. The first row beside a wall, and fluid
/// under an impact, have more pressure than their depth.
const PRESSURE_FACTOR: f32 = 0.5;
/// A step is at most so much longer than the one before: after an impact it grows back gently.
const GROWTH: f32 = 1.1;

/// Pressure iterations above which the next step is shorter. Measured in a dam break with 10, 20, 30 and 50: the same
/// work in PCISPH, whose densities are truer in short steps; in IISPH and DFSPH, whose momentum carries further, a
/// tenth less from 20 on.
const ITERATIONS: u32 = 10;
const ITERATIONS_WITH_MOMENTUM: u32 = 20;
const SHRINKAGE: f32 = 0.9;

/// The control of a scene with `Cfl`.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct TimeStepControl {
    cfl: Cfl,
    /// Pressure iterations above which the next step is shorter.
    iterations: u32,
    /// What viscosity and sound allow [s]: constant through a run.
    constant_limit: f32,
    /// Spacings that `sqrt(p/ρ)` covers in the longest step that pressure allows [-]. With an equation of state sound
    /// is faster.
    pressure_step: f32,
}

/// A limit by its name [s].
pub type Limit = (&'static str, f32);

/// Limits that do not change in a run.
pub fn constant_limits(scene: &Scene) -> Vec<Limit> {
    let h = scene.support_radius();
    let mut limits = Vec::new();
    let viscosity = match scene.fluid.viscosity {
        Viscosity::None => 0.0,
        Viscosity::Laminar {
            kinematic_viscosity,
            ..
        } => kinematic_viscosity,
        // The kinematic viscosity that it amounts to in 3-D (Monaghan 2005, eq. 8.8), with its smoothing length h.
        Viscosity::Artificial { alpha, sound_speed } => alpha * h * sound_speed / 10.0,
    };
    if viscosity > 0.0 {
        limits.push(("viscosity", VISCOSITY_FACTOR * h * h / viscosity));
    }
    if let PressureMethod::Sesph(sesph) = scene.pressure {
        let sound_speed = EquationOfState(sesph.equation).sound_speed(scene.fluid.rest_density);
        limits.push(("sound", SOUND_FACTOR * h / sound_speed));
    }
    limits
}

/// Limits that a run is under from its first step on: those that never change, gravity, and the speed at the start,
/// with which nothing may move more than h/2.
pub(crate) fn certain_limits(scene: &Scene) -> Vec<Limit> {
    let h = scene.support_radius();
    let mut limits = constant_limits(scene);
    let [speed, force] = motion_limits(0.5, h, scene.max_initial_speed(), scene.gravity.length());
    limits.push(("gravity", force.1));
    limits.push(("the speed at the start", speed.1));
    limits.retain(|limit| limit.1.is_finite());
    limits
}

fn constant_limit(scene: &Scene) -> f32 {
    let limits = constant_limits(scene);
    limits
        .iter()
        .fold(f32::INFINITY, |least, limit| least.min(limit.1))
}

/// Limits by the motion, for a factor λ of the speed.
pub fn motion_limits(factor: f32, h: f32, max_speed: f32, max_acceleration: f32) -> [Limit; 2] {
    [
        ("speed", factor * h / max_speed),
        ("force", FORCE_FACTOR * (h / max_acceleration).sqrt()),
    ]
}

/// Longest time step [s] under a pressure [Pa], if `sqrt(p/ρ)` may cover so many spacings in a stable one.
pub(crate) fn pressure_limit(pressure_step: f32, material: &Material, pressure: f32) -> f32 {
    PRESSURE_FACTOR * pressure_step * material.spacing / (pressure / material.rest_density).sqrt()
}

/// Spacings that `sqrt(p/ρ)` may cover in a stable step of a scene [-]; any with an equation of state, whose sound is
/// faster.
pub(crate) fn pressure_step(scene: &Scene) -> f32 {
    match scene.pressure {
        PressureMethod::Sesph(_) => f32::INFINITY,
        _ => Lattice::of(scene).pressure_step() as f32,
    }
}

/// Inserts what the control of a scene's time step needs, and gives the first time step [s].
pub fn install(world: &mut World, scene: &Scene) -> f32 {
    if let Some(recovery) = RecoveryTime::of(scene) {
        world.insert_resource(recovery);
    }
    match scene.time_step {
        TimeStep::Fixed(dt) => dt,
        TimeStep::Cfl(cfl) => {
            let (dt, control) = TimeStepControl::new(cfl, scene);
            world.insert_resource(control);
            dt
        }
        TimeStep::Adaptive(scheme) => {
            let (dt, control) = adaptive::start(scheme, scene);
            world.insert_resource(control);
            world.init_resource::<roll_back::KeptState>();
            dt
        }
    }
}

impl TimeStepControl {
    /// The first time step [s] of a scene, and the control of the next ones.
    fn new(cfl: Cfl, scene: &Scene) -> (f32, Self) {
        let control = Self {
            cfl,
            iterations: match scene.pressure {
                PressureMethod::Iisph(Iisph { momentum, .. })
                | PressureMethod::Dfsph(Dfsph { momentum, .. })
                | PressureMethod::Pcisph(Pcisph { momentum, .. })
                    if momentum =>
                {
                    ITERATIONS_WITH_MOMENTUM
                }
                _ => ITERATIONS,
            },
            constant_limit: constant_limit(scene),
            pressure_step: pressure_step(scene),
        };
        let dt = control.choose(
            scene.support_radius(),
            scene.max_initial_speed(),
            scene.gravity.length(),
            f32::INFINITY,
        );
        (dt, control)
    }

    /// Half a time step [s], if the scene allows it.
    pub fn shorter(&self, dt: f32) -> Option<f32> {
        (0.5 * dt >= self.cfl.min).then_some(0.5 * dt)
    }

    fn choose(&self, h: f32, max_speed: f32, max_acceleration: f32, longest: f32) -> f32 {
        let motion = motion_limits(self.cfl.factor, h, max_speed, max_acceleration);
        motion
            .iter()
            .fold(self.constant_limit.min(longest), |least, limit| {
                least.min(limit.1)
            })
            .clamp(self.cfl.min, self.cfl.max)
    }
}

/// Chooses the next step's length (phase `Integrate`; with `Cfl` only).
pub fn choose_time_step(
    mut clock: ResMut<Clock>,
    control: Res<TimeStepControl>,
    motion: Res<Motion>,
    solve: Res<PressureSolve>,
    material: Res<Material>,
) {
    let h = material.kernel.support_radius;
    let change = if solve.iterations > control.iterations {
        SHRINKAGE
    } else {
        GROWTH
    };
    let pressure = pressure_limit(control.pressure_step, &material, motion.max_pressure);
    let longest = (change * clock.full_dt()).min(pressure);
    clock.next_dt = control.choose(h, motion.max_speed, motion.max_acceleration, longest);
}
