//! Scenes and the files that they name: what is accepted, and what is refused with which message.

#[path = "../mesh_support/mod.rs"]
mod mesh_support;
#[path = "../physics_support/mod.rs"]
mod support;

mod bodies_of_files;
mod brackets;
mod errors;
mod errors_of_flow;
mod errors_of_motion;
mod extremes;
mod files;
mod include;
mod mesh_corpus;
mod mesh_files;
mod mesh_sampling;
mod overrides;
mod periodic;
mod readers;
mod schema;
mod slips;
mod slips_values;
mod starts;
mod thin_cut;
mod turned;
mod usual;
