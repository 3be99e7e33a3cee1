//! Small scenes drawn at random: bodies and solids in the cells of a grid, within a container.
//!
//! A scene is made of a list of numbers, of which zero always means the plainest choice: proptest shrinks towards it.

#![allow(dead_code, reason = "each test uses a part")]

pub(crate) mod solids;
pub(crate) mod sums;

use glam::DVec3;

use crate::mesh_support::{Files, Surface};
use solids::{Side, Solid};

/// Numbers that each part of a scene takes its choices from.
pub(crate) const CHOICES: usize = OF_FLUID + 10 * PART;
/// Of the fluid, of the container and of every cell.
const PART: usize = 28;
const OF_FLUID: usize = 20;

/// Choices, taken in their order; zeros where they end.
struct Choices<'a>(std::slice::Iter<'a, u16>);

impl Choices<'_> {
    fn next(&mut self) -> u16 {
        self.0.next().copied().unwrap_or(0)
    }

    /// One of a list; the first is the plainest.
    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[usize::from(self.next()) % list.len()]
    }

    /// From 0 to below 1.
    fn part(&mut self) -> f64 {
        f64::from(self.next()) / 65536.0
    }

    /// From -1 to below 1, and 0 for 0.
    fn signed(&mut self) -> f64 {
        let part = self.part();
        if self.next().is_multiple_of(2) {
            part
        } else {
            -part
        }
    }

    fn vector(&mut self, flat: bool) -> DVec3 {
        let [x, y, z] = [self.signed(), self.signed(), self.signed()];
        DVec3::new(x, y, if flat { 0.0 } else { z })
    }
}

/// A scene's text, and what a test has to know of it.
#[derive(Debug)]
pub(crate) struct Draft {
    pub(crate) text: String,
    pub(crate) solids: Vec<Solid>,
    /// Whether particles start off their lattices.
    pub(crate) has_jitter: bool,
    /// Part of the time step that the scene's limits allow, if it is fixed.
    pub(crate) fixed_part: Option<f64>,
}

struct Maker<'a> {
    files: &'a Files,
    flat: bool,
    /// Spacing \[m].
    spacing: f64,
    /// Where the grid of cells begins \[m].
    origin: DVec3,
    bodies: Vec<String>,
    boundaries: Vec<String>,
    solids: Vec<Solid>,
    has_jitter: bool,
    /// Scale of velocities \[m/s].
    speed: f64,
}

/// Edge of a cell \[spacings].
fn cell_edge(flat: bool) -> f64 {
    if flat { 9.0 } else { 6.0 }
}

fn vector(x: DVec3) -> String {
    format!("({}, {}, {})", x.x as f32, x.y as f32, x.z as f32)
}

/// Draws a scene; meshes are written into `files`.
pub(crate) fn draw(choices: &[u16], files: &Files) -> Draft {
    let (fluid, rest) = choices.split_at(OF_FLUID.min(choices.len()));
    let mut parts = rest.chunks(PART);
    let mut part = || Choices(parts.next().unwrap_or_default().iter());
    let mut general = part();
    let flat = general.of(&[true, false]);
    let spacing = general.of(&[0.02, 0.1, 0.003, 1.0]);
    let gravity = match general.of(&[0, 1, 2, 3]) {
        0 => DVec3::NEG_Y * 9.81,
        1 => DVec3::ZERO,
        2 => general.vector(flat) * 9.81,
        _ => DVec3::NEG_Y * 100.0,
    };
    let cells = if flat {
        DVec3::new(3.0, 2.0, 0.0)
    } else {
        DVec3::new(2.0, 2.0, 1.0)
    };
    let extent = cells * cell_edge(flat) * spacing;
    // What water gets by falling through the scene, or a tenth of that where nothing falls.
    let fall = (2.0 * gravity.length().max(0.1) * extent.y).sqrt();
    let far = general.of(&[0.0, 0.0, 1.0, -17.37, 3000.0]);
    let mut maker = Maker {
        files,
        flat,
        spacing,
        origin: DVec3::new(1.0, -0.5, if flat { 0.0 } else { 0.25 }) * far * spacing,
        bodies: Vec::new(),
        boundaries: Vec::new(),
        solids: Vec::new(),
        has_jitter: false,
        speed: fall * general.of(&[0.0, 0.3, 1.0, 2.0]),
    };
    maker.container(part(), extent);
    for z in 0..(cells.z as usize).max(1) {
        for y in 0..cells.y as usize {
            for x in 0..cells.x as usize {
                let cell = DVec3::new(x as f64, y as f64, z as f64);
                maker.fill(part(), cell);
            }
        }
    }
    let speed = (fall * fall + 4.0 * maker.speed * maker.speed).sqrt();
    let (numerics, fixed_part) = numerics(Choices(fluid.iter()), flat, spacing, speed);
    let Maker {
        bodies,
        boundaries,
        solids,
        has_jitter,
        ..
    } = maker;
    let text = format!(
        "(\n    name: \"random\", dimension: {}, spacing: {spacing}, gravity: {},\n    {numerics},\n    bodies: \
         [\n        {}\n    ],\n    boundaries: [\n        {}\n    ],\n)",
        if flat { 2 } else { 3 },
        vector(gravity),
        bodies.join(",\n        "),
        boundaries.join(",\n        ")
    );
    Draft {
        text,
        solids,
        has_jitter,
        fixed_part,
    }
}

/// How the fluid is computed, for speeds of up to so much \[m/s]; and the part of the longest time step, if it is
/// fixed.
fn numerics(mut of: Choices, flat: bool, spacing: f64, speed: f64) -> (String, Option<f64>) {
    let support = of.of(&[2.0, 2.0, 1.7, 2.3, 2.6, 3.0]);
    let sound = 10.0 * speed;
    let variant = of.of(&[
        "",
        "",
        "",
        "momentum: false",
        "recovery: 1",
        "warm_start: 0",
        "max_density_error: 1e-3",
    ]);
    let pressure = match of.of(&[0, 1, 2, 3, 4]) {
        0 => format!("Dfsph({variant})"),
        1 => format!("Iisph({variant})"),
        2 => format!("Pcisph({variant})"),
        3 => format!(
            "Sesph(equation: Tait(stiffness: {}))",
            1000.0 * sound * sound / 7.0
        ),
        _ => format!("Sesph(equation: Gas(stiffness: {}))", sound * sound),
    };
    let (time_step, fixed) = match of.of(&[0, 0, 1, 2, 3]) {
        0 => ("Cfl(min: 1e-9)".to_owned(), None),
        1 => ("Cfl(min: 1e-9, factor: 0.4)".to_owned(), None),
        2 => ("Adaptive(min: 1e-9)".to_owned(), None),
        _ => ("Fixed(1e-9)".to_owned(), Some(0.1 + 0.8 * of.part())),
    };
    let viscosity = match of.of(&[0, 0, 1, 2, 3, 4]) {
        0 => "Laminar(kinematic_viscosity: 1e-6)".to_owned(),
        1 => "None".to_owned(),
        2 => "Laminar(kinematic_viscosity: 1e-6, numerical: 0)".to_owned(),
        // A Reynolds number of the spacing of one.
        3 => format!("Laminar(kinematic_viscosity: {})", speed * spacing),
        _ => format!("Artificial(alpha: 0.1, sound_speed: {sound})"),
    };
    // Of a particle at a flat surface about as much as it would get by falling a spacing in the time of a crossing.
    let pull = of.of(&[0.0, 0.0, 0.0, 0.1, 1.0]) * 0.01 * speed * speed / spacing;
    let tension = if pull > 0.0 {
        let power = if flat { 1 } else { 2 };
        format!(
            "BeckerTeschner(kappa: {})",
            pull * spacing.powi(power) / support
        )
    } else {
        "None".to_owned()
    };
    let handling = of.of(&[
        "Akinci",
        "Akinci",
        "DirectForcing()",
        "DirectForcing(rest_distance: 0.7, slip: 0)",
    ]);
    let structure = of.of(&[
        "CompactHashing",
        "UniformGrid",
        "IndexSort",
        "ZIndexSort",
        "SpatialHashing",
        "BruteForce",
    ]);
    let cell = of.of(&[1.0, 1.0, 0.5, 0.3]);
    let neighbours = of.of(&["Stored", "Recomputed"]);
    let reorder = of.of(&[25, 1, 0, 3]);
    let executor = of.of(&["Auto", "SingleThreaded", "Parallel"]);
    let text = format!(
        "support: {support}, pressure: {pressure}, time_step: {time_step},
    fluid: (viscosity: {viscosity}, surface_tension: {tension}), boundary_handling: {handling},
    index: (structure: {structure}, cell_size: {cell}), neighbours: {neighbours}, reorder_interval: {reorder},
    executor: {executor}"
    );
    (text, fixed)
}

impl Maker<'_> {
    /// A solid in the scene and in the list for the test.
    fn solid(&mut self, text: String, solid: Solid) {
        self.boundaries.push(text);
        self.solids.push(solid);
    }

    /// A mesh, turned by angles \[°] and moved.
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

    /// What all of it is in, if anything.
    fn container(&mut self, mut of: Choices, extent: DVec3) {
        let (min, max) = (self.origin, self.origin + extent);
        let middle = 0.5 * (min + max);
        // Seldom of whole spacings.
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
                // A box without a lid, wound so that fluid is in it.
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
                // A bowl, a thin wall that is wet on both sides.
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

    /// What is in a cell of the grid; the first is never empty.
    fn fill(&mut self, mut of: Choices, cell: DVec3) {
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
                // A plate where it is thin.
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
            _ => {
                let angles = of.vector(false) * 180.0;
                let half = 0.5 * least
                    / if angles == DVec3::ZERO {
                        1.0
                    } else {
                        3f64.sqrt()
                    };
                match of.of(&[0, 1, 2, 3]) {
                    0 => {
                        let block = Surface::block(
                            DVec3::splat(-half).as_vec3(),
                            DVec3::splat(half).as_vec3(),
                        );
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
