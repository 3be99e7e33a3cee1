//! Water in and around triangle meshes: it stands as in the built-in shapes, and passes nothing however thin or sharp.

#[path = "mesh_support/mod.rs"]
mod meshes;
#[path = "physics_support/mod.rs"]
mod support;

use glam::Vec3;
use meshes::{Files, Surface};
use overfall::Simulation;
use overfall::particle::{Fluid, Position, Velocity};
use overfall::step::{FailureCause, StepError};
use support::{measured, particles_of, run, simulation, simulation_of};

const DX: f32 = 0.025;

/// Height of the centre of mass, and of the surface as the mean of the highest particles over the floor's middle [m].
fn heights(water: &mut Simulation) -> (f32, f32) {
    let particles = particles_of(water);
    let mean = particles.iter().map(|p| p.position.y).sum::<f32>() / particles.len() as f32;
    let mut all: Vec<f32> = particles.iter().map(|p| p.position.y).collect();
    all.sort_by(f32::total_cmp);
    let top = &all[all.len() - all.len() / 20..];
    (mean, top.iter().sum::<f32>() / top.len() as f32)
}

#[test]
fn water_in_a_mesh_tank_stands_where_it_stands_in_the_built_in_tank() {
    let files = Files::new();
    let tank = Surface::block(Vec3::ZERO, Vec3::new(0.3, 0.4, 0.25));
    let file = files.put("tank.obj", tank.obj());
    for handling in ["Akinci", "DirectForcing(())"] {
        let found = [
            "Tank((min: (0, 0, 0), max: (0.3, 0.4, 0.25)))".replace("((", "(").replace("))", ")"),
            format!("Mesh((file: {file:?}, side: Inside))"),
        ]
        .map(|boundary| {
            let mut water = simulation(&format!(
                "(name: \"rest\", spacing: {DX}, boundary_handling: {handling}, boundaries: [{boundary}],
                  bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.25, 0.25)))])"
            ));
            let first = water.step().expect("a step");
            let (mut error, mut speed, mut energy) = (0.0_f32, 0.0_f32, 0.0_f64);
            let density = particles_of(&mut water).iter().map(|p| p.density).fold(0.0, f32::max);
            run(&mut water, 1.0, |_, report| {
                error = error.max(report.max_density_error);
                if report.time > 0.5 {
                    speed = speed.max(report.max_speed);
                    energy = energy.max(report.kinetic_energy);
                }
            });
            let (mean, top) = heights(&mut water);
            let least = particles_of(&mut water)
                .iter()
                .map(|p| p.position.min(Vec3::new(0.3, 0.4, 0.25) - p.position).min_element())
                .fold(f32::INFINITY, f32::min);
            let floor: Vec<f32> = particles_of(&mut water).iter().map(|p| p.position.y).filter(|y| *y < DX).collect();
            measured(&format!(
                "{handling} {}: first error {:.4} density {density}, mean {:.4} top {:.4} dx, worst error {error:.4}, late speed {speed:.4} energy {energy:.2e}, least {:.3} dx, floor {:.3}",
                &boundary[..4],
                first.max_density_error, mean / DX, top / DX, least / DX, floor.iter().sum::<f32>() / floor.len() as f32 / DX,
            ));
            (mean, top)
        });
        assert!((found[0].0 - found[1].0).abs() < 0.1 * DX, "{found:?}");
    }
}

/// Where particles may be: distance [m] from the solid, negative in it.
type Distance<'a> = &'a dyn Fn(Vec3) -> f32;

fn block_distance(min: Vec3, max: Vec3) -> impl Fn(Vec3) -> f32 {
    move |x| {
        let over = (min - x).max(x - max);
        over.max(Vec3::ZERO).length() + over.max_element().min(0.0)
    }
}

/// Fires lone particles at targets from both sides and all around, and says how deep one got, in spacings, and which
/// ended on the other side of the plane through `target`.
fn fire(what: &str, boundaries: &str, targets: &[(Vec3, Vec3)], distance: Distance, crossed: &dyn Fn(Vec3, Vec3) -> bool) -> f32 {
    let dt = 1e-3;
    let mut least = f32::INFINITY;
    let mut leaks = Vec::new();
    let mut shots = 0;
    let text = format!(
        "(name: \"jet\", spacing: {DX}, gravity: (0, 0, 0), time_step: Fixed({dt}), fluid: (viscosity: None),
          bodies: [(shape: Box(min: (3, 3, 3), max: (3.03, 3.03, 3.03)))], {boundaries})"
    );
    let mut jet = simulation_of(&text, &[]);
    for speed in [0.1, 0.4, 0.49] {
        for &(target, normal) in targets {
            let (u, v) = normal.any_orthonormal_pair();
            for (k, tilt) in [0.0_f32, 0.3, 0.3, 0.7, 0.7, 1.2, 1.2].into_iter().enumerate() {
                let turn = 0.4 + 2.4 * k as f32;
                let across = turn.cos() * u + turn.sin() * v;
                let direction = (-normal * tilt.cos() + across * tilt.sin()).normalize();
                let way = (2.1 + 0.13 * k as f32) * DX;
                let start = target - way * direction;
                if distance(start) < 0.5 * DX { continue; }
                for particle in particles_of(&mut jet) {
                    jet.world_mut().despawn(particle.entity);
                }
                let velocity = speed * 2.0 * DX / dt * direction;
                jet.world_mut().spawn((Fluid, Position(start), Velocity(velocity)));
                shots += 1;
                for _ in 0..14 {
                    match jet.step() {
                        Ok(_) => {}
                        Err(StepError { cause: FailureCause::TooFast { .. }, .. }) if speed > 0.45 => break,
                        Err(error) => panic!("the step failed: {error}"),
                    }
                    let x = particles_of(&mut jet)[0].position;
                    least = least.min(distance(x) / DX);
                    if crossed(start, x) {
                        leaks.push(format!("{speed} from {start} with {direction} is at {x}"));
                        break;
                    }
                }
            }
        }
    }
    measured(&format!("{what}: {shots} shots, least distance {least:.3} dx, {} leaks", leaks.len()));
    if let Some(leak) = leaks.first() { measured(leak); }
    least
}

#[test]
fn shots() {
    let files = Files::new();
    for handling in ["Akinci", "DirectForcing(())"] {
        for thickness in [0.0, 0.001, 0.2, 0.8, 1.1, 1.3, 1.8, 3.0] {
            let max = Vec3::new(0.31, thickness * DX, 0.27);
            let (plate, side) = if thickness == 0.0 {
                let mut sheet = Surface::block(Vec3::ZERO, max);
                sheet.faces.drain(..3);
                sheet.faces.drain(1..);
                (sheet, "Both")
            } else {
                (Surface::block(Vec3::ZERO, max), "Outside")
            };
            let file = files.put(&format!("plate{thickness}.obj"), plate.obj());
            let mut targets = Vec::new();
            for k in 0..6 {
                let at = Vec3::new(0.06 + 0.033 * k as f32, 0.0, 0.05 + 0.029 * k as f32);
                targets.push((at.with_y(max.y), Vec3::Y));
                targets.push((at, Vec3::NEG_Y));
            }
            let distance = block_distance(Vec3::ZERO, max);
            let middle = 0.5 * max.y;
            let crossed = |start: Vec3, x: Vec3| {
                let over = x.x > 0.0 && x.x < max.x && x.z > 0.0 && x.z < max.z;
                over && (start.y > middle) != (x.y > middle) && (x.y - middle).abs() < 4.0 * DX
            };
            fire(
                &format!("{handling} plate of {thickness} dx"),
                &format!("boundary_handling: {handling}, boundaries: [Mesh((file: {file:?}, side: {side}))]"),
                &targets,
                &distance,
                &crossed,
            );
        }
    }
}

#[test]
fn groove() {
    let files = Files::new();
    // A valley of 30°, its apex at the origin, and its lid.
    let (sin, cos) = 15f32.to_radians().sin_cos();
    let half = 0.5 * sin / cos;
    let valley = Surface::prism(&[(0.0, 0.0), (half, 0.5), (-half, 0.5)], 0.2);
    let file = files.put("valley.obj", valley.obj());
    for handling in ["Akinci", "DirectForcing(())"] {
        let mut water = simulation(&format!(
            "(name: \"valley\", spacing: 0.0125, boundary_handling: {handling},
              boundaries: [Mesh((file: {file:?}, side: Inside))],
              bodies: [(shape: Box(min: (-0.05, 0.25, 0), max: (0.05, 0.4, 0.2)))])"
        ));
        let mut least = f32::INFINITY;
        let count = particles_of(&mut water).len();
        run(&mut water, 1.0, |water, _| {
            for p in particles_of(water) {
                let x = p.position;
                let side = (sin * x.y - cos * x.x).min(sin * x.y + cos * x.x);
                least = least.min(side.min(x.z).min(0.2 - x.z).min(0.5 - x.y) / 0.0125);
            }
        });
        let lowest = particles_of(&mut water).iter().map(|p| p.position.y).fold(f32::INFINITY, f32::min);
        let (mean, top) = heights(&mut water);
        // The area under the surface of a triangle of half angle 15°: y² tan 15°.
        let volume = count as f32 * 0.0125f32.powi(3) / 0.2;
        let ideal = (volume / (sin / cos)).sqrt();
        measured(&format!("{handling} valley: {count}, least {least:.3} dx, lowest {lowest:.4} mean {mean:.4} top {top:.4}, ideal surface {ideal:.4}"));
    }
}
