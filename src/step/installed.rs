//! What a world has of the scene that is installed in it.

use bevy_ecs::prelude::*;

use super::order::Due;
use crate::{pairs::choice::KernelChoice, scene::Scene, state::Stage};

/// Path of a file that a scene names, its length \[bytes] and a checksum of its content.
pub(crate) type NamedFile = (String, u64, u32);

/// The scene that is installed in a world.
#[derive(Resource, Debug, Clone)]
pub(crate) struct Installed {
    /// The scene as the host passed it.
    pub(crate) scene: Scene,
    /// The files that the scene names, as they were read.
    pub(crate) files: Vec<NamedFile>,
    /// The stages of a step in their order, with their conditions, and the number of steps between two runs of each.
    pub(crate) stages: Vec<(String, u64)>,
    /// When each is due.
    pub(crate) due: Vec<Due>,
    /// Whether a stage reads what an earlier step left.
    pub(crate) reads_stale: bool,
    /// Stages with another kernel than the scene's.
    pub(crate) with_kernels: Vec<(Stage, KernelChoice)>,
}
