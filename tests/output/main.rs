//! What a run writes: frames, history, pictures.

mod frames;
mod history;
#[cfg(feature = "cli")]
mod pictures;
