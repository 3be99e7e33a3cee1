//! Known answers: every pressure method against every case of `assets/scenes/validation`.

#[path = "physics_support/mod.rs"]
mod support;
#[path = "validation_support/mod.rs"]
mod validation;

use support::{METHODS, measured};
use validation::CASES;

#[test]
fn all() {
    for case in CASES {
        for method in METHODS {
            let start = std::time::Instant::now();
            for figure in case.run(&method, 1.0, 2) {
                measured(&format!("{:24} {:12} {:34} {:12.5} {:12.5} {:8.2} %", case.scene, method.name, figure.quantity, figure.measured, figure.reference, 100.0 * figure.error()));
            }
            measured(&format!("{} s", start.elapsed().as_secs_f64()));
        }
    }
}
