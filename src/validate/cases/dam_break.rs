//! Collapsing columns: front and height compared with experiments, and with the bound of shallow water theory.
//!
//! Lengths in widths L of the column, times in `T = t sqrt(2 g/L)`.

use super::{reference, texts};
use crate::{
    measure::Curve,
    scene::{Scene, Shape},
    validate::{Case, Comparison, Figure, Findings, Runner, Stopped, figure::at},
};

pub(in crate::validate) const KOSHIZUKA_OKA: Case = Case {
    name: "dam_break_koshizuka_oka",
    title: "The column of Koshizuka & Oka",
    texts: texts!("dam_break_koshizuka_oka"),
    across: "width",
    resolution: 20,
    resolutions: [10, 20, 40],
    sound_speed: SOUND_SPEED_OF_A_METRE * 0.54,
    measure: koshizuka_oka,
};

pub(in crate::validate) const MARTIN_MOYCE: Case = Case {
    name: "dam_break_martin_moyce",
    title: "The column of Martin & Moyce",
    texts: texts!("dam_break_martin_moyce"),
    across: "width",
    resolution: 20,
    resolutions: [10, 20, 40],
    sound_speed: SOUND_SPEED_OF_A_METRE * 0.338,
    measure: martin_moyce,
};

const KO_FRONT: &str =
    include_str!("../../../assets/reference/koshizuka_oka_1996_front_experiment.csv");
const MM_FRONT: &str =
    include_str!("../../../assets/reference/martin_moyce_1952_front_n2-2_a2.25in_table2.csv");
const MM_HEIGHT: &str =
    include_str!("../../../assets/reference/martin_moyce_1952_height_n2-2_a2.25in_table6.csv");
const RITTER: &str = include_str!("../../../assets/reference/ritter_1892_front.csv");

/// Ten times 2 sqrt(g H) for H = 1 m \[m/s]; it goes with sqrt(H).
const SOUND_SPEED_OF_A_METRE: f32 = 62.6;

/// Reading of Martin & Moyce's clock, in T, when a column without a gate starts, as others assume it (see the file).
const CLOCK_AT_START: f64 = 0.175;

/// Results of a run over T \[L].
struct Collapse {
    front: Vec<(f64, f64)>,
    height: Vec<(f64, f64)>,
    /// Largest ratio of the front's distance to Ritter's.
    ritter: f64,
}

fn collapse(scene: &Scene, dam: &mut Runner) -> Result<Collapse, Stopped> {
    let Shape::Box { max, .. } = scene.bodies[0].shape else {
        return Err(Stopped::Refused("the column is no box".to_owned()));
    };
    let (width, column) = (f64::from(max.x), f64::from(max.y));
    let g = f64::from(-scene.gravity.y);
    let unit = (2.0 * g / width).sqrt();
    let ritter = reference(RITTER, ["T", "x_over_H"], |[t, x]| {
        (t * (column / g).sqrt(), x * column)
    })?;
    dam.steps(f64::from(scene.duration), |_, _| {})?;
    let fronts = dam.readings("front", "front_m");
    let dx = f64::from(scene.spacing);
    // The front starts from a lattice: its position is known to a spacing.
    let ways = fronts
        .iter()
        .map(|&(t, x)| (x - width - dx) / at(&ritter.points, t));
    let ritter = ways.fold(0.0, f64::max);
    let in_widths = |start: f64, readings: &[(f64, f64)]| {
        let scaled = readings.iter().map(|&(t, x)| (unit * t, x / width));
        [(0.0, start)].into_iter().chain(scaled).collect()
    };
    Ok(Collapse {
        front: in_widths(1.0, &fronts),
        height: in_widths(column / width, &dam.readings("height", "height_m")),
        ritter,
    })
}

/// The points of an experiment that a run reached, if its clock is `late` behind the experiment's \[T].
fn reached<'a>(
    run: &'a [(f64, f64)],
    experiment: &'a Curve,
    late: f64,
) -> impl Iterator<Item = (f64, f64, f64)> + use<'a> {
    let end = run.last().map_or(0.0, |last| last.0);
    let points = experiment.points.iter();
    points
        .filter(move |(time, _)| (0.0..=end).contains(&(time - late)))
        .map(move |&(time, value)| (time, at(run, time - late), value))
}

fn figures(what: &str, run: &[(f64, f64)], experiment: &Curve, late: f64) -> Vec<Figure> {
    let figure = |(time, measured, known)| {
        let name = format!("{what} at T = {time:.2} [L]");
        Figure::exact(name, measured, known).by_experiment()
    };
    reached(run, experiment, late).map(figure).collect()
}

/// Root mean square of the difference from an experiment \[L].
fn distance(run: &[(f64, f64)], experiment: &Curve, late: f64) -> f64 {
    let squares = reached(run, experiment, late).map(|(_, a, b)| (a - b).powi(2));
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), square| {
        (sum + square, count + 1.0)
    });
    (sum / count).sqrt()
}

fn comparison(
    (name, y): (&'static str, &'static str),
    measured: Vec<(f64, f64)>,
    known: Curve,
) -> Comparison {
    Comparison {
        name,
        x: "t sqrt(2 g/L)",
        y,
        measured,
        known,
    }
}

fn ritter(found: &Collapse) -> Figure {
    Figure::residual("largest way of the front [Ritter's]", found.ritter).by_experiment()
}

fn koshizuka_oka(scene: &Scene, dam: &mut Runner) -> Result<Findings, Stopped> {
    let mut known = reference(KO_FRONT, ["T", "Z"], |[t, z]| (t, z))?;
    let found = collapse(scene, dam)?;
    // It starts at the edge of the column.
    let start = known.points.remove(0);
    let mut figures = figures("front", &found.front, &known, 0.0);
    let rms = distance(&found.front, &known, 0.0);
    known.points.insert(0, start);
    figures.push(Figure::residual("rms distance of the front [L]", rms).by_experiment());
    figures.push(ritter(&found));
    Ok(Findings {
        figures,
        comparisons: vec![comparison(("front", "front [L]"), found.front, known)],
    })
}

fn martin_moyce(scene: &Scene, dam: &mut Runner) -> Result<Findings, Stopped> {
    let fronts = reference(MM_FRONT, ["T", "Z"], |[t, z]| (t, z))?;
    // τ = t sqrt(g/a), heights in 2 a.
    let heights = reference(MM_HEIGHT, ["tau", "H"], |[tau, height]| {
        (tau * 2.0_f64.sqrt(), 2.0 * height)
    })?;
    let found = collapse(scene, dam)?;
    let mut all = figures("front", &found.front, &fronts, CLOCK_AT_START);
    // The shift is known only for the table of fronts: with it, the heights of every method are about 5 % above the
    // table's.
    all.extend(figures("height", &found.height, &heights, 0.0));
    let shifts = (0..=100).map(|k| 0.005 * f64::from(k));
    let fits = shifts.map(|late| (distance(&found.front, &fronts, late), late));
    let best = fits.min_by(|a, b| a.0.total_cmp(&b.0));
    let (rms, late) = best.unwrap_or((f64::NAN, f64::NAN));
    let mut push = |figure: Figure| all.push(figure.by_experiment());
    push(Figure::exact(
        "clock at the start that fits best [T]",
        late,
        CLOCK_AT_START,
    ));
    push(Figure::residual(
        "rms distance of the front with that clock [L]",
        rms,
    ));
    let rms = distance(&found.height, &heights, 0.0);
    push(Figure::residual("rms distance of the height [L]", rms));
    push(ritter(&found));
    let shifted = found.front.iter().map(|&(t, x)| (t + late, x)).collect();
    Ok(Findings {
        figures: all,
        comparisons: vec![
            comparison(("front", "front [L], clock fitted"), shifted, fronts),
            comparison(
                ("height", "height at the back wall [L]"),
                found.height,
                heights,
            ),
        ],
    })
}
