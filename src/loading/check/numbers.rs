//! Single numbers and pairs of them.

use super::problem::{Checked, Problem, ensure};
use super::proper::is_flat;
use crate::loading::ron_text::options;
use crate::loading::spans::scan;
use crate::scene::{
    Adaptive, BoundaryHandling, Camera, Cfl, Scene, SurfaceTension, TimeStep, Viscosity,
};

/// Least cell edge in support radii: 41 cells across the support.
const SMALLEST_CELL: f32 = 0.05;

/// Largest skin of lists that are kept, in support radii.
const MOST_SKIN: f32 = 0.5;

/// Every number of the scene is finite: asked of the written scene, so a field added later is asked, too.
pub(super) fn finite(scene: &Scene) -> Checked {
    let text = options()
        .to_string(scene)
        .map_err(|error| Problem::new("name", error.to_string()))?;
    let mut found = None;
    if let Some(tree) = scan(&text) {
        tree.leaves("", &mut |path, leaf| {
            let value = &text[leaf.span.clone()];
            if found.is_none() && matches!(value, "inf" | "-inf" | "NaN" | "-NaN") {
                found = Some(Problem::new(
                    path,
                    format!(
                        "`{path}` is {value}; it must be a finite number (in single precision)"
                    ),
                ));
            }
        });
    }
    found.map_or(Ok(()), Err)
}

fn gravity(scene: &Scene) -> Checked {
    is_flat("gravity", scene.gravity, scene.dimension)?;
    ensure(scene.gravity_ramp >= 0.0, "gravity_ramp", || {
        let ramp = scene.gravity_ramp;
        format!(
            "the ramp is {ramp} s; it must be 0 or more, and 0 is all of gravity from the start on"
        )
    })
}

/// What each number means allows.
pub(super) fn numbers(scene: &Scene) -> Checked {
    let name_is_a_folder = !scene.name.trim().is_empty()
        && !scene.name.contains(['/', '\\'])
        && scene.name != "."
        && scene.name != "..";
    ensure(name_is_a_folder, "name", || {
        format!(
            "the name {:?} cannot name the output folder; write a word without slashes",
            scene.name
        )
    })?;
    positive("spacing", scene.spacing, "m")?;
    let support = scene.support();
    let least = scene.pressure.solver().least_support();
    ensure((least..=4.0).contains(&support), "support", || {
        let advised = Scene {
            support: None,
            ..scene.clone()
        };
        format!(
            "the support is {support} spacings; with this method it must be from {least} (below, a particle has too \
             few neighbours to know its density) to 4 (above, it has over 250), and {} is usual for this kernel",
            advised.support()
        )
    })?;
    gravity(scene)?;
    fluid(scene)?;
    boundary_handling(scene)?;
    match scene.time_step {
        TimeStep::Fixed(dt) => positive("time_step.0", dt, "s")?,
        TimeStep::Cfl(cfl) => follows_the_motion(cfl)?,
        TimeStep::Adaptive(scheme) => adaptive(scheme)?,
    }
    let cell_size = scene.index.cell_size;
    ensure(
        (SMALLEST_CELL..=1.0).contains(&cell_size),
        "index.cell_size",
        || {
            format!(
                "the cell size is {cell_size} support radii; it must be at least {SMALLEST_CELL} (below, a search \
                 goes through tens of thousands of cells around each) and at most 1, which is usual"
            )
        },
    )?;
    if let Some(skin) = scene.skin() {
        ensure(skin > 0.0 && skin <= MOST_SKIN, "neighbours.skin", || {
            format!(
                "the skin is {skin} support radii; it must be above 0 (lists that are found in every step are \
                 `Stored`) and at most {MOST_SKIN} (above, lists are more than three times as long); 0.1 is usual"
            )
        })?;
    }
    positive("limits.compression", scene.limits.compression, "")?;
    positive("limits.energy", scene.limits.energy, "")?;
    if let Some(limit) = scene.memory_limit {
        positive("memory_limit", limit, "GB")?;
    }
    positive("duration", scene.duration, "s")?;
    output(scene)
}

/// The walls suit the method, and their parameters are in range.
fn boundary_handling(scene: &Scene) -> Checked {
    let support = scene.support();
    let has_speed_of_sound = scene.pressure.iterations().is_none();
    ensure(
        !(has_speed_of_sound && scene.boundary_handling() == BoundaryHandling::Extrapolated),
        "boundary_handling",
        || {
            "walls that are `Extrapolated` are for methods that solve for the pressure (Pcisph, Iisph, Dfsph); with an \
             equation of state take `Akinci` or `Layers`"
                .to_owned()
        },
    )?;
    if let BoundaryHandling::DirectForcing(direct) = scene.boundary_handling() {
        let (distance, slip) = (direct.rest_distance, direct.slip);
        ensure(
            distance > 0.0 && distance <= support,
            "boundary_handling.rest_distance",
            || {
                format!(
                    "the rest distance is {distance} spacings; it must be above 0 and at most the support of \
                     {support} (1 is usual)"
                )
            },
        )?;
        ensure(
            (0.0..=1.0).contains(&slip),
            "boundary_handling.slip",
            || {
                format!(
                    "the slip is {slip}; it must be from 0 (fluid sticks) to 1 (it slips freely)"
                )
            },
        )?;
    }
    Ok(())
}

fn fluid(scene: &Scene) -> Checked {
    positive("fluid.rest_density", scene.fluid.rest_density, "kg/m³")?;
    match scene.fluid.viscosity {
        Viscosity::None => {}
        Viscosity::Laminar {
            kinematic_viscosity,
            numerical,
        } => {
            let path = "fluid.viscosity.kinematic_viscosity";
            not_negative(path, kinematic_viscosity, "m²/s")?;
            not_negative(
                "fluid.viscosity.numerical",
                numerical.unwrap_or_default(),
                "",
            )?;
        }
        Viscosity::Artificial { alpha, sound_speed } => {
            not_negative("fluid.viscosity.alpha", alpha, "")?;
            not_negative("fluid.viscosity.sound_speed", sound_speed, "m/s")?;
        }
    }
    match scene.fluid.surface_tension {
        SurfaceTension::None => Ok(()),
        SurfaceTension::BeckerTeschner { kappa } => {
            not_negative("fluid.surface_tension.kappa", kappa, "")
        }
    }
}

pub(super) fn error_limit(path: &str, what: &str, limit: f32) -> Checked {
    ensure(limit > 0.0 && limit < 1.0, path, || {
        format!(
            "the {what} is {limit}, as a part of the rest density; it must be above 0 and below 1 (0.01 is 1 %)"
        )
    })
}

fn follows_the_motion(cfl: Cfl) -> Checked {
    let factor = cfl.factor;
    ensure(factor > 0.0 && factor <= 1.0, "time_step.factor", || {
        let usual = Cfl::default().factor;
        format!("the factor is {factor}; it must be above 0 and at most 1 ({usual} is usual)")
    })?;
    bounds(cfl.min, cfl.max)
}

fn adaptive(scheme: Adaptive) -> Checked {
    let Adaptive { min, max, .. } = scheme;
    bounds(min, max)?;
    let initial = scheme.initial.unwrap_or(max);
    ensure((min..=max).contains(&initial), "time_step.initial", || {
        format!(
            "the first time step is {initial} s; it must be from {min} (`min`) to {max} s (`max`)"
        )
    })?;
    error_limit(
        "time_step.density_error",
        "mean density error up to which the time step grows",
        scheme.density_error,
    )?;
    error_limit(
        "time_step.max_density_error",
        "largest density error that is no shock",
        scheme.max_density_error,
    )?;
    ensure(
        scheme.density_error <= scheme.max_density_error,
        "time_step.max_density_error",
        || {
            format!(
                "the largest density error, {}, is below the mean, {} (`density_error`)",
                scheme.max_density_error, scheme.density_error
            )
        },
    )
}

fn bounds(min: f32, max: f32) -> Checked {
    positive("time_step.min", min, "s")?;
    ensure(min <= max, "time_step.max", || {
        format!("the largest time step, {max} s, is below the smallest, {min} s")
    })
}

fn output(scene: &Scene) -> Checked {
    not_negative(
        "output.frames_per_second",
        scene.output.frames_per_second,
        "1/s",
    )?;
    let Some(camera) = scene.output.camera else {
        return Ok(());
    };
    let view = camera.field_of_view;
    ensure(
        view > 0.0 && view < 180.0,
        "output.camera.field_of_view",
        || {
            format!(
                "the angle of view is {view} degrees; it must be above 0 and below 180 (40 is usual)"
            )
        },
    )?;
    for (name, place) in [("position", camera.position), ("target", camera.target)] {
        ensure(
            place.abs().max_element() <= Camera::FARTHEST,
            format!("output.camera.{name}"),
            || {
                format!(
                    "{name} is {place} m; a camera may be {:e} m from the origin at most",
                    Camera::FARTHEST
                )
            },
        )?;
    }
    ensure(
        camera.position != camera.target,
        "output.camera.target",
        || "the camera looks at the place where it is; move `target` or `position`".to_owned(),
    )
}

pub(super) fn positive(path: &str, value: f32, unit: &str) -> Checked {
    ensure(value > 0.0, path, || {
        format!("`{path}` is {}; it must be above 0", with_unit(value, unit))
    })
}

fn not_negative(path: &str, value: f32, unit: &str) -> Checked {
    ensure(value >= 0.0, path, || {
        format!(
            "`{path}` is {}; it must not be negative",
            with_unit(value, unit)
        )
    })
}

fn with_unit(value: f32, unit: &str) -> String {
    format!("{value} {unit}").trim_end().to_owned()
}
