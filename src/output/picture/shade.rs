//! Colour and light of every sample.
//!
//! A key light with soft shadows, light from the sky and the floor weakened where surroundings block it
//! (ambient occlusion from the depths around a sample, after McGuire et al., "The Alchemy screen-space ambient
//! obscurance algorithm", 2011), and a little gloss.

use glam::{Vec2, Vec3, vec2, vec3};
use rayon::prelude::*;

use super::SAMPLES;
use super::canvas::Canvas;
use super::colour::{SpeedColours, linear};
use super::projection::Projection;
use super::raster::{FLOOR, Layer, NOTHING};
use super::view::View;
use crate::output::Frame;

/// Depths looked at around a sample; a pixel has four samples, each turned differently.
const OCCLUSION_TAPS: usize = 7;
/// How far occlusion reaches [particle radii].
const OCCLUSION_REACH: f32 = 9.0;
const OCCLUSION_STRENGTH: f32 = 1.9;
/// Depths looked at in the light's layer.
const SHADOW_TAPS: usize = 4;
/// Width of a shadow's edge [particle radii].
const SHADOW_SOFTNESS: f32 = 3.0;
/// How far before a surface a blocker must lie [particle radii]: particles do not shade each other one by one.
const SHADOW_BIAS: f32 = 3.5;
/// How much of the key light a shadow takes.
const SHADOW_STRENGTH: f32 = 0.75;

/// What the light sees.
pub(super) struct Shadow {
    pub(super) projection: Projection,
    pub(super) layer: Layer,
}

struct Colours {
    speed: SpeedColours,
    sky_top: Vec3,
    sky_bottom: Vec3,
    floor: Vec3,
    solid: Vec3,
}

/// A sample as the lights see it.
struct Surface {
    at: Vec3,
    normal: Vec3,
    colour: Vec3,
    gloss: f32,
}

struct Shader<'a> {
    frame: &'a Frame,
    view: &'a View,
    projection: &'a Projection,
    layer: &'a Layer,
    shadow: Option<&'a Shadow>,
    colours: Colours,
    /// Towards the key light.
    light: Vec3,
}

/// The picture without lines and text, as linear light.
pub(super) fn shade(
    frame: &Frame,
    view: &View,
    projection: &Projection,
    layer: &Layer,
    shadow: Option<&Shadow>,
) -> Canvas {
    let shader = Shader {
        frame,
        view,
        projection,
        layer,
        shadow,
        colours: Colours {
            speed: SpeedColours::new(),
            sky_top: linear([236, 241, 246]),
            sky_bottom: linear([212, 220, 228]),
            floor: linear([226, 229, 231]),
            solid: linear([178, 172, 164]),
        },
        light: view.light(),
    };
    let (width, height) = view.size();
    let mut canvas = Canvas::new(width, height);
    canvas
        .pixels
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let mut sum = Vec3::ZERO;
                for sample in 0..SAMPLES * SAMPLES {
                    let (dx, dy) = (sample % SAMPLES, sample / SAMPLES);
                    sum += shader.sample(x * SAMPLES + dx, y * SAMPLES + dy);
                }
                *pixel = sum / (SAMPLES * SAMPLES) as f32;
            }
        });
    canvas
}

impl Shader<'_> {
    fn sample(&self, x: usize, y: usize) -> Vec3 {
        let i = y * self.layer.width + x;
        let at = vec2(x as f32 + 0.5, y as f32 + 0.5);
        let sky = self.sky(at);
        if self.layer.surface[i] == NOTHING {
            return sky;
        }
        let surface = self.surface(i, at);
        if self.view.is_flat() {
            return self.flat(&surface);
        }

        let turn = turn(x, y);
        let open = self.openness(&surface, at, self.layer.depth[i], turn);
        let lit = 1.0 - SHADOW_STRENGTH * self.shadow(&surface, turn);
        let towards_eye = -self.projection.ray(at).direction.normalize();

        let facing = surface.normal.dot(self.light);
        let key = ((facing + 0.25) / 1.25).max(0.0) * lit;
        let upwards = 0.5 + 0.5 * surface.normal.y;
        let ambient = vec3(0.62, 0.63, 0.66).lerp(vec3(0.80, 0.84, 0.90), upwards) * open;
        let half = (self.light + towards_eye).normalize_or(self.light);
        let shine = surface.normal.dot(half).max(0.0).powi(48) * lit * open;
        let colour = surface.colour
            * (0.62 * ambient + 0.62 * key * Vec3::splat(0.35 + 0.65 * open))
            + surface.gloss * shine;

        if self.layer.surface[i] == FLOOR {
            // The floor goes over into the background: no horizon.
            return colour.lerp(sky, self.view.distance_haze(surface.at));
        }
        colour
    }

    fn sky(&self, at: Vec2) -> Vec3 {
        let down = at.y / self.layer.height as f32;
        self.colours.sky_top.lerp(self.colours.sky_bottom, down)
    }

    /// In 2-D a disc has its colour, a little darker towards its rim to tell it from its neighbours.
    fn flat(&self, surface: &Surface) -> Vec3 {
        let towards = surface.normal.z.clamp(0.0, 1.0);
        surface.colour * (0.66 + 0.34 * towards.sqrt())
    }

    fn surface(&self, i: usize, at: Vec2) -> Surface {
        let id = self.layer.surface[i];
        let position = self.projection.ray(at).at(self.layer.depth[i]);
        if id == FLOOR {
            return Surface {
                at: position,
                normal: Vec3::Y,
                colour: self.colours.floor,
                gloss: 0.0,
            };
        }
        if let Some(solid) = Layer::solid(id).and_then(|k| self.view.solids.get(k)) {
            return Surface {
                at: position,
                normal: solid.normal(position),
                colour: self.colours.solid,
                gloss: 0.05,
            };
        }
        let splat = &self.layer.splats[id as usize];
        let offset = (at - splat.at) / splat.radius;
        let bulge = (1.0 - offset.length_squared()).max(0.0).sqrt();
        let speed = self
            .frame
            .velocities
            .get(id as usize)
            .map_or(0.0, |velocity| velocity.length());
        Surface {
            at: position,
            normal: self.projection.direction(offset.x, offset.y, -bulge),
            colour: self.colours.speed.at(self.view.place_of_speed(speed)),
            gloss: 0.22,
        }
    }

    /// How much of the surroundings is open, 0 to 1.
    fn openness(&self, surface: &Surface, at: Vec2, depth: f32, turn: f32) -> f32 {
        let reach = OCCLUSION_REACH * self.view.particle_radius;
        let reach_samples = (reach * self.projection.project(surface.at).scale).min(160.0);
        let bias = 0.02 * reach;
        let mut blocked = 0.0;
        for tap in 0..OCCLUSION_TAPS {
            let part = (tap as f32 + 0.5 + 0.5 * turn) / (OCCLUSION_TAPS as f32 + 0.5);
            let angle = std::f32::consts::TAU * (turn + tap as f32 * 0.381_966);
            let (sin, cos) = angle.sin_cos();
            let tap_at = at + reach_samples * part * vec2(cos, sin);
            let Some(j) = index(tap_at, self.layer) else {
                continue;
            };
            let tap_depth = self.layer.depth[j];
            // What is far before the sample is another thing, not its surroundings.
            if depth - tap_depth > 3.0 * reach {
                continue;
            }
            if tap_depth.is_finite() {
                let towards = self.projection.ray(tap_at).at(tap_depth) - surface.at;
                let above = (towards.dot(surface.normal) - bias).max(0.0);
                blocked += above * reach / (towards.length_squared() + 0.05 * reach * reach);
            }
        }
        let mean = blocked / OCCLUSION_TAPS as f32;
        1.0 / (1.0 + OCCLUSION_STRENGTH * mean)
    }

    /// How much of the key light is blocked, 0 to 1.
    fn shadow(&self, surface: &Surface, turn: f32) -> f32 {
        let Some(Shadow { projection, layer }) = self.shadow else {
            return 0.0;
        };
        let radius = self.view.particle_radius;
        let projected = projection.project(surface.at + 0.5 * radius * surface.normal);
        let mut blocked = 0;
        for tap in 0..SHADOW_TAPS {
            let part = ((tap as f32 + turn) / SHADOW_TAPS as f32).sqrt();
            let angle = std::f32::consts::TAU * (turn + tap as f32 * 0.381_966);
            let (sin, cos) = angle.sin_cos();
            let at =
                projected.at + SHADOW_SOFTNESS * radius * projected.scale * part * vec2(cos, sin);
            let blocker = index(at, layer).map_or(f32::INFINITY, |j| layer.depth[j]);
            blocked += u32::from(blocker < projected.depth - SHADOW_BIAS * radius);
        }
        blocked as f32 / SHADOW_TAPS as f32
    }
}

fn index(at: Vec2, layer: &Layer) -> Option<usize> {
    let inside =
        at.x >= 0.0 && at.y >= 0.0 && at.x < layer.width as f32 && at.y < layer.height as f32;
    inside.then(|| at.y as usize * layer.width + at.x as usize)
}

/// A number from 0 to 1 that differs between neighbouring samples and is evenly spread over any few of them
/// (interleaved gradient noise; J. Jimenez, "Next generation post processing in Call of Duty", 2014).
fn turn(x: usize, y: usize) -> f32 {
    let inner = 0.067_110_56 * x as f32 + 0.005_837_15 * y as f32;
    (52.982_918 * inner.fract()).fract()
}
