//! Projection from space to the picture and back.

use glam::{Vec2, Vec3, vec2, vec3};

/// Nothing nearer to the eye than this is drawn \[m].
pub(super) const NEAREST: f32 = 1e-4;

/// A pinhole or parallel projection onto pixels (or samples), x to the right, y down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    pub(super) eye: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Whether distant objects appear smaller.
    perspective: bool,
    /// Pixels per metre; with perspective, at a depth of 1 m.
    scale: f32,
    /// The pixel that the eye looks at.
    centre: Vec2,
}

/// A point on the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projected {
    pub(super) at: Vec2,
    /// Distance from the eye along the direction of view \[m].
    pub(super) depth: f32,
    /// Pixels per metre at this depth.
    pub(super) scale: f32,
}

impl Projection {
    /// Looks from `eye` along `forward`, with y up. Any direction is valid; zero means −z.
    pub(super) fn new(
        eye: Vec3,
        forward: Vec3,
        perspective: bool,
        scale: f32,
        centre: Vec2,
    ) -> Self {
        let forward = forward.normalize_or(Vec3::NEG_Z);
        let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
        Self {
            eye,
            right,
            up: right.cross(forward),
            forward,
            perspective,
            scale,
            centre,
        }
    }

    /// The same projection with `factor` samples per pixel along each edge.
    pub(super) fn magnified(&self, factor: f32) -> Self {
        Self {
            scale: self.scale * factor,
            centre: self.centre * factor,
            ..*self
        }
    }

    pub(super) fn project(&self, point: Vec3) -> Projected {
        let from_eye = point - self.eye;
        let depth = from_eye.dot(self.forward);
        let scale = self.scale_at(depth);
        let offset = vec2(from_eye.dot(self.right), -from_eye.dot(self.up));
        Projected {
            at: self.centre + scale * offset,
            depth,
            scale,
        }
    }

    /// Whether a depth is in front of the eye.
    pub(super) fn sees(&self, depth: f32) -> bool {
        // A parallel projection has no eye: every finite depth is visible.
        depth > NEAREST || (!self.perspective && depth.is_finite())
    }

    /// The ray through a pixel: the point at depth z is `origin + z · direction`.
    pub(super) fn ray(&self, at: Vec2) -> Ray {
        let offset = (at - self.centre) / self.scale;
        let sideways = offset.x * self.right - offset.y * self.up;
        if self.perspective {
            Ray {
                origin: self.eye,
                direction: self.forward + sideways,
            }
        } else {
            Ray {
                origin: self.eye + sideways,
                direction: self.forward,
            }
        }
    }

    /// Direction in space of (right, down, away) on the picture.
    pub(super) fn direction(&self, right: f32, down: f32, away: f32) -> Vec3 {
        right * self.right - down * self.up + away * self.forward
    }

    /// A point given by its position in the picture and its depth, as (right, down, away) from the eye \[m].
    pub(super) fn in_view(&self, at: Vec2, depth: f32) -> Vec3 {
        ((at - self.centre) / self.scale_at(depth)).extend(depth)
    }

    /// A direction in space as (right, down, away).
    pub(super) fn direction_in_view(&self, direction: Vec3) -> Vec3 {
        vec3(
            direction.dot(self.right),
            -direction.dot(self.up),
            direction.dot(self.forward),
        )
    }

    /// Pixels per metre at a depth.
    pub(super) fn scale_at(&self, depth: f32) -> f32 {
        if self.perspective {
            self.scale / depth
        } else {
            self.scale
        }
    }

    /// Depth within a triangle, from its corners' depths and their shares of the place in the picture.
    pub(super) fn depth_within(&self, depths: Vec3, shares: Vec3) -> f32 {
        if self.perspective {
            1.0 / shares.dot(depths.recip())
        } else {
            shares.dot(depths)
        }
    }

    /// Depth at fraction `t` of the distance between two points in the picture.
    pub(super) fn depth_between(&self, from: f32, to: f32, t: f32) -> f32 {
        if self.perspective {
            1.0 / ((1.0 - t) / from + t / to)
        } else {
            (1.0 - t) * from + t * to
        }
    }
}

/// A ray whose parameter is the depth \[m].
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
}

impl Ray {
    pub(super) fn at(&self, depth: f32) -> Vec3 {
        self.origin + depth * self.direction
    }
}
