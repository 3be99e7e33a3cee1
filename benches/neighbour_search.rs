//! How long does it take to find all neighbours of all particles, by structure?
//!
//! `cargo bench --bench neighbour_search` takes 131 072 particles, `-- --million` 1 048 576 instead.
//!
//! The particles lie on a cubic lattice of spacing 1, displaced by up to 0.2 along each axis, and look for neighbours
//! within 2: about 29. They start in Z-curve order. Between two runs each moves by up to 0.02 along each axis, the same
//! for every method, and moves in parallel, as in a step: the threads are awake when the time begins. (A second thread
//! that sleeps gets nothing of a loop of half a millisecond in every third to fifth run.) The methods take turns of
//! five runs: a method finds the caches as it left them, as it would if it ran alone, and a disturbance of the machine
//! meets all alike. The median over the runs counts.
//!
//! Two crates for comparison, each built anew in every run, since they have no update, and both asked for
//! unsorted rows only, written to one array a chunk of 1024 particles:
//!
//! - kiddo: `ImmutableKdTree` of `f32`, the layout it recommends for trees that are built once, built in parallel,
//!   queried by `within(…).unsorted()` with a visitor and a scratch buffer for every chunk.
//! - rstar: `RTree` of points with their row, by bulk loading, queried by `locate_within_distance`.
//!
//! The lists of every method are compared with brute force for a few hundred particles.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "it reports")]

use std::time::Instant;

use glam::{IVec3, Vec4};
use overfall::{
    index::{
        CompactHashing, Grid, IndexSort, SpatialHashing, SpatialIndex, UniformGrid, ZIndexSort,
        z_curve,
    },
    neighbours::{NeighbourLists, Search, search},
    scene::Dimension,
    state::Execution,
};
use rayon::prelude::*;

const RADIUS: f32 = 2.0;
const JITTER: f32 = 0.2;
const MOTION: f32 = 0.02;
const RUNS: usize = 20;
/// Runs of a method at a time.
const TURN: usize = 5;
/// Particles between two that are compared with brute force.
const CHECK_EVERY: usize = 509;
/// Particles that a task moves, or looks up for a peer.
const CHUNK: usize = 1024;

/// A small generator: the same numbers everywhere.
struct Numbers(u64);

impl Numbers {
    /// In [-1, 1).
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    fn vector(&mut self, largest: f32) -> Vec4 {
        let (x, y, z) = (self.next(), self.next(), self.next());
        largest * Vec4::new(x, y, z, 0.0)
    }
}

/// The particles in the order of the Z-curve.
fn lattice(size: IVec3, grid: &Grid, execution: &Execution) -> Vec<Vec4> {
    let mut numbers = Numbers(1);
    let mut points = Vec::new();
    for z in 0..size.z {
        for y in 0..size.y {
            for x in 0..size.x {
                let place = Vec4::new(x as f32, y as f32, z as f32, 0.0);
                points.push(place + numbers.vector(JITTER));
            }
        }
    }
    let mut handles = Vec::new();
    z_curve::sort_handles(&points, grid, execution, &mut handles);
    let sorted = handles.iter().map(|handle| points[handle.1 as usize]);
    sorted.collect()
}

/// A way to find neighbours.
trait Method {
    /// Takes over the positions.
    fn construct(&mut self, points: &[Vec4], execution: &Execution);
    /// Finds all neighbours of all.
    fn query(&mut self, points: &[Vec4], execution: &Execution);
    /// Those of one row that the last query found.
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

/// Lists of one chunk: rows, and where each particle's end.
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

fn methods(grid: &Grid) -> Vec<(&'static str, Box<dyn Method>)> {
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

/// The method that the others are compared with; it comes first.
const REFERENCE: &str = "compact hashing";

/// Compares lists with those of brute force.
fn check(name: &str, method: &dyn Method, points: &[Vec4]) {
    for row in (0..points.len()).step_by(CHECK_EVERY) {
        let mut found = method.neighbours(row);
        found.sort_unstable();
        let near = |other: &Vec4| {
            let d = *other - points[row];
            d.x * d.x + d.y * d.y + d.z * d.z <= RADIUS * RADIUS
        };
        let all = points.iter().zip(0u32..);
        let expected: Vec<u32> = all
            .filter(|(other, k)| *k as usize != row && near(other))
            .map(|(_, k)| k)
            .collect();
        assert_eq!(
            found, expected,
            "{name} disagrees with brute force at row {row}"
        );
    }
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn measure(size: IVec3, threads: usize, execution: &Execution, peers: bool) {
    let grid = Grid::new(Dimension::Three, RADIUS, 1.0);
    let mut methods = methods(&grid);
    if !peers {
        methods.truncate(5);
    }
    let start = lattice(size, &grid, execution);
    let mut states: Vec<_> = methods
        .iter()
        .map(|_| (start.clone(), Numbers(2)))
        .collect();
    let mut times = vec![(Vec::new(), Vec::new()); methods.len()];
    let mut crossed = 0;
    let mut motion = Vec::new();
    for turn in 0..RUNS / TURN {
        for (k, (name, method)) in methods.iter_mut().enumerate() {
            eprint!(
                "\r{threads} thread(s), turn {} of {}: {name:<20}",
                turn + 1,
                RUNS / TURN
            );
            let (points, numbers) = &mut states[k];
            for run in 0..=TURN {
                let start = Instant::now();
                method.construct(points, execution);
                let built = Instant::now();
                method.query(points, execution);
                let done = Instant::now();
                // The first run of a turn warms up.
                if run > 0 {
                    times[k].0.push((built - start).as_secs_f64());
                    times[k].1.push((done - built).as_secs_f64());
                }
                if turn == RUNS / TURN - 1 && run == TURN {
                    break;
                }
                motion.clear();
                motion.extend(points.iter().map(|_| numbers.vector(MOTION)));
                let by_chunk = points.par_chunks_mut(CHUNK).zip(motion.par_chunks(CHUNK));
                let changed: usize = by_chunk
                    .map(|(points, motion)| {
                        let pairs = points.iter_mut().zip(motion);
                        let changed = pairs.map(|(point, motion)| {
                            let before = grid.cell_of(*point);
                            *point += *motion;
                            usize::from(grid.cell_of(*point) != before)
                        });
                        changed.sum::<usize>()
                    })
                    .sum();
                crossed += if k == 0 { changed } else { 0 };
            }
        }
    }
    eprintln!();
    let points = &states[0].0;
    for (name, method) in &methods {
        check(name, &**method, points);
    }
    let motions = RUNS + RUNS / TURN - 1;
    let changed = crossed as f64 / (points.len() * motions) as f64;
    let particles = points.len() as f64;
    let neighbours: usize = (0..points.len())
        .step_by(CHECK_EVERY)
        .map(|row| methods[0].1.neighbours(row).len())
        .sum();
    println!(
        "{} particles, {threads} thread(s), {:.1} neighbours each, {:.2} % change their cell in a run; median of \
         {RUNS} runs",
        points.len(),
        neighbours as f64 / points.len().div_ceil(CHECK_EVERY) as f64,
        100.0 * changed
    );
    println!(
        "{:<16} {:>12} {:>8} {:>8} {:>7} {:>10} {:>10}",
        "ns a particle", "construction", "query", "total", "ratio", "index B", "lists B"
    );
    let mut reference = 0.0;
    for ((name, method), (construction, query)) in methods.iter().zip(&mut times) {
        let mut total: Vec<f64> = construction
            .iter()
            .zip(&*query)
            .map(|(a, b)| a + b)
            .collect();
        let total = median(&mut total);
        if *name == REFERENCE {
            reference = total;
        }
        let ns = |seconds: f64| 1e9 * seconds / particles;
        let bytes = method
            .bytes()
            .map_or(["-".to_owned(), "-".to_owned()], |(index, lists)| {
                [index, lists].map(|bytes| format!("{:.1}", bytes as f64 / particles))
            });
        println!(
            "{name:<16} {:>12.1} {:>8.1} {:>8.1} {:>7.2} {:>10} {:>10}",
            ns(median(construction)),
            ns(median(query)),
            ns(total),
            total / reference,
            bytes[0],
            bytes[1]
        );
    }
    println!();
}

fn main() {
    let has = |flag: &str| std::env::args().any(|argument| argument == flag);
    let size = if has("--million") {
        IVec3::new(128, 128, 64)
    } else {
        IVec3::new(64, 64, 32)
    };
    for threads in [2, 1] {
        let execution = Execution::new(threads).expect("threads");
        execution.install(|| measure(size, threads, &execution, !has("--own")));
    }
}
