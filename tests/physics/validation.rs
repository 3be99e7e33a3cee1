//! Known answers: every pressure method in the inexpensive cases of `assets/cases`.
//!
//! `overfall validate` prints all figures of all cases.

use std::ops::ControlFlow;

use overfall::validate::{CASES, Case, Figure, Findings, METHODS, Method};

use crate::support::measured;

/// Bounds on the errors of the figures whose names start so \[-], one for each of [`METHODS`].
type Bounds = &'static [(&'static str, [f64; METHODS.len()])];

fn case(name: &str) -> &'static Case {
    let mut cases = CASES.iter();
    let found = cases.find(|case| case.name == name);
    found.unwrap_or_else(|| panic!("no case {name}"))
}

fn run(case: &Case, method: &Method, resolution: u32) -> Findings {
    let found = case.run(method, resolution, 1, &mut |_| ControlFlow::Continue(()));
    found.unwrap_or_else(|error| panic!("{}, {}: {error}", case.name, method.name))
}

/// Runs a case with the method at a place of [`METHODS`]: errors stay within ± their bounds.
#[track_caller]
fn holds(name: &str, method: usize, bounds: Bounds) {
    let bounds: Vec<_> = (bounds.iter())
        .map(|(start, bounds)| (*start, bounds[method]))
        .collect();
    stays_within(name, &METHODS[method], &bounds);
}

/// Runs a case with a method: errors stay within ± the bounds of the figures whose names start so \[-].
#[track_caller]
fn stays_within(name: &str, method: &Method, bounds: &[(&str, f64)]) {
    let case = case(name);
    let mut missed = Vec::new();
    for figure in run(case, method, case.resolution).figures {
        let line = format!(
            "{}, {}: {} {:.5}, known {:.5}, error {:.6} %",
            case.name,
            method.name,
            figure.quantity,
            figure.measured,
            figure.known,
            100.0 * figure.error()
        );
        measured(&line);
        let of_figure = bounds
            .iter()
            .find(|(name, _)| figure.quantity.starts_with(name));
        let (_, bound) = of_figure.unwrap_or_else(|| panic!("no bound for {line}"));
        // What is not a number is not within.
        let within = figure.error().abs() <= *bound;
        if !within {
            missed.push(format!("{line}, bound {} %", 100.0 * bound));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

fn method(key: &str) -> &'static Method {
    let mut methods = METHODS.iter();
    let found = methods.find(|method| method.key == key);
    found.unwrap_or_else(|| panic!("no method {key}"))
}

// Known answers that need tension, even particles or walls of several layers: twice the errors with which δ-SPH
// converges from 20 to 80 particles (`docs/accuracy.md`).

#[test]
fn delta_sph_keeps_taylor_green_vortices() {
    let bounds = [
        ("rate of decay", 0.08),
        ("energy at 0.5", 0.12),
        ("error of the velocities", 0.06),
        ("spread of the density", 0.005),
    ];
    stays_within("taylor_green", method("delta-sph"), &bounds);
}

#[test]
fn delta_sph_keeps_a_rotating_patch_together() {
    let bounds = [
        // It starts without the pressure of the rotation and swings.
        ("centre pressure", 0.5),
        ("density of the core", 0.02),
        ("kinetic energy", 0.05),
        ("angular momentum", 0.02),
    ];
    stays_within("rotating_square_patch", method("delta-sph"), &bounds);
}

#[test]
fn delta_sph_swings_a_drop_with_its_period() {
    let bounds = [
        ("period", 0.005),
        ("amplitude", 0.02),
        ("rms distance", 0.01),
        ("area", 0.015),
    ];
    stays_within("oscillating_drop", method("delta-sph"), &bounds);
}

#[test]
fn flow_between_plates_has_the_nominal_viscosity() {
    for (key, most) in [("iisph", 0.005), ("dfsph", 0.005), ("delta-sph", 0.04)] {
        stays_within("poiseuille", method(key), &[("", most)]);
        stays_within("couette", method(key), &[("", most)]);
    }
}

/// A test for every method, so that they run side by side and a failure names its method.
macro_rules! for_every_method {
    ($case:ident, $check:expr) => {
        for_every_method!($case, $check, [sesph_gas 0, sesph_tait 1, pcisph 2, iisph 3, dfsph 4, delta_sph 5]);
    };
    ($case:ident, $check:expr, [$($name:ident $method:literal),*]) => {
        mod $case {
            use super::*;

            $(
                #[test]
                fn $name() {
                    $check($method);
                }
            )*
        }
    };
}

// The target, 2 % of the slope and 1 % of sqrt(g H) for the mean speed, is met by every method. Layers are further off
// at half depth, as the surface settles half a spacing lower, and within three spacings of the floor, where pressures
// alternate from layer to layer (at 60 layers: 1.1 % and 6 %). The sound of the start, when the water falls onto
// pressure that is not there yet, is damped by viscosity alone: SESPH's speeds are what is left of it. The gauge on the
// floor hears particles up to a support radius, 2.2 of 30 or 16 spacings, above it, and adds the weight of the water
// below them. SESPH's walls push too strongly for its equation of state: 16 % in the plane, 14 % in space, half a
// spacing more than what the particles have on average.
const IN_THE_PLANE: Bounds = &[
    (
        "floor pressure",
        [0.17, 0.17, 2.2 / 30.0, 2.2 / 30.0, 2.2 / 30.0, 0.02],
    ),
    ("-dp/dy", [0.025, 0.025, 0.02, 0.02, 0.02, 0.01]),
    ("p at half depth", [0.04, 0.04, 0.04, 0.04, 0.04, 0.015]),
    ("worst layer", [0.035, 0.035, 0.035, 0.035, 0.035, 0.01]),
    ("energy gained", [0.01; 6]),
    ("rms speed", [0.012, 0.012, 0.01, 0.01, 0.01, 0.001]),
    ("largest speed", [0.04, 0.04, 0.02, 0.02, 0.02, 0.003]),
];
const IN_SPACE: Bounds = &[
    (
        "floor pressure",
        [0.155, 0.155, 0.1375, 0.1375, 0.1375, 0.03],
    ),
    ("-dp/dy", [0.02, 0.02, 0.03, 0.02, 0.02, 0.01]),
    ("p at half depth", [0.06, 0.06, 0.06, 0.06, 0.06, 0.015]),
    ("worst layer", [0.045, 0.045, 0.045, 0.045, 0.045, 0.01]),
    ("energy gained", [0.01; 6]),
    ("rms speed", [0.01, 0.01, 0.01, 0.01, 0.01, 0.001]),
    // Single particles in the edges of the tank, where two walls push; the mean speed is 0.2 %.
    ("largest speed", [0.05, 0.05, 0.07, 0.045, 0.045, 0.004]),
];

// The target, 1 % of the semi-major axis at the end, is met within 0.01 % by IISPH and DFSPH; the others are 1.1 % off.
// It is met with 0.15 % at 80 particles along a radius. What is left is the sum of the density: a square lattice that
// is drawn out 1.44 times along an axis at constant area has 5.5 % more of it than at rest. Pressure follows that sum:
// 38 to 48 % too much of it pushes the lattice back, in every method alike, and then, with the drop ahead of the
// ellipse, there is none. Nothing pulls it together again. The area follows that sum as well: with 20, 40 and 80
// particles along a radius it is 20 to 22, 10 to 12 and 0.5 to 5.5 % too large. IISPH and DFSPH keep their pressure to
// the end, and are pushed for longer: with 20, 40, 80 and 160 particles the axis is 1.7, 1.5, 1.0 and 0.05 % off, the
// area 24, 21, 11 and 0.3 %.
const DROP: Bounds = &[
    (
        "semi-major axis at 0.0008",
        [0.01, 0.01, 0.01, 0.01, 0.01, 0.003],
    ),
    (
        "semi-major axis at 0.0038",
        [0.011, 0.011, 0.011, 0.011, 0.011, 0.003],
    ),
    (
        "semi-major axis at 0.0076",
        [0.012, 0.012, 0.012, 0.016, 0.016, 0.003],
    ),
    ("area", [0.13, 0.13, 0.11, 0.22, 0.22, 0.015]),
    ("centre pressure", [0.52, 0.52, 0.45, 0.45, 0.45, 0.06]),
];

// Rounding; shifting moves particles with their velocities, which changes their moments.
const FREE_FLIGHT: Bounds = &[("", [1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 0.01])];

for_every_method!(still_water_in_the_plane, |method| holds(
    "hydrostatic_2d",
    method,
    IN_THE_PLANE
));
for_every_method!(still_water_in_space, |method| holds(
    "hydrostatic_3d",
    method,
    IN_SPACE
));
for_every_method!(drop_keeps_its_axes, |method| holds(
    "elliptic_drop",
    method,
    DROP
));
for_every_method!(free_flight_keeps_momenta, |method| holds(
    "free_flight",
    method,
    FREE_FLIGHT
));

/// Fronts of a case at its coarsest and its middle resolution, the times of the experiment, in widths: the middle one
/// is within the distance of both of where the fronts go, if they converge with the order 1 or better; and Ritter's
/// bound holds. Those of `to_experiment` are within so much of the experiment \[-].
fn front_converges(name: &str, method: usize, bound: f64, to_experiment: &[(&str, f64)]) {
    let case = case(name);
    let [coarse, middle, _] = case.resolutions;
    let runs = [coarse, middle].map(|n| run(case, &METHODS[method], n).figures);
    let [coarse, middle] = &runs;
    let mut worst = 0.0_f64;
    for (coarse, middle) in coarse.iter().zip(middle) {
        assert_eq!(coarse.quantity, middle.quantity);
        if middle.quantity.starts_with("front at") {
            let step = (middle.measured - coarse.measured).abs() / middle.measured;
            worst = worst.max(step);
        }
        if middle.quantity.starts_with("largest way") {
            assert!(middle.measured <= 1.0, "{middle:?}");
        }
        let mut bounds = to_experiment.iter();
        if let Some((_, most)) = bounds.find(|(start, _)| middle.quantity.starts_with(start)) {
            assert!(middle.error().abs() <= *most, "{middle:?} above {most}");
        }
    }
    let method = METHODS[method].name;
    measured(&format!(
        "{name}, {method}: fronts move by {worst:.4} with half the spacing"
    ));
    assert!(worst <= bound, "{name}, {method}: {worst} above {bound}");
}

/// Converged front of the column of Koshizuka & Oka at the times of the experiment \[L]: what DFSPH and δ-SPH go to
/// with the order 1, from 20 and 40 particles over the width, on the mean. Both are within 1 % of it. The experiment is
/// up to a fifth behind: its gate opens and its floor has friction.
const CONVERGED: [f64; 8] = [1.106, 1.376, 1.722, 2.118, 2.591, 3.104, 3.670, 4.246];

/// The front at the middle resolution is as near to the converged one as twice the distance at the finest \[-], which
/// is 1.8 % with DFSPH.
fn front_is_the_converged_one(method: usize) {
    let case = case("dam_break_koshizuka_oka");
    let bound = [0.05, 0.05, 0.035, 0.035, 0.035, 0.05][method];
    let figures = run(case, &METHODS[method], case.resolutions[1]).figures;
    let fronts = figures
        .iter()
        .filter(|f| f.quantity.starts_with("front at"));
    let off = |(front, known): (&Figure, f64)| (front.measured / known - 1.0).abs();
    let worst = fronts.clone().zip(CONVERGED).map(off).fold(0.0, f64::max);
    let method = METHODS[method].name;
    measured(&format!("{method}: {worst:.4} off the converged front"));
    assert_eq!(fronts.count(), CONVERGED.len());
    assert!(worst <= bound, "{method}: {worst} above {bound}");
    let ritter = figures
        .iter()
        .find(|f| f.quantity.starts_with("largest way"));
    assert!(ritter.is_some_and(|way| way.measured <= 1.0), "{ritter:?}");
}

for_every_method!(front_of_koshizuka_and_oka, front_is_the_converged_one);
// The experiment's early fronts lag behind the converged one by as much as 9.4 %.
for_every_method!(column_of_martin_and_moyce, |method| front_converges(
    "dam_break_martin_moyce",
    method,
    0.05,
    &[("front at", 0.1), ("height at", 0.15)]
));

/// A flow that is chosen, with the forces that it needs: errors at 16 particles over the depth are within what they
/// converge from. The uneven pressure goes to its value with the order 1 to 2, from 3.5 and 12 %. Viscosity is too
/// large by what narrow kernels show of it where particles are out of order, and by the numerical one: 12 % here, 7 %
/// with 64. The pressures of SESPH swing with the sound of a start without pressure.
fn manufactured_flow(method: usize) {
    let case = case("manufactured_solution");
    let bounds = [
        (
            "amplitude of the shear",
            [0.13, 0.13, 0.13, 0.13, 0.13, 0.02],
        ),
        (
            "amplitude of the uneven",
            [0.05, 0.05, 0.05, 0.05, 0.05, 0.13],
        ),
        ("error of the velocities", [0.1, 0.1, 0.1, 0.1, 0.1, 0.02]),
        (
            "error of the pressures",
            [0.25, 0.25, 0.05, 0.03, 0.03, 0.025],
        ),
    ];
    let name = METHODS[method].name;
    for figure in run(case, &METHODS[method], case.resolutions[0]).figures {
        let of = bounds
            .iter()
            .find(|(start, _)| figure.quantity.starts_with(start));
        let bound = of.map_or(0.0, |(_, bounds)| bounds[method]);
        let off = figure.error().abs();
        measured(&format!("{name}: {} {off:.4}", figure.quantity));
        assert!(off <= bound, "{name}: {figure:?} above {bound}");
    }
}

for_every_method!(flow_that_is_manufactured, manufactured_flow);

/// A wave swings with the period of linear theory at half the resolution of the case, and viscosity takes energy from
/// it.
fn wave_swings(method: usize) {
    let case = case("standing_wave_viscous");
    let found = run(case, &METHODS[method], case.resolutions[0]);
    let [period, decay] = &found.figures[..] else {
        panic!("two figures: {found:?}");
    };
    let name = METHODS[method].name;
    measured(&format!(
        "{name}: period {:.4} s, decay {:.4} 1/s",
        period.measured, decay.measured
    ));
    assert!(period.error().abs() < 0.1, "{name}: {period:?}");
    assert!(decay.measured > 0.0, "{name}: {decay:?}");
}

// δ-SPH needs more than 10 rows.
for_every_method!(
    standing_wave,
    wave_swings,
    [sesph_gas 0, sesph_tait 1, pcisph 2, iisph 3, dfsph 4]
);
