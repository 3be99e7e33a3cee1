//! From a text to a checked scene: the file first, then the overrides, then the checks.
//!
//! Every error names file, line and column, what is wrong and what would be right. The methods of
//! [`Scene`](crate::scene::Scene) that read, check and write one are here, since checks know of walls, meshes and
//! time-step limits, of which the scene's own types do not.

mod check;
mod explain;
mod include;
mod load;
mod overrides;
mod ron_text;
mod slips;
mod spans;
mod written;

pub(crate) use check::Size;
#[cfg(feature = "cli")]
pub(crate) use explain::written_at;
pub(crate) use explain::{place_of, read};
pub use overrides::Override;
