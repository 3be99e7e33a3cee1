//! A host that exchanges a resource of the engine with that of another world, within a step and between two.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy_ecs::{component::Mutable, prelude::*};
use overfall::{
    Simulation, Step,
    boundary::{friction::WallFriction, owners::Owners, sums::BoundarySums},
    gauge::{EnergyAccount, Gauges},
    index::{BoundarySamples, FluidIndex},
    integrate::Motion,
    neighbours::{BoundaryNeighbours, FluidNeighbours},
    pairs::KernelGradients,
    pressure::{
        SolverState,
        density_rate::{DensityRates, PredictedVelocities},
        dfsph::DivergenceTerms,
        diagonal::InverseDiagonals,
        implicit::{Iterates, Jacobi},
        initial::StartingRates,
        neighbour_count::NeighbourCounts,
        pcisph::PredictedDensities,
    },
    reorder::ReorderState,
    scene::{Executor, FluidBody, Scene, Shape},
    state::{Displacements, MeanPressures, PredictedPositions, PressureAccelerations},
    step::{Accelerations, Densities, FailureCause, Positions, Pressures, Rows, Velocities},
    time_step::{RecoveryTime, roll_back::KeptState},
};

use crate::common::{PLACES, bits, methods, run, simulation};

type Change = fn(&mut World);

/// Another simulation.
#[derive(Resource)]
struct Other(Simulation);

/// A change of the world in the middle of a step, executed once.
#[derive(Resource)]
struct Deed(Option<Change>);

fn interfere(world: &mut World) {
    if let Some(deed) = world.resource_mut::<Deed>().0.take() {
        deed(world);
    }
}

fn exchange<R: Resource<Mutability = Mutable>>(world: &mut World) {
    world.resource_scope(|world, mut other: Mut<Other>| {
        let own = world.get_resource_mut::<R>();
        let others = other.0.world_mut().get_resource_mut::<R>();
        if let (Some(mut own), Some(mut others)) = (own, others) {
            std::mem::swap(&mut *own, &mut *others);
        }
    });
}

#[rustfmt::skip]
const EXCHANGES: [(&str, Change); 34] = [
    ("Accelerations", exchange::<Accelerations>),
    ("BoundaryNeighbours", exchange::<BoundaryNeighbours>),
    ("BoundarySamples", exchange::<BoundarySamples>),
    ("BoundarySums", exchange::<BoundarySums>),
    ("Densities", exchange::<Densities>),
    ("DensityRates", exchange::<DensityRates>),
    ("Displacements", exchange::<Displacements>),
    ("DivergenceTerms", exchange::<DivergenceTerms>),
    ("EnergyAccount", exchange::<EnergyAccount>),
    ("FluidIndex", exchange::<FluidIndex>),
    ("FluidNeighbours", exchange::<FluidNeighbours>),
    ("Gauges", exchange::<Gauges>),
    ("InverseDiagonals", exchange::<InverseDiagonals>),
    ("Iterates", exchange::<Iterates>),
    ("Jacobi", exchange::<Jacobi>),
    ("KeptState", exchange::<KeptState>),
    ("KernelGradients", exchange::<KernelGradients>),
    ("MeanPressures", exchange::<MeanPressures>),
    ("Motion", exchange::<Motion>),
    ("NeighbourCounts", exchange::<NeighbourCounts>),
    ("Owners", exchange::<Owners>),
    ("Positions", exchange::<Positions>),
    ("PredictedDensities", exchange::<PredictedDensities>),
    ("PredictedPositions", exchange::<PredictedPositions>),
    ("PredictedVelocities", exchange::<PredictedVelocities>),
    ("PressureAccelerations", exchange::<PressureAccelerations>),
    ("Pressures", exchange::<Pressures>),
    ("RecoveryTime", exchange::<RecoveryTime>),
    ("ReorderState", exchange::<ReorderState>),
    ("Rows", exchange::<Rows>),
    ("SolverState", exchange::<SolverState>),
    ("StartingRates", exchange::<StartingRates>),
    ("Velocities", exchange::<Velocities>),
    ("WallFriction", exchange::<WallFriction>),
];

/// What remembers earlier steps: no step can be taken until it is put back.
const LASTING: [&str; 8] = [
    "EnergyAccount",
    "Jacobi",
    "KeptState",
    "MeanPressures",
    "Motion",
    "RecoveryTime",
    "ReorderState",
    "SolverState",
];

/// A small scene with gauges and walls that hold the fluid.
fn scene(method: usize, rows: u8) -> Scene {
    let height = 0.02 * f32::from(rows);
    let text = r#"(
        name: "box", spacing: 0.02,
        fluid: (viscosity: Laminar(kinematic_viscosity: 1e-3)),
        bodies: [(shape: Box(min: (0, 0, 0), max: (0.08, 0.04, 0.08)))],
        boundaries: [Tank(min: (0, 0, 0), max: (0.12, 0.2, 0.08), slip: NoSlip, name: "tank")],
        gauges: [(name: "p", kind: Pressure(at: (0.02, 0.02, 0.02))), (name: "e", kind: Energy),
            (name: "f", kind: Force(boundary: "tank"))],
        reorder_interval: 2,
    )"#;
    let mut scene = Scene::parse(text, "box.ron", &[]).expect("a scene");
    scene.bodies = vec![FluidBody::new(Shape::cuboid(
        [0.0; 3],
        [0.08, height, 0.08],
    ))];
    scene.pressure = methods()[method];
    if method % 2 == 1 {
        scene.executor = Executor::Parallel;
    }
    scene
}

/// Steps with an exchange in one of them. Returns what went wrong.
fn exchanged(simulation: &mut Simulation, (name, deed): (&str, Change)) -> Result<(), String> {
    let kept = bits(simulation.world_mut());
    simulation.world_mut().resource_mut::<Deed>().0 = Some(deed);
    let step = |simulation: &mut Simulation| {
        catch_unwind(AssertUnwindSafe(|| simulation.step())).map_err(|_| "a panic".to_owned())
    };
    let mut result = step(simulation)?;
    if result.is_ok() {
        // The state was taken over already: the next one says so.
        let kept = bits(simulation.world_mut());
        result = step(simulation)?;
        if result.is_err() && bits(simulation.world_mut()) != kept {
            return Err("another state".to_owned());
        }
    } else if bits(simulation.world_mut()) != kept {
        return Err("another state".to_owned());
    }
    if let Err(error) = &result {
        let FailureCause::ResourceWritten { resource } = &error.cause else {
            return Err(format!("another cause: {error}"));
        };
        if resource != name {
            return Err(format!("{resource} is named"));
        }
        if LASTING.contains(&name) {
            match step(simulation)? {
                Err(again) if again.cause == error.cause => {}
                other => return Err(format!("the next step: {other:?}")),
            }
            deed(simulation.world_mut());
        }
    }
    match step(simulation)? {
        Ok(_) => Ok(()),
        Err(error) => Err(format!("the last step: {error}")),
    }
}

#[test]
fn a_resource_of_another_world_is_named_and_panics_nothing() {
    let mut wrong = Vec::new();
    let mut case = 0;
    for (number, place) in PLACES.into_iter().enumerate() {
        let mut both: Vec<(Simulation, usize)> = Vec::new();
        for method in [number % 5, (number + 2) % 5] {
            let mut own = simulation(&scene(method, 4));
            let mut second = simulation(&scene(method, [3, 4, 6][case % 3]));
            case += 1;
            run(&mut second, 2);
            own.world_mut().insert_resource(Other(second));
            own.world_mut().insert_resource(Deed(None));
            own.world_mut().schedule_scope(Step, |_, step| {
                step.add_systems(interfere.after(place.0).before(place.1));
            });
            run(&mut own, 1);
            both.push((own, method));
        }
        for (own, method) in &mut both {
            for exchange in EXCHANGES {
                if let Err(what) = exchanged(own, exchange) {
                    wrong.push(format!(
                        "{} after {:?}, {method}: {what}",
                        exchange.0, place.0
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
