//! Collapsing columns: front and height against experiments, and the bound of shallow water.
//!
//! Lengths in widths L of the column, times in `T = t sqrt(2 g/L)`.

use overfall::{
    Simulation,
    measure::{front, height},
    scene::{Scene, Shape},
};

use super::{Case, Figure, at};
use crate::support::{particles_of, reference, run};

pub(crate) const KOSHIZUKA_OKA: Case = Case {
    scene: "dam_break_koshizuka_oka",
    sound_speed: SOUND_SPEED_OF_A_METRE * 0.54,
    measure: koshizuka_oka,
};

pub(crate) const MARTIN_MOYCE: Case = Case {
    scene: "dam_break_martin_moyce",
    sound_speed: SOUND_SPEED_OF_A_METRE * 0.338,
    measure: martin_moyce,
};

/// Ten times 2 sqrt(g H) for H = 1 m \[m/s]; it goes with sqrt(H).
const SOUND_SPEED_OF_A_METRE: f32 = 62.6;

/// What the clock of Martin & Moyce shows, in T, when a column without a gate starts.
const CLOCK_AT_START: f64 = 0.175;

/// What a run shows: rows of T and front, rows of T and height at the back wall, and the front's way over Ritter's.
struct Collapse {
    front: Vec<[f64; 2]>,
    height: Vec<[f64; 2]>,
    ritter: f64,
}

fn collapse(scene: &Scene, dam: &mut Simulation) -> Collapse {
    let Shape::Box { max, .. } = scene.bodies[0].shape else {
        panic!("the column is no box");
    };
    let (width, column) = (f64::from(max.x), f64::from(max.y));
    let g = f64::from(-scene.gravity.y);
    let unit = (2.0 * g / width).sqrt();
    let ritter = reference("ritter_1892_front.csv", ["T", "x_over_H"]);
    let mut found = Collapse {
        front: vec![[0.0, 1.0]],
        height: vec![[0.0, column / width]],
        ritter: 0.0,
    };
    let dx = scene.spacing;
    run(dam, f64::from(scene.duration), |dam, report| {
        let particles = particles_of(dam).into_iter();
        let positions: Vec<_> = particles.map(|p| p.position).collect();
        let now = f64::from(front(positions.iter().copied(), dx).expect("a front"));
        let top = height(positions.iter().copied(), [0.0, 2.0 * dx], dx);
        found.front.push([unit * report.time, now / width]);
        found
            .height
            .push([unit * report.time, f64::from(top.unwrap_or(0.0)) / width]);
        // The front starts from a lattice: it is known to a spacing.
        let way = now - width - f64::from(dx);
        let fastest = at(&ritter, report.time * (g / column).sqrt()) * column;
        found.ritter = found.ritter.max(way / fastest);
    });
    found
}

fn compare(what: &str, rows: &[[f64; 2]], experiment: &[[f64; 2]], start: f64) -> Vec<Figure> {
    let reached = rows.last().expect("rows")[0];
    let rows_in_time = experiment
        .iter()
        .filter(|[time, _]| *time - start <= reached);
    rows_in_time
        .map(|&[time, value]| {
            Figure::new(
                format!("{what} at T = {time:.2} [L]"),
                at(rows, time - start),
                value,
            )
        })
        .collect()
}

fn koshizuka_oka(scene: &Scene, dam: &mut Simulation) -> Vec<Figure> {
    let found = collapse(scene, dam);
    let experiment = reference("koshizuka_oka_1996_front_experiment.csv", ["T", "Z"]);
    let mut figures = compare("front", &found.front, &experiment[1..], 0.0);
    figures.push(Figure::residual(
        "largest way of the front [Ritter's]",
        found.ritter,
    ));
    figures
}

fn martin_moyce(scene: &Scene, dam: &mut Simulation) -> Vec<Figure> {
    let found = collapse(scene, dam);
    let front = reference(
        "martin_moyce_1952_front_n2-2_a2.25in_table2.csv",
        ["T", "Z"],
    );
    let heights = reference(
        "martin_moyce_1952_height_n2-2_a2.25in_table6.csv",
        ["tau", "H"],
    );
    // τ = t sqrt(g/a), heights in 2 a.
    let heights: Vec<[f64; 2]> = heights
        .iter()
        .map(|[tau, height]| [tau * 2.0_f64.sqrt(), 2.0 * height])
        .collect();
    let mut figures = compare("front", &found.front, &front, CLOCK_AT_START);
    // The shift is known of the table of fronts alone: with it, the heights of every method are some 5 % above the
    // table's.
    figures.extend(compare("height", &found.height, &heights, 0.0));
    figures.push(Figure::residual(
        "largest way of the front [Ritter's]",
        found.ritter,
    ));
    figures
}
