//! Simpler scenes: what one could do without, each by an override.

use crate::{
    loading::Override,
    scene::{
        Criterion, KernelFunction, Neighbours, PressureMethod, Scene, SceneError, SurfaceTension,
        TimeStep, Viscosity, WallSlip,
    },
};

/// A simpler scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// What is simpler, in words.
    pub what: String,
    /// Overrides, in the form of `--set`.
    pub set: Vec<String>,
}

impl Change {
    fn new(what: impl Into<String>, set: &[&str]) -> Self {
        Self {
            what: what.into(),
            set: set.iter().map(|&text| text.to_owned()).collect(),
        }
    }

    /// The scene with the change.
    pub fn scene(&self, scene: &Scene) -> Result<Scene, SceneError> {
        let changed = self.set.iter().try_fold(scene.clone(), |scene, text| {
            Override::parse(text)?.apply(&scene)
        })?;
        changed.check()?;
        Ok(changed)
    }
}

/// The simpler scenes that a scene has: of each thing that it asks for, the scene without, or with less of it.
pub fn simpler(scene: &Scene) -> Vec<Change> {
    let mut changes = Vec::new();
    let holds: Vec<String> = (scene.boundaries.iter().enumerate())
        .filter(|(_, wall)| wall.slip() != WallSlip::Free)
        .map(|(k, _)| format!("boundaries.{k}.slip=Free"))
        .collect();
    if scene.fluid.viscosity != Viscosity::None {
        // Walls hold what is viscous alone.
        let none = "fluid.viscosity=None".to_owned();
        changes.push(Change {
            what: "without viscosity".to_owned(),
            set: [none].into_iter().chain(holds.iter().cloned()).collect(),
        });
    }
    if scene.numerical_viscosity() > 0.0 {
        let set = &["fluid.viscosity.numerical=0"];
        changes.push(Change::new("without numerical viscosity", set));
    }
    if scene.fluid.surface_tension != SurfaceTension::None {
        let set = &["fluid.surface_tension=None"];
        changes.push(Change::new("without surface tension", set));
    }
    if !holds.is_empty() {
        changes.push(Change {
            what: "walls without friction".to_owned(),
            set: holds,
        });
    }
    if !scene.gauges.is_empty() {
        changes.push(Change::new("without gauges", &["gauges=[]"]));
    }
    if scene.reorder_interval > 0 {
        changes.push(Change::new("without reordering", &["reorder_interval=0"]));
    }
    if scene.neighbours == Neighbours::Stored {
        let set = &["neighbours=Recomputed"];
        changes.push(Change::new("neighbours recomputed", set));
    }
    if scene.kernel() != KernelFunction::CubicSpline || scene.support() > 2.0 {
        let set = &["kernel=CubicSpline", "support=2"];
        changes.push(Change::new("cubic spline, support 2", set));
    }
    if let Some((error, criterion)) = tolerance(&scene.pressure) {
        let set = format!("pressure.max_density_error={:e}", 10.0 * error);
        let what = match criterion {
            Criterion::Largest => "ten times the tolerance (largest error)",
            Criterion::Mean => "ten times the tolerance (mean error)",
        };
        changes.push(Change::new(what, &[&set]));
    }
    if let PressureMethod::Dfsph(method) = scene.pressure
        && method.max_divergence_iterations > 1
    {
        let set = &[
            "pressure.min_divergence_iterations=0",
            "pressure.max_divergence_iterations=1",
        ];
        changes.push(Change::new("one divergence iteration at most", set));
    }
    if matches!(scene.time_step, TimeStep::Fixed(_)) {
        changes.push(Change::new("time step by the motion", &["time_step=Cfl"]));
    }
    // What the checks refuse for this scene is no change for it.
    changes.retain(|change| change.scene(scene).is_ok());
    changes
}

/// The tolerance of a method that iterates.
pub(super) fn tolerance(pressure: &PressureMethod) -> Option<(f32, Criterion)> {
    match pressure {
        PressureMethod::Sesph(_) | PressureMethod::DeltaSph(_) => None,
        PressureMethod::Pcisph(method) => Some((method.max_density_error, method.criterion)),
        PressureMethod::Iisph(method) => Some((method.max_density_error, method.criterion)),
        PressureMethod::Dfsph(method) => Some((method.max_density_error, method.criterion)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(rest: &str) -> Scene {
        let text = format!(
            "(name: \"t\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0.5)))], {rest})"
        );
        Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn a_scene_has_changes_for_what_it_asks_for_alone() {
        let bare = "fluid: (viscosity: None), pressure: Sesph(equation: Gas(stiffness: 100)), reorder_interval: 0, \
                    neighbours: Recomputed, time_step: Cfl(), kernel: CubicSpline, support: 2";
        assert_eq!(simpler(&scene(bare)), []);
        let all = "fluid: (viscosity: Laminar(kinematic_viscosity: 0.01, numerical: 0.1), surface_tension: \
                   BeckerTeschner(kappa: 1)), pressure: Dfsph(), kernel: WendlandC4, time_step: Fixed(0.001), \
                   gauges: [(name: \"e\", kind: Energy)], boundaries: [Tank(min: (0, 0, 0), max: (1, 1, 1), slip: \
                   NoSlip)]";
        let all = scene(all);
        let found = simpler(&all);
        assert_eq!(found.len(), 11, "{found:?}");
        for change in &found {
            let changed = change.scene(&all).unwrap_or_else(|error| panic!("{error}"));
            assert_ne!(changed, all, "{change:?}");
        }
    }
}
