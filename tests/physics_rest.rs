//! Fluid at rest: the density of a lattice. Still water is among the known answers, `validation.rs`.

#[path = "physics_support/mod.rs"]
mod support;

use support::{Particle, measured, particles_of, simulation, step};

/// Densities over the rest density of the lattice of `text`, with how many walls of the tank 0–`size` m are
/// `spacing` m or nearer.
fn lattice_densities(text: &str, spacing: f32, size: f32, axes: usize) -> Vec<(usize, f32)> {
    let mut simulation = simulation(text);
    let start: Vec<Particle> = particles_of(&mut simulation);
    step(&mut simulation);
    let after = particles_of(&mut simulation);
    start
        .iter()
        .zip(after)
        .map(|(start, after)| {
            assert_eq!(start.entity, after.entity);
            let near = start.position.to_array()[..axes]
                .iter()
                .filter(|x| **x < spacing || **x > size - spacing)
                .count();
            (near, after.density / 1000.0)
        })
        .collect()
}

/// Smallest and largest density of the particles near `walls` walls.
fn range(densities: &[(usize, f32)], walls: usize) -> (f32, f32) {
    let chosen = densities.iter().filter(|(near, _)| *near == walls);
    let range = chosen.fold((f32::INFINITY, 0.0_f32), |(low, high), (_, rho)| {
        (low.min(*rho), high.max(*rho))
    });
    assert!(range.1 > 0.0, "no particle is near {walls} walls");
    range
}

/// A tank that the lattice fills.
fn full_tank(dimension: u32) -> String {
    let depth = if dimension == 2 { "0" } else { "1" };
    format!(
        "(name: \"full\", dimension: {dimension}, spacing: 0.1, gravity: (0, 0, 0), time_step: Fixed(1e-4),
          reorder_interval: 0, limits: (compression: 0.9),
          pressure: Sesph((equation: Gas(stiffness: 1e-3))),
          bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, {depth})))],
          boundaries: [Tank(min: (0, 0, 0), max: (1, 1, {depth}))])"
    )
}

/// The mass is defined by the density of the lattice (Σ m W = ρ0), so only rounding is left: 1e-4 is a hundred times
/// what the sum of 33 terms loses in f32.
#[test]
fn lattice_at_rest_has_the_rest_density_in_the_interior() {
    for dimension in [2, 3] {
        let densities = lattice_densities(&full_tank(dimension), 0.1, 1.0, dimension as usize);
        let (low, high) = range(&densities, 0);
        measured(&format!("{dimension}-D interior: {low:.6}–{high:.6} ρ0"));
        assert!((low - 1.0).abs() < 1e-4 && (high - 1.0).abs() < 1e-4);
    }
}

/// The volumes of boundary particles are calibrated on an infinite flat wall; a face that ends in edges differs by what
/// the volumes there lose. In edges and corners a lattice may start a few per cent under its rest density (it then feels
/// no pressure), but if it started over it, the wall would throw it off.
#[test]
fn lattice_at_a_wall_has_the_rest_density() {
    for dimension in [2, 3] {
        let densities = lattice_densities(&full_tank(dimension), 0.1, 1.0, dimension as usize);
        for walls in 1..=dimension as usize {
            let (low, high) = range(&densities, walls);
            measured(&format!(
                "{dimension}-D, {walls} walls: {low:.4}–{high:.4} ρ0"
            ));
            let tolerance = if walls == 1 { 0.01 } else { 0.05 };
            assert!(
                (low - 1.0).abs() < tolerance && high < 1.01,
                "{dimension}-D, {walls} walls: {low}–{high}"
            );
        }
    }
}
