//! A case, and a run of it.

use std::ops::ControlFlow;

use super::{Findings, Method, Runner, Spent, Stopped};
use crate::{
    Simulation,
    loading::Override,
    scene::{Scene, SceneError},
};

/// A flow with a known answer.
#[derive(Debug)]
pub struct Case {
    /// Its folder in `assets/cases`.
    pub name: &'static str,
    /// A description in one line.
    pub title: &'static str,
    /// Scene and page (Markdown), the files of the folder.
    pub texts: (&'static str, &'static str),
    /// Name of the characteristic length; the spacing is this length divided by the resolution.
    pub across: &'static str,
    /// The resolution of the scene file.
    pub resolution: u32,
    /// The resolutions for its convergence; each is twice the previous one.
    pub resolutions: [u32; 3],
    /// Speed of sound for SESPH \[m/s].
    pub sound_speed: f32,
    /// Runs the case and measures it.
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

    /// Runs the case with a method at a resolution. `tell` gets the completed fraction after every step.
    pub fn run(
        &self,
        method: &Method,
        resolution: u32,
        threads: usize,
        tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Findings, Stopped> {
        let scene = self.scene(method, resolution);
        let scene = scene.map_err(|error| Stopped::Refused(error.to_string()))?;
        self.run_scene(&scene, threads, tell).1
    }

    /// Runs a scene that differs from the case's in its settings alone, and says what its steps took, whether it was
    /// measured or not.
    pub fn run_scene(
        &self,
        scene: &Scene,
        threads: usize,
        tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> (Spent, Result<Findings, Stopped>) {
        match Simulation::with_threads(scene, threads) {
            Ok(simulation) => {
                let mut runner = Runner::new(simulation, tell);
                let found = (self.measure)(scene, &mut runner);
                (runner.spent(), found)
            }
            Err(error) => (Spent::default(), Err(Stopped::Refused(error.to_string()))),
        }
    }
}
