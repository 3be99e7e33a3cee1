//! PCISPH with and without the correction after the last prediction in the paper's Algorithm 2.

use overfall::{
    pressure::pressure_force,
    scene::{Pcisph, PressureMethod, Scene},
    state::{PressureAccelerations, Pressures},
};

use crate::common::{bits, dam, run, simulation};

fn scene(last_correction: bool) -> Scene {
    Scene {
        pressure: PressureMethod::Pcisph(Pcisph {
            last_correction,
            ..Pcisph::default()
        }),
        ..dam()
    }
}

#[test]
fn the_last_correction_acts_only_where_the_scene_asks_for_it() {
    for last_correction in [false, true] {
        let mut simulation = simulation(&scene(last_correction));
        run(&mut simulation, 5);
        let world = simulation.world_mut();
        assert!(world.resource::<Pressures>().iter().any(|&p| p > 0.0));
        // The columns still contain the positions of the step, with the last corrected pressures.
        let acted = world.resource::<PressureAccelerations>().to_vec();
        world.run_system_cached(pressure_force).expect("it runs");
        let corrected = world.resource::<PressureAccelerations>();
        assert_eq!(acted == **corrected, last_correction);
    }
}

#[test]
fn the_last_correction_changes_the_motion() {
    let [without, with] = [false, true].map(|last_correction| {
        let mut simulation = simulation(&scene(last_correction));
        run(&mut simulation, 20);
        bits(simulation.world_mut())
    });
    assert_ne!(without, with);
}
