//! Content and viewpoint of a picture.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3, vec2, vec3};

use super::camera_path::CameraPath;
use super::colour::ColourMap;
use super::projection::Projection;
use super::quantity::Quantity;
use super::solid::{Solid, Turned, around, corners};
use crate::mesh::Mesh;
use crate::scene::shapes::{Inlet, wall_axes};
use crate::scene::{BoundaryShape, Bounds, Camera, Dimension, FluidBody, Frame, Scene, Shape};

/// Direction from the scene to the default camera: from the front, slightly from the right and above.
const DEFAULT_DIRECTION: Vec3 = vec3(0.40, 0.38, 1.0);
/// Vertical field of view of the default camera \[°].
const DEFAULT_FIELD_OF_VIEW: f32 = 26.0;
/// Part of the picture that the default camera fills, from −1 to 1 between the edges: left, right, bottom, top.
const FILLED: [f32; 4] = [-0.93, 0.93, -0.80, 0.90];
/// Thickness below which walls of meshes are transparent \[spacings].
const THIN: f32 = 3.0;
/// Samples along an edge of the light's layer.
const SHADOW_SIZE: usize = 1024;

/// Content and viewpoint of a picture. The same view for all frames of a series makes them comparable.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Width \[pixels].
    pub width: u32,
    /// Height \[pixels].
    pub height: u32,
    /// 2-D scenes are shown as a plane, without the camera.
    pub dimension: Dimension,
    /// The camera; if absent, one that fills the picture with [`bounds`](Self::bounds).
    pub camera: Option<Camera>,
    /// Where the camera is over time, instead.
    pub camera_path: Option<Arc<CameraPath>>,
    /// The region that should be visible.
    pub bounds: Bounds,
    /// Radius of drawn particles \[m].
    pub particle_radius: f32,
    /// What colours show.
    pub quantity: Quantity,
    /// Values at the two ends of the colour range, in the unit of the quantity.
    pub range: (f32, f32),
    /// The colours.
    pub colours: ColourMap,
    /// Height of the floor \[m]; `None` for no floor.
    pub floor: Option<f32>,
    /// Edges of tanks and walls: end points of lines \[m].
    pub edges: Vec<[Vec3; 2]>,
    /// Obstacles.
    pub solids: Vec<Solid>,
    /// Obstacles of glass.
    pub glass: Vec<Arc<Mesh>>,
    /// Whether time and colour bar are drawn.
    pub legend: bool,
}

impl View {
    /// A view of 960 × 540 pixels of all bodies and boundaries of a scene, by the scene's camera if it has one.
    ///
    /// The colour range ends at the speed of free fall through the height of the scene, plus the largest speed at the
    /// start. Few particles exceed it.
    pub fn from_scene(scene: &Scene) -> Self {
        let flat = scene.dimension == Dimension::Two;
        let mut view = Self {
            width: 960,
            height: 540,
            dimension: scene.dimension,
            camera: scene.output.camera,
            camera_path: None,
            bounds: Bounds {
                min: Vec3::INFINITY,
                max: Vec3::NEG_INFINITY,
            },
            particle_radius: scene.spacing * if flat { 0.72 } else { 0.60 },
            quantity: Quantity::Speed,
            range: (0.0, 1.0),
            colours: ColourMap::default(),
            floor: None,
            edges: Vec::new(),
            solids: Vec::new(),
            glass: Vec::new(),
            legend: true,
        };
        for body in &scene.bodies {
            view.include(body_bounds(body));
        }
        for emitter in &scene.emitters {
            let (min, max) = Inlet::new(emitter, scene).bounds();
            view.include(Bounds::new(min.as_vec3(), max.as_vec3()));
        }
        let fluid = view.bounds;
        // A picture does not know where a wall that moves is.
        let standing = |wall: &&BoundaryShape| wall.motion().is_none();
        for boundary in scene.boundaries.iter().filter(standing) {
            view.add_boundary(boundary, flat, scene.spacing);
        }
        if !(view.bounds.min.is_finite() && view.bounds.max.is_finite()) {
            view.bounds = Bounds {
                min: Vec3::splat(-0.5),
                max: Vec3::splat(0.5),
            };
        }
        if flat {
            (view.bounds.min.z, view.bounds.max.z) = (0.0, 0.0);
        } else if scene.gravity.y < 0.0 {
            let bottoms = scene
                .boundaries
                .iter()
                .filter_map(|boundary| match boundary {
                    BoundaryShape::Tank { min, max, .. } => {
                        let tank = Bounds::new(*min, *max);
                        Some(turned_bounds(&boundary.frame(), tank).min.y)
                    }
                    _ => None,
                });
            view.floor = bottoms.reduce(f32::min);
        }
        let drop = (fluid.max.y - view.bounds.min.y).max(0.0);
        let fastest = (2.0 * scene.gravity.length() * drop).sqrt() + scene.max_initial_speed();
        if fastest.is_finite() && fastest > 0.0 {
            view.range.1 = round_up(fastest);
        }
        view
    }

    /// The same view at another size \[pixels].
    pub fn with_size(mut self, width: u32, height: u32) -> Self {
        (self.width, self.height) = (width, height);
        self
    }

    /// The same view with other values at the ends of the colour range.
    pub fn with_range(mut self, low: f32, high: f32) -> Self {
        self.range = (low, high);
        self
    }

    /// The same view of another quantity, in other colours; its range must be set.
    pub fn of(mut self, quantity: Quantity, colours: ColourMap) -> Self {
        (self.quantity, self.colours) = (quantity, colours);
        self
    }

    /// The same view with meshes and surfaces of revolution as glass; grounds stay as they are. A scene without a floor
    /// gets one under the glass.
    pub fn with_glass(mut self) -> Self {
        let mut low = f32::INFINITY;
        self.solids.retain(|solid| match solid {
            Solid::Mesh { mesh, .. } if mesh.heights.is_none() => {
                low = low.min(mesh.bounds().0.y as f32);
                self.glass.push(mesh.clone());
                false
            }
            _ => true,
        });
        if low.is_finite() && !self.is_flat() {
            self.floor.get_or_insert(low);
        }
        self
    }

    fn include(&mut self, bounds: Bounds) {
        self.bounds.min = self.bounds.min.min(bounds.min);
        self.bounds.max = self.bounds.max.max(bounds.max);
    }

    fn add_boundary(&mut self, boundary: &BoundaryShape, flat: bool, spacing: f32) {
        let frame = boundary.frame();
        let place = |point: Vec3| frame.place(point.as_dvec3()).as_vec3();
        match *boundary {
            BoundaryShape::Tank {
                mut min, mut max, ..
            } => {
                if flat {
                    (min.z, max.z) = (0.0, 0.0);
                }
                self.include(turned_bounds(&frame, Bounds { min, max }));
                let edges = edges(&Bounds { min, max });
                self.edges.extend(edges.map(|edge| edge.map(place)));
            }
            BoundaryShape::Box {
                mut min, mut max, ..
            } => {
                self.include(turned_bounds(&frame, Bounds { min, max }));
                if flat {
                    // A plane gets the thickness of a particle; otherwise it has no visible face.
                    (min.z, max.z) = (-0.5 * spacing, 0.5 * spacing);
                }
                let bounds = Bounds { min, max };
                self.solids.push(if frame.is_turned() {
                    Solid::TurnedBox(bounds, Turned(frame))
                } else {
                    Solid::Box(bounds)
                });
            }
            BoundaryShape::Sphere { center, radius, .. } => {
                self.include(around(center, Vec3::splat(radius)));
                self.solids.push(Solid::Sphere { center, radius });
            }
            BoundaryShape::Plane {
                center,
                normal,
                half_size,
                ..
            } => {
                let normal = normal.normalize_or(Vec3::Y);
                let (u, v) = wall_axes(normal, self.dimension);
                let turned = |vector: Vec3| frame.direction(vector.as_dvec3()).as_vec3();
                let normal = turned(normal);
                let (u, v) = (half_size * turned(u), half_size * turned(v));
                if flat {
                    self.include(around(center, u.abs()));
                    self.edges.push([center - u, center + u]);
                    return;
                }
                let corners = [u + v, v - u, -u - v, u - v].map(|at| center + at);
                for i in 0..4 {
                    self.include(around(corners[i], Vec3::ZERO));
                    self.edges.push([corners[i], corners[(i + 1) % 4]]);
                }
                self.solids.push(Solid::Wall {
                    center,
                    normal,
                    half_edges: [u, v],
                });
            }
            BoundaryShape::Mesh(_) | BoundaryShape::Revolution(_) | BoundaryShape::Terrain(_) => {
                // If the file was removed since the scene was checked, the rest is still drawn.
                let Some(Ok(mesh)) = boundary.mesh(spacing) else {
                    return;
                };
                let (min, max) = mesh.bounds();
                self.include(Bounds {
                    min: min.as_vec3(),
                    max: max.as_vec3(),
                });
                self.solids.push(Solid::Mesh {
                    mesh: Arc::new(mesh),
                    thin: THIN * spacing,
                });
            }
        }
    }

    pub(super) fn is_flat(&self) -> bool {
        self.dimension == Dimension::Two
    }

    pub(super) fn size(&self) -> (usize, usize) {
        (self.width.max(1) as usize, self.height.max(1) as usize)
    }

    /// Position of a value in the colour range, 0 to 1.
    pub(super) fn place_in_range(&self, value: f32) -> f32 {
        let (low, high) = self.range;
        (value - low) / (high - low).max(f32::MIN_POSITIVE)
    }

    /// Direction towards the key light: from the left, above and in front of the scene.
    pub(super) fn light(&self) -> Vec3 {
        vec3(-0.45, 1.0, 0.40).normalize()
    }

    /// Degree to which the floor has faded into the background, 0 to 1.
    pub(super) fn distance_haze(&self, at: Vec3) -> f32 {
        let size = self.bounds.max - self.bounds.min;
        let beyond = (at - at.clamp(self.bounds.min, self.bounds.max)).length();
        let t = (beyond / (0.55 * size.max_element()).max(1e-6)).min(1.0);
        t * t * (3.0 - 2.0 * t)
    }

    pub(super) fn projection(&self) -> Projection {
        let (width, height) = self.size();
        let size = vec2(width as f32, height as f32);
        if self.is_flat() {
            return self.flat_projection(size);
        }
        let camera = self.camera.unwrap_or_else(|| self.fitting_camera(size));
        let half_angle = 0.5 * camera.field_of_view.clamp(1.0, 170.0).to_radians();
        Projection::new(
            camera.position,
            camera.target - camera.position,
            true,
            0.5 * size.y / half_angle.tan(),
            0.5 * size,
        )
    }

    fn flat_projection(&self, size: Vec2) -> Projection {
        let [left, right, bottom, top] = FILLED;
        let shown = (self.bounds.max - self.bounds.min).truncate();
        let shown = shown.max(Vec2::splat(2.0 * self.particle_radius));
        let room = 0.5 * size * vec2(right - left, top - bottom);
        let centre = 0.5 * size * vec2(1.0 + 0.5 * (left + right), 1.0 - 0.5 * (bottom + top));
        let eye = 0.5 * (self.bounds.min + self.bounds.max) + Vec3::Z;
        Projection::new(
            eye,
            Vec3::NEG_Z,
            false,
            (room / shown).min_element(),
            centre,
        )
    }

    /// A camera that fills the picture with the bounds, found by iteration.
    fn fitting_camera(&self, size: Vec2) -> Camera {
        let [left, right, bottom, top] = FILLED;
        let tan = (0.5 * DEFAULT_FIELD_OF_VIEW.to_radians()).tan();
        let direction = DEFAULT_DIRECTION.normalize();
        let mut target = 0.5 * (self.bounds.min + self.bounds.max);
        let diagonal = (self.bounds.max - self.bounds.min).length();
        let mut distance = diagonal.max(self.particle_radius) / tan;
        // Each iteration reduces the error of the fit about tenfold.
        for _ in 0..12 {
            let view = Projection::new(
                target + distance * direction,
                -direction,
                true,
                1.0 / tan,
                Vec2::ZERO,
            );
            let wide = vec2(size.y / size.x, 1.0);
            let points = corners(&self.bounds).map(|corner| view.project(corner).at * wide);
            let low = points.into_iter().reduce(Vec2::min).unwrap_or_default();
            let high = points.into_iter().reduce(Vec2::max).unwrap_or_default();
            let wanted = vec2(0.5 * (left + right), -0.5 * (bottom + top));
            let shift = (0.5 * (low + high) - wanted) / wide * tan * distance;
            target += view.direction(shift.x, shift.y, 0.0);
            let excess = (high - low) / vec2(right - left, top - bottom);
            let factor = excess.max_element();
            if !(factor.is_finite() && factor > 0.0) {
                break;
            }
            distance *= factor.clamp(0.5, 2.0);
        }
        Camera {
            position: target + distance * direction,
            target,
            field_of_view: DEFAULT_FIELD_OF_VIEW,
        }
    }

    /// A parallel projection of all visible objects from the direction of the light; `None` in 2-D.
    pub(super) fn shadow_projection(&self) -> Option<(Projection, usize)> {
        if self.is_flat() {
            return None;
        }
        let centre = 0.5 * (self.bounds.min + self.bounds.max);
        let radius = 0.55 * (self.bounds.max - self.bounds.min).length();
        let half = 0.5 * SHADOW_SIZE as f32;
        let scale = half / radius.max(self.particle_radius);
        let light = self.light();
        let eye = centre + 2.0 * radius * light;
        let projection = Projection::new(eye, -light, false, scale, Vec2::splat(half));
        Some((projection, SHADOW_SIZE))
    }
}

fn edges(bounds: &Bounds) -> impl Iterator<Item = [Vec3; 2]> + use<> {
    let corners = corners(bounds);
    let pairs = (0..8).flat_map(|i| [1, 2, 4].map(|bit| (i, i | bit)));
    let ends = pairs.map(move |(i, j)| [corners[i], corners[j]]);
    ends.filter(|[from, to]| from != to)
}

fn body_bounds(body: &FluidBody) -> Bounds {
    let bounds = match body.shape {
        Shape::Box { min, max } => Bounds { min, max },
        Shape::Sphere { center, radius } => around(center, Vec3::splat(radius)),
        Shape::Cylinder { start, end, radius } => Bounds {
            min: start.min(end) - radius,
            max: start.max(end) + radius,
        },
        Shape::Mesh(_) | Shape::Particles(_) => {
            let around = body.shape.extent_of_file();
            let (min, max) = around.unwrap_or((DVec3::INFINITY, DVec3::NEG_INFINITY));
            Bounds::new(min.as_vec3(), max.as_vec3())
        }
    };
    turned_bounds(&body.frame(), bounds)
}

fn turned_bounds(frame: &Frame, Bounds { min, max }: Bounds) -> Bounds {
    let (min, max) = frame.bounds(min.as_dvec3(), max.as_dvec3());
    Bounds::new(min.as_vec3(), max.as_vec3())
}

/// The next of 1, 1.5, 2, 3, 4, 5, 6, 8, 10 times a power of ten.
fn round_up(value: f32) -> f32 {
    let power = 10f32.powf(value.log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0];
    let step = steps.into_iter().find(|step| step * power >= value);
    step.unwrap_or(10.0) * power
}
