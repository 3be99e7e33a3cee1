//! Colour and light of every sample.
//!
//! A key light with soft shadows, light from the sky and the floor weakened where surroundings block it
//! (ambient occlusion from the depths around a sample, after McGuire et al., "The Alchemy screen-space ambient
//! obscurance algorithm", 2011), and a little gloss.

use glam::{Vec2, Vec3, vec2, vec3};
use rayon::prelude::*;

use super::canvas::Canvas;
use super::colour::{Colours, linear};
use super::glass::{Glass, lamp};
use super::projection::Projection;
use super::raster::{FLOOR, Fluid, Layer, NOTHING, SAMPLES};
use super::triangles;
use super::view::View;
use crate::output::surface::SurfaceMesh;

/// Depths that are sampled around a pixel, distributed over its samples.
const OCCLUSION_TAPS: usize = 16;
/// Range of the occlusion \[particle radii].
const OCCLUSION_REACH: f32 = 9.0;
const OCCLUSION_STRENGTH: f32 = 1.9;
/// Depths that are sampled in the light's layer per pixel, distributed over its samples.
const SHADOW_TAPS: usize = 8;
/// Number of rotations of the sampling pattern, so that neighbouring pixels sample different points.
const TURNS: usize = 64;
/// Width of a shadow's edge \[particle radii].
const SHADOW_SOFTNESS: f32 = 3.0;
/// [`Surface::shadow_bias`] of particles: they do not shade each other one by one.
const PARTICLE_SHADOW_BIAS: f32 = 3.5;
/// [`Surface::shadow_bias`] of solids: the light's layer shows their round sides as steps.
const SOLID_SHADOW_BIAS: f32 = 2.5;
/// [`Surface::shadow_bias`] of the floor, which is flat and directly below its particles.
const FLOOR_SHADOW_BIAS: f32 = 0.8;
/// Part of the light that water reflects at right angles.
const REFLECTED: f32 = 0.02;
/// How far the fluid may be in front of the glass that holds it \[particle radii]: its surface is around its particles.
const GLASS_BIAS: f32 = 2.0;
/// Fraction of the key light that a shadow removes.
const SHADOW_STRENGTH: f32 = 0.75;

/// The layer as seen from the light.
pub(super) struct Shadow {
    pub(super) projection: Projection,
    pub(super) layer: Layer,
}

struct Palette {
    values: Colours,
    sky_top: Vec3,
    sky_bottom: Vec3,
    floor: Vec3,
    solid: Vec3,
}

/// A sample, as input to the lighting.
struct Surface {
    at: Vec3,
    normal: Vec3,
    colour: Vec3,
    gloss: f32,
    /// Whether it mirrors the sky as water does, more at flat angles.
    mirrors: bool,
    /// Least distance in front of the surface at which another surface casts a shadow on it \[particle radii].
    shadow_bias: f32,
}

struct Shader<'a> {
    fluid: Fluid<'a>,
    /// What colours show, by particle or by vertex of the surface.
    values: &'a [f32],
    view: &'a View,
    projection: &'a Projection,
    layer: &'a Layer,
    shadow: Option<&'a Shadow>,
    colours: Palette,
    glass: Glass,
    /// Direction towards the key light.
    light: Vec3,
    /// Depth of the first sample of every pixel, for occlusion. It has a quarter of the layer's size and stays in the
    /// cache.
    pixel_depth: Vec<f32>,
    occlusion_taps: Vec<Vec2>,
    shadow_taps: Vec<Vec2>,
}

/// A sample of a pixel.
#[derive(Clone, Copy)]
struct Place {
    pixel: (usize, usize),
    sample: usize,
    /// Position in samples, from the top left.
    at: Vec2,
    /// Index in the layer.
    index: usize,
}

/// The picture without lines and text, as linear light.
pub(super) fn shade(
    (fluid, values): (Fluid<'_>, &[f32]),
    view: &View,
    projection: &Projection,
    layer: &Layer,
    shadow: Option<&Shadow>,
) -> Canvas {
    let shader = Shader {
        fluid,
        values,
        view,
        projection,
        layer,
        shadow,
        colours: Palette {
            values: Colours::new(view.colours),
            // Darker than foam, which must be seen before them.
            sky_top: linear([186, 197, 208]),
            sky_bottom: linear([208, 215, 222]),
            floor: linear([172, 178, 184]),
            solid: linear([178, 172, 164]),
        },
        glass: Glass::new(&view.glass, projection, (layer.width, layer.height)),
        light: view.light(),
        pixel_depth: first_samples(layer),
        occlusion_taps: spirals(OCCLUSION_TAPS),
        shadow_taps: spirals(SHADOW_TAPS),
    };
    let (width, height) = view.size();
    let mut canvas = Canvas::new(width, height);
    canvas
        .pixels
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let samples = (0..SAMPLES * SAMPLES).map(|sample| shader.sample((x, y), sample));
                let sum: Vec3 = samples.sum();
                *pixel = sum / (SAMPLES * SAMPLES) as f32;
            }
        });
    canvas
}

impl Shader<'_> {
    fn sample(&self, pixel: (usize, usize), sample: usize) -> Vec3 {
        let x = pixel.0 * SAMPLES + sample % SAMPLES;
        let y = pixel.1 * SAMPLES + sample / SAMPLES;
        let place = Place {
            pixel,
            sample,
            at: vec2(x as f32 + 0.5, y as f32 + 0.5),
            index: y * self.layer.width + x,
        };
        let behind = self.opaque(place);
        if self.view.glass.is_empty() {
            return behind;
        }
        let ray = self.projection.ray(place.at);
        let towards_eye = -ray.direction.normalize();
        let depth = self.layer.depth[place.index] + GLASS_BIAS * self.view.particle_radius;
        let crossings = self.glass.crossings(place.at, &ray, depth);
        crossings.iter().fold(behind, |behind, crossing| {
            let from = crossing.mirrored_from(towards_eye);
            let mirrored = lamp(from, self.light).unwrap_or_else(|| self.surroundings(from));
            crossing.over(behind, mirrored, towards_eye)
        })
    }

    /// The nearest surface that is not of glass.
    fn opaque(&self, place: Place) -> Vec3 {
        let sky = self.sky(place.at);
        if self.layer.surface[place.index] == NOTHING {
            return sky;
        }
        let surface = self.surface(place.index, place.at);
        if self.view.is_flat() {
            return self.flat(&surface);
        }
        if self.layer.surface[place.index] == FLOOR {
            // The floor fades into the background, so that there is no horizon.
            let haze = self.view.distance_haze(surface.at);
            if haze >= 1.0 {
                return sky;
            }
            return self.lit(&surface, place).lerp(sky, haze);
        }
        self.lit(&surface, place)
    }

    fn lit(&self, surface: &Surface, place: Place) -> Vec3 {
        let turn = turn(place.pixel);
        let open = self.openness(surface, place, turn);
        let lit = 1.0 - SHADOW_STRENGTH * self.shadow(surface, place, turn);
        let towards_eye = -self.projection.ray(place.at).direction.normalize();

        let facing = surface.normal.dot(self.light);
        let key = ((facing + 0.25) / 1.25).max(0.0) * lit;
        let upwards = 0.5 + 0.5 * surface.normal.y;
        let ambient = vec3(0.62, 0.63, 0.66).lerp(vec3(0.80, 0.84, 0.90), upwards) * open;
        let half = (self.light + towards_eye).normalize_or(self.light);
        let shine = surface.normal.dot(half).max(0.0).powi(48) * lit * open;
        let light = 0.66 * ambient + 0.74 * key * (0.35 + 0.65 * open);
        let seen = surface.colour * light + surface.gloss * shine;
        if surface.mirrors {
            seen.lerp(
                self.mirrored(surface, towards_eye) * open,
                fresnel(surface, towards_eye),
            )
        } else {
            seen
        }
    }

    /// The surroundings as the surface mirrors them: the floor below, the sky above.
    fn mirrored(&self, surface: &Surface, towards_eye: Vec3) -> Vec3 {
        self.surroundings(2.0 * surface.normal.dot(towards_eye) * surface.normal - towards_eye)
    }

    fn surroundings(&self, direction: Vec3) -> Vec3 {
        let up = (0.5 + 1.5 * direction.y).clamp(0.0, 1.0);
        self.colours.floor.lerp(self.colours.sky_bottom, up)
    }

    fn sky(&self, at: Vec2) -> Vec3 {
        let down = at.y / self.layer.height as f32;
        self.colours.sky_top.lerp(self.colours.sky_bottom, down)
    }

    /// In 2-D a disc has its colour, slightly darker towards its rim to separate it from its neighbours.
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
                mirrors: false,
                shadow_bias: FLOOR_SHADOW_BIAS,
            };
        }
        if let Some(solid) = Layer::solid(id).and_then(|k| self.view.solids.get(k)) {
            return Surface {
                at: position,
                normal: solid.normal(position, self.projection.ray(at).direction),
                colour: self.colours.solid,
                gloss: 0.05,
                mirrors: false,
                shadow_bias: SOLID_SHADOW_BIAS,
            };
        }
        let spheres = match self.fluid {
            Fluid::Surface(mesh) => return self.of_triangle(mesh, id, position),
            Fluid::Spheres(spheres) => spheres,
        };
        let splat = spheres.splat(id, self.projection, (self.layer.width, self.layer.height));
        let offset = (at - splat.at) / splat.radius;
        let bulge = (1.0 - offset.length_squared()).max(0.0).sqrt();
        let value = self.values.get(id as usize).copied().unwrap_or_default();
        Surface {
            at: position,
            normal: self.projection.direction(offset.x, offset.y, -bulge),
            colour: self.colours.values.at(self.view.place_in_range(value)),
            gloss: 0.25,
            mirrors: false,
            shadow_bias: PARTICLE_SHADOW_BIAS,
        }
    }

    fn of_triangle(&self, mesh: &SurfaceMesh, triangle: u32, at: Vec3) -> Surface {
        let (corners, shares) = triangles::shares(mesh, triangle, at);
        let values = corners.map(|i| self.values.get(i).copied().unwrap_or_default());
        let normals = corners.map(|i| mesh.normals.get(i).copied().unwrap_or(Vec3::Y));
        let shares_of = shares.to_array();
        let normal: Vec3 = (normals.iter().zip(shares_of))
            .map(|(normal, share)| share * *normal)
            .sum();
        let value = shares.dot(Vec3::from(values));
        Surface {
            at,
            normal: normal.normalize_or(Vec3::Y),
            colour: self.colours.values.at(self.view.place_in_range(value)),
            gloss: 0.5,
            mirrors: true,
            shadow_bias: PARTICLE_SHADOW_BIAS,
        }
    }

    /// Unoccluded fraction of the surroundings, 0 to 1. Computed in view space: right, down, away.
    fn openness(&self, surface: &Surface, place: Place, turn: usize) -> f32 {
        let reach = OCCLUSION_REACH * self.view.particle_radius;
        let depth = self.layer.depth[place.index];
        let at = self.projection.in_view(place.at, depth);
        let normal = self.projection.direction_in_view(surface.normal);
        let reach_pixels = (reach * self.projection.scale_at(depth) / SAMPLES as f32).min(80.0);
        let centre = vec2(place.pixel.0 as f32 + 0.5, place.pixel.1 as f32 + 0.5);
        let (width, height) = self.view.size();

        let taps = share(&self.occlusion_taps, OCCLUSION_TAPS, turn, place.sample);
        let mut blocked = 0.0;
        let count = taps.len();
        for tap in taps {
            let tap_at = centre + reach_pixels * *tap;
            let Some(i) = index(tap_at, width, height) else {
                continue;
            };
            let tap_depth = self.pixel_depth[i];
            // Surfaces far in front of the sample are unrelated objects; those far behind it do not occlude.
            if depth - tap_depth > 3.0 * reach || tap_depth - depth > reach {
                continue;
            }
            let towards = self.projection.in_view(SAMPLES as f32 * tap_at, tap_depth) - at;
            let above = (towards.dot(normal) - 0.02 * reach).max(0.0);
            blocked += above * reach / (towards.length_squared() + 0.05 * reach * reach);
        }
        1.0 / (1.0 + OCCLUSION_STRENGTH * blocked / count as f32)
    }

    /// Blocked fraction of the key light, 0 to 1.
    fn shadow(&self, surface: &Surface, place: Place, turn: usize) -> f32 {
        let Some(Shadow { projection, layer }) = self.shadow else {
            return 0.0;
        };
        let radius = self.view.particle_radius;
        let projected = projection.project(surface.at + 0.5 * radius * surface.normal);
        let spread = SHADOW_SOFTNESS * radius * projected.scale;
        let taps = share(&self.shadow_taps, SHADOW_TAPS, turn, place.sample);
        let blocked = taps.iter().filter(|tap| {
            let at = projected.at + spread * **tap;
            index(at, layer.width, layer.height)
                .is_some_and(|i| layer.depth[i] < projected.depth - surface.shadow_bias * radius)
        });
        blocked.count() as f32 / taps.len() as f32
    }
}

/// Part of the light that the surface mirrors (C. Schlick, "An inexpensive BRDF model for physically-based rendering",
/// 1994).
fn fresnel(surface: &Surface, towards_eye: Vec3) -> f32 {
    let facing = surface.normal.dot(towards_eye).clamp(0.0, 1.0);
    REFLECTED + (1.0 - REFLECTED) * (1.0 - facing).powi(5)
}

fn index(at: Vec2, width: usize, height: usize) -> Option<usize> {
    let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < width as f32 && at.y < height as f32;
    inside.then(|| at.y as usize * width + at.x as usize)
}

fn first_samples(layer: &Layer) -> Vec<f32> {
    let rows = layer.depth.chunks_exact(layer.width).step_by(SAMPLES);
    rows.flat_map(|row| row.iter().step_by(SAMPLES).copied())
        .collect()
}

/// Sampling points in the unit disc along a spiral, once for every rotation, in the order needed by [`share`].
fn spirals(taps: usize) -> Vec<Vec2> {
    let samples = SAMPLES * SAMPLES;
    let tap = |turn: usize, i: usize| {
        // Consecutive taps belong to different samples: each sample gets near and far ones.
        let tap = (i % (taps / samples)) * samples + i / (taps / samples);
        let turn = turn as f32 / TURNS as f32;
        let part = (tap as f32 + 0.25 + 0.5 * turn) / taps as f32;
        // Seven revolutions of the spiral; with 16 points no two neighbours coincide.
        let angle = std::f32::consts::TAU * (turn + 7.0 * part);
        part * vec2(angle.cos(), angle.sin())
    };
    (0..TURNS * taps).map(|i| tap(i / taps, i % taps)).collect()
}

/// The sampling points of a rotation that belong to a sample.
fn share(places: &[Vec2], taps: usize, turn: usize, sample: usize) -> &[Vec2] {
    let each = taps / (SAMPLES * SAMPLES);
    &places[turn * taps + sample * each..][..each]
}

/// A rotation that differs between neighbouring pixels and is evenly distributed over any small group of them
/// (interleaved gradient noise; J. Jimenez, "Next generation post processing in Call of Duty", 2014).
fn turn((x, y): (usize, usize)) -> usize {
    // Not `f32::fract`: it is a function call on targets without a rounding instruction.
    let fraction = |value: f32| value - (value as i32) as f32;
    let inner = 0.067_110_56 * x as f32 + 0.005_837_15 * y as f32;
    (fraction(52.982_918 * fraction(inner)) * TURNS as f32) as usize % TURNS
}
