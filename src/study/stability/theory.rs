//! Longest stable steps that analysis knows: of waves on the lattice at rest.

use crate::{
    filling,
    lattice::Lattice,
    scene::{Scene, TimeStep, Viscosity},
};

/// A limit on the time step of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct StepLimit {
    /// Its name.
    pub name: &'static str,
    /// The longest stable time step \[s].
    pub dt: f64,
}

/// Sound alone, viscosity alone, both together, and waves of the lattice under the pressure at the fluid's depth.
const SOUND: &str = "sound";
const VISCOSITY: &str = "viscosity";
const BOTH: &str = "sound and viscosity";
const PRESSURE: &str = "lattice under pressure";

/// The limits that apply to a scene, without safety factors.
///
/// Semi-implicit Euler follows an oscillation up to `ω dt = 2`, decay up to `λ dt = 2`, and both together up to
/// `λ dt/2 + (ω dt/2)² = 1` (von Neumann's analysis, as in Violeau & Leroy 2014).
pub fn step_limits(scene: &Scene) -> Vec<StepLimit> {
    let lattice = Lattice::of(scene);
    let dx = f64::from(scene.spacing);
    let sound = scene.pressure.solver().sound_speed(scene);
    let sound = sound.map(|c| lattice.sound_step() * dx / f64::from(c));
    let viscous = viscosity(scene).map(|nu| lattice.viscous_step() * dx * dx / nu);
    let both = sound
        .zip(viscous)
        .map(|(sound, viscous)| together(sound, viscous));
    // An equation of state has faster waves than those of the lattice.
    let pressure = (sound.is_none())
        .then(|| speed_of_depth(scene))
        .filter(|speed| *speed > 0.0);
    let pressure = pressure.map(|speed| lattice.pressure_step() * dx / speed);
    let all = [
        (SOUND, sound),
        (VISCOSITY, viscous),
        (BOTH, both),
        (PRESSURE, pressure),
    ];
    all.into_iter()
        .filter_map(|(name, dt)| Some(StepLimit { name, dt: dt? }))
        .collect()
}

/// The time step of a scene over each limit; none unless it is fixed.
pub fn shares_of_limits(scene: &Scene) -> Vec<(&'static str, f64)> {
    let TimeStep::Fixed(dt) = scene.time_step else {
        return Vec::new();
    };
    let limits = step_limits(scene).into_iter();
    limits
        .map(|limit| (limit.name, f64::from(dt) / limit.dt))
        .collect()
}

/// The positive root of `dt/viscous + (dt/sound)² = 1`.
fn together(sound: f64, viscous: f64) -> f64 {
    let linear = 1.0 / viscous;
    let square = 1.0 / (sound * sound);
    2.0 / (linear + (linear * linear + 4.0 * square).sqrt())
}

/// Kinematic viscosity \[m²/s], and what an artificial one amounts to (Monaghan 2005, eq. 8.8).
fn viscosity(scene: &Scene) -> Option<f64> {
    let d = f64::from(u8::from(scene.dimension));
    let viscosity = match scene.fluid.viscosity {
        Viscosity::Laminar {
            kinematic_viscosity,
            ..
        } => f64::from(kinematic_viscosity) / Lattice::of(scene).shear_viscosity(),
        Viscosity::Artificial { alpha, sound_speed } => {
            f64::from(alpha * scene.support_radius() * sound_speed) / (2.0 * (d + 2.0))
        }
        _ => 0.0,
    };
    (viscosity > 0.0).then_some(viscosity)
}

/// `sqrt(p/ρ)` below the fluid at rest, and where it hits something at its speed \[m/s].
fn speed_of_depth(scene: &Scene) -> f64 {
    let along = scene.gravity.normalize_or_zero();
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    for particle in filling::fluid_particles(scene) {
        let height = along.dot(particle.position);
        (low, high) = (low.min(height), high.max(height));
    }
    let depth = f64::from((high - low).max(0.0) + scene.spacing);
    let speed = f64::from(scene.max_initial_speed());
    (f64::from(scene.gravity.length()) * depth + 0.5 * speed * speed).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(dimension: u8, rest: &str) -> Scene {
        let text = format!(
            "(name: \"t\", dimension: {dimension}, spacing: 0.1, kernel: CubicSpline, support: 4, bodies: [(shape: \
             Box(min: (0, 0, 0), max: (0.4, 2, 0.4)))], {rest})"
        );
        Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"))
    }

    /// With many neighbours the lattice is a continuum. There sound has the limits 0.94 and 0.914 h/c. Of viscosity the
    /// shortest waves are known: they decay with `2 (d + 2)/d ν ∫ −W′/r dV`, which is 45.7 ν/h² in 2-D and 40 ν/h² in
    /// 3-D; the fastest is somewhat longer.
    #[test]
    fn limits_are_those_of_the_continuum_where_there_are_many_neighbours() {
        let h = 0.4;
        for (dimension, sound, shortest) in [(2, 0.94, 45.7), (3, 0.914, 40.0)] {
            let of = |rest: &str| step_limits(&scene(dimension, rest));
            let gas = "time_step: Fixed(1e-4), pressure: Sesph(equation: Gas(stiffness: 400))";
            let found = of(&format!("fluid: (viscosity: None), {gas}"));
            assert_eq!(found.len(), 1);
            let found = found[0].dt * 20.0 / h;
            assert!((found / sound - 1.0).abs() < 0.03, "{dimension}: {found}");
            let thick = "fluid: (viscosity: Laminar(kinematic_viscosity: 0.5, numerical: 0))";
            let both = of(&format!("{thick}, {gas}"));
            let names: Vec<&str> = both.iter().map(|limit| limit.name).collect();
            assert_eq!(names, [SOUND, VISCOSITY, BOTH]);
            let [s, v, b] = [0, 1, 2].map(|k| both[k].dt);
            let share = v * 0.5 / (h * h) * shortest / 2.0;
            assert!(share > 0.6 && share < 1.1, "{dimension}: {share}");
            assert!((b / v + (b / s).powi(2) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn methods_that_iterate_have_the_waves_of_the_lattice_alone() {
        let found = step_limits(&scene(2, "fluid: (viscosity: None), pressure: Iisph()"));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].name, PRESSURE);
        assert!(found[0].dt > 0.0 && found[0].dt.is_finite());
        assert!(shares_of_limits(&scene(2, "time_step: Cfl()")).is_empty());
    }
}
