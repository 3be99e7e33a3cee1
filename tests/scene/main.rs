//! Scenes and the files that they name: what is read, what is refused and with which words.

#[path = "../mesh_support/mod.rs"]
mod mesh_support;
#[path = "../physics_support/mod.rs"]
mod support;

mod errors;
mod extremes;
mod files;
mod mesh_corpus;
mod mesh_files;
mod mesh_sampling;
mod overrides;
mod readers;
