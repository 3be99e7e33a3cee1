//! Physics: motions with known results, and walls that are tight.

#[path = "../mesh_support/mod.rs"]
mod mesh_support;
#[path = "../random_support/mod.rs"]
mod random_support;
#[path = "../robustness_support/mod.rs"]
mod robustness_support;
#[path = "../physics_support/mod.rs"]
mod support;

mod body_forces;
mod couette;
mod dam_break;
mod emitters;
mod forces;
mod gauge_readings;
mod gauges;
mod impacts;
mod layers;
mod mesh_rims;
mod mesh_shots;
mod meshes;
mod momentum;
mod moving_walls;
mod moving_walls_gauges;
mod paper_scenes;
mod periodic;
mod random_scenes;
mod rest;
mod robustness;
mod shallow_gauges;
mod shots;
mod validation;
mod walls;
