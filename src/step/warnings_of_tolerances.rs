//! Warnings for tolerances of a pressure solve that let the energy of impacts rise.
//!
//! Measured with a block of water, 0.4 m by 0.2 m at a spacing of 20 mm, that meets the floor at 3 m/s: the rise of its
//! energy over its kinetic one before. Mean errors of 0.3 and 0.5 % leave 6 and 19 % (DFSPH; IISPH 6 and 16), of 1 %
//! more than the guard allows (70); largest errors of 1, 2 and 5 % leave 7, 30 and more than the guard allows (4, 11
//! and 55), and PCISPH 3, 5 and 20. All compression removed at once leaves 113 % (109), nine tenths of it 4 % (2).

use crate::scene::{Criterion, Scene};

/// Limits up to which less than a tenth of the energy comes back \[-]: on the mean error, on the largest with
/// velocities that are solved for, and with positions that are predicted.
const MEAN: f32 = 0.003;
const LARGEST: f32 = 0.01;
const LARGEST_PREDICTED: f32 = 0.02;

/// The same for the part of the compression that a step removes \[-].
const RECOVERY: f32 = 0.9;

pub(super) fn of(scene: &Scene) -> impl Iterator<Item = String> {
    error(scene).into_iter().chain(recovery(scene))
}

fn error(scene: &Scene) -> Option<String> {
    let iterations = scene.pressure.iterations()?;
    let convergence = iterations.convergence;
    let limit = convergence.max_density_error;
    let (most, what) = match convergence.criterion {
        Criterion::Mean => (
            MEAN,
            "the mean over all particles (`criterion: Mean`), of which single ones have many times as much",
        ),
        Criterion::Largest if iterations.is_linear => (LARGEST, "the largest error"),
        Criterion::Largest => (LARGEST_PREDICTED, "the largest error"),
    };
    let mean_is_limited = (convergence.mean_density_error).is_some_and(|mean| mean <= MEAN);
    let other = match convergence.criterion {
        Criterion::Mean => format!(", or {LARGEST} of the largest error (`criterion: Largest`)"),
        Criterion::Largest => String::new(),
    };
    (limit > most && !mean_is_limited).then(|| {
        format!(
            "`pressure.max_density_error` is {limit}, of {what}: fluid that meets a wall or other fluid stays \
             compressed, \
             and springs back with up to all of its energy; at most {most} keeps that below a tenth{other}"
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
             removes \
             all of it throws the fluid back with up to twice its energy; at most {RECOVERY} keeps that below a tenth \
             ({usual} is usual)"
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
                "at most 0.003 keeps that below a tenth, or 0.01",
            ),
            (
                "Iisph(max_density_error: 0.02, criterion: Largest)",
                "at most 0.01 keeps",
            ),
            (
                "Pcisph(max_density_error: 0.05, mean_density_error: None)",
                "at most 0.02 keeps",
            ),
            (
                "Pcisph(max_density_error: 0.05, mean_density_error: 0.04)",
                "at most 0.02 keeps",
            ),
            (
                "Dfsph(recovery: 1)",
                "at most 0.9 keeps that below a tenth (0.1 is usual)",
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
            // As published.
            "Pcisph(warm_start: 0, momentum: false, recovery: 1, mean_density_error: None, last_correction: true)",
            "Sesph(equation: Gas(stiffness: 1000))",
            "DeltaSph",
        ] {
            assert_eq!(of(pressure), "", "{pressure}");
        }
    }
}
