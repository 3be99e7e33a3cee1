//! Warnings for tolerances of a pressure solve that let the energy of impacts rise.

use crate::scene::{Criterion, Scene};

/// Limits up to which about a tenth of the energy comes back at most \[-], on the mean error and on the largest: with
/// velocities that are solved for, and with positions that are predicted. Measured in `docs/decisions/impacts.md`.
const SOLVED: Limits = Limits {
    mean: 0.003,
    largest: 0.01,
};
const PREDICTED: Limits = Limits {
    mean: 0.001,
    largest: 0.005,
};

/// Limit on the mean error that makes up for any on the largest \[-].
const MEAN_BESIDE: f32 = 0.003;

/// The same for the part of the compression that a step removes \[-].
const RECOVERY: f32 = 0.9;

struct Limits {
    mean: f32,
    largest: f32,
}

pub(super) fn of(scene: &Scene) -> impl Iterator<Item = String> {
    error(scene).into_iter().chain(recovery(scene))
}

fn error(scene: &Scene) -> Option<String> {
    let iterations = scene.pressure.iterations()?;
    let convergence = iterations.convergence;
    let limit = convergence.max_density_error;
    let limits = if iterations.is_linear {
        SOLVED
    } else {
        PREDICTED
    };
    let (most, what, other) = match convergence.criterion {
        Criterion::Mean => (
            limits.mean,
            "the mean over all particles (`criterion: Mean`), of which single ones have many times as much",
            format!(
                ", and so does {} of the largest error (`criterion: Largest`)",
                limits.largest
            ),
        ),
        Criterion::Largest => (limits.largest, "the largest error", String::new()),
    };
    let mean_is_limited = (convergence.mean_density_error).is_some_and(|mean| mean <= MEAN_BESIDE);
    (limit > most && !mean_is_limited).then(|| {
        format!(
            "`pressure.max_density_error` is {limit}, of {what}: fluid that meets a wall or other fluid stays \
             compressed, and springs back with all of its energy or more; {most} keeps that to about a tenth{other}"
        )
    })
}

fn recovery(scene: &Scene) -> Option<String> {
    let iterations = scene.pressure.iterations()?;
    let usual = scene.pressure.with_defaults().iterations()?.recovery;
    let share = iterations.recovery;
    (iterations.is_linear && share > RECOVERY).then(|| {
        format!(
            "`pressure.recovery` is {share}: fluid that meets a wall or other fluid is compressed, and a step that \
             removes all of it throws the fluid back with more than its energy; {RECOVERY} keeps that to about a \
             tenth ({usual} is usual)"
        )
    })
}

#[cfg(test)]
mod tests {
    use crate::{scene::Scene, step::warnings};

    #[test]
    fn tolerances_that_let_impacts_spring_back_are_told() {
        let of = |pressure: &str| {
            let text = format!(
                "(name: \"t\", dimension: 2, spacing: 0.1, pressure: {pressure},
                bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))])"
            );
            let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
            warnings(&scene).expect("a scene").join("\n")
        };
        for (pressure, part) in [
            (
                "Dfsph(max_density_error: 0.01)",
                "0.003 keeps that to about a tenth, and so does 0.01",
            ),
            (
                "Iisph(max_density_error: 0.02, criterion: Largest)",
                "0.01 keeps",
            ),
            (
                "Pcisph(max_density_error: 0.05, mean_density_error: None)",
                "0.005 keeps",
            ),
            (
                "Pcisph(max_density_error: 0.05, mean_density_error: 0.04)",
                "0.005 keeps",
            ),
            (
                "Pcisph(max_density_error: 0.002, criterion: Mean, mean_density_error: None)",
                "0.001 keeps",
            ),
            // As published.
            (
                "Pcisph(warm_start: 0, momentum: false, recovery: 1, mean_density_error: None, last_correction: true)",
                "0.005 keeps",
            ),
            (
                "Dfsph(recovery: 1)",
                "0.9 keeps that to about a tenth (0.1 is usual)",
            ),
        ] {
            let told = of(pressure);
            assert!(told.contains(part), "{pressure}: {told}");
        }
        for pressure in [
            "Dfsph",
            "Dfsph(max_density_error: 0.003, recovery: 0.9)",
            "Iisph(max_density_error: 0.01, criterion: Largest)",
            "Pcisph(max_density_error: 0.05)",
            "Sesph(equation: Gas(stiffness: 1000))",
            "DeltaSph",
        ] {
            assert_eq!(of(pressure), "", "{pressure}");
        }
    }
}
