//! `overfall check --json`: the plan of a scene for programs.

use overfall::Plan;
use overfall::scene::Scene;
use serde_json::{Value, json};

use super::check_memory::run_memory;
use super::exit::Failure;
use super::report;

/// The plan as JSON, with the `cost` of a trial if there was one. Numbers are in SI units; what is not known is `null`.
pub(super) fn text(
    scene: &Scene,
    plan: &Plan,
    threads: usize,
    cost: Option<Value>,
) -> Result<String, Failure> {
    let corners = |(low, high): (glam::Vec3, glam::Vec3)| json!([low.to_array(), high.to_array()]);
    let phases: Vec<Value> = (plan.phases.iter())
        .map(|(phase, stages)| json!({"phase": phase.name(), "stages": stages}))
        .collect();
    let limits: Vec<Value> = (plan.time_step_limits.iter())
        .map(|(name, limit)| json!({"limit": name, "dt_s": limit}))
        .collect();
    let start = plan.start_density.as_ref().map(|start| {
        json!({
            "largest_error": start.max_error,
            "mean_error": start.mean_error,
            "place_m": start.place.to_array(),
        })
    });
    let memory = run_memory(scene, plan);
    let all: f64 = memory.iter().map(|part| part.1).sum();
    let memory: Vec<Value> = (memory.iter())
        .map(|(part, bytes)| json!({"part": part, "bytes": bytes}))
        .collect();
    report::pretty(&json!({
        "scene": scene.name,
        "dimension": u8::from(scene.dimension),
        "spacing_m": scene.spacing,
        "duration_s": scene.duration,
        "particles": plan.particles,
        "boundary_particles": plan.boundary_particles,
        "boundary_is_estimate": plan.boundary_is_estimate,
        "fluid_box_m": corners(plan.fluid_box),
        "whole_box_m": corners(plan.whole_box),
        "support_radius_m": plan.support_radius,
        "particle_mass_kg": plan.particle_mass,
        "expected_neighbours": plan.expected_neighbours,
        "expected_steps": plan.expected_steps,
        "time_step_limits": limits,
        "phases": phases,
        "memory_bytes": all,
        "memory": memory,
        "start_density": start,
        "threads": threads,
        "warnings": plan.warnings,
        "settings": scene,
        "cost": cost,
    }))
}
