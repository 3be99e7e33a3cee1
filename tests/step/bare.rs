//! A scene has no more than it asks for: no stage, system, resource or column of what it leaves out.

use std::collections::BTreeSet;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::Schedules;
use overfall::scene::Scene;
use overfall::{Simulation, Step};

/// Fluid and gravity alone.
const BARE: &str =
    "fluid: (viscosity: None), reorder_interval: 0, output: (pictures: false, formats: [])";

/// Everything that a scene can ask for beside its pressure method.
const FULL: &str = "fluid: (viscosity: Laminar(kinematic_viscosity: 0.01, numerical: 0.1), surface_tension: \
    BeckerTeschner(kappa: 0.01)), body_forces: [Central(center: (0, 0, 0), linear: 1)], boundaries: [Tank(min: (-0.2, \
    -0.2, -0.2), max: (1, 1, 1), slip: NoSlip, motion: Velocity(velocity: (0.1, 0, 0)))], gauges: [(name: \"e\", kind: \
    Energy), \
    (name: \"p\", kind: Pressure(at: (0.1, 0.1, 0.1)))], emitters: [(shape: Disc(center: (0.5, 0.8, 0.5), radius: 0.1, \
    normal: (0, -1, 0)), speed: 1)], outflow: [(min: (0.8, 0.8, 0.8), max: (0.9, 0.9, 0.9))], reorder_interval: 20";

fn scene(pressure: &str, rest: &str) -> Scene {
    let text = format!(
        "(name: \"t\", spacing: 0.05, bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.3, 0.3)))], pressure: \
         {pressure}, time_step: Fixed(0.0002), {rest})"
    );
    Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// What a run of a scene has, in lower case: its systems, its resources, the columns of its particles.
struct Inventory {
    systems: BTreeSet<String>,
    resources: BTreeSet<String>,
    columns: BTreeSet<String>,
}

fn inventory(scene: &Scene) -> Inventory {
    let mut simulation =
        Simulation::with_threads(scene, 1).unwrap_or_else(|error| panic!("{error}"));
    simulation.step().unwrap_or_else(|error| panic!("{error}"));
    let world = simulation.world_mut();
    let own = |name: String| name.contains("overfall").then(|| name.to_lowercase());
    let systems = world
        .resource::<Schedules>()
        .get(Step)
        .expect("the step's schedule");
    let systems = systems.systems().expect("a schedule that has run");
    let systems = systems
        .filter_map(|(_, system)| own(system.name().to_string()))
        .collect();
    let resources = world
        .iter_resources()
        .filter_map(|(_, of, _)| own(of.name().to_string()))
        .collect();
    let mut fluid = world.query_filtered::<Entity, With<overfall::particle::Fluid>>();
    let particle = fluid.iter(world).next().expect("a particle");
    let columns = world.inspect_entity(particle).expect("a particle");
    let columns = columns
        .filter_map(|(_, of)| own(of.name().to_string()))
        .collect();
    Inventory {
        systems,
        resources,
        columns,
    }
}

/// Parts of names that stand for what the bare scene leaves out.
const LEFT_OUT: [&str; 14] = [
    "viscosity",
    "tension",
    "friction",
    "boundar",
    "wall",
    "gauge",
    "snapshot",
    "emit",
    "outflow",
    "moving",
    "body_forces",
    "bodyforces",
    "reorder",
    "account",
];

#[test]
fn a_scene_that_asks_for_nothing_has_nothing_of_it() {
    for pressure in [
        "Sesph(equation: Gas(stiffness: 400))",
        "Pcisph()",
        "Iisph()",
        "Dfsph()",
    ] {
        let bare = inventory(&scene(pressure, BARE));
        let full = inventory(&scene(pressure, FULL));
        for part in LEFT_OUT {
            let all = |of: &Inventory| -> Vec<String> {
                let names = of.systems.iter().chain(&of.resources).chain(&of.columns);
                names.filter(|name| name.contains(part)).cloned().collect()
            };
            assert_eq!(all(&bare), Vec::<String>::new(), "{pressure}: {part}");
        }
        // The search would find them where they are asked for.
        for (part, names) in [
            ("viscosity", &full.systems),
            ("tension", &full.systems),
            ("friction", &full.systems),
            ("gauge", &full.systems),
            ("viscosity", &full.resources),
            ("boundar", &full.resources),
            ("gauge", &full.resources),
        ] {
            assert!(
                names.iter().any(|name| name.contains(part)),
                "{pressure}: {part} is not in {names:?}"
            );
        }
        assert!(
            bare.columns.is_subset(&full.columns),
            "{pressure}: {:?}",
            bare.columns
        );
        assert!(
            bare.systems.len() + 8 <= full.systems.len(),
            "{pressure}: {:?}",
            bare.systems
        );
    }
}
