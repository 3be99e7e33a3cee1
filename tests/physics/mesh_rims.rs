//! Rims of thin mesh walls: water beside and above them starts at rest, and none passes through them.

use crate::mesh_support::{Files, Surface};
use crate::support::{METHODS, measured, particles_of, simulation, step};
use glam::Vec3;
use overfall::{Simulation, scene::Scene};

const DX: f32 = 0.02;

/// Largest density error at the start \[-].
fn start(text: &str) -> Result<f32, String> {
    let scene = Scene::parse(text, "rim.ron", &[]).map_err(|error| error.to_string())?;
    let plan = overfall::plan(&scene).map_err(|error| error.to_string())?;
    Ok(plan.start_density.expect("few particles").max_error)
}

fn scene(bodies: &str, boundaries: &str, rest: &str) -> String {
    format!("(name: \"rim\", spacing: {DX}, {rest} bodies: [{bodies}], boundaries: [{boundaries}])")
}

/// A plate of every thickness between two bodies that are higher and wider than it, upright and turned: its edges and
/// corners are in the water. Plates thinner than 1.2 spacings are treated as 1.2 spacings thick.
#[test]
fn water_beside_rims_of_every_thickness_starts_at_rest() {
    let files = Files::new();
    let (mut worst, mut refused, mut faults) = (0.0_f32, 0, Vec::<String>::new());
    for thickness in [
        0.05, 0.3, 0.6, 0.9, 1.1, 1.2, 1.25, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 2.0, 2.3, 2.6, 3.0, 3.7,
    ] {
        let room = f32::max(thickness, 1.25) * DX;
        for end in [0.1, 0.107, 0.2] {
            let aside = 0.2 + 0.5 * (room - thickness * DX);
            let (min, max) = (
                Vec3::new(aside, -0.05, -0.05),
                Vec3::new(aside + thickness * DX, end, end),
            );
            let file = files.put("plate.obj", Surface::block(min, max).obj());
            let bodies = format!(
                "(shape: Box(min: (0, 0, 0), max: (0.2, 0.2, 0.2))),
                (shape: Box(min: ({}, 0, 0), max: ({}, 0.2, 0.2)))",
                0.2 + room,
                0.4 + room
            );
            let text = scene(&bodies, &format!("Mesh(file: {file:?})"), "");
            match start(&text) {
                Ok(error) if error < 0.05 => worst = worst.max(error),
                // A thinner one may be too near at a rim with which no row of the lattice is aligned.
                Err(error) if thickness < 1.2 && error.contains("thinner than 1.2") => refused += 1,
                wrong => {
                    faults.push(format!(
                        "{thickness} spacings thick, up to {end} m: {wrong:?}"
                    ));
                }
            }
        }
    }
    measured(&format!("largest density error beside a rim: {worst:.4}"));
    assert!(
        faults.is_empty(),
        "{}",
        faults.join(
            "
"
        )
    );
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(refused < 3, "{refused} thin plates are refused");
}

/// Positions of all particles, in a fixed order.
fn places(simulation: &mut Simulation) -> Vec<Vec3> {
    let mut particles = particles_of(simulation);
    particles.sort_by_key(|particle| particle.entity);
    particles.iter().map(|particle| particle.position).collect()
}

/// Bowls with walls of every thickness, closed and as open shells, whose rims are below water that falls into them: a
/// particle that is inside the wall or passes from one side to the other has penetrated it.
#[test]
fn no_water_passes_thin_walls_beside_their_rims() {
    let files = Files::new();
    let [.., method] = METHODS;
    for (thickness, side) in [
        (0.4, "Outside"),
        (0.8, "Outside"),
        (1.25, "Outside"),
        (1.5, "Outside"),
        (0.0, "Both"),
        (0.0, "Front"),
    ] {
        let (inner, height) = (0.12_f32, 0.12_f32);
        let outer = inner + thickness * DX;
        let cup: Vec<(f32, f32)> = if side == "Outside" {
            vec![
                (0.0, -0.06),
                (outer, -0.06),
                (outer, height),
                (inner, height),
                (inner, 0.0),
                (0.0, 0.0),
            ]
        } else {
            // The inside of the bowl is the front.
            vec![(inner, height), (inner, 0.0), (0.0, 0.0)]
        };
        let cup = Surface::turned(&cup, 24);
        let file = files.put("cup.obj", cup.obj());
        let bodies = "(shape: Cylinder(start: (0, 0.02, 0), end: (0, 0.2, 0), radius: 0.085), velocity: (1.5, -1, \
         0.3))";
        let rest = format!(
            "time_step: Cfl(max: 0.002), pressure: {},",
            (method.pressure)(20.0)
        );
        let mut simulation = simulation(&scene(
            bodies,
            &format!("Mesh(file: {file:?}, side: {side})"),
            &rest,
        ));
        let mut before = places(&mut simulation);
        let inscribed = inner * (std::f32::consts::PI / 24.0).cos();
        let mut over = 0;
        for _ in 0..150 {
            step(&mut simulation);
            let after = places(&mut simulation);
            for (from, to) in before.iter().zip(&after) {
                let radius = |x: &Vec3| x.x.hypot(x.z);
                // Well below the rim, so that no particle passes around it in one step.
                let is_low = |x: &Vec3| x.y < height - 1.0 * DX && x.y > 0.5 * DX;
                let from_within = radius(from) < inscribed + 0.3 * DX;
                let is_without = radius(to) > inner + 0.5 * DX;
                over += usize::from(to.y > height && is_without);
                assert!(
                    !(is_low(from) && is_low(to) && from_within && is_without),
                    "{side}, {thickness} spacings: from {from} to {to}"
                );
                assert!(
                    !(from_within && from.y > 0.0 && to.y < -0.5 * DX && radius(to) < inner),
                    "{side}, {thickness} spacings: from {from} through the floor to {to}"
                );
            }
            before = after;
        }
        assert!(
            over > 0,
            "{side}, {thickness} spacings: no water came to the rim"
        );
    }
}
