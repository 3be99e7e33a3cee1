//! Shapes into particles: bodies of fluid filled on a square or cubic lattice.
//!
//! - A box has its lattice points at `min + (i + ½) spacing`, so a box of n spacings has exactly n particles on that
//!   axis, and half a spacing is left to a wall it touches. A rest at the upper side that holds no whole spacing
//!   stays empty.
//! - A sphere (a disc in 2-D) has them at `center + (i + ½) spacing`, those within `radius` of the centre.
//! - A cylinder has them in a frame of its own: `(i + ½) spacing` along its axis from `start`, and
//!   `(i + ½) spacing` from the axis across, those within `radius` of it.
//!
//! Option 1 for round shapes: a lattice point in the centre, all within `radius − spacing/2`. Option 2: as above. We
//! use 2: the number of particles times spacing³ then estimates the volume without a bias (1 loses 1.5 spacing/radius
//! of it), and no lone particles stick out at the poles.
//!
//! Everything is computed in f64 with IEEE operations alone, then rounded once: the same scene gives the same
//! particles on every machine.

use glam::{DVec2, DVec3, Vec3};

use super::{Dimension, FluidBody, Jitter, Scene, Shape};

/// The step between two coordinates in single precision may be so many spacings; coarser ones are refused.
pub(crate) const RESOLUTION: f64 = 0.01;

/// By how many spacings counts and distances may miss, for the rounding of the file's numbers to f32: more where the
/// largest of them \[m] is many spacings.
pub(crate) fn tolerance(largest: f64, spacing: f64) -> f64 {
    1e-3 + (f64::from(f32::EPSILON) * largest / spacing).min(RESOLUTION)
}

/// A fluid particle to be spawned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParticleSeed {
    /// \[m]; z is zero in 2-D.
    pub position: Vec3,
    /// \[m/s]
    pub velocity: Vec3,
}

/// The particles of all bodies of a scene that [`Scene::check`] accepts: body after body, within a body along x
/// first, then y, then z (along a cylinder's axis last).
pub fn fluid_particles(scene: &Scene) -> Vec<ParticleSeed> {
    let mut seeds = Vec::new();
    for_each_particle(scene, |seed| seeds.push(seed));
    seeds
}

/// Calls `visit` with what [`fluid_particles`] would hold, and needs no memory for it.
pub(crate) fn for_each_particle(scene: &Scene, mut visit: impl FnMut(ParticleSeed)) {
    for body in &scene.bodies {
        for_each_particle_of(body, scene, &mut visit);
    }
}

/// The same for one of its bodies.
pub(crate) fn for_each_particle_of(
    body: &FluidBody,
    scene: &Scene,
    mut visit: impl FnMut(ParticleSeed),
) {
    let spacing = f64::from(scene.spacing);
    let velocity_at = body.velocities();
    let mut displace = Displacement::new(body.jitter, spacing, scene.dimension);
    Lattice::new(&body.shape, spacing, scene.dimension).for_each(|point| {
        let position = point + displace.next();
        visit(ParticleSeed {
            position: position.as_vec3(),
            velocity: velocity_at(position).as_vec3(),
        });
    });
}

/// A direction along a flat wall and, in 3-D, the second one: with the normal they are an orthonormal frame.
/// In 2-D the first lies in the plane z = 0. `normal` must not be zero.
pub fn wall_axes(normal: Vec3, dimension: Dimension) -> (Vec3, Vec3) {
    let normal = normal.as_dvec3().normalize();
    match dimension {
        Dimension::Two => (DVec3::new(-normal.y, normal.x, 0.0).as_vec3(), Vec3::Z),
        Dimension::Three => {
            let (first, second) = frame(normal);
            (first.as_vec3(), second.as_vec3())
        }
    }
}

/// Two axes that make an orthonormal frame with the unit vector `axis`; along x and y or the like where it can be.
fn frame(axis: DVec3) -> (DVec3, DVec3) {
    let size = axis.abs();
    let helper = if size.z >= size.x && size.z >= size.y {
        DVec3::Y
    } else if size.y >= size.x {
        DVec3::X
    } else {
        DVec3::Z
    };
    let first = helper.cross(axis).normalize();
    (first, axis.cross(first))
}

/// The largest coordinate of the ends between which a shape has rows \[m].
fn largest(shape: &Shape) -> f64 {
    let ends = match *shape {
        Shape::Box { min, max } => [min, max],
        Shape::Sphere { .. } => [Vec3::ZERO; 2],
        Shape::Cylinder { start, end, .. } => [start, end],
    };
    f64::from(ends[0].abs().max(ends[1].abs()).max_element())
}

/// The lattice of one shape, before jitter.
pub(crate) struct Lattice {
    /// The first point \[m].
    origin: DVec3,
    /// From one point to the next \[m].
    steps: [DVec3; 3],
    counts: [u32; 3],
    keep: Keep,
}

/// Which lattice points belong to the shape.
enum Keep {
    All,
    Within {
        center: DVec3,
        radius: f64,
    },
    Around {
        start: DVec3,
        axis: DVec3,
        radius: f64,
    },
}

impl Lattice {
    pub(crate) fn new(shape: &Shape, spacing: f64, dimension: Dimension) -> Self {
        let flat = dimension == Dimension::Two;
        let tolerance = tolerance(largest(shape), spacing);
        let along = |length: f64| (length / spacing + tolerance).floor() as u32;
        // Both sides of a centre: i from -half to half - 1.
        let across = |radius: f64| (radius / spacing + 1e-3).ceil() as u32;
        let reach = |radius: f64| radius + 1e-3 * spacing;
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * spacing);

        let mut lattice = match *shape {
            Shape::Box { min, max } => {
                let (min, max) = (min.as_dvec3(), max.as_dvec3());
                Self {
                    origin: min + 0.5 * spacing,
                    steps: axes,
                    counts: (max - min).to_array().map(along),
                    keep: Keep::All,
                }
            }
            Shape::Sphere { center, radius } => {
                let (center, radius) = (center.as_dvec3(), f64::from(radius));
                let half = across(radius);
                Self {
                    origin: center + (0.5 - f64::from(half)) * spacing,
                    steps: axes,
                    counts: [half.saturating_mul(2); 3],
                    keep: Keep::Within {
                        center: if flat { center.with_z(0.0) } else { center },
                        radius: reach(radius),
                    },
                }
            }
            Shape::Cylinder { start, end, radius } => {
                let (start, end, radius) = (start.as_dvec3(), end.as_dvec3(), f64::from(radius));
                let axis = (end - start).normalize_or_zero();
                let (u, v) = frame(axis);
                let half = across(radius);
                let first = (0.5 - f64::from(half)) * spacing;
                Self {
                    origin: start + first * (u + v) + 0.5 * spacing * axis,
                    steps: [u, v, axis].map(|axis| axis * spacing),
                    counts: [
                        half.saturating_mul(2),
                        half.saturating_mul(2),
                        along((end - start).length()),
                    ],
                    keep: Keep::Around {
                        start,
                        axis,
                        radius: reach(radius),
                    },
                }
            }
        };
        if flat {
            lattice.origin.z = 0.0;
            lattice.counts[2] = 1;
        }
        // A needle or a sheet thinner than the spacing holds nothing, however many rows it is long.
        let thin = match *shape {
            Shape::Box { .. } => false,
            Shape::Sphere { radius, .. } | Shape::Cylinder { radius, .. } => {
                reach(f64::from(radius)) < spacing / 2.0_f64.sqrt()
            }
        };
        if thin || lattice.counts.contains(&0) {
            lattice.counts = [0; 3];
        }
        lattice
    }

    /// How many points there are, at most.
    pub(crate) fn most(&self) -> f64 {
        self.counts.iter().map(|&count| f64::from(count)).product()
    }

    pub(crate) fn for_each(&self, mut visit: impl FnMut(DVec3)) {
        let [across, up, deep] = self.counts;
        for k in 0..deep {
            for j in 0..up {
                let row = self.origin + f64::from(k) * self.steps[2] + f64::from(j) * self.steps[1];
                for i in 0..across {
                    let point = row + f64::from(i) * self.steps[0];
                    if self.keeps(point) {
                        visit(point);
                    }
                }
            }
        }
    }

    fn keeps(&self, point: DVec3) -> bool {
        match self.keep {
            Keep::All => true,
            Keep::Within { center, radius } => (point - center).length_squared() <= radius * radius,
            Keep::Around {
                start,
                axis,
                radius,
            } => {
                let from = point - start;
                (from - axis * from.dot(axis)).length_squared() <= radius * radius
            }
        }
    }
}

/// Volume of a shape \[m³; m² in 2-D].
pub(crate) fn volume(shape: &Shape, dimension: Dimension) -> f64 {
    use std::f64::consts::PI;
    match (*shape, dimension) {
        (Shape::Box { min, max }, _) => {
            let size = max.as_dvec3() - min.as_dvec3();
            match dimension {
                Dimension::Two => DVec2::new(size.x, size.y).element_product(),
                Dimension::Three => size.element_product(),
            }
        }
        (Shape::Sphere { radius, .. }, Dimension::Two) => PI * f64::from(radius).powi(2),
        (Shape::Sphere { radius, .. }, Dimension::Three) => {
            4.0 / 3.0 * PI * f64::from(radius).powi(3)
        }
        (Shape::Cylinder { start, end, radius }, _) => {
            PI * f64::from(radius).powi(2) * (end.as_dvec3() - start.as_dvec3()).length()
        }
    }
}

/// The random displacements of a body's particles, in their order: the upper 24 bits of a draw of [`split_mix`] for
/// each coordinate, even in `[-amplitude, amplitude) × spacing`.
struct Displacement {
    state: u64,
    /// Largest displacement of a coordinate \[m]; 0 without jitter.
    size: f64,
    dimension: Dimension,
}

impl Displacement {
    fn new(jitter: Option<Jitter>, spacing: f64, dimension: Dimension) -> Self {
        let (amplitude, seed) = jitter.map_or((0.0, 0), |jitter| (jitter.amplitude, jitter.seed));
        Self {
            state: seed,
            size: f64::from(amplitude) * spacing,
            dimension,
        }
    }

    fn next(&mut self) -> DVec3 {
        if self.size == 0.0 {
            return DVec3::ZERO;
        }
        let (x, y) = (self.coordinate(), self.coordinate());
        let z = match self.dimension {
            Dimension::Two => 0.0,
            Dimension::Three => self.coordinate(),
        };
        DVec3::new(x, y, z)
    }

    fn coordinate(&mut self) -> f64 {
        let unit = (split_mix(&mut self.state) >> 40) as f64 / f64::from(1 << 24);
        (2.0 * unit - 1.0) * self.size
    }
}

/// The next 64 random bits of SplitMix64 (Steele, Lea & Flood 2014).
pub(crate) fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut bits = *state;
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(shape: Shape, spacing: f64, dimension: Dimension) -> usize {
        let mut count = 0;
        Lattice::new(&shape, spacing, dimension).for_each(|_| count += 1);
        count
    }

    fn scene(rest: &str) -> Scene {
        let text = format!(
            "(name: \"a\", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0.5)){rest})])"
        );
        Scene::parse(&text, "a.ron", &[]).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn a_box_of_n_spacings_has_n_particles_an_axis_whatever_the_rounding() {
        for n in [1, 2, 3, 7, 49, 50, 51, 333] {
            for spacing in [0.02_f32, 0.1, 1.0 / 3.0, 0.146 / 40.0, 7e-4] {
                // Rounding takes up to half of 1/100 spacing far away.
                for start in [0.0_f32, -0.7, 0.3, 7e4 * spacing, -6.1e4 * spacing] {
                    let end = start + n as f32 * spacing;
                    let (min, max) = (Vec3::splat(start), Vec3::new(end, start + spacing, end));
                    let shape = Shape::Box { min, max };
                    let expected = n * n;
                    let found = count(shape, f64::from(spacing), Dimension::Three);
                    assert_eq!(found, expected, "{n} × {spacing} from {start}");
                }
            }
        }
    }

    #[test]
    fn a_rest_that_holds_no_whole_spacing_stays_empty() {
        let (min, max) = (Vec3::ZERO, Vec3::new(0.19, 0.1, 0.1));
        assert_eq!(count(Shape::Box { min, max }, 0.1, Dimension::Three), 1);
    }

    #[test]
    fn shapes_thinner_than_the_spacing_hold_nothing_and_are_not_searched() {
        let (min, max) = (Vec3::ZERO, Vec3::new(1e-4, 1e6, 1e6));
        assert_eq!(count(Shape::Box { min, max }, 0.1, Dimension::Three), 0);
        let needle = Shape::Cylinder {
            start: Vec3::ZERO,
            end: Vec3::new(0.0, 1e8, 0.0),
            radius: 1e-4,
        };
        assert_eq!(count(needle, 0.1, Dimension::Three), 0);
    }

    #[test]
    fn round_shapes_hold_their_volume_in_particles() {
        let center = Vec3::new(0.3, -0.2, 0.0);
        let (start, end) = (center, Vec3::new(1.0, 0.4, 0.7));
        let radius = 0.5;
        let shapes = [
            (Shape::Sphere { center, radius }, Dimension::Three),
            (Shape::Sphere { center, radius }, Dimension::Two),
            (Shape::Cylinder { start, end, radius }, Dimension::Three),
        ];
        for (shape, dimension) in shapes {
            let spacing = 0.5 / 20.0;
            let exponent = if dimension == Dimension::Two { 2 } else { 3 };
            let filled = count(shape, spacing, dimension) as f64 * spacing.powi(exponent);
            let ratio = filled / volume(&shape, dimension);
            assert!((ratio - 1.0).abs() < 0.02, "{shape:?}: {ratio}");
        }
    }

    #[test]
    fn a_sphere_is_symmetric_about_its_centre() {
        let center = Vec3::new(0.3, -0.2, 0.7);
        let mut sum = DVec3::ZERO;
        let sphere = Shape::Sphere {
            center,
            radius: 0.26,
        };
        let mut n = 0;
        Lattice::new(&sphere, 0.1, Dimension::Three).for_each(|point| {
            n += 1;
            sum += point - center.as_dvec3();
        });
        assert!(n > 0 && sum.length() < 1e-9, "{n} {sum}");
    }

    #[test]
    fn a_cylinder_along_an_axis_has_whole_layers() {
        let cylinder = Shape::Cylinder {
            start: Vec3::ZERO,
            end: Vec3::new(0.0, 0.5, 0.0),
            radius: 0.2,
        };
        let mut heights = Vec::new();
        Lattice::new(&cylinder, 0.1, Dimension::Three).for_each(|point| heights.push(point.y));
        assert_eq!(heights.len(), 5 * 12);
        assert!(heights.iter().all(|y| (0.049..0.451).contains(y)));
    }

    #[test]
    fn jitter_is_bounded_and_the_same_for_a_seed() {
        let plain = fluid_particles(&scene(""));
        let one = fluid_particles(&scene(", jitter: (amplitude: 0.2, seed: 1)"));
        let again = fluid_particles(&scene(", jitter: (amplitude: 0.2, seed: 1)"));
        let two = fluid_particles(&scene(", jitter: (amplitude: 0.2, seed: 2)"));
        assert_eq!(one, again);
        assert_ne!(one, two);
        let mut largest = 0.0_f32;
        for (a, b) in plain.iter().zip(&one) {
            largest = largest.max((a.position - b.position).abs().max_element());
        }
        assert!(largest > 0.019 && largest < 0.02 + 1e-6, "{largest}");
        // SplitMix64 from seed 1 starts with 0x910a2dec89025cc1: the displacement is 0.2 × 0.1 × (2 × 0.5665615 − 1).
        let moved = one[0].position.x - plain[0].position.x;
        assert!((moved - 0.002_662_46).abs() < 1e-7, "{moved}");
    }

    #[test]
    fn the_axes_of_a_wall_are_perpendicular() {
        for normal in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(1.0, -2.0, 0.5)] {
            let (u, v) = wall_axes(normal, Dimension::Three);
            assert!(u.dot(v).abs() < 1e-6 && u.dot(normal).abs() < 1e-6);
            assert!(v.dot(normal).abs() < 1e-6 && (u.length() - 1.0).abs() < 1e-6);
        }
        let (u, _) = wall_axes(Vec3::new(0.0, 2.0, 0.0), Dimension::Two);
        assert_eq!(u, -Vec3::X);
    }
}
