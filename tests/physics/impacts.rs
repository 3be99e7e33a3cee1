//! Blocks of water that fall flat onto a wall. An incompressible fluid that fills its shaft stops at once and keeps
//! none of its energy; in no case may it gain energy, nor move faster than it fell and its own weight can drive it.

use overfall::Simulation;

use crate::support::{measured, simulation};

const G: f64 = 9.81;

/// A block, and the way it falls.
struct Flat {
    name: &'static str,
    scene: String,
    /// Height that the block falls through, and its own along that way \[m].
    fall: f64,
    depth: f64,
    /// Whether it fills its shaft.
    fills: bool,
}

/// Blocks of 0.4 m in shafts that they fill or not, in three directions.
fn blocks(dimension: u32, spacing: f64) -> Vec<Flat> {
    let deep = if dimension == 2 { 0.0 } else { 0.24 };
    let scene = |body: [f64; 4], tank: [f64; 2], gravity: &str| {
        let [x0, y0, x1, y1] = body;
        let [width, height] = tank;
        format!(
            "(name: \"flat\", dimension: {dimension}, spacing: {spacing}, gravity: {gravity},
              bodies: [(shape: Box(min: ({x0}, {y0}, 0), max: ({x1}, {y1}, {deep})))],
              boundaries: [Tank(min: (0, 0, 0), max: ({width}, {height}, {deep}))])"
        )
    };
    let down = "(0, -9.81, 0)";
    let (long, wide) = if dimension == 2 {
        (0.4, 0.48)
    } else {
        (0.24, 0.24)
    };
    vec![
        Flat {
            name: "down",
            scene: scene([0.0, 0.2, wide, 0.2 + long], [wide, 0.8], down),
            fall: 0.2,
            depth: long,
            fills: true,
        },
        Flat {
            name: "up",
            scene: scene([0.0, 0.0, wide, long], [wide, 0.6], "(0, 9.81, 0)"),
            fall: 0.6 - long,
            depth: long,
            fills: true,
        },
        Flat {
            name: "sideways",
            scene: scene([0.0, 0.0, wide, long], [wide + 0.28, long], "(9.81, 0, 0)"),
            fall: 0.28,
            depth: wide,
            fills: true,
        },
        Flat {
            name: "narrow",
            scene: scene(
                [0.12, 0.2, 0.12 + long, 0.2 + long],
                [long + 0.24, 0.8],
                down,
            ),
            fall: 0.2,
            depth: long,
            fills: false,
        },
    ]
}

/// Lets a block fall until a tenth of a second after it met its wall. Returns the energy that it gained, of what it
/// had, and its largest speed over that of free fall through its own depth, too.
fn fall(block: &Flat, settings: &str) -> (f64, f64) {
    let text = block
        .scene
        .replacen("dimension", &format!("{settings} dimension"), 1);
    let mut simulation: Simulation = simulation(&text);
    let end = (2.0 * block.fall / G).sqrt() + 0.1;
    let (mut lowest, mut gained, mut fastest) = (f64::INFINITY, 0.0_f64, 0.0_f64);
    let mut mass_g = 0.0;
    loop {
        let report =
            (simulation.step()).unwrap_or_else(|e| panic!("{} {settings}: {e}", block.name));
        let energy = report.kinetic_energy + report.potential_energy;
        if mass_g == 0.0 {
            mass_g = report.kinetic_energy / (0.5 * (G * report.time).powi(2)) * G;
        }
        lowest = lowest.min(energy);
        gained = gained.max(energy - lowest);
        fastest = fastest.max(report.max_speed.into());
        if report.time > end {
            break;
        }
    }
    let scale = mass_g * (block.fall + block.depth);
    let speed = (2.0 * G * (block.fall + block.depth)).sqrt();
    measured(&format!(
        "{} {settings}: gained {:.4}, fastest {:.2}",
        block.name,
        gained / scale,
        fastest / speed
    ));
    (gained / scale, fastest / speed)
}

/// Checks energy and speed of a block.
fn falls(block: &Flat, settings: &str) {
    let (gained, fastest) = fall(block, settings);
    // What is compressed while the lowest rows meet their wall springs back; ten rows have the most of it. PCISPH
    // removes it by the step and not in a time, since its columns gain energy otherwise: what can spread springs back
    // further.
    let most = if settings.contains("Pcisph") && !block.fills {
        0.12
    } else {
        0.05
    };
    assert!(gained < most, "{} {settings}: {gained}", block.name);
    // Single particles are squeezed out of the rows that meet. A block that can spread squeezes out its lowest row, the
    // faster the nearer it is to the floor.
    assert!(
        !block.fills || fastest < 1.5,
        "{} {settings}: {fastest}",
        block.name
    );
}

#[test]
fn a_block_that_falls_flat_gains_no_energy() {
    for (dimension, spacing) in [(2, 0.04), (2, 0.02), (3, 0.04)] {
        for block in blocks(dimension, spacing) {
            for method in ["Pcisph()", "Iisph()", "Dfsph()"] {
                falls(&block, &format!("pressure: {method},"));
            }
        }
    }
}

#[test]
fn nor_with_other_steps_walls_and_viscosities() {
    for settings in [
        "time_step: Adaptive(()),",
        "time_step: Fixed(0.001),",
        "boundary_handling: Akinci,",
        "fluid: (viscosity: None),",
        "pressure: Dfsph(stabilisation: 0.3),",
        "pressure: Dfsph(momentum: false),",
    ] {
        for block in blocks(2, 0.02) {
            falls(&block, settings);
        }
    }
}

/// The solve after the impact starts from its pressures, and its steps are too short for densities to show that they
/// throw the block back.
#[test]
fn a_deep_block_does_not_spring_back() {
    for (width, rows) in [(0.4, 40.0), (1.6, 80.0)] {
        let spacing = 0.02;
        let depth = rows * spacing;
        let block = Flat {
            name: "deep",
            scene: format!(
                "(name: \"deep\", dimension: 2, spacing: {spacing},
                  bodies: [(shape: Box(min: (0, 0.4, 0), max: ({width}, {}, 0)))],
                  boundaries: [Tank(min: (0, 0, 0), max: ({width}, {}, 0))])",
                depth + 0.4,
                depth + 0.6,
            ),
            fall: 0.4,
            depth,
            fills: true,
        };
        for settings in ["", "pressure: Pcisph(()),", "time_step: Cfl(factor: 0.1),"] {
            let (gained, _) = fall(&block, settings);
            assert!(gained < 0.02, "{width} m, {settings}: {gained}");
        }
    }
}
