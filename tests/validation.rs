//! Known answers: every pressure method against every case of `assets/scenes/validation`.
//!
//! `cargo bench --bench validation` prints all figures, `-- 0.5` at twice the resolution.

#[path = "physics_support/mod.rs"]
mod support;
#[path = "validation_support/mod.rs"]
mod validation;

use support::{METHODS, measured};
use validation::{Case, dam_break, elliptic_drop, free_flight, hydrostatic};

/// Runs a case with every method. Errors of the figures whose names start so stay within ± the bound, one for each of
/// [`METHODS`].
#[track_caller]
fn holds(case: &Case, bounds: &[(&str, [f64; METHODS.len()])]) {
    let mut missed = Vec::new();
    for (k, method) in METHODS.iter().enumerate() {
        for figure in case.run(method, 1.0, 1) {
            let line = format!(
                "{}, {}: {} {:.5}, known {:.5}, error {:.3} %",
                case.scene,
                method.name,
                figure.quantity,
                figure.measured,
                figure.reference,
                100.0 * figure.error()
            );
            measured(&line);
            let of_figure = bounds.iter().find(|(name, _)| figure.quantity.starts_with(name));
            let (_, bound) = of_figure.unwrap_or_else(|| panic!("no bound for {line}"));
            // Not a number misses.
            if !(figure.error().abs() <= bound[k]) {
                missed.push(format!("{line}, bound {} %", 100.0 * bound[k]));
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn still_water_in_the_plane() {
    holds(&hydrostatic::IN_THE_PLANE, &[("", [0.02; 5])]);
}

#[test]
fn still_water_in_space() {
    holds(&hydrostatic::IN_SPACE, &[("", [0.02; 5])]);
}

#[test]
fn elliptic_drop_keeps_its_axes() {
    holds(&elliptic_drop::CASE, &[("", [0.01; 5])]);
}

#[test]
fn front_of_koshizuka_and_oka() {
    holds(&dam_break::KOSHIZUKA_OKA, &[("", [0.15; 5])]);
}

#[test]
fn front_and_height_of_martin_and_moyce() {
    holds(&dam_break::MARTIN_MOYCE, &[("", [0.15; 5])]);
}

#[test]
fn free_flight_keeps_momenta_and_parabola() {
    holds(&free_flight::CASE, &[("", [1e-5; 5])]);
}
