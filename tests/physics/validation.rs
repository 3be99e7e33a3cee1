//! Known answers: every pressure method against every case of `assets/scenes/validation`.
//!
//! `cargo bench --bench validation` prints all figures, `-- 0.5` at twice the resolution.

use crate::support::{METHODS, measured};
use crate::validation_support::{Case, dam_break, elliptic_drop, free_flight, hydrostatic};

/// Bounds on the errors of the figures whose names start so \[-], one for each of [`METHODS`].
type Bounds = &'static [(&'static str, [f64; METHODS.len()])];

/// Runs a case with the method at a place of [`METHODS`]: errors stay within ± their bounds.
#[track_caller]
fn holds(case: &Case, method: usize, bounds: Bounds) {
    let mut missed = Vec::new();
    for figure in case.run(&METHODS[method], 1.0, 1) {
        let line = format!(
            "{}, {}: {} {:.5}, known {:.5}, error {:.6} %",
            case.scene,
            METHODS[method].name,
            figure.quantity,
            figure.measured,
            figure.reference,
            100.0 * figure.error()
        );
        measured(&line);
        let of_figure = bounds
            .iter()
            .find(|(name, _)| figure.quantity.starts_with(name));
        let (_, bound) = of_figure.unwrap_or_else(|| panic!("no bound for {line}"));
        // What is not a number is not within.
        let within = figure.error().abs() <= bound[method];
        if !within {
            missed.push(format!("{line}, bound {} %", 100.0 * bound[method]));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

/// A test for every method, so that they run side by side and a failure names its method.
macro_rules! for_every_method {
    ($case:ident, $scene:expr, $bounds:expr) => {
        for_every_method!($case, $scene, $bounds, [sesph_gas 0, sesph_tait 1, pcisph 2, iisph 3, dfsph 4]);
    };
    ($case:ident, $scene:expr, $bounds:expr, [$($name:ident $method:literal),*]) => {
        mod $case {
            use super::*;

            $(
                #[test]
                fn $name() {
                    holds(&$scene, $method, $bounds);
                }
            )*
        }
    };
}

// The target, 2 % of the slope and 1 % of sqrt(g H) for the mean speed, is met by every method. Layers are further off
// at half depth, as the surface settles half a spacing lower, and within three spacings of the floor, where pressures
// alternate from layer to layer (at 60 layers: 1.1 % and 6 %). The sound of the start, when the water falls onto
// pressure that is not there yet, is damped by viscosity alone: SESPH's speeds are what is left of it.
const IN_THE_PLANE: Bounds = &[
    ("-dp/dy", [0.02; 5]),
    ("p at half depth", [0.04; 5]),
    ("worst layer", [0.035; 5]),
    ("energy gained", [0.01; 5]),
    ("rms speed", [0.01; 5]),
    ("largest speed", [0.04, 0.04, 0.02, 0.01, 0.01]),
];
const IN_SPACE: Bounds = &[
    ("-dp/dy", [0.02; 5]),
    ("p at half depth", [0.06; 5]),
    ("worst layer", [0.045; 5]),
    ("energy gained", [0.01; 5]),
    ("rms speed", [0.01; 5]),
    // Single particles in the edges of the tank, where two walls push; the mean speed is 0.2 %.
    ("largest speed", [0.05, 0.05, 0.07, 0.045, 0.045]),
];

// The target, 1 % of the semi-major axis at the end, is met within 0.01 % by IISPH and DFSPH; the others are 1.1 % off.
// It is met with 0.15 % at 80 particles along a radius. What is left is the sum of the density: a square lattice that
// is drawn out 1.44 times along an axis at constant area has 5.5 % more of it than at rest. Pressure follows that sum:
// 38 to 48 % too much of it pushes the lattice back, in every method alike, and then, with the drop ahead of the
// ellipse, there is none. Nothing pulls it together again.
const DROP: Bounds = &[
    ("semi-major axis at 0.0008", [0.01; 5]),
    ("semi-major axis at 0.0038", [0.011; 5]),
    (
        "semi-major axis at 0.0076",
        [0.012, 0.012, 0.012, 0.011, 0.011],
    ),
    ("centre pressure", [0.5, 0.5, 0.45, 0.45, 0.45]),
];

// All methods agree to 2 %, and are as much as 22 % ahead of Koshizuka & Oka where they are within 5 % of the fronts of
// Martin & Moyce after T = 1.5: in the same units the experiments are 10 % apart (T = 2.7: 3.00 and 3.30 L), and 17 %
// with the clock of the latter shifted. Ritter's bound holds for all.
const KOSHIZUKA_OKA: Bounds = &[("front", [0.23; 5]), ("largest way", [1.0; 5])];
// Since walls push as the fluid does, fronts of 2 : 1 columns lie within 1 % of the converged one; the experiment's
// early ones lag behind it by as much as 9.4 %.
const MARTIN_MOYCE: Bounds = &[
    ("front", [0.1; 5]),
    ("height", [0.15; 5]),
    ("largest way", [1.0; 5]),
];

// Rounding.
const FREE_FLIGHT: Bounds = &[("", [1e-5; 5])];

for_every_method!(
    still_water_in_the_plane,
    hydrostatic::IN_THE_PLANE,
    IN_THE_PLANE
);
for_every_method!(still_water_in_space, hydrostatic::IN_SPACE, IN_SPACE);
for_every_method!(drop_keeps_its_axes, elliptic_drop::CASE, DROP);
for_every_method!(
    front_of_koshizuka_and_oka,
    dam_break::KOSHIZUKA_OKA,
    KOSHIZUKA_OKA
);
for_every_method!(
    column_of_martin_and_moyce,
    dam_break::MARTIN_MOYCE,
    MARTIN_MOYCE
);
for_every_method!(free_flight_keeps_momenta, free_flight::CASE, FREE_FLIGHT);
