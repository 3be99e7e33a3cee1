//! Warnings about forces that do nothing, or not yet.

use glam::Vec3;

use crate::scene::{BodyForce, LEAST_WAY, Scene};

pub(super) fn of(scene: &Scene) -> impl Iterator<Item = String> {
    let waves = scene.body_forces.iter().enumerate();
    ramp(scene)
        .into_iter()
        .chain(waves.filter_map(|wave| quick(scene, wave)))
}

/// A warning for a ramp of gravity that ramps nothing, or not to its end.
fn ramp(scene: &Scene) -> Option<String> {
    let (ramp, end) = (scene.gravity_ramp, scene.duration);
    if ramp > 0.0 && scene.gravity == Vec3::ZERO {
        return Some(
            "`gravity_ramp` has no gravity to let grow; write `gravity`, or leave it out"
                .to_owned(),
        );
    }
    (ramp > end).then(|| {
        format!(
            "gravity grows over {ramp} s, and the scene ends at {end} s: it never has all of its gravity; a ramp of \
             some times the fall through the fluid's depth would do"
        )
    })
}

/// A warning for a wave that moves the fluid by nothing before it turns.
fn quick(scene: &Scene, (index, force): (usize, &BodyForce)) -> Option<String> {
    let BodyForce::Wave(wave) = force else {
        return None;
    };
    let omega = std::f64::consts::TAU * f64::from(wave.frequency);
    let way = 2.0 * wave.amplitude.as_dvec3().length() / omega.powi(2);
    let least = f64::from(LEAST_WAY * scene.spacing);
    (way < least).then(|| {
        format!(
            "the wave `body_forces.{index}` comes {:e} times a second and moves the fluid {way:.1e} m there and back: \
             it does nothing, and steps do not follow it; from an amplitude of {:.1e} m/s² on, or below {:.1e} times a \
             second, they do",
            wave.frequency,
            0.5 * least * omega.powi(2),
            f64::from(wave.frequency.abs()) * (way / least).sqrt()
        )
    })
}

#[cfg(test)]
mod tests {
    use crate::{scene::Scene, step::warnings};

    #[test]
    fn forces_that_do_nothing_are_named() {
        let all = |more: &str| {
            let text = format!(
                "(name: \"f\", dimension: 2, spacing: 0.1, duration: 2,
                  bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))], {more})"
            );
            let scene = Scene::parse(&text, "f.ron", &[]).expect("a scene");
            warnings(&scene).expect("a scene").join("\n")
        };
        for (more, part) in [
            (
                "gravity_ramp: 1, gravity: (0, 0, 0)",
                "no gravity to let grow",
            ),
            ("gravity_ramp: 3", "the scene ends at 2 s"),
            (
                "body_forces: [Wave(amplitude: (1, 0, 0), frequency: 1e6)]",
                "`body_forces.0` comes 1e6 times a second",
            ),
        ] {
            let found = all(more);
            assert!(found.contains(part), "{more}: {found}");
        }
        for more in [
            "gravity_ramp: 1",
            "body_forces: [Wave(amplitude: (1, 0, 0), frequency: 5)]",
            "body_forces: [Wave(amplitude: (1, 0, 0), wave_number: (3, 0, 0))]",
        ] {
            let found = all(more);
            assert!(
                !found.contains("ramp") && !found.contains("wave"),
                "{found}"
            );
        }
    }
}
