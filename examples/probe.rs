//! Queries of a host: pressure, density and velocity at points, neighbours of a point, the row of a particle.
//!
//! `cargo run --release --example probe`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use overfall::{
    Simulation,
    particle::{Density, Pressure, Velocity},
    scene::{BoundaryShape, FluidBody, Scene, Shape},
    step::Densities,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene {
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.5, 0.8, 0.4]))],
        boundaries: vec![BoundaryShape::tank([0.0; 3], [0.5, 1.2, 0.4])],
        ..Scene::new("column", 0.05)
    };
    let mut simulation = Simulation::new(&scene)?;
    simulation.advance(0.05)?;

    // One snapshot for many queries, at depths of 0.2, 0.4 and 0.6 m, and in the air.
    let points = [0.6, 0.4, 0.2, 1.1].map(|y| [0.25, y, 0.2].into());
    let snapshot = simulation.snapshot()?;
    let pressures = snapshot.interpolate::<Pressure>(&points);
    let densities = snapshot.interpolate::<Density>(&points);
    let velocities = snapshot.interpolate::<Velocity>(&points);
    for (k, at) in points.iter().enumerate() {
        match (pressures[k].value, densities[k].value, velocities[k].value) {
            (Some(p), Some(rho), Some(v)) => println!(
                "y = {} m: {:.0} Pa, {:.0} kg/m³, {:.3} m/s, as {} particles say",
                at.y,
                p.0,
                rho.0,
                v.0.length(),
                pressures[k].neighbours
            ),
            _ => println!("y = {} m: no fluid", at.y),
        }
    }

    // From a point to a particle, to its row, to a column of the last step, and back.
    let nearest = simulation.neighbours_of(points[0])?[0];
    let around = simulation.neighbours_of(nearest.particle)?;
    let row = simulation.row_of(nearest.particle).ok_or("no row")?;
    let rho = simulation.world().resource::<Densities>()[row];
    assert_eq!(simulation.entity_of(row), Some(nearest.particle));
    let (particle, distance) = (nearest.particle, nearest.distance);
    println!("{particle} is {distance:.3} m from there, in row {row}, at {rho:.0} kg/m³");
    println!("{} others are around it", around.len());
    Ok(())
}
