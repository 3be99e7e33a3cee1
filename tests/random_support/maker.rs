//! Adds the parts of a random scene.

use glam::DVec3;

use super::{
    Choices, Maker, cell_edge,
    solids::{Side, Solid},
    vector,
};
use crate::mesh_support::Surface;

impl Maker<'_> {
    /// Adds a solid to the scene and to the list for the test.
    fn solid(&mut self, text: String, solid: Solid) {
        self.boundaries.push(text);
        self.solids.push(solid);
    }

    /// Adds a mesh, rotated by angles \[°] and translated.
    fn mesh(&mut self, surface: &Surface, side: Side, angles: DVec3, at: DVec3) {
        let name = format!("mesh_{}.obj", self.boundaries.len());
        let file = self.files.put(&name, surface.obj());
        let text = format!(
            "Mesh(file: {file:?}, side: {side:?}, rotation: ({}, {}, {}), translation: ({}, {}, {}))",
            angles.x, angles.y, angles.z, at.x, at.y, at.z
        );
        let solid = Solid::mesh(surface, side, angles, at);
        self.solid(text, solid);
    }

    fn tank(&mut self, min: DVec3, max: DVec3, open: bool) {
        let text = format!(
            "Tank(min: {}, max: {}, open: {open})",
            vector(min),
            vector(max)
        );
        self.solid(text, Solid::Tank { min, max, open });
    }

    fn plane(&mut self, center: DVec3, normal: DVec3, half_size: f64) {
        let text = format!(
            "Plane(center: {}, normal: {}, half_size: {half_size})",
            vector(center),
            vector(normal)
        );
        let normal = normal.normalize();
        self.solid(
            text,
            Solid::Plane {
                center,
                normal,
                half_size,
            },
        );
    }

    /// Adds a container, or none.
    pub(super) fn container(&mut self, mut of: Choices, extent: DVec3) {
        let (min, max) = (self.origin, self.origin + extent);
        let middle = 0.5 * (min + max);
        // Rarely a whole number of spacings.
        let room = of.of(&[0.0, 0.0, 0.37]) * self.spacing;
        let wall = extent.max_element();
        let kinds: &[u8] = if self.flat {
            &[0, 0, 1, 2, 3]
        } else {
            &[0, 0, 1, 2, 3, 4, 5, 6, 7]
        };
        let (low, high) = ((min - room).as_vec3(), (max + room).as_vec3());
        let reach = (max - min).length();
        match of.of(kinds) {
            0 => self.tank(min - room, max + room, false),
            1 => self.tank(min - room, max + room, true),
            2 => {
                let floor = middle.with_y(min.y);
                self.plane(floor, DVec3::Y, wall);
            }
            3 => {}
            4 => {
                let block = Surface::block(low, high);
                self.mesh(&block, Side::Inside, DVec3::ZERO, DVec3::ZERO);
            }
            5 => {
                // A box without a lid, oriented so that the fluid is inside.
                let mut block = Surface::block(low, high);
                block.faces.remove(3);
                block.faces.iter_mut().for_each(|face| face.reverse());
                self.mesh(&block, Side::Front, DVec3::ZERO, DVec3::ZERO);
            }
            6 => {
                // A terrain that rises towards its sides.
                let (count, half) = (8, 0.7 * reach);
                let mut terrain = Surface::default();
                let height = of.part() * 0.5;
                for z in 0..=count {
                    for x in 0..=count {
                        let part = |k: i32| 2.0 * f64::from(k) / f64::from(count) - 1.0;
                        let (x, z) = (part(x), part(z));
                        let y = half * height * (x * x * x * x + z * z * z * z);
                        terrain
                            .vertices
                            .push(DVec3::new(half * x, y, half * z).as_vec3());
                    }
                }
                let row = count as usize + 1;
                for z in 0..count as usize {
                    for x in 0..count as usize {
                        let k = z * row + x;
                        terrain.faces.push(vec![k, k + row, k + row + 1]);
                        terrain.faces.push(vec![k, k + row + 1, k + 1]);
                    }
                }
                let at = middle.with_y(min.y - room);
                self.mesh(&terrain, Side::Front, DVec3::ZERO, at);
            }
            _ => {
                // A bowl: a thin wall that is wet on both sides.
                let radius = 0.5 * reach + self.spacing;
                let profile: Vec<(f32, f32)> = (0..=8)
                    .map(|k| {
                        let angle = std::f64::consts::FRAC_PI_2 * f64::from(k) / 8.0;
                        let (sin, cos) = angle.sin_cos();
                        ((radius * sin) as f32, (-radius * cos) as f32)
                    })
                    .map(|(r, y)| if r < 1e-6 { (0.0, y) } else { (r, y) })
                    .collect();
                let bowl = Surface::turned(&profile, 20);
                self.mesh(&bowl, Side::Both, DVec3::ZERO, middle);
            }
        }
    }

    /// Fills a cell of the grid; the first is never empty.
    pub(super) fn fill(&mut self, mut of: Choices, cell: DVec3) {
        let edge = cell_edge(self.flat) * self.spacing;
        let corner = self.origin + edge * cell;
        let fluids: &[u8] = if self.flat { &[0, 1] } else { &[0, 1, 2] };
        let all: &[u8] = if self.flat {
            &[9, 9, 0, 0, 1, 3, 4, 5, 6]
        } else {
            &[9, 9, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 8]
        };
        let kind = of.of(if cell == DVec3::ZERO { fluids } else { all });
        let insets = [0.0, 0.0, 1.0, 0.5, 0.31, 2.2];
        let low = DVec3::from_array([0; 3].map(|_| of.of(&insets))) * self.spacing;
        let high = DVec3::from_array([0; 3].map(|_| of.of(&insets))) * self.spacing;
        let (mut min, mut max) = (corner + low, corner + edge - high);
        if self.flat {
            (min.z, max.z) = (0.0, 0.0);
        }
        let middle = 0.5 * (min + max);
        let size = max - min;
        let least = if self.flat {
            size.x.min(size.y)
        } else {
            size.min_element()
        };
        match kind {
            0 => self.body(
                of,
                format!("Box(min: {}, max: {})", vector(min), vector(max)),
            ),
            1 => self.body(
                of,
                format!(
                    "Sphere(center: {}, radius: {})",
                    vector(middle),
                    0.5 * least
                ),
            ),
            2 => {
                let along = DVec3::new(of.signed(), 1.0, of.signed()).normalize() * 0.35 * least;
                let (start, end) = (middle - along, middle + along);
                let shape = format!(
                    "Cylinder(start: {}, end: {}, radius: {})",
                    vector(start),
                    vector(end),
                    0.35 * least
                );
                self.body(of, shape);
            }
            3 | 5 => {
                // A plate, thin along one axis.
                if kind == 5 {
                    let axis = usize::from(of.next()) % if self.flat { 2 } else { 3 };
                    max[axis] = min[axis] + self.spacing * of.of(&[1.0, 0.3, 1.3, 2.1]);
                }
                let text = format!("Box(min: {}, max: {})", vector(min), vector(max));
                self.solid(text, Solid::Block { min, max });
            }
            4 => {
                let radius = 0.5 * least * of.of(&[1.0, 0.6, 0.2]);
                let text = format!("Sphere(center: {}, radius: {radius})", vector(middle));
                self.solid(
                    text,
                    Solid::Ball {
                        center: middle,
                        radius,
                    },
                );
            }
            6 => {
                let normal = of.vector(self.flat);
                let normal = if normal == DVec3::ZERO {
                    DVec3::X
                } else {
                    normal
                };
                self.plane(middle, normal, 0.4 * least);
            }
            _ if kind == 9 => {}
            _ => self.fill_mesh(of, middle, least),
        }
    }

    /// Adds a mesh of a size of at most `least` \[m]: a block, a body of revolution, a wedge or a sheet.
    fn fill_mesh(&mut self, mut of: Choices, middle: DVec3, least: f64) {
        let angles = of.vector(false) * 180.0;
        let half = 0.5 * least
            / if angles == DVec3::ZERO {
                1.0
            } else {
                3f64.sqrt()
            };
        match of.of(&[0, 1, 2, 3]) {
            0 => {
                let block =
                    Surface::block(DVec3::splat(-half).as_vec3(), DVec3::splat(half).as_vec3());
                self.mesh(&block, Side::Outside, angles, middle);
            }
            1 => {
                let profile: Vec<(f32, f32)> = (0..=6)
                    .map(|k| {
                        let angle = std::f64::consts::PI * f64::from(k) / 6.0;
                        let radius = if k == 0 || k == 6 {
                            0.0
                        } else {
                            half * angle.sin()
                        };
                        (radius as f32, (-half * angle.cos()) as f32)
                    })
                    .collect();
                self.mesh(&Surface::turned(&profile, 9), Side::Outside, angles, middle);
            }
            2 => {
                // A wedge.
                let outline = [(0.0, 0.0), (1.0, 0.0), (0.0, 0.3 + 0.7 * of.part())]
                    .map(|(x, y)| ((half * x) as f32, (half * y) as f32));
                let wedge = Surface::prism(&outline, half as f32);
                self.mesh(&wedge, Side::Outside, angles, middle);
            }
            _ => {
                let sheet = Surface {
                    vertices: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                        .map(|(x, y)| DVec3::new(half * x, half * y, 0.0).as_vec3())
                        .into(),
                    faces: vec![vec![0, 1, 2, 3]],
                };
                self.mesh(&sheet, Side::Both, angles, middle);
            }
        }
    }

    fn body(&mut self, mut of: Choices, shape: String) {
        let velocity = of.vector(self.flat) * self.speed;
        let jitter = of.of(&[0.0, 0.0, 0.0, 0.02, 0.1]);
        let mut text = format!("(shape: {shape}");
        if velocity != DVec3::ZERO {
            text += &format!(", velocity: {}", vector(velocity));
        }
        if jitter > 0.0 {
            self.has_jitter = true;
            text += &format!(", jitter: (amplitude: {jitter}, seed: {})", of.next());
        }
        let turn = of.signed() * self.speed / (cell_edge(self.flat) * self.spacing);
        if turn != 0.0 {
            text += &format!(
                ", velocity_gradient: ((0, {turn}, 0), ({}, 0, 0), (0, 0, 0))",
                -turn as f32
            );
        }
        self.bodies.push(text + ")");
    }
}
