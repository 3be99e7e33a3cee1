//! Time to find all neighbours of all particles, by spatial structure.
//!
//! `cargo bench --bench neighbour_search` uses 131 072 particles, `-- --million` 1 048 576. Particles lie on a cubic
//! lattice of spacing 1 in Z-curve order, displaced by up to 0.2 along each axis, with about 29 neighbours within a
//! distance of 2. Between two runs each moves by up to 0.02 along each axis, identically for every method, in parallel,
//! so that all threads are awake when the measurement starts. The methods take turns of five runs: each finds the
//! caches as it left them, and disturbances of the machine affect all alike. Figures are medians over the runs.
//!
//! `methods.rs` has the methods, among them k-d and R-trees of other crates for comparison. The lists of every method
//! are checked against brute force for a few hundred particles.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "it reports")]

use std::time::Instant;

use glam::{IVec3, Vec4};
use overfall::{
    index::{Grid, z_curve},
    scene::{Dimension, RowOrder},
    state::Execution,
};
use rayon::prelude::*;

mod methods;

use methods::{CHUNK, Method, RADIUS, REFERENCE, methods};

const JITTER: f32 = 0.2;
const MOTION: f32 = 0.02;
const RUNS: usize = 20;
/// Consecutive runs of a method.
const TURN: usize = 5;
/// Distance between rows that are checked against brute force.
const CHECK_EVERY: usize = 509;

/// A small random number generator with the same numbers on every machine.
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

/// The particles in Z-curve order.
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
    z_curve::sort_handles(&points, (grid, RowOrder::ZCurve), execution, &mut handles);
    let sorted = handles.iter().map(|handle| points[handle.1 as usize]);
    sorted.collect()
}

/// Checks lists against brute force.
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

/// Construction and query times of every run of a method \[s].
type Times = (Vec<f64>, Vec<f64>);

/// Runs all methods in turns. Returns their times, the final positions, and the number of points that changed their
/// cell.
fn run_in_turns(
    methods: &mut [(&'static str, Box<dyn Method>)],
    start: &[Vec4],
    grid: &Grid,
    (threads, execution): (usize, &Execution),
) -> (Vec<Times>, Vec<Vec4>, usize) {
    let mut states: Vec<_> = methods
        .iter()
        .map(|_| (start.to_vec(), Numbers(2)))
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
                // The first run of a turn is a warm-up.
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
    (times, states.swap_remove(0).0, crossed)
}

fn measure(size: IVec3, threads: usize, execution: &Execution, peers: bool) {
    let grid = Grid::new(Dimension::Three, RADIUS, 1.0);
    let mut methods = methods(&grid);
    if !peers {
        methods.truncate(5);
    }
    let start = lattice(size, &grid, execution);
    let (mut times, points, crossed) =
        run_in_turns(&mut methods, &start, &grid, (threads, execution));
    for (name, method) in &methods {
        check(name, &**method, &points);
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
        "ns per particle", "construction", "query", "total", "ratio", "index B", "lists B"
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
