//! `overfall check --cost`: what the parts of a scene cost in a few steps, and what could go.

use std::fmt::Write as _;
use std::ops::ControlFlow;

use overfall::Plan;
use overfall::scene::Scene;
use overfall::step::Phase;
use overfall::trial::{Cost, Saving, TrialError, cost};
use serde_json::{Value, json};

use super::exit::Failure;
use super::stages::Display;
use super::{interrupt, options};

/// Steps of a trial, if none are given.
const STEPS: u64 = 20;
/// Wall time of one trial \[s].
const SECONDS: f64 = 120.0;

/// Runs the trials of a scene, with progress.
pub(super) fn measure(scene: &Scene, options: &options::Check) -> Result<Cost, Failure> {
    let mut display = Display::start(options.run.reporting.quiet);
    interrupt::listen(display.announcer())?;
    let steps = options.run.steps.unwrap_or(STEPS);
    let limits = (options.run.scene.threads(), SECONDS);
    let found = cost(scene, steps, limits, &mut |what, fraction| {
        display.step("trying", what, fraction);
        if interrupt::asked() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    display.finish();
    found.map_err(|error| match error {
        TrialError::Refused(error) => options.run.scene.refuse(&error),
        other => Failure::Failed(other.to_string()),
    })
}

/// What the parts cost, and what could go without changing the result by more than `error` \[-].
pub(super) fn text(plan: &Plan, cost: &Cost, error: f64) -> String {
    let trial = &cost.trial;
    let steps = trial.steps.max(1) as f64;
    let mut text = format!(
        "\nCost in {} steps, {:.4} s of simulated time, {:.3} s/s\n",
        trial.steps,
        trial.time,
        trial.cost()
    );
    for (phase, seconds) in Phase::ALL.into_iter().zip(trial.phase_seconds) {
        let stages = plan.phases.iter().find(|(of, _)| *of == phase);
        let stages = stages.map_or_else(String::new, |(_, stages)| stages.join(", "));
        let share = 100.0 * seconds / trial.wall();
        let ms = 1e3 * seconds / steps;
        let _ = writeln!(
            text,
            "  {:<15} {ms:>9.3} ms a step {share:>5.1} %  {stages}",
            phase.name()
        );
    }
    let iterations = trial.iterations as f64 / steps;
    let _ = writeln!(text, "  {:<15} {iterations:>9.2} a step", "iterations");
    if trial.divergence_iterations > 0 {
        let iterations = trial.divergence_iterations as f64 / steps;
        let _ = writeln!(text, "  {:<15} {iterations:>9.2} a step", "of divergence");
    }
    let bytes: f64 = cost.bytes.iter().map(|part| part.1).sum();
    let _ = writeln!(
        text,
        "  {:<15} {bytes:>9.0} bytes for a fluid particle",
        "memory"
    );
    text.push_str(
        "\nSimpler scenes after the same simulated time; the difference is that of the particles' places, over their \
         ways\n",
    );
    let _ = writeln!(
        text,
        "  {:<38} {:>7} {:>10} {:>7} {:>10}",
        "", "time", "iterations", "bytes", "difference"
    );
    for saving in &cost.savings {
        let what = &saving.change.what;
        let _ = match &saving.outcome {
            Ok(saved) => writeln!(
                text,
                "  {what:<38} {:>6.0} % {:>10.2} {:>+7.0} {:>8.2} %",
                100.0 * saved.cost,
                saved.iterations,
                saved.bytes,
                100.0 * saved.difference
            ),
            Err(error) => writeln!(text, "  {what:<38} {error}"),
        };
    }
    text.push_str(&what_could_go(cost, error));
    text
}

/// The changes that save something within an error, as options to paste.
fn what_could_go(cost: &Cost, error: f64) -> String {
    let mut text = String::new();
    let could_go: Vec<&Saving> = cost
        .savings
        .iter()
        .filter(|saving| is_free(saving, error))
        .collect();
    if could_go.is_empty() {
        let _ = writeln!(
            text,
            "\nNothing of this saves time or memory within {} %.",
            100.0 * error
        );
    } else {
        let _ = writeln!(
            text,
            "\nWithin {} % these save time or memory, each alone:",
            100.0 * error
        );
    }
    for saving in could_go {
        let set: Vec<String> = saving
            .change
            .set
            .iter()
            .map(|set| format!("--set '{set}'"))
            .collect();
        let _ = writeln!(text, "  {}", set.join(" "));
    }
    text
}

/// Whether a change saves something and leaves the result as it is, up to an error. Times differ by chance: less than
/// three per cent is no saving.
fn is_free(saving: &Saving, error: f64) -> bool {
    match &saving.outcome {
        Ok(saved) => saved.difference <= error && (saved.cost < 0.97 || saved.bytes < 0.0),
        Err(_) => false,
    }
}

/// The same for programs.
pub(super) fn json(plan: &Plan, cost: &Cost, error: f64) -> Value {
    let trial = &cost.trial;
    let phases = Phase::ALL.into_iter().zip(trial.phase_seconds);
    let phases: Vec<Value> = phases
        .map(|(phase, seconds)| {
            let stages = plan
                .phases
                .iter()
                .find(|(of, _)| *of == phase)
                .map(|(_, stages)| stages);
            json!({"phase": phase.name(), "seconds": seconds, "stages": stages})
        })
        .collect();
    let savings: Vec<Value> = (cost.savings.iter())
        .map(|saving| {
            let saved = saving.outcome.as_ref().ok();
            json!({
                "what": saving.change.what,
                "set": saving.change.set,
                "cost": saved.map(|saved| saved.cost),
                "iterations": saved.map(|saved| saved.iterations),
                "bytes": saved.map(|saved| saved.bytes),
                "difference": saved.map(|saved| saved.difference),
                "could_go": is_free(saving, error),
                "failure": saving.outcome.as_ref().err().map(ToString::to_string),
            })
        })
        .collect();
    let bytes: Vec<Value> = (cost.bytes.iter())
        .map(|(name, bytes)| json!({"what": name, "bytes": bytes}))
        .collect();
    json!({
        "steps": trial.steps,
        "time_s": trial.time,
        "wall_s": trial.wall(),
        "iterations": trial.iterations,
        "divergence_iterations": trial.divergence_iterations,
        "phases": phases,
        "bytes_per_particle": bytes,
        "error": error,
        "savings": savings,
    })
}
