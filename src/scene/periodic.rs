//! Periodic axes: space closes on itself, and what leaves at one face comes in at the other.

use glam::{BVec3, DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::{BoundaryShape, Bounds};

/// The axes along which space repeats, each with the two faces that are one \[m].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Periodic {
    /// From where to where along x \[m]; not periodic if absent.
    pub x: Option<[f32; 2]>,
    /// Along y \[m].
    pub y: Option<[f32; 2]>,
    /// Along z \[m]; not in 2-D.
    pub z: Option<[f32; 2]>,
}

impl Periodic {
    /// Along x, y and z.
    pub fn axes(&self) -> [Option<[f32; 2]>; 3] {
        [self.x, self.y, self.z]
    }
}

/// The box that repeats, as loops read it. Every figure of an axis that is not periodic is 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Period {
    /// Lower face \[m].
    low: Vec3,
    /// Length of a period \[m].
    pub length: Vec3,
    /// Periods per length \[m⁻¹].
    pub inverse: Vec3,
}

impl Period {
    /// Space that does not repeat.
    pub const NONE: Self = Self {
        low: Vec3::ZERO,
        length: Vec3::ZERO,
        inverse: Vec3::ZERO,
    };

    /// Whether an axis is periodic.
    #[inline(always)]
    pub fn is_any(&self) -> bool {
        self.length != Vec3::ZERO
    }

    /// The axes that are periodic.
    pub fn axes(&self) -> BVec3 {
        self.length.cmpgt(Vec3::ZERO)
    }

    /// Lower and upper face \[m] along a periodic axis.
    pub fn faces(&self, axis: usize) -> Option<[f32; 2]> {
        let (low, length) = (self.low[axis], self.length[axis]);
        (length > 0.0).then_some([low, low + length])
    }

    /// The axes as a scene has them.
    pub fn to_scene(&self) -> Periodic {
        let [x, y, z] = [0, 1, 2].map(|axis| self.faces(axis));
        Periodic { x, y, z }
    }

    /// The difference of two points \[m] by the nearest of their images.
    #[inline]
    pub fn nearest(&self, difference: Vec3) -> Vec3 {
        // Most points have no nearer image; to round costs a call.
        let is_far = difference.abs().cmpgt(0.5 * self.length) & self.axes();
        if !is_far.any() {
            return difference;
        }
        difference - self.length * (difference * self.inverse).round()
    }

    /// A point \[m] in the box that repeats.
    #[inline]
    pub fn wrap(&self, point: Vec3) -> Vec3 {
        let within = point - self.low;
        let is_outside = within.cmplt(Vec3::ZERO) | within.cmpge(self.length);
        if !(is_outside & self.axes()).any() {
            return point;
        }
        // A point in the box keeps its bits.
        let periods = ((point - self.low) * self.inverse).floor();
        point - self.length * periods
    }

    /// Whether a box \[m], or one of its images, contains a point.
    pub fn contains(&self, Bounds { min, max }: &Bounds, point: Vec3) -> bool {
        // The first image of the point above the lower faces.
        let periods = ((point - *min) * self.inverse).floor();
        let image = Vec3::select(self.axes(), point - self.length * periods, point);
        image.cmpge(*min).all() && image.cmple(*max).all()
    }

    /// The same in double precision.
    pub fn wrap_exactly(&self, point: DVec3) -> DVec3 {
        if !self.is_any() {
            return point;
        }
        let (low, length) = (self.low.as_dvec3(), self.length.as_dvec3());
        let periods = DVec3::select(self.axes(), ((point - low) / length).floor(), DVec3::ZERO);
        point - length * periods
    }

    /// Whether a point \[m] in the box is nearer than `reach` \[m] to a face, or beyond it.
    #[inline(always)]
    pub fn is_near_face(&self, point: Vec3, reach: f32) -> bool {
        let within = point - self.low;
        let near = within.cmplt(Vec3::splat(reach)) | within.cmpgt(self.length - reach);
        (near & self.axes()).any()
    }

    /// The part of a vector along axes that do not repeat.
    pub fn open_part(&self, vector: Vec3) -> Vec3 {
        Vec3::select(self.axes(), Vec3::ZERO, vector)
    }

    /// The axes along which what reaches from `low` to `high` \[m] goes round: it meets its own image.
    pub fn goes_round(&self, low: Vec3, high: Vec3) -> BVec3 {
        // Rounding of the faces.
        self.axes() & (high - low).cmpge(self.length * (1.0 - 1e-5))
    }

    /// The boundary as long as fluid within two periods of the box can see it, where it goes round.
    pub fn unrolled(&self, boundary: &BoundaryShape) -> BoundaryShape {
        let is_turned = boundary.frame().is_turned();
        let mut boundary = boundary.clone();
        if is_turned {
            return boundary;
        }
        if let BoundaryShape::Tank { min, max, .. } | BoundaryShape::Box { min, max, .. } =
            &mut boundary
        {
            let round = self.goes_round(*min, *max);
            *min = Vec3::select(round, min.min(self.low - 2.0 * self.length), *min);
            *max = Vec3::select(round, max.max(self.low + 3.0 * self.length), *max);
        }
        boundary
    }
}

impl From<Periodic> for Period {
    fn from(periodic: Periodic) -> Self {
        let mut period = Self::NONE;
        for (axis, faces) in periodic.axes().into_iter().enumerate() {
            let Some([low, high]) = faces else { continue };
            let length = high - low;
            if length > 0.0 {
                (period.low[axis], period.length[axis]) = (low, length);
                period.inverse[axis] = 1.0 / length;
            }
        }
        period
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn period() -> Period {
        let periodic = Periodic {
            x: Some([-0.3, 0.9]),
            y: None,
            z: Some([1.0, 4.0]),
        };
        Period::from(periodic)
    }

    #[test]
    fn points_wrap_and_differences_are_the_shortest() {
        let period = period();
        for (point, expected) in [
            (Vec3::new(0.0, 7.0, 2.0), Vec3::new(0.0, 7.0, 2.0)),
            (Vec3::new(-0.4, -7.0, 4.5), Vec3::new(0.8, -7.0, 1.5)),
            (Vec3::new(3.4, 0.0, -5.5), Vec3::new(-0.2, 0.0, 3.5)),
        ] {
            assert!(period.wrap(point).distance(expected) < 1e-5, "{point}");
            let exactly = period.wrap_exactly(point.as_dvec3()).as_vec3();
            assert!(exactly.distance(expected) < 1e-5, "{point}");
        }
        // A box that reaches across a face has its other part at the other face.
        let (min, max) = (Vec3::new(0.7, 0.0, 0.0), Vec3::new(1.1, 1.0, 2.0));
        let bounds = Bounds { min, max };
        for (x, is_inside) in [
            (0.8, true),
            (-0.2, true),
            (2.2, true),
            (0.6, false),
            (0.0, false),
        ] {
            let point = Vec3::new(x, 0.5, 1.5);
            assert_eq!(period.contains(&bounds, point), is_inside, "{x}");
            assert!(
                !period.contains(&bounds, point + Vec3::Y),
                "y is not periodic"
            );
            assert_eq!(Period::NONE.contains(&bounds, point), x == 0.8, "{x}");
        }
        let difference = period.nearest(Vec3::new(1.1, 5.0, -2.9));
        assert!(difference.distance(Vec3::new(-0.1, 5.0, 0.1)) < 1e-6);
        assert!(!Period::NONE.is_any() && !Period::NONE.is_near_face(Vec3::ZERO, 1.0));
        assert!(period.is_near_face(Vec3::new(0.85, 0.0, 2.5), 0.1));
        assert!(!period.is_near_face(Vec3::new(0.3, 0.0, 2.5), 0.1));
    }
}
