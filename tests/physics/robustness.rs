//! Water at rest, columns and drops: the affordable part of `benches/robustness.rs`. Bounds are twice the measured
//! values.

use overfall::scene::KernelFunction;

use crate::robustness_support::{Case, Outcome, column, drop, slosh, tank};
use crate::support::{METHODS, Method, measured};

/// Runs a case and returns its result; it must not fail.
#[track_caller]
fn run(case: &Case) -> Outcome {
    let outcome = case.run(&[]);
    let text = format!("{}, {}: {}", case.name, case.method.name, outcome.text());
    measured(&text);
    assert_eq!(outcome.failure, None, "{text}");
    outcome
}

fn solvers() -> impl Iterator<Item = Method> {
    METHODS
        .into_iter()
        .filter(|method| !method.name.starts_with("SESPH"))
}

/// Those that solve for the density.
fn implicit() -> impl Iterator<Item = Method> {
    solvers().filter(|method| method.name != "δ-SPH")
}

fn default_method() -> Method {
    let mut methods = METHODS.into_iter();
    let found = methods.find(|method| method.name == "DFSPH");
    found.expect("the default method")
}

/// Every method that solves for the pressure, with defaults: shallow to deep water, narrow and wide. The remaining
/// speeds are those of a square lattice that melts into a denser one; water that fell onto its floor had 0.2 to 25.
#[test]
fn water_at_rest_rests() {
    for method in solvers() {
        for counts in [
            [8, 10, 0],
            [18, 40, 0],
            [30, 60, 0],
            [18, 120, 0],
            [8, 20, 10],
            [4, 60, 0],
            [4, 4, 4],
            [4, 12, 4],
            [10, 30, 4],
        ] {
            let outcome = run(&tank(method, counts, 0.5));
            // PCISPH, and the cubic spline of 3-D, leave the lattice that melts.
            let still = method.name != "PCISPH" && counts[2] == 0;
            let (fastest, rms) = if still { (0.15, 0.03) } else { (0.3, 0.06) };
            assert!(outcome.figure("fastest") < fastest && outcome.figure("rms") < rms);
            // δ-SPH starts without pressure, and its kernel is as wide as the narrowest tank.
            let most = if counts[0] == 4 { 0.02 } else { 0.01 };
            assert!(outcome.figure("gained") < most);
        }
    }
}

/// Every kernel is stable in 2-D and 3-D with its default support.
#[test]
fn every_kernel_holds() {
    let method = default_method();
    for kernel in KernelFunction::ALL {
        for counts in [[18, 40, 0], [8, 10, 8]] {
            let case = tank(method, counts, 0.3);
            let outcome = case.run(&[format!("kernel={kernel:?}")]);
            let text = format!("{kernel:?}, {}: {}", case.name, outcome.text());
            measured(&text);
            assert!(
                outcome.failure.is_none() && outcome.figure("gained") < 0.01,
                "{text}"
            );
            assert!(outcome.figure("fastest") < 0.3, "{text}");
            // The lowest row carries the weight above it.
            assert!((outcome.figure("floor") - 1.0).abs() < 0.3, "{text}");
        }
    }
}

/// The energy of a collapsing column does not rise, neither with fixed short steps nor with adaptive ones.
#[test]
fn a_column_gains_no_energy() {
    for method in implicit() {
        for step in ["", "Fixed(2e-4)"] {
            let outcome = run(&column(method, 40, step, 0.5));
            assert!(outcome.figure("rise") < 0.006);
        }
    }
}

/// The axis of the elliptic drop converges, and its energy does not rise.
#[test]
fn the_elliptic_drop_converges() {
    for method in implicit() {
        let errors = [20, 80].map(|radius| {
            let outcome = run(&drop(method, radius));
            assert!(outcome.figure("energy most %") < 0.2);
            assert!(outcome.figure("energy least %") > -0.6);
            outcome.figure("axis error %").abs()
        });
        assert!(errors[1] < 0.7 * errors[0], "{}: {errors:?}", method.name);
    }
}

/// The pressure of sloshing water does not alternate from particle to particle: without stabilisation it differs from a
/// plane through its neighbours by 0.25 of its mean, with a correlation of −0.40 at a distance of one spacing. That of
/// single runs of 30 to 60 rows, with either wall, is −0.05 to −0.22, on the mean −0.14.
#[test]
fn pressure_does_not_alternate() {
    for method in implicit().filter(|method| method.name != "PCISPH") {
        let [without, with] = ["0", "0.1"].map(|share| {
            let case = slosh(method, 40, false);
            let outcome = case.run(&[format!("pressure.stabilisation={share}")]);
            let text = format!("{}, {share}: {}", method.name, outcome.text());
            measured(&text);
            assert_eq!(outcome.failure, None, "{text}");
            ["residual", "correlation"].map(|name| outcome.figure(name))
        });
        assert!(
            with[0] < 0.6 * without[0],
            "{}: {with:?} {without:?}",
            method.name
        );
        assert!(
            with[1] > 0.6 * without[1] && without[1] < -0.3,
            "{}: {with:?} {without:?}",
            method.name
        );
    }
}

/// Still water with any support from 1.5 to 3.5 spacings, or a refusal that names those that are possible.
#[test]
fn every_support_holds_water_or_is_refused() {
    for method in METHODS {
        for counts in [[12, 16, 0], [6, 8, 6]] {
            let case = tank(method, counts, 0.3);
            for support in [1.5, 2.0, 2.6, 3.0, 3.5] {
                let what = format!("{}, {counts:?}, support {support}", method.name);
                let overrides = [format!("support={support}")];
                match case.refusal(&overrides) {
                    Some(told) => {
                        assert!(
                            told.contains("with this method it must be from"),
                            "{what}: {told}"
                        );
                        assert!(method.name == "δ-SPH" && support < 2.6, "{what}: {told}");
                    }
                    None => {
                        let outcome = case.run(&overrides);
                        measured(&format!("{what}: {}", outcome.text()));
                        assert_eq!(outcome.failure, None, "{what}");
                        assert!(outcome.figure("rms") < 0.2, "{what}: {}", outcome.text());
                        let gained = outcome.figure("gained");
                        assert!(gained < 0.01 || method.name != "DFSPH", "{what}: {gained}");
                    }
                }
            }
        }
    }
}
