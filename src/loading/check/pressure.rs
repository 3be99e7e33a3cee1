//! Parameters of pressure methods.

use super::numbers::{error_limit, positive};
use super::problem::{Checked, ensure};
use crate::pressure::{
    implicit::MAX_RELAXATION_WITH_MOMENTUM,
    solver::{Iterations, Requirement},
    stabilisation::Stabilisation,
    warm_start::WarmStart,
};
use crate::scene::PressureMethod;

/// Each is in its range.
pub(super) fn parameters(method: &PressureMethod) -> Checked {
    if let Some(parameters) = method.iterations() {
        let usual = (method.with_defaults().iterations()).unwrap_or(parameters);
        iterates(&parameters, &usual)?;
    }
    // In the order of the method's own.
    let usual = method.with_defaults().solver().requirements();
    let requirements = method.solver().requirements().into_iter().zip(usual);
    requirements.into_iter().try_for_each(|pair| match pair {
        (Requirement::Positive(path, value, unit), _) => positive(path, value, unit),
        (Requirement::Error(path, limit, what), _) => error_limit(path, what, limit),
        (Requirement::Iterations(path, min, max), _) => iterations(path, min, max),
        (Requirement::Relaxation(path, value, momentum), usual) => {
            relaxation(path, value, momentum, usual)
        }
        (Requirement::Stabilisation(share), usual) => stabilisation(share, usual),
        (Requirement::Factor(path, value, most), _) => factor(path, value, most),
    })
}

/// The value of a parameter that a scene leaves out.
fn usual_value(usual: Requirement) -> f32 {
    match usual {
        Requirement::Positive(_, value, _)
        | Requirement::Error(_, value, _)
        | Requirement::Relaxation(_, value, _)
        | Requirement::Factor(_, value, _)
        | Requirement::Stabilisation(value) => value,
        Requirement::Iterations(_, min, _) => min as f32,
    }
}

fn iterates(parameters: &Iterations, usual: &Iterations) -> Checked {
    let convergence = parameters.convergence;
    error_limit(
        "pressure.max_density_error",
        "largest density error",
        convergence.max_density_error,
    )?;
    iterations(
        "pressure.max_iterations",
        convergence.min_iterations,
        convergence.max_iterations,
    )?;
    let share = parameters.recovery;
    ensure(share > 0.0 && share <= 1.0, "pressure.recovery", || {
        format!(
            "a step removes {share} of the compression that it finds; it must be above 0 and at most 1, all of it \
             ({} is usual)",
            usual.recovery
        )
    })?;
    let WarmStart { share, steps } = parameters.warm_start;
    ensure((0.0..=1.0).contains(&share), "pressure.warm_start", || {
        format!(
            "the iterations start from {share} of the pressures before; it must be from 0 (none) to 1 (all)"
        )
    })?;
    ensure(steps > 0, "pressure.warm_start_steps", || {
        "is a mean over 0 steps; it must be at least 1 (the last step alone)".to_owned()
    })?;
    ensure(
        steps == 1 || share > 0.0,
        "pressure.warm_start_steps",
        || {
            format!(
                "the pressures of {steps} steps are averaged, and iterations start from none of them; set \
                 pressure.warm_start above 0, or pressure.warm_start_steps to 1"
            )
        },
    )
}

fn relaxation(path: &str, relaxation: f32, momentum: bool, usual: Requirement) -> Checked {
    let (with, most) = if momentum {
        ("with", MAX_RELAXATION_WITH_MOMENTUM)
    } else {
        ("without", 1.0)
    };
    let proper = relaxation > 0.0 && relaxation <= most;
    ensure(proper, path, || {
        let usual = usual_value(usual);
        format!(
            "the relaxation is {relaxation}; {with} momentum it must be above 0 and at most {most} ({usual} is usual)"
        )
    })
}

fn stabilisation(share: f32, usual: Requirement) -> Checked {
    let most = Stabilisation::MOST;
    ensure(
        (0.0..=most).contains(&share),
        "pressure.stabilisation",
        || {
            let usual = usual_value(usual);
            format!(
                "the share of the compact Laplacian is {share}; it must be from 0 (none) to {most} ({usual} is usual)"
            )
        },
    )
}

fn factor(path: &str, value: f32, most: f32) -> Checked {
    ensure((0.0..=most).contains(&value), path, || {
        format!("it is {value}; it must be from 0 (none) to {most}")
    })
}

fn iterations(path: &str, min: u32, max: u32) -> Checked {
    ensure(max >= 1 && min <= max, path, || {
        format!(
            "at most {max} iterations, at least {min}; the first must be 1 or more and not below the second"
        )
    })
}
