//! Warnings for numbers that were probably written in other units than SI.

use std::f32::consts::TAU;

use super::numbers::short;
use crate::{
    loading::Size,
    scene::{BodyForce, Scene, Viscosity, WallMotion},
};

/// Above these lengths a scene was probably written in millimetres: spacing and extent \[m].
const LARGE_SPACING: f32 = 1.0;
const LARGE_EXTENT: f64 = 500.0;

/// Gravity of 50 times the Earth's, as in a centrifuge; 9810 is that of the Earth in mm/s² \[m/s²].
const STRONG_GRAVITY: f32 = 50.0 * 9.81;

/// A fiftieth of it, less than any planet has; 0.00981 is that of the Earth in km/s² \[m/s²].
const WEAK_GRAVITY: f64 = 0.02 * 9.81;

/// From hydrogen, the lightest liquid, to osmium, the heaviest metal \[kg/m³].
const LIQUIDS: [f32; 2] = [70.0, 23_000.0];

/// Ten times that of honey \[m²/s].
const STIFF: f32 = 0.1;

/// Dynamic viscosity of water from 25 °C to 20 °C \[Pa s], and its densities \[kg/m³].
const OF_WATER: [f32; 2] = [8.85e-4, 1.01e-3];
const WATER: [f32; 2] = [950.0, 1050.0];

pub(super) fn of(scene: &Scene, size: &Size) -> impl Iterator<Item = String> {
    let all = [
        lengths(scene, size),
        gravity(scene),
        density(scene),
        viscosity(scene),
    ];
    let forces = scene.body_forces.iter().enumerate();
    let forces = forces.filter_map(|force| strong(scene, force));
    let angles = phases(scene).into_iter().chain(radians(scene));
    all.into_iter().flatten().chain(forces).chain(angles)
}

fn lengths(scene: &Scene, size: &Size) -> Option<String> {
    let extent = (size.whole_box.1 - size.whole_box.0).max_element();
    let is_large = scene.spacing >= LARGE_SPACING || extent >= LARGE_EXTENT;
    let spacing = f64::from(scene.spacing);
    is_large.then(|| {
        format!(
            "the scene is {} m long at a spacing of {} m; lengths are in metres, so if these are millimetres, write \
             {} and {}",
            short(extent),
            short(spacing),
            short(1e-3 * extent),
            short(1e-3 * spacing),
        )
    })
}

fn gravity(scene: &Scene) -> Option<String> {
    let gravity = scene.gravity.as_dvec3().length();
    // Along a periodic axis it drives a channel, by however little.
    if gravity > 0.0 && gravity < WEAK_GRAVITY && !scene.period().is_any() {
        return Some(format!(
            "gravity is {} m/s², {} times the Earth's; it is in m/s², so if this is in km/s², write {}",
            short(gravity),
            short(gravity / 9.81),
            short(1e3 * gravity)
        ));
    }
    (gravity > f64::from(STRONG_GRAVITY)).then(|| {
        format!(
            "gravity is {} m/s², {} times the Earth's; it is in m/s², so if this is in mm/s², write {}",
            short(gravity),
            short(gravity / 9.81),
            short(1e-3 * gravity)
        )
    })
}

/// A warning for a force that no centrifuge has.
fn strong(scene: &Scene, (index, force): (usize, &BodyForce)) -> Option<String> {
    let most = f64::from(scene.greatest_acceleration_of(force));
    (most > f64::from(STRONG_GRAVITY)).then(|| {
        format!(
            "`body_forces.{index}` accelerates the fluid by up to {} m/s², {} times the Earth's gravity; \
             accelerations are in m/s², so if this is in mm/s², write a thousandth of it",
            short(most),
            short(most / 9.81)
        )
    })
}

/// Warnings for phases beyond a turn, which are probably in degrees.
fn phases(scene: &Scene) -> Vec<String> {
    let waves = (scene.body_forces.iter().enumerate()).filter_map(|(index, force)| match force {
        BodyForce::Wave(wave) => Some((format!("body_forces.{index}"), wave.phase)),
        BodyForce::Central(_) | BodyForce::Table(_) => None,
    });
    let walls =
        (scene.boundaries.iter().enumerate()).filter_map(|(index, wall)| match wall.motion() {
            Some(&WallMotion::Oscillation { phase, .. }) => {
                Some((format!("boundaries.{index}.motion"), phase))
            }
            _ => None,
        });
    let beyond = waves
        .chain(walls)
        .filter(|(_, phase)| phase.abs() > 1.001 * TAU);
    let told = beyond.map(|(path, phase)| {
        format!(
            "the phase of `{path}` is {phase} rad, more than a turn of 6.2832; if it is in degrees, write {}",
            short(f64::from(phase).to_radians())
        )
    });
    told.collect()
}

/// Warnings for rotations by parts of π, which are probably in radians.
fn radians(scene: &Scene) -> Vec<String> {
    let bodies = scene.bodies.iter().enumerate();
    let bodies = bodies.map(|(index, body)| (format!("bodies.{index}"), body.rotation));
    let walls = scene.boundaries.iter().enumerate();
    let walls = walls.map(|(index, wall)| (format!("boundaries.{index}"), wall.rotation()));
    let told = bodies.chain(walls).filter_map(|(path, rotation)| {
        let angle = rotation.to_array().into_iter().find(|angle| is_part_of_pi(*angle))?;
        Some(format!(
            "`{path}` is turned by {}°; angles of `rotation` are in degrees, so if this is in rad, write {}",
            short(angle),
            short(angle.to_degrees().round())
        ))
    });
    told.collect()
}

/// Whether a number is π over 1, 2, 3, 4 or 6, or 2π or 3π/2, with three digits or more.
fn is_part_of_pi(angle: f64) -> bool {
    let parts = [1.0, 2.0, 3.0, 4.0, 6.0, 0.5, 2.0 / 3.0];
    let off = |part: f64| (angle.abs() * part / std::f64::consts::PI - 1.0).abs();
    parts.into_iter().any(|part| off(part) < 6e-4)
}

fn density(scene: &Scene) -> Option<String> {
    let density = scene.fluid.rest_density;
    let [least, most] = LIQUIDS;
    (!(least..=most).contains(&density)).then(|| {
        let meant = match density {
            density if density < least => 1e3 * f64::from(density),
            density => 1e-3 * f64::from(density),
        };
        format!(
            "the rest density is {} kg/m³, which no liquid has (water has 1000); if it is in another unit, write {}",
            short(density.into()),
            short(meant)
        )
    })
}

fn viscosity(scene: &Scene) -> Option<String> {
    let Viscosity::Laminar {
        kinematic_viscosity,
        ..
    } = scene.fluid.viscosity
    else {
        return None;
    };
    let is_in = |[least, most]: [f32; 2], value: f32| (least..=most).contains(&value);
    if is_in(OF_WATER, kinematic_viscosity) && is_in(WATER, scene.fluid.rest_density) {
        return Some(format!(
            "the kinematic viscosity is {kinematic_viscosity} m²/s, the number of water's dynamic one in Pa s; if \
             water is meant, write 1e-6, that over its density"
        ));
    }
    (kinematic_viscosity > STIFF).then(|| {
        let nu = f64::from(kinematic_viscosity);
        format!(
            "the kinematic viscosity is {} m²/s, {} times that of water (1e-6); honey has about 0.01; if it is a \
             dynamic one in Pa s, write {}, that over the density",
            short(nu),
            short(1e6 * nu),
            short(nu / f64::from(scene.fluid.rest_density))
        )
    })
}

#[cfg(test)]
mod tests {
    use crate::{scene::Scene, step::warnings};

    fn told(more: &str) -> String {
        let text = format!(
            "(name: \"t\", dimension: 2, spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))], {more})"
        );
        let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        warnings(&scene).expect("a scene").join("\n")
    }

    #[test]
    fn numbers_in_other_units_are_told_with_what_would_do() {
        for (more, part) in [
            ("gravity: (0, -9810, 0)", "if this is in mm/s², write 9.81"),
            ("gravity: (-981, 0, 0)", "100 times the Earth's"),
            (
                "fluid: (rest_density: 1)",
                "if it is in another unit, write 1000",
            ),
            (
                "fluid: (rest_density: 1e6)",
                "if it is in another unit, write 1000",
            ),
            (
                "fluid: (viscosity: Laminar(kinematic_viscosity: 1))",
                "1000000 times that of water (1e-6); honey has about 0.01; if it is a dynamic one in Pa s, write 0.001",
            ),
        ] {
            let told = told(more);
            assert!(told.contains(part), "{more}: {told}");
        }
        for more in [
            "gravity: (0, -274, 0)",
            "fluid: (rest_density: 70.8)",
            "fluid: (rest_density: 13534, viscosity: Laminar(kinematic_viscosity: 0.01))",
        ] {
            assert_eq!(told(more), "", "{more}");
        }
    }

    #[test]
    fn forces_phases_and_angles_in_other_units_are_told() {
        let wave = |rest: &str| format!("body_forces: [Wave({rest}, frequency: 5)]");
        let wall =
            |rest: &str| format!("boundaries: [Box(min: (5, 0, 0), max: (6, 1, 0), {rest})]");
        let swings = |phase: &str| {
            wall(&format!(
                "motion: Oscillation(amplitude: (0.01, 0, 0), frequency: 1, phase: {phase})"
            ))
        };
        for (more, part) in [
            (
                wave("amplitude: (1e6, 0, 0)"),
                "`body_forces.0` accelerates the fluid by up to 1000000 m/s²",
            ),
            (
                wave("amplitude: (1, 0, 0), phase: 90"),
                "if it is in degrees, write 1.571",
            ),
            (swings("-180"), "`boundaries.0.motion` is -180 rad"),
            (
                wall("rotation: (0, 0, 1.5708)"),
                "if this is in rad, write 90",
            ),
            (
                wall("rotation: (0, 0, -0.785)"),
                "if this is in rad, write -45",
            ),
            (
                "body_forces: [Central(center: (0, 0, 0), linear: 1e4)]".to_owned(),
                "`body_forces.0` accelerates",
            ),
            (
                "gravity: (0, -0.00981, 0)".to_owned(),
                "if this is in km/s², write 9.81",
            ),
            (
                "fluid: (viscosity: Laminar(kinematic_viscosity: 0.001))".to_owned(),
                "if water is meant, write 1e-6",
            ),
        ] {
            let told = told(&more);
            assert!(told.contains(part), "{more}: {told}");
        }
        for more in [
            wave("amplitude: (10, 0, 0), phase: -6.2832"),
            swings("1.5708"),
            wall("rotation: (0, 0, 1.5)"),
            "gravity: (0, -0.28, 0)".to_owned(),
            "periodic: (x: (0, 1)), gravity: (1e-4, 0, 0)".to_owned(),
            "fluid: (rest_density: 1260, viscosity: Laminar(kinematic_viscosity: 0.001))"
                .to_owned(),
        ] {
            assert_eq!(told(&more), "", "{more}");
        }
    }

    #[test]
    fn lengths_that_look_like_millimetres_are_told_in_few_digits() {
        let text = "(name: \"t\", dimension: 2, spacing: 10, gravity: (0, 0, 0),
            bodies: [(shape: Box(min: (0, 0, 0), max: (700.2, 500, 0)))])";
        let scene = Scene::parse(text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        let told = warnings(&scene).expect("a scene").join("\n");
        assert!(
            told.contains("700.2 m long") && told.contains("write 0.7002 and 0.01"),
            "{told}"
        );
    }
}
