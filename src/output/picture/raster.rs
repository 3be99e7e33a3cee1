//! The nearest surface of every sample: spheres, solids, the floor.

use glam::{Vec3, vec2};
use rayon::prelude::*;

use super::projection::{Projection, Ray};
use super::solid::Solid;
use super::target::{Splat, Target};
use super::triangles::Faces;
use super::window::Window;
use crate::output::surface::SurfaceMesh;

/// Samples along an edge of a pixel.
pub(super) const SAMPLES: usize = 2;
/// Rows of samples that are drawn by one task.
const BAND: usize = 16;
/// Smallest radius of a drawn sphere \[samples], so that distant particles do not fall between samples.
const SMALLEST_RADIUS: f32 = 0.75;

/// [`Layer::surface`] where there is no surface.
pub(super) const NOTHING: u32 = u32::MAX;
/// [`Layer::surface`] of the floor.
pub(super) const FLOOR: u32 = u32::MAX - 1;
/// [`Layer::surface`] of the first solid; further solids count down from it. Smaller numbers are rows of particles or
/// triangles of the fluid's surface.
const FIRST_SOLID: u32 = u32::MAX - 2;
/// Largest number of solids that are drawn.
const MAX_SOLIDS: usize = 1 << 16;

/// What is drawn of the fluid.
#[derive(Clone, Copy)]
pub(super) enum Fluid<'a> {
    Spheres(Spheres<'a>),
    Surface(&'a SurfaceMesh),
}

/// Particles to draw.
#[derive(Clone, Copy)]
pub(super) struct Spheres<'a> {
    /// Centres \[m].
    pub(super) positions: &'a [Vec3],
    /// Common radius \[m].
    pub(super) radius: f32,
}

impl Fluid<'_> {
    /// Number of particles or triangles.
    fn len(&self) -> usize {
        match self {
            Self::Spheres(spheres) => spheres.positions.len(),
            Self::Surface(mesh) => mesh.triangles.len(),
        }
    }
}

/// The nearest surface of every sample, rows from the top.
pub(super) struct Layer {
    pub(super) width: usize,
    pub(super) height: usize,
    /// \[m]; infinity where there is no surface.
    pub(super) depth: Vec<f32>,
    /// Row of a particle or number of a triangle, [`FLOOR`], [`NOTHING`], or a solid (see [`Layer::solid`]).
    pub(super) surface: Vec<u32>,
}

impl Spheres<'_> {
    /// A particle on a picture of this size. Computed wherever it is needed: the splats of all particles would take as
    /// much memory as half a frame.
    pub(super) fn splat(&self, row: u32, projection: &Projection, size: (usize, usize)) -> Splat {
        splat(projection, size, self.positions[row as usize], self.radius)
    }
}

impl Layer {
    pub(super) fn draw(
        projection: &Projection,
        (width, height): (usize, usize),
        fluid: Fluid<'_>,
        solids: &[Solid],
        floor: Option<f32>,
    ) -> Self {
        let size = (width, height);
        let faces = match fluid {
            Fluid::Spheres(_) => None,
            Fluid::Surface(mesh) => Some(Faces::new(projection, mesh)),
        };
        let splat = |row: u32| match (fluid, &faces) {
            (Fluid::Surface(_), Some(faces)) => faces.splat(row, size),
            (Fluid::Spheres(spheres), _) => spheres.splat(row, projection, size),
            // A surface has faces.
            (Fluid::Surface(_), None) => Splat::default(),
        };
        let bands = Bands::new(fluid.len(), splat, height);
        let windows: Vec<Window> = solids
            .iter()
            .take(MAX_SOLIDS)
            .map(|solid| Window::new(projection, solid, (width, height)))
            .collect();

        let mut depth = vec![f32::INFINITY; width * height];
        let mut surface = vec![NOTHING; width * height];
        let samples = (
            depth.par_chunks_mut(BAND * width),
            surface.par_chunks_mut(BAND * width),
        );
        samples
            .into_par_iter()
            .enumerate()
            .for_each(|(band, (depth, surface))| {
                let mut target = Target {
                    first_row: band * BAND,
                    width,
                    depth,
                    surface,
                };
                if let Some(height) = floor {
                    target.floor(projection, height);
                }
                for (k, (solid, window)) in solids.iter().zip(&windows).enumerate() {
                    target.solid(projection, solid, window, FIRST_SOLID - k as u32);
                }
                for &row in bands.rows(band) {
                    match (fluid, &faces) {
                        (Fluid::Spheres(spheres), _) => {
                            target.sphere(&splat(row), row, spheres.radius);
                        }
                        (_, Some(faces)) => faces.draw(row, projection, &mut target),
                        _ => {}
                    }
                }
            });
        Self {
            width,
            height,
            depth,
            surface,
        }
    }

    /// The number of the solid that a surface belongs to, if it is a solid.
    pub(super) fn solid(surface: u32) -> Option<usize> {
        (surface > FIRST_SOLID - MAX_SOLIDS as u32 && surface <= FIRST_SOLID)
            .then(|| (FIRST_SOLID - surface) as usize)
    }
}

fn splat(
    projection: &Projection,
    (width, height): (usize, usize),
    centre: Vec3,
    radius: f32,
) -> Splat {
    let projected = projection.project(centre);
    let r = (radius * projected.scale).max(SMALLEST_RADIUS);
    let at = projected.at;
    let on_picture = projection.sees(projected.depth - radius)
        && at.x + r > 0.0
        && at.y + r > 0.0
        && at.x - r < width as f32
        && at.y - r < height as f32;
    Splat {
        at,
        radius: if on_picture { r } else { 0.0 },
        depth: projected.depth,
    }
}

/// The particles that touch each band of rows, in the order of their rows.
struct Bands {
    starts: Vec<usize>,
    rows: Vec<u32>,
}

impl Bands {
    fn new(count: usize, splat: impl Fn(u32) -> Splat, height: usize) -> Self {
        let bands = height.div_ceil(BAND);
        let touched = |splat: &Splat| {
            // The cast turns a negative number into 0.
            let first = (splat.at.y - splat.radius) as usize / BAND;
            let last = (splat.at.y + splat.radius) as usize / BAND;
            first..(last + 1).min(bands)
        };
        let all = || (0..count as u32).map(|row| (row, splat(row)));
        let drawn = || all().filter(|(_, splat)| splat.radius > 0.0);

        let mut starts = vec![0; bands + 1];
        for (_, splat) in drawn() {
            touched(&splat).for_each(|band| starts[band + 1] += 1);
        }
        for band in 0..bands {
            starts[band + 1] += starts[band];
        }
        let mut next = starts.clone();
        let mut rows = vec![0; starts[bands]];
        for (row, splat) in drawn() {
            for band in touched(&splat) {
                rows[next[band]] = row;
                next[band] += 1;
            }
        }
        Self { starts, rows }
    }

    fn rows(&self, band: usize) -> &[u32] {
        &self.rows[self.starts[band]..self.starts[band + 1]]
    }
}

impl Target<'_> {
    fn ray(&self, projection: &Projection, x: usize, y: usize) -> Ray {
        let y = self.first_row + y;
        projection.ray(vec2(x as f32 + 0.5, y as f32 + 0.5))
    }

    fn floor(&mut self, projection: &Projection, height: f32) {
        for i in 0..self.depth.len() {
            let ray = self.ray(projection, i % self.width, i / self.width);
            let depth = (height - ray.origin.y) / ray.direction.y;
            if ray.direction.y < 0.0 && projection.sees(depth) {
                self.depth[i] = depth;
                self.surface[i] = FLOOR;
            }
        }
    }

    /// Casts a ray through every sample in which the solid may be visible.
    fn solid(&mut self, projection: &Projection, solid: &Solid, window: &Window, surface: u32) {
        let rows = self.depth.len() / self.width;
        let first = window.rows.start.saturating_sub(self.first_row);
        let end = window.rows.end.saturating_sub(self.first_row).min(rows);
        for y in first..end {
            for x in window.columns.clone() {
                let depth = solid.hit(&self.ray(projection, x, y));
                let i = y * self.width + x;
                if depth < self.depth[i] {
                    self.depth[i] = depth;
                    self.surface[i] = surface;
                }
            }
        }
    }

    /// Draws the front of a sphere. With perspective its outline is approximated by a circle, which is accurate for
    /// small ones.
    fn sphere(&mut self, splat: &Splat, row: u32, radius: f32) {
        let rows = self.depth.len() / self.width;
        let r2 = splat.radius * splat.radius;
        let top = splat.at.y - self.first_row as f32;
        let first = (top - splat.radius - 0.5).ceil().max(0.0) as usize;
        let end = ((top + splat.radius + 0.5).max(0.0) as usize).min(rows);
        for y in first..end {
            let dy = y as f32 + 0.5 - top;
            let half = (r2 - dy * dy).max(0.0).sqrt();
            let left = (splat.at.x - half - 0.5).ceil().max(0.0) as usize;
            let right = ((splat.at.x + half + 0.5).max(0.0) as usize).min(self.width);
            for x in left..right {
                let dx = x as f32 + 0.5 - splat.at.x;
                let bulge = (1.0 - (dx * dx + dy * dy) / r2).max(0.0).sqrt();
                let depth = splat.depth - radius * bulge;
                let i = y * self.width + x;
                if depth < self.depth[i] {
                    self.depth[i] = depth;
                    self.surface[i] = row;
                }
            }
        }
    }
}
