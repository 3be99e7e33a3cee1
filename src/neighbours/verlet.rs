//! Verlet lists (paper section 2; Verlet 1967): lists of all pairs within s > h, kept until something moved more than
//! (s − h)/2.
//!
//! Two particles within h of each other now were within s when the lists were found, if neither has moved farther than
//! that since. Kernels are zero beyond h, so entries farther away add nothing to a sum. The index is rebuilt together
//! with the lists. Lists are also found again when rows hold other particles: after a reordering, when fluid entered or
//! left, and when a host spawned, despawned or tagged particles.
//!
//! The lists decide the order of sums, so they are part of a run's state, and a checkpoint holds them.

use bevy_ecs::prelude::*;
use glam::Vec4;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::find::{
    BoundaryNeighbours, FluidNeighbours, find_boundary_neighbours, find_fluid_neighbours,
};
use super::lists::NeighbourLists;
use crate::{
    index::{BoundarySamples, FluidIndex, update_index},
    scene::{Period, Scene},
    state::{
        CHUNK, Execution, Material, Positions, Remembered, Rows, Systems, failure::healthy,
        from_bytes, to_bytes,
    },
};

/// Part of (s − h)/2 that particles may move \[-]: distances are rounded.
const SAFETY: f32 = 0.999;

/// Where everything was when the lists were found. In scenes that keep them.
#[derive(Resource, Debug)]
pub struct KeptLists {
    /// How far a particle may move before the lists are found again \[m].
    slack: f32,
    /// The particles that the lists are of, by row.
    entities: Vec<Entity>,
    /// Their positions.
    places: Vec<Vec4>,
    /// Positions of the boundary particles.
    walls: Vec<Vec4>,
    /// Whether the lists are to be found.
    due: bool,
    /// Whether the index is to be rebuilt before.
    index_due: bool,
    /// Generation of the rows that were compared last.
    checked: u64,
    /// Number of times that the lists were found.
    pub(crate) searches: u64,
}

impl KeptLists {
    /// Whether the lists need not be found again for these own rows of a rank, which begin with a row.
    pub(crate) fn hold(
        &self,
        (first, entities): (usize, &[Entity]),
        points: &[Vec4],
        period: &Period,
    ) -> bool {
        let places = self.places.get(first..first + points.len());
        let places = places.filter(|_| !self.due && self.entities == entities);
        places.is_some_and(|places| !moved(points, places, self.slack, period))
    }

    /// Number of times that the lists were found.
    pub fn searches(&self) -> u64 {
        self.searches
    }
}

/// The state of kept lists in a checkpoint. Entries of fluid and of boundary, each with the lengths of the lists.
#[derive(Serialize, Deserialize)]
struct Saved {
    places: Vec<[f32; 3]>,
    walls: Vec<[f32; 3]>,
    fluid: (Vec<u16>, Vec<u32>),
    boundary: Option<(Vec<u16>, Vec<u32>)>,
}

/// The row of kept lists among what a run remembers.
pub(crate) const REMEMBERED: Remembered = Remembered {
    name: "neighbour lists",
    save,
    load,
    is_present: |world| world.contains_resource::<KeptLists>(),
};

/// Inserts what keeping lists needs.
pub(super) fn install(world: &mut World, scene: &Scene) {
    let difference = scene.search_radius() - scene.support_radius();
    world.insert_resource(KeptLists {
        slack: SAFETY * 0.5 * difference,
        entities: Vec::new(),
        places: Vec::new(),
        walls: Vec::new(),
        due: true,
        index_due: true,
        checked: 0,
        searches: 0,
    });
}

/// The systems of stage `rebuild_index`: the index, if the lists will be found.
pub(super) fn index_systems() -> Systems {
    (
        check_lists,
        update_index.run_if(index_is_due),
        index_done.run_if(index_is_due).run_if(healthy),
    )
        .chain()
}

/// The systems of stage `find_neighbours`: the lists, if they are due. Walls that moved after stage `rebuild_index`
/// make them due here.
pub(super) fn list_systems(scene: &Scene) -> Systems {
    let find = if scene.boundaries.is_empty() {
        find_fluid_neighbours.into_configs()
    } else {
        (find_fluid_neighbours, find_boundary_neighbours).chain()
    };
    (
        index_systems(),
        find.run_if(lists_are_due).run_if(healthy),
        lists_done.run_if(lists_are_due).run_if(healthy),
    )
        .chain()
}

fn index_is_due(kept: Res<KeptLists>) -> bool {
    kept.index_due
}

fn lists_are_due(kept: Res<KeptLists>) -> bool {
    kept.due
}

fn index_done(mut kept: ResMut<KeptLists>) {
    kept.index_due = false;
}

/// Decides whether the lists are to be found in this step.
fn check_lists(
    mut kept: ResMut<KeptLists>,
    rows: Res<Rows>,
    positions: Res<Positions>,
    samples: Option<Res<BoundarySamples>>,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    let kept = &mut *kept;
    let is_new = kept.checked != rows.generation;
    kept.checked = rows.generation;
    if kept.due {
        // They were not found in an earlier step, which failed: the index is of its positions.
        kept.index_due |= is_new;
        return;
    }
    let period = &material.period;
    let has_moved =
        |now: &[Vec4], then: &[Vec4]| execution.install(|| moved(now, then, kept.slack, period));
    let fluid =
        is_new && (kept.entities != rows.entities || has_moved(positions.points(), &kept.places));
    let walls = samples
        .is_some_and(|samples| samples.is_changed() && has_moved(samples.points(), &kept.walls));
    kept.due = execution.any(fluid || walls);
    kept.index_due = kept.due;
}

/// Whether one of the points is farther than `slack` from where it was \[m].
fn moved(now: &[Vec4], then: &[Vec4], slack: f32, period: &Period) -> bool {
    let limit = slack * slack;
    let is_near = |(now, then): (&Vec4, &Vec4)| {
        let way = period.nearest((*now - *then).truncate());
        // A distance that is not a number is not near.
        way.length_squared() <= limit
    };
    now.len() != then.len()
        || now
            .par_chunks(CHUNK)
            .zip(then.par_chunks(CHUNK))
            .any(|(now, then)| !now.iter().zip(then).all(is_near))
}

/// Notes where everything was.
fn lists_done(
    mut kept: ResMut<KeptLists>,
    rows: Res<Rows>,
    positions: Res<Positions>,
    samples: Option<Res<BoundarySamples>>,
) {
    kept.due = false;
    kept.searches += 1;
    kept.entities.clone_from(&rows.entities);
    kept.places.clear();
    kept.places.extend_from_slice(positions.points());
    kept.walls.clear();
    if let Some(samples) = samples {
        kept.walls.extend_from_slice(samples.points());
    }
}

fn save(world: &World, rows: &[Entity]) -> Result<Option<Vec<u8>>, String> {
    let Some(kept) = world.get_resource::<KeptLists>() else {
        return Ok(None);
    };
    // Lists of other rows are found again in the next step.
    let is_of_use = !kept.due && kept.entities == rows;
    let fluid = world.get_resource::<FluidNeighbours>();
    let saved = fluid.filter(|_| is_of_use).map(|fluid| {
        let places = |points: &[Vec4]| points.iter().map(|x| x.truncate().to_array()).collect();
        let boundary = world.get_resource::<BoundaryNeighbours>();
        Saved {
            places: places(&kept.places),
            walls: places(&kept.walls),
            fluid: fluid.lists.to_parts(rows.len()),
            boundary: boundary.map(|lists| lists.0.to_parts(rows.len())),
        }
    });
    to_bytes(&(kept.searches, saved)).map(Some)
}

fn load(world: &mut World, rows: &[Entity], bytes: &[u8]) -> Result<(), String> {
    let (searches, saved): (u64, Option<Saved>) = from_bytes(bytes)?;
    let walls = world.get_resource::<BoundarySamples>();
    let walls = walls.map_or(0, |samples| samples.points().len());
    let Some(mut kept) = world.get_resource_mut::<KeptLists>() else {
        return Err("this scene keeps no lists".to_owned());
    };
    kept.due = true;
    kept.searches = searches;
    let Some(saved) = saved else { return Ok(()) };
    if saved.places.len() != rows.len() || saved.walls.len() != walls {
        return Err("its lists are of other particles".to_owned());
    }
    let points = |places: &[[f32; 3]]| -> Vec<Vec4> {
        let points = places.iter().map(|&[x, y, z]| Vec4::new(x, y, z, 0.0));
        points.collect()
    };
    let lists = |parts: (Vec<u16>, Vec<u32>), among: usize| {
        let found = NeighbourLists::from_parts(parts, rows.len(), among);
        found.ok_or("its lists name rows that do not exist")
    };
    let fluid = lists(saved.fluid, rows.len())?;
    let boundary = saved
        .boundary
        .map(|parts| lists(parts, walls))
        .transpose()?;
    kept.entities = rows.to_vec();
    kept.places = points(&saved.places);
    kept.walls = points(&saved.walls);
    kept.due = false;
    kept.checked = 0;
    let places = kept.places.clone();
    if let Some(mut found) = world.get_resource_mut::<FluidNeighbours>() {
        found.lists = fluid;
    }
    match (world.get_resource_mut::<BoundaryNeighbours>(), boundary) {
        (Some(mut found), Some(boundary)) => found.0 = boundary,
        (None, None) => {}
        _ => return Err("its walls differ".to_owned()),
    }
    // What reads the index between two searches finds it as it was.
    let Some(execution) = world.get_resource::<Execution>().cloned() else {
        return Err("the world has no threads".to_owned());
    };
    let Some(mut index) = world.get_resource_mut::<FluidIndex>() else {
        return Err("the world has no index".to_owned());
    };
    let rebuilt = index.structure.rebuild(&places, &execution);
    rebuilt.map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Simulation, scene::Scene, state::seal::reseal};

    fn simulation() -> Simulation {
        let text = r#"(
            name: "kept",
            dimension: 2,
            spacing: 0.1,
            neighbours: Verlet(skin: 0.2),
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0)))],
            boundaries: [Tank(min: (0, 0, 0), max: (1, 1, 0))],
        )"#;
        let scene = Scene::parse(text, "kept.ron", &[]).expect("a scene");
        let mut simulation = Simulation::with_threads(&scene, 1).expect("a scene that runs");
        simulation.step().expect("a step");
        simulation
    }

    #[test]
    fn lists_that_do_not_fit_the_particles_are_refused() {
        let mut simulation = simulation();
        let rows = simulation.world().resource::<Rows>().entities.clone();
        let bytes = save(simulation.world(), &rows).expect("bytes");
        let bytes = bytes.expect("kept lists");
        let world = simulation.world_mut();
        assert_eq!(load(world, &rows, &bytes), Ok(()));
        let change = |change: &dyn Fn(&mut Saved)| {
            let (searches, saved): (u64, Option<Saved>) = from_bytes(&bytes).expect("lists");
            let mut saved = saved.expect("lists of these rows");
            change(&mut saved);
            to_bytes(&(searches, Some(saved))).expect("bytes")
        };
        let changes: [&dyn Fn(&mut Saved); 7] = [
            &|saved| saved.fluid.1[3] = 25,
            &|saved| saved.fluid.0[0] += 1,
            &|saved| saved.fluid.0.truncate(1),
            &|saved| saved.places.truncate(1),
            &|saved| saved.walls.truncate(1),
            &|saved| saved.boundary.as_mut().expect("walls").1[0] = u32::MAX,
            &|saved| saved.boundary = None,
        ];
        for (k, with) in changes.iter().enumerate() {
            let refused = load(world, &rows, &change(with));
            assert!(refused.is_err(), "change {k}");
        }
        for cut in 0..bytes.len() {
            assert!(load(world, &rows, &bytes[..cut]).is_err(), "{cut} bytes");
        }
        // Places that are no numbers are no places: lists are found again.
        let nowhere = change(&|saved| saved.places[0][0] = f32::NAN);
        if load(world, &rows, &nowhere).is_ok() {
            reseal(world);
            simulation.step().expect("a step");
        }
    }
}
