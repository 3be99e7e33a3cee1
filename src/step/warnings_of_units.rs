//! Warnings for numbers that were probably written in other units than SI.

use super::numbers::short;
use crate::{
    loading::Size,
    scene::{Scene, Viscosity},
};

/// Above these lengths a scene was probably written in millimetres: spacing and extent \[m].
const LARGE_SPACING: f32 = 1.0;
const LARGE_EXTENT: f64 = 500.0;

/// Gravity of 50 times the Earth's, as in a centrifuge; 9810 is that of the Earth in mm/s² \[m/s²].
const STRONG_GRAVITY: f32 = 50.0 * 9.81;

/// From hydrogen, the lightest liquid, to osmium, the heaviest metal \[kg/m³].
const LIQUIDS: [f32; 2] = [70.0, 23_000.0];

/// Ten times that of honey \[m²/s].
const STIFF: f32 = 0.1;

pub(super) fn of(scene: &Scene, size: &Size) -> impl Iterator<Item = String> {
    let all = [
        lengths(scene, size),
        gravity(scene),
        density(scene),
        viscosity(scene),
    ];
    all.into_iter().flatten()
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
    (gravity > f64::from(STRONG_GRAVITY)).then(|| {
        format!(
            "gravity is {} m/s², {} times the Earth's; it is in m/s², so if this is in mm/s², write {}",
            short(gravity),
            short(gravity / 9.81),
            short(1e-3 * gravity)
        )
    })
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
