//! A picture while it is drawn: an image in linear light, with antialiased lines.

use glam::{Vec2, Vec3, vec2};
use rayon::prelude::*;

use super::colour::{linear, srgb};
use super::image::Image;
use super::projection::{NEAREST, Projection};
use super::raster::{Layer, SAMPLES};
use super::view::View;

/// Pixels of linear light, rows from the top.
pub(super) struct Canvas {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<Vec3>,
}

impl Canvas {
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            pixels: vec![Vec3::ZERO; width * height],
        }
    }

    /// Blends a colour into a pixel; pixels outside the picture are ignored.
    pub(super) fn blend(&mut self, x: usize, y: usize, colour: Vec3, alpha: f32) {
        if x < self.width && y < self.height {
            let pixel = &mut self.pixels[y * self.width + x];
            *pixel = pixel.lerp(colour, alpha);
        }
    }

    /// A line with round ends. `visible` weights a pixel, given its position and the fraction of the line's length.
    pub(super) fn line(
        &mut self,
        [from, to]: [Vec2; 2],
        half_width: f32,
        colour: Vec3,
        visible: impl Fn(usize, usize, f32) -> f32,
    ) {
        let along = to - from;
        let length_squared = along.length_squared().max(1e-12);
        let steep = along.y.abs() > along.x.abs();
        // Walk along the longer side. Across it, the line is at most √2 times as wide as its width.
        let flip = |v: Vec2| if steep { vec2(v.y, v.x) } else { v };
        let (a, b) = (flip(from), flip(to));
        let (long, across) = if steep {
            (self.height, self.width)
        } else {
            (self.width, self.height)
        };
        let margin = 1.5 * half_width + 1.5;
        let first = (a.x.min(b.x) - margin).clamp(0.0, long as f32) as usize;
        let end = (a.x.max(b.x) + margin).clamp(0.0, long as f32) as usize;
        for u in first..end {
            let centre_u = u as f32 + 0.5;
            let t = ((centre_u - a.x) / (b.x - a.x)).clamp(0.0, 1.0);
            // A line of zero length has no direction: t is NaN.
            let v = if t.is_nan() {
                a.y
            } else {
                a.y + t * (b.y - a.y)
            };
            let low = (v - margin).clamp(0.0, across as f32) as usize;
            let high = (v + margin).clamp(0.0, across as f32) as usize;
            for w in low..high {
                let (x, y) = if steep { (w, u) } else { (u, w) };
                let at = vec2(x as f32 + 0.5, y as f32 + 0.5);
                let t = ((at - from).dot(along) / length_squared).clamp(0.0, 1.0);
                let distance = at.distance(from + t * along);
                let cover = (half_width + 0.5 - distance).clamp(0.0, 1.0);
                if cover > 0.0 {
                    let alpha = cover.min(2.0 * half_width) * visible(x, y, t);
                    self.blend(x, y, colour, alpha);
                }
            }
        }
    }

    /// A line in space, hidden by nearer surfaces.
    pub(super) fn edge(
        &mut self,
        projection: &Projection,
        layer: &Layer,
        ends: [Vec3; 2],
        view: &View,
    ) {
        let mut ends = ends.map(|end| (end, projection.project(end).depth));
        // Clip the part behind the eye.
        let near = 100.0 * NEAREST;
        if ends.iter().all(|end| !projection.sees(end.1 - near)) {
            return;
        }
        for i in 0..2 {
            let (other, depth) = (ends[1 - i], ends[i].1);
            if !projection.sees(depth - near) {
                let t = (near - depth) / (other.1 - depth);
                let cut = ends[i].0.lerp(other.0, t);
                ends[i] = (cut, projection.project(cut).depth);
            }
        }
        let [a, b] = ends.map(|end| projection.project(end.0));
        if !(a.at.is_finite() && b.at.is_finite()) {
            return;
        }
        let half_width = 0.6 * (self.height as f32 / 540.0).max(0.75);
        let tolerance = 0.5 * view.particle_radius;
        self.line([a.at, b.at], half_width, linear([70, 80, 92]), |x, y, t| {
            let depth = projection.depth_between(a.depth, b.depth, t) - tolerance;
            let seen = (0..SAMPLES * SAMPLES).filter(|sample| {
                let (sx, sy) = (sample % SAMPLES, sample / SAMPLES);
                let i = (y * SAMPLES + sy) * layer.width + x * SAMPLES + sx;
                depth <= layer.depth[i]
            });
            0.75 * seen.count() as f32 / (SAMPLES * SAMPLES) as f32
        });
    }

    pub(super) fn encode(&self) -> Image {
        let rgb = self
            .pixels
            .par_iter()
            .flat_map_iter(|&pixel| srgb(pixel))
            .collect();
        Image {
            width: self.width,
            height: self.height,
            rgb,
        }
    }
}
