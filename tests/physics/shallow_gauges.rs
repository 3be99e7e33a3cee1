//! Gauges in shallow layers over a floor: `ρ g h` within half a spacing's worth, and nothing where there is no fluid.

use overfall::{Simulation, gauge::Gauges};

use super::gauges::{scene, value};

const SPACING: f64 = 0.02;
/// Weight of a spacing of water \[Pa].
const ROW: f64 = 1000.0 * 9.81 * SPACING;

/// Time means \[Pa] of the pressures that gauges at these places have after a layer of `rows` has settled.
fn means(method: &str, rows: u32, gauges: &[(&str, String)]) -> Vec<f64> {
    let kinds: Vec<String> = gauges
        .iter()
        .map(|(name, kind)| format!("(name: \"{name}\", kind: {kind})"))
        .collect();
    let scene = scene(&format!(
        "(name: \"layer\", dimension: 2, spacing: {SPACING}, pressure: {method},
          time_step: Fixed(0.001),
          bodies: [(shape: Box(min: (0, 0, 0), max: (0.24, {height}, 0)))],
          boundaries: [Tank(min: (0, 0, 0), max: (0.24, 0.4, 0))], gauges: [{gauges}])",
        height = f64::from(rows) * SPACING,
        gauges = kinds.join(", ")
    ));
    let mut simulation = Simulation::with_threads(&scene, 2).expect("threads");
    let mut sums = vec![0.0; gauges.len()];
    while simulation.time() < 0.6 {
        let dt = f64::from(simulation.step().expect("a step").dt);
        if simulation.time() > 0.4 {
            for (sum, (name, _)) in sums.iter_mut().zip(gauges) {
                *sum += dt * value(&simulation, name, "pressure_Pa");
            }
        }
    }
    let (time, begun) = (simulation.time(), 0.4);
    sums.iter().map(|sum| sum / (time - begun)).collect()
}

/// The one row of δ-SPH is left out in the corner: its particle there carries tension.
#[test]
fn a_shallow_layer_presses_with_its_weight_on_the_floor_and_nowhere_above_it() {
    let mut failed = Vec::new();
    for (method, rows) in [
        ("Dfsph", 1),
        ("Dfsph", 5),
        ("DeltaSph()", 1),
        ("DeltaSph()", 2),
        ("DeltaSph()", 5),
    ] {
        let surface = f64::from(rows) * SPACING;
        let wall = |x: f64, y: f64, normal: &str| {
            format!("WallPressure(at: ({x}, {y}, 0), normal: ({normal}, 0))")
        };
        let gauges = [
            ("floor", wall(0.12, 0.0, "0, 1")),
            ("corner", wall(0.0, 0.0, "1, 0")),
            ("above", wall(0.0, surface + 1.5 * SPACING, "1, 0")),
            (
                "inside",
                format!("Pressure(at: (0.12, {}, 0))", 0.5 * SPACING),
            ),
        ];
        let found = means(method, rows, &gauges);
        let weight = f64::from(rows) * ROW;
        let of_corner = if (method, rows) == ("DeltaSph()", 1) {
            2.0 * ROW
        } else {
            0.5 * ROW
        };
        let expected = [
            (weight, 0.5 * ROW),
            (weight, of_corner),
            (0.0, 1e-9),
            (weight - 0.5 * ROW, 0.5 * ROW),
        ];
        for ((gauge, found), (expected, by)) in gauges.iter().zip(found).zip(expected) {
            if (found - expected).abs() > by {
                let name = gauge.0;
                failed.push(format!(
                    "{method}, {rows} rows, {name}: {found:.1} for {expected:.1} Pa"
                ));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn spray_and_air_have_no_pressure() {
    let scene = scene(
        "(name: \"spray\", dimension: 2, spacing: 0.02,
          bodies: [(shape: Box(min: (0.1, 0.2, 0), max: (0.12, 0.22, 0))),
                   (shape: Box(min: (0, 0, 0), max: (0.3, 0.1, 0)))],
          boundaries: [Tank(min: (0, 0, 0), max: (0.3, 0.6, 0))],
          gauges: [(name: \"drop\", kind: Pressure(at: (0.11, 0.21, 0))),
                   (name: \"air\", kind: Pressure(at: (0.2, 0.3, 0))),
                   (name: \"wall\", kind: WallPressure(at: (0, 0.2, 0), normal: (1, 0, 0)))])",
    );
    let mut simulation = Simulation::with_threads(&scene, 2).expect("threads");
    simulation.step().expect("a step");
    assert_eq!(value(&simulation, "drop", "pressure_Pa"), 0.0);
    assert_eq!(value(&simulation, "wall", "pressure_Pa"), 0.0);
    let gauges = simulation.world().resource::<Gauges>();
    let air = gauges.get("air").expect("a gauge");
    assert_eq!(air.value("pressure_Pa"), None);
}
