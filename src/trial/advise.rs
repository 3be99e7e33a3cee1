//! The cheapest settings of a scene that hold an error, by trials of the scene itself.
//!
//! A trial with tight settings is the reference: DFSPH with a density error of 1e-5 and half the usual time step.
//! Trials with looser settings are compared with it over the same simulated time. The spacing stays: its error is in
//! all of them.

use std::ops::ControlFlow;

use super::{
    Limits, Trial, TrialError,
    run::{End, run},
};
use crate::{
    Plan,
    loading::Override,
    measure::{distance, range},
    plan,
    scene::{Scene, SceneError, unknown_name},
    step::InstallError,
};

/// The settings of the reference.
const TIGHT: [&str; 2] = [
    "pressure=Dfsph(max_density_error: 1e-5, max_divergence_error: 1e-4)",
    "time_step=Cfl(factor: 0.1)",
];

/// Part of the energy of the start, or of the fluid's size, that the error of a curve is relative to at least: what
/// hardly moves has no range of its own.
const FLOOR: f64 = 0.01;

/// What is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Asked {
    /// Largest error that is allowed \[-].
    pub error: f64,
    /// The curve whose error it is: `energy`, `centre_x`, `centre_y`, `centre_z` or a gauge.
    pub measure: String,
    /// Simulated time of a trial \[s]; a fall through the fluid's height if absent.
    pub time: Option<f64>,
    /// Threads; 0 for all cores.
    pub threads: usize,
    /// Wall time of the reference at most \[s].
    pub seconds: f64,
}

/// Settings of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Overrides, in the form of `--set`.
    pub set: Vec<String>,
}

/// Settings, and what their trial found.
#[derive(Debug)]
pub struct Tried {
    /// The settings.
    pub setting: Setting,
    /// Error of the curve \[-] and wall time per simulated time \[s/s], or why there are none.
    pub outcome: Result<(f64, f64), TrialError>,
}

/// What the trials found.
#[derive(Debug)]
pub struct Advice {
    /// Simulated time of the trials \[s].
    pub time: f64,
    /// Wall time per simulated time of the reference \[s/s].
    pub reference_cost: f64,
    /// All trials, the cheapest first, then those without a result.
    pub tried: Vec<Tried>,
    /// Number of the cheapest one that holds the error.
    pub chosen: Option<usize>,
}

impl Setting {
    fn new(pressure: String, factor: f64) -> Self {
        Self {
            set: vec![
                format!("pressure={pressure}"),
                format!("time_step=Cfl(factor: {factor})"),
            ],
        }
    }

    /// Lines of a scene file.
    pub fn lines(&self) -> Vec<String> {
        let line = |text: &String| {
            let (path, value) = text.split_once('=').unwrap_or((text, ""));
            format!("{path}: {value},")
        };
        self.set.iter().map(line).collect()
    }

    fn scene(&self, scene: &Scene) -> Result<Scene, SceneError> {
        with(scene, self.set.iter().map(String::as_str))
    }
}

impl Advice {
    /// The costliest of the settings that are cheaper than the chosen ones and do not hold the error.
    pub fn next_cheaper(&self) -> Option<&Tried> {
        let cheaper = self.tried.get(..self.chosen?)?;
        cheaper.iter().rev().find(|tried| tried.outcome.is_ok())
    }
}

fn with<'a>(scene: &Scene, set: impl Iterator<Item = &'a str>) -> Result<Scene, SceneError> {
    let mut set = set;
    let changed = set.try_fold(scene.clone(), |scene, text| {
        Override::parse(text)?.apply(&scene)
    })?;
    changed.check()?;
    Ok(changed)
}

/// Settings to try, for fluid as fast as `speed` \[m/s].
fn settings(scene: &Scene, speed: f64) -> Vec<Setting> {
    let mut all = Vec::new();
    for times in [10.0, 20.0] {
        let stiffness = f64::from(scene.fluid.rest_density) * (times * speed).powi(2) / 7.0;
        all.push(Setting::new(
            format!("Sesph(equation: Tait(stiffness: {stiffness:.4e}))"),
            0.2,
        ));
    }
    for factor in [0.4, 0.2] {
        for error in ["0.1", "0.01", "0.001"] {
            all.push(Setting::new(
                format!("Pcisph(max_density_error: {error})"),
                factor,
            ));
        }
        for method in ["Iisph", "Dfsph"] {
            for error in ["0.01", "0.001", "0.0001"] {
                all.push(Setting::new(
                    format!("{method}(max_density_error: {error})"),
                    factor,
                ));
            }
        }
    }
    all
}

/// Height of the fluid along gravity \[m], and the speed of a fall through it with that of the start \[m/s].
fn fall(scene: &Scene, plan: &Plan) -> (f64, f64) {
    let (low, high) = plan.fluid_box;
    let along = scene.gravity.normalize_or_zero().abs();
    let height = f64::from(along.dot(high - low) + scene.spacing);
    let start = f64::from(scene.max_initial_speed());
    let g = f64::from(scene.gravity.length());
    (height, (2.0 * g * height + start * start).sqrt())
}

/// Time of a fall from a height \[s], or a tenth of the scene's; not more than the scene's.
fn time_of_fall(scene: &Scene, height: f64) -> f64 {
    let g = f64::from(scene.gravity.length());
    let natural = if g > 0.0 {
        (2.0 * height / g).sqrt()
    } else {
        0.1 * f64::from(scene.duration)
    };
    natural.min(scene.duration.into())
}

/// Finds the cheapest settings that hold an error. `tell` gets what is run and the completed fraction of all trials,
/// and may stop it. A trial that has cost more than the cheapest that holds is given up.
pub fn advise(
    scene: &Scene,
    asked: &Asked,
    tell: &mut dyn FnMut(&str, f64) -> ControlFlow<()>,
) -> Result<Advice, AdviceError> {
    let planned = plan(scene).map_err(TrialError::Refused)?;
    let (height, speed) = fall(scene, &planned);
    let time = asked.time.unwrap_or_else(|| time_of_fall(scene, height));
    let mut limits = Limits {
        end: End::Time(time),
        threads: asked.threads,
        seconds: asked.seconds,
    };
    let candidates = settings(scene, speed.max(1e-3));
    let all = candidates.len() as f64 + 1.0;
    let tight = with(scene, TIGHT.into_iter())
        .map_err(InstallError::Scene)
        .map_err(TrialError::Refused)?;
    let reference = run(&tight, &limits, &mut |part| {
        tell("the reference", part / all)
    })?;
    let Some(known) = reference.curves.get(&asked.measure) else {
        let names: Vec<&str> = reference.curves.keys().map(String::as_str).collect();
        return Err(AdviceError::Measure(unknown_name(
            "measure",
            &asked.measure,
            None,
            &names,
        )));
    };
    let energy = f64::from(planned.particle_mass) * planned.particles as f64 * 0.5 * speed * speed;
    let floor = match asked.measure.as_str() {
        "energy" => FLOOR * energy,
        name if name.starts_with("centre_") => {
            FLOOR * f64::from((planned.fluid_box.1 - planned.fluid_box.0).max_element())
        }
        _ => 0.0,
    };
    let scale = range(known).max(floor);
    if scale <= 0.0 || scale.is_nan() {
        return Err(AdviceError::Measure(format!(
            "`{}` is the same all the time in {time:.4} s; give a longer --time, or another --measure",
            asked.measure
        )));
    }
    let mut tried = Vec::new();
    let mut cheapest = asked.seconds;
    for (k, setting) in candidates.into_iter().enumerate() {
        let name = setting.set.join(", ");
        let mut told = |part: f64| tell(&name, (k as f64 + 1.0 + part) / all);
        limits.seconds = cheapest;
        let outcome = trial_of(scene, &setting, &limits, &mut told).map(|trial| {
            let found = trial.curves.get(&asked.measure);
            let error = found.map_or(f64::NAN, |found| distance(found, known) / scale);
            if error <= asked.error {
                // Set-up is not counted, so the limit leaves it some room.
                cheapest = cheapest.min(1.5 * trial.wall() + 1.0);
            }
            (error, trial.cost())
        });
        if matches!(outcome, Err(TrialError::Asked)) {
            return Err(TrialError::Asked.into());
        }
        tried.push(Tried { setting, outcome });
    }
    let cost = |tried: &Tried| {
        tried
            .outcome
            .as_ref()
            .map_or(f64::INFINITY, |found| found.1)
    };
    tried.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let holds = |tried: &Tried| matches!(tried.outcome, Ok((error, _)) if error <= asked.error);
    Ok(Advice {
        time,
        reference_cost: reference.cost(),
        chosen: tried.iter().position(holds),
        tried,
    })
}

fn trial_of(
    scene: &Scene,
    setting: &Setting,
    limits: &Limits,
    tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Trial, TrialError> {
    let scene = setting.scene(scene).map_err(InstallError::Scene)?;
    run(&scene, limits, tell)
}

/// Why there is no advice.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AdviceError {
    /// The reference has no result, or the caller stopped.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// The measure is none of the scene's, or says nothing.
    #[error("{0}")]
    Measure(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let text = "(name: \"t\", dimension: 2, spacing: 0.05, bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.8, \
                    0)))], boundaries: [Tank(min: (0, 0, 0), max: (1.2, 1.2, 0))], gauges: [(name: \"front\", kind: \
                    Front(direction: (1, 0, 0)))])";
        Scene::parse(text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"))
    }

    fn asked(error: f64, measure: &str) -> Asked {
        Asked {
            error,
            measure: measure.to_owned(),
            time: Some(0.15),
            threads: 1,
            seconds: 600.0,
        }
    }

    #[test]
    fn the_settings_hold_the_error_and_the_cheaper_ones_do_not() {
        let scene = scene();
        for measure in ["energy", "front"] {
            let asked = asked(0.3, measure);
            let advice = advise(&scene, &asked, &mut |_, _| ControlFlow::Continue(()));
            let advice = advice.unwrap_or_else(|error| panic!("{error}"));
            let chosen = advice
                .chosen
                .unwrap_or_else(|| panic!("{measure}: {:?}", advice.tried));
            let holds = |tried: &Tried| matches!(tried.outcome, Ok((error, _)) if error <= 0.3);
            assert!(holds(&advice.tried[chosen]));
            assert!(!advice.tried[..chosen].iter().any(holds));
            assert!(advice.next_cheaper().is_none_or(|next| !holds(next)));
            // What is advised can be pasted.
            let lines = advice.tried[chosen].setting.lines().join("\n");
            let text = format!(
                "(name: \"t\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))], {lines})"
            );
            Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
            // An error that every trial has is held by the cheapest.
            let loose = Asked {
                error: 1e9,
                ..asked
            };
            let loose = advise(&scene, &loose, &mut |_, _| ControlFlow::Continue(()))
                .unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(loose.chosen, Some(0));
        }
    }

    #[test]
    fn what_cannot_be_measured_is_said() {
        let none = advise(&scene(), &asked(0.01, "frond"), &mut |_, _| {
            ControlFlow::Continue(())
        });
        assert!(
            none.expect_err("no gauge")
                .to_string()
                .contains("did you mean `front`?")
        );
        let text = "(name: \"t\", dimension: 2, spacing: 0.1, gravity: (0, 0, 0), bodies: [(shape: Box(min: (0, 0, 0), \
                    max: (0.4, 0.4, 0)))], gauges: [(name: \"front\", kind: Front(direction: (1, 0, 0)))])";
        let still = Scene::parse(text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        let flat = advise(&still, &asked(0.01, "front"), &mut |_, _| {
            ControlFlow::Continue(())
        });
        assert!(
            flat.expect_err("nothing moves")
                .to_string()
                .contains("the same all the time")
        );
    }

    #[test]
    fn settings_are_scenes() {
        let scene = scene();
        for setting in settings(&scene, 3.0) {
            setting
                .scene(&scene)
                .unwrap_or_else(|error| panic!("{setting:?}: {error}"));
            assert!(
                setting.lines()[0].starts_with("pressure: ") && setting.lines()[1].ends_with("),")
            );
        }
    }
}
