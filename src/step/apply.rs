//! Changes of a scene while it runs.

use bevy_ecs::prelude::*;

use super::{
    install::step_limits,
    installed::Installed,
    simulation::Simulation,
    uninstall::{NotBetweenSteps, between_steps},
};
use crate::{
    boundary::friction::WallFriction,
    force,
    integrate::GuardLimits,
    loading::Override,
    registry::Stages,
    scene::{GaugeKind, Scene, SceneError, TimeStep, Viscosity},
    state::{Clock, Material, seal::reseal},
    time_step::{self, AdaptiveTimeStep, RecoveryTime},
};

/// What may change while a scene runs, as a message lists it.
const CHANGEABLE: &str = "gravity, fluid.viscosity (numbers of the same model), the errors and iterations of pressure, \
                          time_step (numbers of the same kind), limits, duration and output";

/// Why a change of a running scene is refused. The scene goes on as it was.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ApplyError {
    /// No scene is installed in the world.
    #[error("no scene is installed in this world; call `install` first")]
    NotInstalled,
    /// A step is being taken, or a part of the scene is gone.
    #[error(transparent)]
    NotBetweenSteps(#[from] NotBetweenSteps),
    /// The override is none, or the changed scene makes no sense.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The field is fixed from the start of a run.
    #[error("`{path}` cannot change while the scene runs{reason}; what can: {CHANGEABLE}")]
    Fixed {
        /// Path of the field, as the override has it.
        path: String,
        /// Why, if not because particles, walls and stages are made from it; begins with a comma.
        reason: String,
    },
}

impl ApplyError {
    fn fixed(change: &Override, reason: &str) -> Self {
        Self::Fixed {
            path: change.path.clone(),
            reason: reason.to_owned(),
        }
    }
}

/// Changes the scene in a world between two steps: gravity, viscosity, tolerances, time step, limits, duration, output.
/// The next step is taken with them, and checkpoints hold the changed scene. All overrides apply, or none.
///
/// # Errors
/// When an override is none, the changed scene makes no sense, something else would change, or a system of the step
/// called it.
pub fn apply(world: &mut World, overrides: &[Override]) -> Result<(), ApplyError> {
    let installed = world
        .get_resource::<Installed>()
        .ok_or(ApplyError::NotInstalled)?;
    between_steps(world)?;
    let before = installed.scene.clone();
    let mut scene = before.clone();
    for change in overrides {
        let changed = change.apply(&scene)?;
        may_change(&scene, &changed, change)?;
        scene = changed;
    }
    scene.check()?;
    put(world, &before, &scene);
    if let Some(mut installed) = world.get_resource_mut::<Installed>() {
        installed.scene = scene;
    }
    reseal(world);
    Ok(())
}

/// Refuses a change of what is fixed.
fn may_change(before: &Scene, after: &Scene, change: &Override) -> Result<(), ApplyError> {
    let fixed = |reason: &str| Err(ApplyError::fixed(change, reason));
    let measures_level = |scene: &Scene| {
        let mut gauges = scene.gauges.iter();
        gauges.any(|gauge| matches!(gauge.kind, GaugeKind::Height { .. }))
    };
    let up = |scene: &Scene| scene.gravity.normalize_or_zero();
    if measures_level(before) && up(before).distance(up(after)) > 1e-6 {
        return fixed(", because a `Height` gauge measures against its direction");
    }
    let model = |scene: &Scene| match scene.fluid.viscosity {
        Viscosity::None => 0,
        Viscosity::Laminar { .. } => 1 + u8::from(scene.numerical_viscosity() > 0.0),
        Viscosity::Artificial { .. } => 3,
    };
    if model(before) != model(after) {
        return fixed(" to another model: a step has other stages then");
    }
    if std::mem::discriminant(&before.time_step) != std::mem::discriminant(&after.time_step) {
        return fixed(" to another kind: a step has other stages then");
    }
    let rest = Scene {
        gravity: before.gravity,
        fluid: crate::scene::Fluid {
            viscosity: before.fluid.viscosity,
            ..after.fluid
        },
        pressure: (after.pressure.solver()).with_tolerances_of(&before.pressure),
        time_step: before.time_step,
        limits: before.limits,
        duration: before.duration,
        output: before.output.clone(),
        ..after.clone()
    };
    if rest == *before { Ok(()) } else { fixed("") }
}

/// Gives the resources of a step their new values.
fn put(world: &mut World, before: &Scene, scene: &Scene) {
    if scene.gravity != before.gravity {
        world.resource_mut::<Material>().gravity = scene.gravity;
    }
    if scene.fluid.viscosity != before.fluid.viscosity {
        force::install_viscosity(world, scene);
        if let Some(mut friction) = world.get_resource_mut::<WallFriction>() {
            friction.set_viscosity(scene);
        }
    }
    if scene.pressure != before.pressure {
        scene.pressure.solver().set_tolerances(world);
    }
    if scene.limits != before.limits {
        world.insert_resource(GuardLimits(scene.limits));
    }
    let stages = world.get_resource::<Stages>().cloned().unwrap_or_default();
    let with_kernels = (world.get_resource::<Installed>())
        .map_or_else(Vec::new, |installed| installed.with_kernels.clone());
    let limits = step_limits(scene, &stages, &with_kernels);
    let Clock { next_dt, step, .. } = *world.resource::<Clock>();
    let has_begun = step > 0;
    if let Some(iterations) = scene.pressure.iterations().filter(|_| !has_begun)
        && let Some(recovery) = RecoveryTime::new(iterations.recovery, iterations.is_linear, scene)
    {
        world.insert_resource(recovery);
    }
    let next_dt = match scene.time_step {
        TimeStep::Fixed(dt) => dt,
        TimeStep::Cfl(cfl) => {
            // Stateless: it is created again.
            let first = time_step::install(world, scene, &limits);
            let by_forces = time_step::motion_limits(
                1.0,
                scene.support_radius(),
                0.0,
                scene.greatest_acceleration(),
            );
            match has_begun {
                false => first,
                true => next_dt
                    .min(by_forces[1].1)
                    .min(limits.constant)
                    .clamp(cfl.min, cfl.max),
            }
        }
        TimeStep::Adaptive(scheme) => match world.get_resource_mut::<AdaptiveTimeStep>() {
            Some(mut control) => control.set_scheme(scheme, &limits, next_dt),
            None => next_dt,
        },
    };
    world.resource_mut::<Clock>().next_dt = next_dt;
}

impl Simulation {
    /// Changes the scene while it runs, between two steps: see [`apply`].
    ///
    /// ```
    /// use overfall::{Override, Simulation, scene::Scene};
    ///
    /// let scene = r#"(
    ///     name: "drop of water",
    ///     spacing: 0.1,
    ///     bodies: [(shape: Sphere(center: (0, 1, 0), radius: 0.3))],
    /// )"#;
    /// let scene = Scene::parse(scene, "drop.ron", &[]).expect("a scene");
    /// let mut simulation = Simulation::new(&scene).expect("threads");
    /// simulation.step().expect("a step");
    /// let moon = Override::parse("gravity=(0, -1.62, 0)").expect("an override");
    /// simulation.apply(&[moon]).expect("gravity may change");
    /// let finer = Override::parse("spacing=0.05").expect("an override");
    /// let error = simulation.apply(&[finer]).expect_err("the spacing may not");
    /// assert!(error.to_string().contains("`spacing` cannot change while the scene runs"));
    /// simulation.step().expect("a step");
    /// ```
    ///
    /// # Errors
    /// As [`apply`].
    pub fn apply(&mut self, overrides: &[Override]) -> Result<(), ApplyError> {
        apply(self.world_mut(), overrides)
    }

    /// The scene that runs, changes included; none if a host has uninstalled it.
    pub fn scene(&self) -> Option<&Scene> {
        let installed = self.world().get_resource::<Installed>();
        installed.map(|installed| &installed.scene)
    }
}
