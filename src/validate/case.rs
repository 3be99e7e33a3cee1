//! What a case is, and a run of it.

use std::ops::ControlFlow;

use super::{Findings, Method, Runner, Stopped};
use crate::{
    Simulation,
    loading::Override,
    scene::{Scene, SceneError},
};

/// A flow whose answer is known.
#[derive(Debug)]
pub struct Case {
    /// Its folder in `assets/cases`.
    pub name: &'static str,
    /// What it is, in a line.
    pub title: &'static str,
    /// Scene and page of explanation (Markdown), the files of the folder.
    pub texts: (&'static str, &'static str),
    /// What particles are counted across: the spacing is this length over the resolution.
    pub across: &'static str,
    /// The resolution of the scene as it stands.
    pub resolution: u32,
    /// The resolutions that its convergence is measured at; each twice the one before.
    pub resolutions: [u32; 3],
    /// Speed of sound for SESPH \[m/s].
    pub sound_speed: f32,
    /// Runs and measures it.
    pub measure: fn(&Scene, &mut Runner) -> Result<Findings, Stopped>,
}

impl Case {
    /// The scene with a method at a resolution.
    pub fn scene(&self, method: &Method, resolution: u32) -> Result<Scene, SceneError> {
        let pressure = Override {
            path: "pressure".to_owned(),
            value: (method.pressure)(self.sound_speed),
        };
        let file = format!("assets/cases/{}/scene.ron", self.name);
        let mut scene = Scene::parse(self.texts.0, &file, &[pressure])?;
        if resolution != self.resolution {
            scene.spacing *= self.resolution as f32 / resolution as f32;
            scene.check()?;
        }
        Ok(scene)
    }

    /// Runs the case with a method at a resolution. `tell` is told which part is done, after every step.
    pub fn run(
        &self,
        method: &Method,
        resolution: u32,
        threads: usize,
        tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Findings, Stopped> {
        let refused = |error: &dyn std::fmt::Display| Stopped::Refused(error.to_string());
        let scene = self
            .scene(method, resolution)
            .map_err(|error| refused(&error))?;
        let simulation =
            Simulation::with_threads(&scene, threads).map_err(|error| refused(&error))?;
        (self.measure)(&scene, &mut Runner::new(simulation, tell))
    }
}
