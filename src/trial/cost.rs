//! What the parts of a scene cost, and what could go.

use std::ops::ControlFlow;

use super::{
    Change, Trial, TrialError,
    run::{End, Limits, run},
    simpler,
};
use crate::{Plan, plan, scene::Scene, step::InstallError};

/// A trial whose particles moved less than this part of a spacing says nothing about what moves them.
const LEAST_WAY: f64 = 1e-4;

/// What the parts of a scene cost.
#[derive(Debug)]
pub struct Cost {
    /// The trial of the scene.
    pub trial: Trial,
    /// Memory of a fluid particle by purpose \[bytes].
    pub bytes: Vec<(&'static str, f64)>,
    /// What simpler scenes would save.
    pub savings: Vec<Saving>,
}

/// A simpler scene beside the scene.
#[derive(Debug)]
pub struct Saving {
    /// What is simpler.
    pub change: Change,
    /// What it saves and changes, or why it does not run.
    pub outcome: Result<Saved, TrialError>,
}

/// What a simpler scene saves and changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Saved {
    /// Wall time per simulated time, over that of the scene \[-].
    pub cost: f64,
    /// Pressure iterations of a step.
    pub iterations: f64,
    /// Memory of a fluid particle, less that of the scene \[bytes].
    pub bytes: f64,
    /// Root mean square of the distances between the particles of both at the same time, over that of their ways \[-].
    pub difference: f64,
}

/// Runs a scene for a number of steps, and every simpler scene for the same simulated time. `tell` gets what is run and
/// the completed fraction of all, and may stop it.
pub fn cost(
    scene: &Scene,
    steps: u64,
    (threads, seconds): (usize, f64),
    tell: &mut dyn FnMut(&str, f64) -> ControlFlow<()>,
) -> Result<Cost, TrialError> {
    let changes = simpler(scene);
    let all = changes.len() as f64 + 1.0;
    let limits = |end| Limits {
        end,
        threads,
        seconds,
    };
    let trial = run(scene, &limits(End::Steps(steps)), &mut |part| {
        tell("the scene", part / all)
    })?;
    let planned = plan(scene)?;
    let mut savings = Vec::new();
    for (k, change) in changes.into_iter().enumerate() {
        let mut told = |part: f64| tell(&change.what, (k as f64 + 1.0 + part) / all);
        let outcome = match saved(
            scene,
            &planned,
            &change,
            (&trial, &limits(End::Time(trial.time))),
            &mut told,
        ) {
            Err(TrialError::Asked) => return Err(TrialError::Asked),
            outcome => outcome,
        };
        savings.push(Saving { change, outcome });
    }
    Ok(Cost {
        bytes: planned.bytes_per_particle,
        trial,
        savings,
    })
}

fn saved(
    scene: &Scene,
    planned: &Plan,
    change: &Change,
    (base, limits): (&Trial, &Limits),
    tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Saved, TrialError> {
    let changed = change.scene(scene).map_err(InstallError::Scene)?;
    let trial = run(&changed, limits, tell)?;
    let bytes = |plan: &Plan| -> f64 { plan.bytes_per_particle.iter().map(|part| part.1).sum() };
    let way = base.way().max(LEAST_WAY * f64::from(scene.spacing));
    Ok(Saved {
        cost: trial.cost() / base.cost(),
        iterations: trial.iterations as f64 / trial.steps.max(1) as f64,
        bytes: bytes(&plan(&changed)?) - bytes(planned),
        difference: base.distance(&trial) / way,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gauges change nothing, recomputed neighbours rounding at most, and a viscosity as thick as honey much.
    #[test]
    fn what_changes_nothing_is_told_from_what_does() {
        let text = "(name: \"t\", dimension: 2, spacing: 0.05, bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.4, \
                    0)), velocity_field: TaylorGreen(speed: 1.0, wavelength: 0.4))], boundaries: [Tank(min: (0, 0, \
                    0), max: (1, 1, 0))], fluid: (viscosity: Laminar(kinematic_viscosity: 0.2)), gauges: [(name: \
                    \"e\", kind: Energy)], time_step: Fixed(0.0005))";
        let scene = Scene::parse(text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut told = Vec::new();
        let cost = cost(&scene, 30, (1, 600.0), &mut |what, part| {
            told.push((what.to_owned(), part));
            ControlFlow::Continue(())
        });
        let cost = cost.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(cost.trial.steps, 30);
        assert!(
            told.windows(2).all(|pair| pair[0].1 <= pair[1].1)
                && told.last().is_some_and(|last| last.1 <= 1.0)
        );
        let saved = |what: &str| {
            let found = cost
                .savings
                .iter()
                .find(|saving| saving.change.what == what);
            let found = found.unwrap_or_else(|| panic!("{what}: {:?}", cost.savings));
            *found
                .outcome
                .as_ref()
                .unwrap_or_else(|error| panic!("{what}: {error}"))
        };
        assert_eq!(saved("without gauges").difference, 0.0);
        assert!(saved("neighbours recomputed").difference < 1e-3);
        assert!(saved("neighbours recomputed").bytes < -10.0);
        assert!(
            saved("without viscosity").difference > 0.01,
            "{:?}",
            saved("without viscosity")
        );
        assert!(saved("without viscosity").cost > 0.0);
    }

    #[test]
    fn a_trial_can_be_stopped() {
        let text = "(name: \"t\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.3, 0.3)))])";
        let scene = Scene::parse(text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        let stopped = cost(&scene, 5, (1, 600.0), &mut |what, _| {
            if what == "the scene" {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        });
        assert!(matches!(stopped, Err(TrialError::Asked)));
    }
}
