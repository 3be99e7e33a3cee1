//! Methods to find neighbours: the structures of the engine, and trees of other crates.

use glam::Vec4;
use overfall::{
    index::{
        CompactHashing, Grid, IndexSort, SpatialHashing, SpatialIndex, UniformGrid, ZIndexSort,
    },
    neighbours::{NeighbourLists, Search, search},
    state::Execution,
};
use rayon::prelude::*;

pub(super) const RADIUS: f32 = 2.0;
/// Particles per task, for motion and for queries of the peers.
pub(super) const CHUNK: usize = 1024;
/// The method to which ratios refer; it comes first.
pub(super) const REFERENCE: &str = "compact hashing";

/// A way to find neighbours.
pub(super) trait Method {
    /// Builds or updates the structure for the positions.
    fn construct(&mut self, points: &[Vec4], execution: &Execution);
    /// Finds all neighbours of all particles.
    fn query(&mut self, points: &[Vec4], execution: &Execution);
    /// Neighbours of one row as found by the last query.
    fn neighbours(&self, row: usize) -> Vec<u32>;
    /// Memory of the structure and of the lists \[bytes].
    fn bytes(&self) -> Option<(usize, usize)>;
}

struct Structure {
    index: Box<dyn SpatialIndex>,
    lists: NeighbourLists,
    built: bool,
}

impl Method for Structure {
    fn construct(&mut self, points: &[Vec4], execution: &Execution) {
        let result = if self.built {
            self.index.update(points, execution)
        } else {
            self.index.rebuild(points, execution)
        };
        result.expect("a box that fits");
    }

    fn query(&mut self, points: &[Vec4], execution: &Execution) {
        let task = Search::among_themselves(&*self.index, points);
        search(&task, &mut self.lists, execution).expect("short lists");
        self.built = true;
    }

    fn neighbours(&self, row: usize) -> Vec<u32> {
        self.lists.of(row).to_vec()
    }

    fn bytes(&self) -> Option<(usize, usize)> {
        Some((self.index.bytes(), self.lists.bytes()))
    }
}

/// Lists of one chunk: rows, and the end of each particle's list.
#[derive(Default)]
struct ChunkLists {
    rows: Vec<u32>,
    ends: Vec<usize>,
}

impl ChunkLists {
    fn of(lists: &[Self], row: usize) -> Vec<u32> {
        let (chunk, k) = (&lists[row / CHUNK], row % CHUNK);
        let start = k.checked_sub(1).map_or(0, |k| chunk.ends[k]);
        chunk.rows[start..chunk.ends[k]].to_vec()
    }
}

/// Calls `look_up` for every row of every chunk, in parallel.
fn in_chunks<T>(
    points: &[Vec4],
    lists: &mut Vec<ChunkLists>,
    execution: &Execution,
    scratch: impl Fn() -> T + Sync,
    look_up: impl Fn(&mut T, Vec4, u32, &mut Vec<u32>) + Sync,
) {
    lists.resize_with(points.len().div_ceil(CHUNK), ChunkLists::default);
    execution.install(|| {
        lists
            .par_iter_mut()
            .zip(points.par_chunks(CHUNK))
            .enumerate()
            .for_each(|(chunk, (lists, points))| {
                lists.rows.clear();
                lists.ends.clear();
                let mut scratch = scratch();
                for (row, &point) in (chunk * CHUNK..).zip(points) {
                    look_up(&mut scratch, point, row as u32, &mut lists.rows);
                    lists.ends.push(lists.rows.len());
                }
            });
    });
}

/// The k-d tree of the crate kiddo: `ImmutableKdTree` of `f32`, its recommended layout for trees that are built once.
/// It is rebuilt in parallel for every run, because it has no update, and queried by `within(…).unsorted()` with a
/// visitor and a scratch buffer per chunk.
#[derive(Default)]
struct Kiddo {
    tree: Option<kiddo::ImmutableKdTree<f32, 3>>,
    lists: Vec<ChunkLists>,
}

impl Method for Kiddo {
    fn construct(&mut self, points: &[Vec4], execution: &Execution) {
        self.tree = None;
        let points: Vec<[f32; 3]> = points.iter().map(|x| x.truncate().to_array()).collect();
        self.tree = execution.install(|| {
            kiddo::ImmutableKdTree::builder()
                .with_parallel_construction()
                .build_from_slice(&points)
                .ok()
        });
    }

    fn query(&mut self, points: &[Vec4], execution: &Execution) {
        let tree = self.tree.as_ref().expect("it is built");
        in_chunks(
            points,
            &mut self.lists,
            execution,
            || tree.create_scratch::<kiddo::SquaredEuclidean<f32>>(),
            |scratch, point, row, out| {
                tree.query(&point.truncate().to_array())
                    .within::<kiddo::SquaredEuclidean<f32>>(RADIUS * RADIUS)
                    .unsorted()
                    .without_distances()
                    .with_scratch(scratch)
                    .visit(|found| {
                        if found.item != row {
                            out.push(found.item);
                        }
                    });
            },
        );
    }

    fn neighbours(&self, row: usize) -> Vec<u32> {
        ChunkLists::of(&self.lists, row)
    }

    fn bytes(&self) -> Option<(usize, usize)> {
        None
    }
}

type Located = rstar::primitives::GeomWithData<[f32; 3], u32>;

/// The R-tree of the crate rstar, with the row of each point: rebuilt by bulk loading for every run and queried by
/// `locate_within_distance`.
#[derive(Default)]
struct Rstar {
    tree: rstar::RTree<Located>,
    lists: Vec<ChunkLists>,
}

impl Method for Rstar {
    fn construct(&mut self, points: &[Vec4], _: &Execution) {
        self.tree = rstar::RTree::default();
        let points = points.iter().map(|x| x.truncate().to_array());
        let points = points.zip(0..).map(|(x, row)| Located::new(x, row));
        self.tree = rstar::RTree::bulk_load(points.collect());
    }

    fn query(&mut self, points: &[Vec4], execution: &Execution) {
        let tree = &self.tree;
        in_chunks(
            points,
            &mut self.lists,
            execution,
            || (),
            |(), point, row, out| {
                let found = tree
                    .locate_within_distance(point.truncate().to_array(), RADIUS * RADIUS)
                    .map(|found| found.data);
                out.extend(found.filter(|&other| other != row));
            },
        );
    }

    fn neighbours(&self, row: usize) -> Vec<u32> {
        ChunkLists::of(&self.lists, row)
    }

    fn bytes(&self) -> Option<(usize, usize)> {
        None
    }
}

/// All methods, the reference first.
pub(super) fn methods(grid: &Grid) -> Vec<(&'static str, Box<dyn Method>)> {
    let structure = |index: Box<dyn SpatialIndex>| -> Box<dyn Method> {
        Box::new(Structure {
            index,
            lists: NeighbourLists::default(),
            built: false,
        })
    };
    let grid = || grid.clone();
    vec![
        (
            REFERENCE,
            structure(Box::new(CompactHashing::new(grid(), 8.0))),
        ),
        (
            "uniform grid",
            structure(Box::new(UniformGrid::new(grid()))),
        ),
        ("index sort", structure(Box::new(IndexSort::new(grid())))),
        ("Z-index sort", structure(Box::new(ZIndexSort::new(grid())))),
        (
            "spatial hashing",
            structure(Box::new(SpatialHashing::new(grid(), 8.0))),
        ),
        ("kiddo", Box::<Kiddo>::default()),
        ("rstar", Box::<Rstar>::default()),
    ]
}
