//! The step: in a host's world, with its stages in any order, on any number of threads.

#[path = "../common/mod.rs"]
mod common;

mod algorithm_2;
mod apply;
mod checkpoints;
mod checkpoints_refused;
mod determinism;
mod embedding;
mod flow;
mod guard;
mod host;
mod host_columns;
mod host_exchanges;
mod host_random;
mod host_resources;
mod host_spoils;
mod host_stages;
mod host_systems;
mod lists;
mod orders;
mod orders_groups;
mod orders_kernels;
mod orders_refused;
mod orders_resume;
mod orders_stale;
#[cfg(feature = "bevy_app")]
mod plugin;
mod queries;
mod ranks;
mod recompute;
mod roll_back;
mod tables;
mod variants;
mod verlet;
mod warm_start;
mod world;
