//! Data layouts for gathering the positions of neighbours: an array of `Vec3` as in the tables, a packed copy of
//! `Vec4`, or one column per coordinate; with rows along the Z-curve and in random order.
//!
//! `cargo bench --bench gathers` uses 130 000 particles.
//!
//! A pass sums `|x_i − x_j|²` over the lists of the corner dam break, as passes that need only positions do, or `(t_i +
//! t_j) |x_i − x_j|²`, as the pressure force does. It consists of gathers only and runs on one thread. Layouts take
//! turns, and every figure is the minimum of its runs.
#![allow(clippy::print_stdout, reason = "a benchmark talks to its reader")]

use std::{array::from_fn, hint::black_box, path::Path, time::Instant};

use glam::{Vec3, Vec4};
use overfall::{
    Simulation,
    neighbours::FluidNeighbours,
    scene::Scene,
    simd::{InstructionSet, LANES, Lanes, Simd, Vectorised},
    state::Positions,
};

/// Steps before the lists are taken, and runs per layout.
const STEPS: usize = 100;
const RUNS: usize = 15;

/// Neighbour lists, concatenated.
struct Lists {
    ends: Vec<usize>,
    rows: Vec<u32>,
}

impl Lists {
    /// Every row with its list.
    fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts
            .zip(&self.ends)
            .map(|(start, &end)| &self.rows[start..end])
    }
}

/// A layout of positions, with a term for each.
trait Layout: Copy {
    /// One row.
    fn one(self, row: usize) -> Vec4;
    /// Eight rows; lanes without a row have arbitrary values. Terms are loaded only if they are not beside the
    /// positions.
    fn eight<S: Simd>(self, simd: S, rows: &[u32]) -> [S::F; 3];
    /// The same with terms.
    fn eight_with_terms<S: Simd>(self, simd: S, rows: &[u32]) -> [S::F; 4];
}

/// Positions as in the tables, and the terms.
#[derive(Clone, Copy)]
struct Tables<'a>(&'a [Vec3], &'a [f32]);

/// Sixteen bytes per row, which one load reads.
#[derive(Clone, Copy)]
struct Packed<'a>(&'a [Vec4]);

/// One column per coordinate, and one for the terms.
#[derive(Clone, Copy)]
struct Columns<'a>([&'a [f32]; 4]);

/// Eight values of a column.
#[inline(always)]
fn gather<S: Simd>(simd: S, column: &[f32], rows: &[u32]) -> S::F {
    simd.load(&Lanes(from_fn(|lane| column[of_lane(rows, lane)])))
}

/// Row of a lane in a list that may have fewer entries.
#[inline(always)]
fn of_lane(rows: &[u32], lane: usize) -> usize {
    rows[lane.min(rows.len() - 1)] as usize
}

impl Layout for Tables<'_> {
    #[inline(always)]
    fn one(self, row: usize) -> Vec4 {
        self.0[row].extend(self.1[row])
    }

    #[inline(always)]
    fn eight<S: Simd>(self, simd: S, rows: &[u32]) -> [S::F; 3] {
        let points: [Vec3; LANES] = from_fn(|lane| self.0[of_lane(rows, lane)]);
        from_fn(|axis| simd.load(&Lanes(points.map(|point| point[axis]))))
    }

    #[inline(always)]
    fn eight_with_terms<S: Simd>(self, simd: S, rows: &[u32]) -> [S::F; 4] {
        let [x, y, z] = self.eight(simd, rows);
        [x, y, z, gather(simd, self.1, rows)]
    }
}

impl Layout for Packed<'_> {
    #[inline(always)]
    fn one(self, row: usize) -> Vec4 {
        self.0[row]
    }

    #[inline(always)]
    fn eight<S: Simd>(self, simd: S, rows: &[u32]) -> [S::F; 3] {
        let [x, y, z, _] = self.eight_with_terms(simd, rows);
        [x, y, z]
    }

    #[inline(always)]
    fn eight_with_terms<S: Simd>(self, simd: S, rows: &[u32]) -> [S::F; 4] {
        simd.gather(self.0, simd.rows(rows))
    }
}

impl Layout for Columns<'_> {
    #[inline(always)]
    fn one(self, row: usize) -> Vec4 {
        self.0.map(|column| column[row]).into()
    }

    #[inline(always)]
    fn eight<S: Simd>(self, simd: S, rows: &[u32]) -> [S::F; 3] {
        from_fn(|axis| gather(simd, self.0[axis], rows))
    }

    #[inline(always)]
    fn eight_with_terms<S: Simd>(self, simd: S, rows: &[u32]) -> [S::F; 4] {
        self.0.map(|column| gather(simd, column, rows))
    }
}

/// A pass with or without terms.
struct Pass<'a, L, const TERMS: bool>(L, &'a Lists);

impl<L: Layout, const TERMS: bool> Vectorised for Pass<'_, L, TERMS> {
    type Output = f32;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f32 {
        let Self(layout, lists) = self;
        let mut total = 0.0;
        for (row, mut rest) in lists.iter().enumerate() {
            let [x, y, z, own_term] = layout.one(row).to_array().map(|x| simd.splat(x));
            let mut sum = simd.splat(0.0);
            while !rest.is_empty() {
                let (others, terms) = if TERMS {
                    let [x, y, z, term] = layout.eight_with_terms(simd, rest);
                    ([x, y, z], simd.add(own_term, term))
                } else {
                    (layout.eight(simd, rest), simd.splat(1.0))
                };
                for (own, other) in [x, y, z].into_iter().zip(others) {
                    let x = simd.sub(own, other);
                    sum = simd.mul_add(simd.mul(terms, x), x, sum);
                }
                rest = rest.get(LANES..).unwrap_or_default();
            }
            total += simd.sum(sum);
        }
        total
    }
}

/// Positions in the three layouts, and the lists of their rows.
struct Fluid {
    tables: Vec<Vec3>,
    packed: Vec<Vec4>,
    columns: [Vec<f32>; 4],
    lists: Lists,
}

impl Fluid {
    fn new(tables: Vec<Vec3>, lists: Lists) -> Self {
        // The values of the terms do not matter.
        let packed: Vec<Vec4> = tables.iter().map(|x| x.extend(x.x + x.y)).collect();
        Self {
            columns: from_fn(|axis| packed.iter().map(|x| x[axis]).collect()),
            packed,
            tables,
            lists,
        }
    }

    /// The same with rows in random order.
    fn shuffled(&self) -> Self {
        let rows = self.tables.len();
        // Source of the k-th row: the multiplier is a prime, so every row occurs once.
        let from: Vec<usize> = (0..rows).map(|k| k * 7_368_787 % rows).collect();
        let mut to = vec![0; rows];
        for (k, &row) in from.iter().enumerate() {
            to[row] = k as u32;
        }
        let lists: Vec<&[u32]> = self.lists.iter().collect();
        let mut moved = Lists {
            ends: Vec::new(),
            rows: Vec::new(),
        };
        for &row in &from {
            let list = lists[row].iter().map(|&j| to[j as usize]);
            moved.rows.extend(list);
            moved.ends.push(moved.rows.len());
        }
        Self::new(from.iter().map(|&row| self.tables[row]).collect(), moved)
    }

    /// Nanoseconds per particle for every layout.
    fn time<const TERMS: bool>(&self) -> [f64; 3] {
        let set = InstructionSet::detect().arithmetic();
        let columns = self.columns.each_ref().map(Vec::as_slice);
        let tables = Tables(&self.tables, columns[3]);
        let passes: [&dyn Fn() -> f32; 3] = [
            &|| set.dispatch(Pass::<_, TERMS>(tables, &self.lists)),
            &|| set.dispatch(Pass::<_, TERMS>(Packed(&self.packed), &self.lists)),
            &|| set.dispatch(Pass::<_, TERMS>(Columns(columns), &self.lists)),
        ];
        let mut least = [f64::INFINITY; 3];
        for _ in 0..RUNS {
            for (pass, least) in passes.iter().zip(&mut least) {
                let start = Instant::now();
                black_box(pass());
                let seconds = start.elapsed().as_secs_f64();
                *least = least.min(1e9 * seconds / self.tables.len() as f64);
            }
        }
        least
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes/corner_dam_break_130k.ron");
    let mut simulation = Simulation::new(&Scene::load(&file, &[])?)?;
    for _ in 0..STEPS {
        simulation.step()?;
    }
    let world = simulation.world();
    let lists = world.resource::<FluidNeighbours>().lists();
    let points = world.resource::<Positions>().points();
    let mut all = Lists {
        ends: Vec::new(),
        rows: Vec::new(),
    };
    for row in 0..points.len() {
        all.rows.extend(lists.of(row));
        all.ends.push(all.rows.len());
    }
    let fluid = Fluid::new(points.iter().map(|x| x.truncate()).collect(), all);
    println!(
        "{} particles, {:.1} neighbours, ns a particle on one thread",
        points.len(),
        lists.pairs() as f64 / points.len() as f64
    );
    println!(
        "{:20} {:18} {:>8} {:>8} {:>8}",
        "rows", "pass takes", "Vec3", "Vec4", "columns"
    );
    for (rows, fluid) in [
        ("along the Z-curve", &fluid),
        ("in no order", &fluid.shuffled()),
    ] {
        let figures = [
            ("positions", fluid.time::<false>()),
            ("positions, terms", fluid.time::<true>()),
        ];
        for (takes, [tables, packed, columns]) in figures {
            println!("{rows:20} {takes:18} {tables:8.1} {packed:8.1} {columns:8.1}");
        }
    }
    Ok(())
}
