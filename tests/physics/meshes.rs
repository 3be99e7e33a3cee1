//! Water in and around triangle meshes: it rests as in the built-in shapes, and passes through no mesh, however thin or
//! sharp.

use glam::{EulerRot, Quat, Vec3};
use overfall::Simulation;

use crate::mesh_support::{Files, Surface};
use crate::support::{measured, particles_of, run, simulation, simulation_of, step};

pub(super) const DX: f32 = 0.025;

/// Height of the centre of mass, and of the surface as the mean of the highest particles over the floor's middle \[m].
fn heights(water: &mut Simulation) -> (f32, f32) {
    let particles = particles_of(water);
    let mean = particles.iter().map(|p| p.position.y).sum::<f32>() / particles.len() as f32;
    let mut all: Vec<f32> = particles.iter().map(|p| p.position.y).collect();
    all.sort_by(f32::total_cmp);
    let top = &all[all.len() - all.len() / 20..];
    (mean, top.iter().sum::<f32>() / top.len() as f32)
}

const HANDLINGS: [&str; 2] = ["Akinci", "DirectForcing(())"];

#[test]
fn water_in_a_mesh_tank_stands_where_it_stands_in_the_built_in_tank() {
    let files = Files::new();
    let max = Vec3::new(0.3, 0.35, 0.25);
    let file = files.put("tank.obj", Surface::block(Vec3::ZERO, max).obj());
    for handling in HANDLINGS {
        let boundaries = [
            "Tank(min: (0, 0, 0), max: (0.3, 0.35, 0.25))".to_owned(),
            format!("Mesh((file: {file:?}, side: Inside))"),
        ];
        let found = boundaries.map(|boundary| {
            let mut water = simulation(&format!(
                "(name: \"rest\", spacing: {DX}, boundary_handling: {handling}, boundaries: [{boundary}],
                  bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.25, 0.25)))])"
            ));
            step(&mut water);
            let densest = particles_of(&mut water).iter().map(|p| p.density).fold(0.0, f32::max);
            let (mut error, mut speed) = (0.0_f32, 0.0_f32);
            run(&mut water, 0.6, |_, report| {
                error = error.max(report.max_density_error);
                if report.time > 0.4 {
                    speed = speed.max(report.max_speed);
                }
            });
            let (mean, top) = heights(&mut water);
            let (mean, top) = (mean / DX, top / DX);
            let particles = particles_of(&mut water);
            let least = particles.iter().map(|p| p.position.min(max - p.position).min_element());
            let least = least.fold(f32::INFINITY, f32::min) / DX;
            let bottom: Vec<f32> = particles.iter().map(|p| p.position.y).filter(|y| *y < DX).collect();
            let bottom = bottom.iter().sum::<f32>() / bottom.len() as f32 / DX;
            let figures = format!(
                "{handling} {}: densest at the start {densest:.1} kg/m³, centre at {mean:.3}, surface at {top:.3}, \
                 lowest layer at {bottom:.3}, nearest to a wall {least:.3} spacings; density error to {error:.4}, up \
                 to {speed:.3} m/s after 0.4 s",
                &boundary[..4]
            );
            measured(&figures);
            // Compression at a corner at the start is removed over many steps, a tenth of it in each.
            assert!(densest < 1035.0 && error < 0.065 && least > -0.26, "{figures}");
            (mean, top, bottom)
        });
        let [built_in, mesh] = found;
        assert!((built_in.0 - mesh.0).abs() < 0.2, "{handling}: {found:?}");
        assert!((built_in.1 - mesh.1).abs() < 0.35, "{handling}: {found:?}");
        assert!((built_in.2 - mesh.2).abs() < 0.2, "{handling}: {found:?}");
    }
}

/// Region where particles may be: distance \[m] from the solid, negative inside it.
pub(super) type Distance<'a> = &'a dyn Fn(Vec3) -> f32;

/// A closed surface with fluid in it.
struct Vessel<'a> {
    name: &'a str,
    surface: Surface,
    /// Corners of the fluid's box.
    body: &'a str,
    /// Distance from the solid, except for the ends along z.
    distance: Distance<'a>,
    /// Height of the surface \[m] at rest, for a number of particles.
    level: &'a dyn Fn(usize) -> f32,
}

/// A valley of 30°, and a tank with a corner that projects into the water.
#[test]
fn sharp_and_jutting_corners_hold_water() {
    const DX: f32 = 0.0125;
    let files = Files::new();
    let (sin, cos) = 15f32.to_radians().sin_cos();
    let half = 0.5 * sin / cos;
    let valley = Surface::prism(&[(0.0, 0.0), (half, 0.5), (-half, 0.5)], 0.1);
    let corner = Surface::prism(
        &[
            (0.1, 0.1),
            (0.1, 0.3),
            (0.0, 0.3),
            (0.0, 0.0),
            (0.3, 0.0),
            (0.3, 0.1),
        ],
        0.1,
    );
    let in_valley = |x: Vec3| (sin * x.y - cos * x.x.abs()).min(0.5 - x.y);
    let in_corner = |x: Vec3| {
        let leg = x.x.min(0.1 - x.x).min(x.y).min(0.3 - x.y);
        leg.max(x.x.min(0.3 - x.x).min(x.y).min(0.1 - x.y))
    };
    // Height of the surface above the apex: y² tan 15° is the area of the water's section; in the other case it is
    // flat.
    let deep = |count: usize| (count as f32 * DX.powi(3) / 0.1 / (sin / cos)).sqrt();
    let flat = |count: usize| count as f32 * DX.powi(3) / 0.1 / 0.3;
    let vessels = [
        Vessel {
            name: "valley",
            surface: valley,
            body: "(-0.05, 0.25, 0), max: (0.05, 0.4, 0.1)",
            distance: &in_valley,
            level: &deep,
        },
        Vessel {
            name: "corner",
            surface: corner,
            body: "(0, 0, 0), max: (0.1, 0.2, 0.1)",
            distance: &in_corner,
            level: &flat,
        },
    ];
    for handling in HANDLINGS {
        for vessel in &vessels {
            let Vessel { name, body, .. } = vessel;
            let file = files.put("vessel.obj", vessel.surface.obj());
            let mut water = simulation(&format!(
                "(name: \"vessel\", spacing: {DX}, boundary_handling: {handling},
                  boundaries: [Mesh((file: {file:?}, side: Inside))],
                  bodies: [(shape: Box(min: {body}))])"
            ));
            let mut least = f32::INFINITY;
            run(&mut water, 1.2, |water, _| {
                for particle in particles_of(water) {
                    let x = particle.position;
                    least = least.min((vessel.distance)(x).min(x.z).min(0.1 - x.z) / DX);
                }
            });
            let particles = particles_of(&mut water);
            let ideal = (vessel.level)(particles.len());
            let over = particles
                .iter()
                .filter(|p| p.position.y > ideal + DX)
                .count();
            let lowest = particles
                .iter()
                .map(|p| p.position.y)
                .fold(f32::INFINITY, f32::min);
            let (_, top) = heights(&mut water);
            let figures = format!(
                "{handling}, {name}: {} particles, least distance {least:.3} spacings, lowest at {:.2}, highest \
                 twentieth at {:.2}, a full vessel's surface at {:.2}, {over} more than one over it",
                particles.len(),
                lowest / DX,
                top / DX,
                ideal / DX
            );
            measured(&figures);
            assert!(least > -0.36, "{figures}");
            assert!(lowest < 2.0 * DX && top < ideal + 2.0 * DX, "{figures}");
        }
    }
}

/// Water is pressed into the edge of a wedge of 9° to 33° in various orientations: none escapes through a face, through
/// the edge, or where the edge meets the ends.
#[test]
fn acute_wedges_hold_water_whichever_way_they_lie() {
    const DX: f32 = 0.02;
    let files = Files::new();
    let methods = [
        "Pcisph(())",
        "Iisph(())",
        "Dfsph(())",
        "Sesph((equation: Tait(stiffness: 50000)))",
    ];
    for case in 0..8 {
        let angle = (9.0 + 3.4 * case as f32).to_radians();
        let (sin, cos) = angle.sin_cos();
        let tilt = if case < 4 { 0.0 } else { case as f32 };
        let turn = Quat::from_euler(EulerRot::XYZ, tilt, 0.3 * tilt, 1.1 * tilt);
        let mut wedge = Surface::prism(&[(0.0, 0.0), (0.5, 0.0), (0.5, 0.5 * sin / cos)], 0.2);
        wedge.vertices.iter_mut().for_each(|x| *x = turn * *x);
        let file = files.put("wedge.obj", wedge.obj());
        let (drop, gravity) = (
            turn * Vec3::new(0.46, 0.03, 0.1),
            turn * Vec3::new(-9.81, 0.0, 0.0),
        );
        let pressure = methods[case % 4];
        let text = format!(
            "(name: \"wedge\", spacing: {DX}, pressure: {pressure}, gravity: ({}, {}, {}),
              boundaries: [Mesh((file: {file:?}, side: Inside))],
              bodies: [(shape: Sphere(center: ({}, {}, {}), radius: 0.018))])",
            gravity.x, gravity.y, gravity.z, drop.x, drop.y, drop.z
        );
        let places = (0..25 * 5 * 10)
            .map(|k| Vec3::new((k % 25) as f32, (k / 25 % 5) as f32, (k / 125) as f32));
        let places = places.map(|place| (place + 0.5) * DX);
        let within = places.filter(|x| sin * x.x - cos * x.y > 0.5 * DX);
        let particles: Vec<_> = within.map(|x| (turn * x, Vec3::ZERO)).collect();
        let mut water = simulation_of(&text, &particles);
        let mut least = f32::INFINITY;
        run(&mut water, 0.6, |water, _| {
            for particle in particles_of(water) {
                let x = turn.inverse() * particle.position;
                let faces = [x.y, sin * x.x - cos * x.y, 0.5 - x.x, x.z, 0.2 - x.z, x.x];
                least = faces
                    .map(|distance| distance / DX)
                    .into_iter()
                    .fold(least, f32::min);
            }
        });
        let figures = format!(
            "{:.1}°, {pressure}: {} particles, least distance {least:.3} spacings",
            angle.to_degrees(),
            particles.len()
        );
        measured(&figures);
        assert!(least > -0.36, "{figures}");
    }
}

/// A box without lid whose triangles do not share vertices: coordinates differ by less than 1/100 spacing, and the
/// sides and the floor have different vertices along their common edge. No water escapes through the seams.
#[test]
fn seams_hold_water() {
    const DX: f32 = 0.04;
    let files = Files::new();
    let mut random = 5_u64;
    let mut unit = || {
        random = next_random(random);
        (random >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    for (off, strips) in [
        (1e-6, [1, 1, 1, 1]),
        (1e-4, [1, 1, 1, 1]),
        (4e-5, [3, 2, 7, 1]),
    ] {
        let mut triangles: Vec<[Vec3; 3]> = Vec::new();
        let mut strip = |from: Vec3, along: Vec3, across: Vec3, count: usize| {
            for k in 0..count {
                let [a, b] = [k, k + 1].map(|k| from + along * k as f32 / count as f32);
                triangles.extend([[a, b, b + across], [a, b + across, a + across]]);
            }
        };
        for k in 0..5 {
            strip(
                Vec3::new(0.08 * k as f32, 0.0, 0.0),
                0.4 * Vec3::Z,
                0.08 * Vec3::X,
                5,
            );
        }
        let corners =
            [(0.0, 0.0), (0.4, 0.0), (0.4, 0.4), (0.0, 0.4)].map(|(x, z)| Vec3::new(x, 0.0, z));
        for (k, count) in strips.into_iter().enumerate() {
            strip(
                corners[k],
                corners[(k + 1) % 4] - corners[k],
                0.4 * Vec3::Y,
                count,
            );
        }
        let mut surface = Surface::default();
        let middle = Vec3::splat(0.2);
        for [a, b, c] in triangles {
            let faces_in = (b - a).cross(c - a).dot(middle - a) > 0.0;
            let first = surface.vertices.len();
            for x in if faces_in { [a, b, c] } else { [a, c, b] } {
                surface
                    .vertices
                    .push(x + off * Vec3::new(unit(), unit(), unit()));
            }
            surface.faces.push(vec![first, first + 1, first + 2]);
        }
        let file = files.put("seams.obj", surface.obj());
        let mut water = simulation(&format!(
            "(name: \"seams\", spacing: {DX}, boundaries: [Mesh((file: {file:?}, side: Front))],
              bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.28, 0.4)))])"
        ));
        let mut least = f32::INFINITY;
        run(&mut water, 0.5, |water, _| {
            for particle in particles_of(water) {
                let x = particle.position;
                let sides = x.min(0.4 - x);
                least = least.min(sides.x.min(sides.z).min(x.y) / DX);
            }
        });
        let figures =
            format!("seams off by {off} m, {strips:?}: least distance {least:.3} spacings");
        measured(&figures);
        assert!(least > -0.36, "{figures}");
    }
}

fn next_random(state: u64) -> u64 {
    state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407)
}

/// A sheet in the middle of a tank holds a column on one side.
#[test]
fn a_sheet_keeps_water_on_its_side() {
    let files = Files::new();
    let mut sheet = Surface::block(Vec3::ZERO, Vec3::new(0.25, 0.5, 0.2));
    // Its side towards +x, extending slightly into the tank's walls.
    sheet
        .vertices
        .iter_mut()
        .for_each(|x| x.z = 1.1 * x.z - 0.01);
    sheet.faces = vec![sheet.faces.swap_remove(1)];
    let file = files.put("sheet.obj", sheet.obj());
    for handling in HANDLINGS {
        let mut water = simulation(&format!(
            "(name: \"dam\", spacing: {DX}, boundary_handling: {handling},
              boundaries: [
                Tank(min: (0, 0, 0), max: (0.5, 0.5, 0.2)), Mesh((file: {file:?}, side: Both)),
              ],
              bodies: [(shape: Box(min: (0, 0, 0), max: (0.225, 0.3, 0.2)))])"
        ));
        let (mut nearest, mut below) = (f32::INFINITY, 0.0_f32);
        run(&mut water, 0.6, |water, _| {
            for particle in particles_of(water) {
                nearest = nearest.min(0.25 - particle.position.x);
                below = below.max(-particle.position.y);
            }
        });
        let figures = format!(
            "{handling}: nearest to the sheet {:.3} spacings",
            nearest / DX
        );
        measured(&figures);
        assert!(nearest > 0.25 * DX && below < 0.26 * DX, "{figures}");
    }
}
