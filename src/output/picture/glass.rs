//! Glass in front of what a picture shows: it mirrors its surroundings, and absorbs a little light.
//!
//! Light passes without being refracted, so that a sheet without thickness is enough for the wall of a vessel.

use std::sync::Arc;

use glam::{Vec2, Vec3, vec3};

use super::projection::{Projection, Ray};
use super::solid::Solid;
use super::window::Window;
use crate::mesh::Mesh;

/// Part of the light that a pane reflects at right angles: 4 % at each of its two faces.
const REFLECTED: f32 = 0.08;
/// Part of the light, by colour, that a pane absorbs at right angles; obliquely the path through it is longer.
const ABSORBED: Vec3 = vec3(0.035, 0.025, 0.030);
/// Least cosine of the angle to the normal with which the path through a pane is computed: its edge is round.
const LEAST_COSINE: f32 = 0.07;
/// Cosine of the angle between the normals of a triangle and of a vertex beyond which the edge there is sharp.
const SHARP: f32 = 0.8;
/// Light of the lamp that glass mirrors. It is as wide and as high \[rad] as a window that one sees in a wine glass.
const LAMP: f32 = 5.0;
const LAMP_WIDTH: f32 = 0.6;
const LAMP_HEIGHT: f32 = 1.2;

/// Meshes of glass on a picture.
pub(super) struct Glass {
    panes: Vec<Pane>,
}

struct Pane {
    mesh: Arc<Mesh>,
    /// Normals at the corners of each triangle: smooth but for sharp edges.
    normals: Vec<[Vec3; 3]>,
    window: Window,
}

/// Where a ray meets glass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub(super) depth: f32,
    /// Unit normal, towards the eye.
    pub(super) normal: Vec3,
}

impl Glass {
    pub(super) fn new(meshes: &[Arc<Mesh>], projection: &Projection, size: (usize, usize)) -> Self {
        let pane = |mesh: &Arc<Mesh>| {
            let solid = Solid::Mesh {
                mesh: mesh.clone(),
                thin: 0.0,
            };
            Pane {
                mesh: mesh.clone(),
                normals: corner_normals(mesh),
                window: Window::new(projection, &solid, size),
            }
        };
        Self {
            panes: meshes.iter().map(pane).collect(),
        }
    }

    /// Where a ray through a sample meets glass before `depth` \[m], the farthest first.
    pub(super) fn crossings(&self, at: Vec2, ray: &Ray, depth: f32) -> Vec<Crossing> {
        let mut found = Vec::new();
        let mut hits = Vec::new();
        for pane in &self.panes {
            if !pane.window.contains(at) {
                continue;
            }
            let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            pane.mesh.hits(origin, direction, &mut hits);
            let mut last = f64::NEG_INFINITY;
            for &(hit, triangle) in &hits {
                // A ray through an edge meets both of its triangles.
                if hit > 0.0 && hit < f64::from(depth) && hit - last > 1e-9 * hit {
                    let normal = pane.normal(triangle, ray.at(hit as f32));
                    let towards_eye = if normal.dot(ray.direction) > 0.0 {
                        -normal
                    } else {
                        normal
                    };
                    found.push(Crossing {
                        depth: hit as f32,
                        normal: towards_eye,
                    });
                    last = hit;
                }
            }
        }
        found.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        found
    }
}

impl Crossing {
    /// What is seen of a colour behind the glass, which mirrors another. `towards_eye` is a unit vector.
    pub(super) fn over(&self, behind: Vec3, mirrored: Vec3, towards_eye: Vec3) -> Vec3 {
        let cosine = self.normal.dot(towards_eye).clamp(0.0, 1.0);
        let path = 1.0 / cosine.max(LEAST_COSINE);
        let passed = (-ABSORBED * path).exp();
        // Schlick's approximation, as for water.
        let reflected = REFLECTED + (1.0 - REFLECTED) * (1.0 - cosine).powi(5);
        (behind * passed).lerp(mirrored, reflected)
    }

    /// The direction from which light is mirrored to the eye.
    pub(super) fn mirrored_from(&self, towards_eye: Vec3) -> Vec3 {
        2.0 * self.normal.dot(towards_eye) * self.normal - towards_eye
    }
}

/// The light of the lamp that stands below the key light, if it is in a direction.
pub(super) fn lamp(direction: Vec3, light: Vec3) -> Option<Vec3> {
    let aside = light.x.atan2(light.z) - direction.x.atan2(direction.z);
    // The cosine has no jump at half a turn.
    let in_width = aside.cos() > (0.5 * LAMP_WIDTH).cos();
    let in_height = direction.y.abs() < (0.5 * LAMP_HEIGHT).sin();
    (in_width && in_height).then_some(Vec3::splat(LAMP))
}

impl Pane {
    fn normal(&self, triangle: usize, at: Vec3) -> Vec3 {
        let [a, b, c] = self.mesh.corners(triangle).map(|corner| corner.as_vec3());
        let face = (b - a).cross(c - a);
        let of_b = (at - a).cross(c - a).dot(face) / face.length_squared();
        let of_c = (b - a).cross(at - a).dot(face) / face.length_squared();
        let shares = vec3(1.0 - of_b - of_c, of_b, of_c).clamp(Vec3::ZERO, Vec3::ONE);
        let [of_a, of_b, of_c] = self.normals[triangle];
        let smooth = shares.x * of_a + shares.y * of_b + shares.z * of_c;
        smooth.normalize_or(self.mesh.normals[triangle].as_vec3())
    }
}

fn corner_normals(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let of_vertices = mesh.vertex_normals();
    let rows = mesh.triangles.iter().zip(&mesh.normals);
    rows.map(|(corners, normal)| {
        let face = normal.as_vec3();
        corners.map(|corner| {
            let vertex = of_vertices[corner as usize].as_vec3();
            if vertex.dot(face) > SHARP {
                vertex
            } else {
                face
            }
        })
    })
    .collect()
}
