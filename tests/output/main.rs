//! Output of a run: frames, history, pictures.

mod frames;
mod history;
#[cfg(feature = "cli")]
mod pictures;
#[cfg(feature = "surface")]
mod surface;
