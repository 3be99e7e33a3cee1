//! A scene created in Rust, written as RON for the command line, and read again.
//!
//! `cargo run --release --example scene_from_code`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use overfall::{
    plan,
    scene::{
        BoundaryShape, Bounds, FluidBody, Gauge, GaugeKind, Pcisph, PressureMethod, Rate, Scene,
        Shape, TimeStep,
    },
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Any number of steps into a pool, which a file would have to list.
    let steps = (0..4).map(|k| {
        let (x, y) = (0.3 * k as f32, 0.8 - 0.2 * k as f32);
        BoundaryShape::cuboid([x, 0.0, 0.0], [x + 0.3, y, 0.5]).named(format!("step {k}"))
    });
    let tank = BoundaryShape::tank([0.0; 3], [2.0, 1.6, 0.5]);
    let scene = Scene {
        bodies: vec![FluidBody {
            velocity: [1.0, 0.0, 0.0].into(),
            ..FluidBody::new(Shape::cuboid([0.05, 0.85, 0.05], [0.3, 1.3, 0.45]))
        }],
        boundaries: steps.chain([tank]).collect(),
        domain: Some(Bounds::new([-0.5; 3], [2.5, 2.1, 1.0])),
        pressure: PressureMethod::Pcisph(Pcisph {
            max_density_error: 0.005,
            ..Pcisph::default()
        }),
        time_step: TimeStep::Fixed(5e-4),
        gauges: vec![Gauge {
            every: Rate::Seconds(0.01),
            ..Gauge::new(
                "load",
                GaugeKind::Force {
                    boundary: "step 3".to_owned(),
                    about: [1.05, 0.0, 0.25].into(),
                },
            )
        }],
        duration: 0.5,
        ..Scene::new("cascade", 0.05)
    };
    let plan = plan(&scene)?;
    println!(
        "{} particles, {} of walls",
        plan.particles, plan.boundary_particles
    );
    let file = std::env::temp_dir().join("overfall_cascade.ron");
    std::fs::write(&file, scene.to_ron()?)?;
    assert_eq!(Scene::load(&file, &[])?, scene);
    println!("`overfall run {}` runs it", file.display());
    Ok(())
}
