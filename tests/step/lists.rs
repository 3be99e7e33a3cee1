//! The lists of every step of a dam break are identical to those of brute force.

use overfall::{
    Simulation,
    index::{BoundarySamples, BruteForce, FluidIndex, SpatialIndex},
    neighbours::{BoundaryNeighbours, FluidNeighbours, NeighbourLists, Search, search},
    scene::Scene,
    state::{Execution, Positions},
};

const SCENE: &str = r#"(
    name: "column",
    spacing: 0.03,
    time_step: Cfl(max: 0.002),
    reorder_interval: 40,
    bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.3, 0.3)))],
    boundaries: [Tank(min: (0, 0, 0), max: (0.9, 0.6, 0.5))],
)"#;

/// Steps until the water has hit the far wall and returned.
const STEPS: usize = 400;

fn assert_same(found: &NeighbourLists, expected: &NeighbourLists, rows: usize, step: usize) {
    for row in 0..rows {
        let sorted = |lists: &NeighbourLists| {
            let mut list = lists.of(row).to_vec();
            list.sort_unstable();
            list
        };
        assert_eq!(sorted(found), sorted(expected), "row {row}, step {step}");
    }
}

#[test]
fn lists_of_every_step_are_those_of_brute_force() {
    let scene = Scene::parse(SCENE, "column", &[]).expect("a scene");
    let mut simulation = Simulation::with_threads(&scene, 2).expect("threads");
    let execution = Execution::new(2).expect("threads");
    for step in 0..STEPS {
        simulation.step().expect("a step");
        let world = simulation.world();
        let positions = world.resource::<Positions>();
        let walls = world.resource::<BoundarySamples>();
        let grid = world.resource::<FluidIndex>().structure().grid();
        let brute = |points| {
            let mut index = BruteForce::new(grid.clone());
            index.rebuild(points, &execution).expect("no box");
            index
        };
        let (of, walls_of) = (brute(positions.points()), brute(walls.points()));
        let mut lists = NeighbourLists::default();
        let fluid = Search::among_themselves(&of, positions.points());
        search(&fluid, &mut lists, &execution).expect("short lists");
        let found = world.resource::<FluidNeighbours>().lists();
        assert_same(found, &lists, positions.rows(), step);
        let boundary = Search {
            among: &walls_of,
            among_points: walls.points(),
            same: false,
            ..fluid
        };
        search(&boundary, &mut lists, &execution).expect("short lists");
        let found = world.resource::<BoundaryNeighbours>().lists();
        assert_same(found, &lists, positions.rows(), step);
    }
}
