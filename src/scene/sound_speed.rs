//! The speed of sound of δ-SPH in a scene that does not write one.

use glam::{DVec3, Vec3};

use super::{BoundaryShape, DeltaSph, Dimension, Scene, Shape, SurfaceTension};

/// Speed of sound over the largest speed expected: about 1 % of compression (Monaghan 1994).
const SOUND: f32 = 10.0;

/// Least speed of sound \[m/s], for scenes in which nothing is expected to move.
const LEAST: f32 = 0.1;

impl DeltaSph {
    /// The speed of sound in a scene \[m/s]: as written, or ten times the largest speed expected.
    pub fn sound_speed_in(&self, scene: &Scene) -> f32 {
        self.sound_speed
            .unwrap_or_else(|| (SOUND * scene.expected_speed()).max(LEAST))
    }
}

impl Scene {
    /// A largest speed to expect \[m/s], or one whose dynamic pressure is that of the fluid: that of the start or of a
    /// wall, `sqrt(2 a L)` of bodies of length L that a wall accelerates by more than gravity, that of a free fall, and
    /// that of cohesion.
    pub fn expected_speed(&self) -> f32 {
        let in_plane = self.dimension == Dimension::Two;
        let speeds = self.boundaries.iter();
        let speeds = speeds.filter_map(|boundary| boundary.greatest_speed(in_plane, None));
        let shaken = self.boundaries.iter();
        let shaken = shaken.filter_map(|boundary| boundary.greatest_acceleration());
        let length = self.bodies.iter();
        let length = length.fold(0.0, |most: f32, body| most.max(2.0 * body.shape.reach()));
        let shaken = shaken.fold(0.0, f32::max);
        // Under more gravity, a free surface gives way to what the wall presses.
        let of_shaking = if shaken > self.greatest_acceleration() {
            (2.0 * length * shaken).sqrt()
        } else {
            0.0
        };
        speeds
            .chain([of_shaking, self.fall_speed(), self.cohesion_speed()])
            .fold(self.max_initial_speed(), f32::max)
    }

    /// `sqrt(2 p/ρ)` \[m/s] of the pressure in fluid that its cohesion holds together, by the virial of pairs:
    /// `p/ρ = κ n ∫ W r²/(2 d)`, with the mean square of the distance over d of 0.05 to 0.08 h².
    fn cohesion_speed(&self) -> f32 {
        match self.fluid.surface_tension {
            SurfaceTension::None => 0.0,
            SurfaceTension::BeckerTeschner { kappa } => {
                let number = self.spacing.powi(-i32::from(u8::from(self.dimension)));
                self.support_radius() * (0.08 * kappa * number).sqrt()
            }
        }
    }

    /// `sqrt(2 a H)` of a free fall \[m/s], H from the top of the fluid to the lowest place of fluid, tanks, planes,
    /// boxes and spheres, along gravity. Surfaces from files and profiles are not looked at.
    fn fall_speed(&self) -> f32 {
        let up = -self.gravity.as_dvec3().normalize_or(DVec3::NEG_Y);
        let acceleration = self.greatest_acceleration();
        let of_box = |min: Vec3, max: Vec3| {
            let (min, max) = (min.as_dvec3(), max.as_dvec3());
            let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
            let (middle, half) = (middle.dot(up), half.abs().dot(up.abs()));
            (middle - half, middle + half)
        };
        let bodies = self.bodies.iter().map(|body| match body.shape {
            Shape::Box { min, max } => of_box(min, max),
            ref shape => {
                let (middle, reach) = (shape.center().dot(up), f64::from(shape.reach()));
                (middle - reach, middle + reach)
            }
        });
        let emitters = self.emitters.iter().map(|emitter| {
            let place = emitter.shape.center().as_dvec3().dot(up);
            (place, place)
        });
        let (mut low, high) = bodies.chain(emitters).fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(low, high), (bottom, top)| (low.min(bottom), high.max(top)),
        );
        for boundary in &self.boundaries {
            low = low.min(match *boundary {
                BoundaryShape::Tank { min, max, .. } | BoundaryShape::Box { min, max, .. } => {
                    of_box(min, max).0
                }
                BoundaryShape::Sphere { center, radius, .. } => {
                    center.as_dvec3().dot(up) - f64::from(radius)
                }
                BoundaryShape::Plane { center, .. } => center.as_dvec3().dot(up),
                _ => f64::INFINITY,
            });
        }
        let height = (high - low).max(0.0) as f32;
        (2.0 * acceleration * height).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{DeltaSph, Scene};

    #[test]
    fn a_column_expects_the_speed_of_a_fall_and_a_thrown_body_its_own() {
        let scene = |rest: &str| {
            let text = format!(
                "(name: \"s\", spacing: 0.1, pressure: DeltaSph(), {rest},
                bodies: [(shape: Box(min: (0, 1, 0), max: (1, 3, 1)), velocity: (3, 0, 0))])"
            );
            Scene::parse(&text, "s.ron", &[]).expect("a scene")
        };
        let column = "boundaries: [Tank(min: (-1, 0.5, 0), max: (9, 9, 1))]";
        let expected = (2.0 * 9.81_f32 * 2.5).sqrt();
        assert!((scene(column).expected_speed() / expected - 1.0).abs() < 1e-5);
        let block = "boundaries: [Box(min: (-1, 0.2, 0), max: (9, 0.5, 1))]";
        assert!(scene(block).expected_speed() > expected);
        let thrown = scene("gravity: (0, 0, 0)");
        assert_eq!(thrown.expected_speed(), 3.0);
        let wall = "boundaries: [Tank(min: (-1, 0.5, 0), max: (9, 9, 1), motion: Oscillation(amplitude: (0.1, 0, 0),
            frequency: 5))]";
        let shaken = (2.0 * 98.7_f32 * 6.0_f32.sqrt()).sqrt();
        assert!((scene(wall).expected_speed() / shaken - 1.0).abs() < 0.01);
        let held = scene("gravity: (0, 0, 0), fluid: (surface_tension: BeckerTeschner(kappa: 10))");
        // 1000 per m³, support 0.35 m.
        assert!((held.expected_speed() / (0.35 * 800.0_f32.sqrt()) - 1.0).abs() < 0.01);
        let method = DeltaSph::default();
        assert_eq!(method.sound_speed_in(&thrown), 30.0);
        let written = DeltaSph {
            sound_speed: Some(7.0),
            ..method
        };
        assert_eq!(written.sound_speed_in(&thrown), 7.0);
    }
}
