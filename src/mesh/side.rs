//! Which side of a surface is solid.

use serde::{Deserialize, Serialize};

/// Where the solid is that a mesh bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum MeshSide {
    /// The mesh is closed and the solid in it: fluid is outside. The winding must be the same all over a shell; a shell
    /// within another bounds a cavity and is wound the other way. Shells that cross are refused.
    #[default]
    Outside,
    /// The mesh is closed and fluid is in it, as in a tank. Shells as above, with fluid in the place of the solid.
    Inside,
    /// Fluid is where triangles are seen counter-clockwise, the solid behind them. The mesh may be open, as a terrain
    /// is; past its border there is nothing.
    Front,
    /// A sheet with fluid on both sides, or thin walls that need not be closed. It acts as a wall as thick as twice the
    /// depth of the layer of samples, about 1.2 spacings.
    Both,
}
