//! Another kernel for the sums of one stage.
//!
//! Forces that are opposite for both particles of a pair may have any kernel: momentum is conserved with each. The
//! lists hold the neighbours of the scene's support, so that of a stage is at most as large.

use bevy_ecs::prelude::*;

use crate::{
    kernel::Kernel,
    lattice::Lattice,
    scene::{KernelFunction, Scene},
    state::Systems,
};

/// A kernel for a stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct KernelChoice {
    pub(crate) function: KernelFunction,
    /// Support radius in spacings \[-].
    pub(crate) support: f32,
}

impl KernelChoice {
    /// The scene as the stage sees it.
    pub(crate) fn scene(self, scene: &Scene) -> Scene {
        Scene {
            kernel: Some(self.function),
            support: Some(self.support),
            ..scene.clone()
        }
    }

    /// Systems before the stage.
    pub(crate) fn begin(self, scene: &Scene) -> Systems {
        let of_stage = self.scene(scene);
        // Densities are those of the scene's kernel, for both.
        let shown = |scene: &Scene| {
            let lattice = Lattice::of(scene);
            lattice.shear_viscosity() * lattice.density()
        };
        let chosen = Chosen {
            kernel: Kernel::of(&of_stage),
            viscosity: (shown(scene) / shown(&of_stage)) as f32,
        };
        let begin = move |mut own: ResMut<OwnKernel>| own.0 = Some(chosen);
        begin.into_configs()
    }
}

/// Systems after the stage.
pub(crate) fn end() -> Systems {
    (|mut own: ResMut<OwnKernel>| own.0 = None).into_configs()
}

/// The kernel of the stage that runs, if it is not the scene's. In runs whose order has such stages.
#[derive(Resource, Debug, Default)]
pub(crate) struct OwnKernel(pub(super) Option<Chosen>);

#[derive(Debug, Clone, Copy)]
pub(super) struct Chosen {
    pub(super) kernel: Kernel,
    /// The viscosity that a sheared lattice shows with the scene's kernel, over that with this one \[-].
    pub(super) viscosity: f32,
}
