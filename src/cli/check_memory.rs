//! The memory that a run takes, for `overfall check`.

use std::fmt::Write;

use overfall::Plan;
use overfall::output::memory;
use overfall::scene::Scene;

use super::report::size;

/// The memory of a particle, and of a run.
pub(super) fn text(scene: &Scene, plan: &Plan) -> String {
    let mut text = String::new();
    for (what, count, rows) in [
        ("fluid", plan.particles, &plan.bytes_per_particle),
        (
            "boundary",
            plan.boundary_particles,
            &plan.bytes_per_boundary_particle,
        ),
    ] {
        if count == 0 {
            continue;
        }
        let _ = writeln!(text, "\nMemory per {what} particle [bytes]");
        let mut total = 0.0;
        for (name, bytes) in rows {
            total += bytes;
            let _ = writeln!(text, "  {bytes:>8.1}  {name}");
        }
        let _ = writeln!(text, "  {total:>8.1}  in all");
    }
    text.push_str("\nMemory of a run\n");
    let parts = run_memory(scene, plan);
    for (name, bytes) in &parts {
        let _ = writeln!(text, "  {:>10}  {name}", size(*bytes));
    }
    let all: f64 = parts.iter().map(|part| part.1).sum();
    let _ = writeln!(text, "  {:>10}  in all, at most", size(all));
    text
}

/// Memory of a run by what holds it \[bytes], output included.
pub(super) fn run_memory(scene: &Scene, plan: &Plan) -> Vec<(&'static str, f64)> {
    let boundary = plan.boundary_particles as f64;
    let output = memory::bytes(scene, plan.most_particles, boundary);
    plan.memory_by_part.iter().copied().chain(output).collect()
}
