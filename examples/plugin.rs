//! Water in a headless bevy `App`, synchronised with `FixedUpdate`.
//!
//! `cargo run --release --features bevy_app --example plugin`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use std::time::Duration;

use bevy_app::{App, FixedUpdate};
use bevy_ecs::prelude::*;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use overfall::{
    FluidPlugin, FluidStatus, FluidStopped,
    particle::{Fluid, Position},
    scene::{BoundaryShape, FluidBody, Scene, Shape},
};

fn watch(fluid: Query<&Position, With<Fluid>>, status: Res<FluidStatus>) {
    let front = fluid.iter().map(|x| x.0.x).fold(0.0, f32::max);
    if let FluidStatus::Running(advance) = &*status {
        println!("{} steps, up to x = {front:.2} m", advance.steps);
    }
}

fn main() {
    let scene = Scene {
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.5, 0.8, 0.4]))],
        boundaries: vec![BoundaryShape::tank([0.0; 3], [1.6, 1.2, 0.4])],
        ..Scene::new("pond", 0.1)
    };
    let mut app = App::new();
    app.add_plugins((TimePlugin, FluidPlugin::new(scene)))
        .add_systems(FixedUpdate, watch)
        .add_observer(|stopped: On<FluidStopped>| println!("{}", stopped.reason))
        // A frame is a twentieth of a second of simulated time, however long it takes.
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(
            50,
        )));
    for _ in 0..6 {
        app.update();
    }
}
