//! Difficult cases for every method: `cargo bench --bench robustness`. Every row is a run that should end with water at
//! rest, an energy that does not rise, or a known answer.
//!
//! Arguments after `--`: words select the cases and methods whose names contain one of them, `--set PATH=VALUE`
//! overrides a field of all scenes, `--quick` omits the largest. Prints one line per run.
#![expect(clippy::print_stdout, reason = "a table for whoever runs it")]

#[path = "../tests/robustness_support/mod.rs"]
mod robustness;
#[path = "../tests/physics_support/mod.rs"]
mod support;

use std::time::Instant;

fn main() {
    let mut words = Vec::new();
    let mut overrides = Vec::new();
    let mut quick = false;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--set" => overrides.extend(arguments.next()),
            "--quick" => quick = true,
            "--bench" => {}
            _ => words.push(argument),
        }
    }
    println!(
        "{:<28} {:<11} {:>6} {:>6} {:>8}  measured",
        "case", "method", "steps", "iter", "wall s"
    );
    for case in robustness::cases(quick) {
        let asked = |word: &String| {
            word.split('|')
                .any(|word| case.name.contains(word) || case.method.name.contains(word))
        };
        if !words.iter().all(asked) {
            continue;
        }
        let start = Instant::now();
        let outcome = case.run(&overrides);
        println!(
            "{:<28} {:<11} {:>6} {:>6.1} {:>8.2}  {}",
            case.name,
            case.method.name,
            outcome.steps,
            outcome.iterations as f64 / f64::from(outcome.steps.max(1)),
            start.elapsed().as_secs_f64(),
            outcome.text()
        );
    }
}
