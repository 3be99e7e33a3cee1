//! Every pressure method against every case with a known answer: `cargo bench --bench validation`.
//!
//! Arguments after `--`: a number multiplies the spacing of every scene (0.5 doubles the resolution), a word keeps the
//! cases and methods whose name holds it. Prints one line a figure: measured, known, error.
#![expect(clippy::print_stdout, reason = "a table for whoever runs it")]

#[path = "../tests/physics_support/mod.rs"]
mod support;
#[path = "../tests/validation_support/mod.rs"]
mod validation;

use std::time::Instant;

use support::METHODS;
use validation::CASES;

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    let number = arguments.iter().find_map(|word| word.parse().ok());
    let words: Vec<&String> = arguments
        .iter()
        .filter(|word| word.parse::<f32>().is_err())
        .collect();
    let coarseness = number.unwrap_or(1.0);
    for case in CASES {
        for method in METHODS {
            let asked = |word: &&String| {
                case.scene.contains(word.as_str()) || method.name.contains(word.as_str())
            };
            if !words.iter().all(asked) {
                continue;
            }
            let start = Instant::now();
            let figures = case.run(&method, coarseness, 0);
            println!(
                "\n{}, {}: {:.1} s",
                case.scene,
                method.name,
                start.elapsed().as_secs_f64()
            );
            for figure in figures {
                println!(
                    "  {:34} {:12.5} known {:12.5} error {:8.2} %",
                    figure.quantity,
                    figure.measured,
                    figure.reference,
                    100.0 * figure.error()
                );
            }
        }
    }
}
