//! The results for a terminal.

use std::fmt::Write as _;

use super::{FrontierPlan, Runs, pareto_front};
use crate::study::short;

/// All points by error, those that nothing beats marked, and the settings that failed.
pub fn text_of(plan: &FrontierPlan, runs: &Runs) -> String {
    let mut text = format!("{}\n", plan.study.title());
    for figure in plan.study.measures() {
        let (points, failed) = runs.points(&figure);
        let front = pareto_front(&points);
        let _ = writeln!(
            text,
            "\nerror of {figure}; * nothing is as good for less time"
        );
        let label = |variant: &str, settings: &str| match settings {
            "" => variant.to_owned(),
            _ => format!("{variant}, {settings}"),
        };
        let labels = points.iter().map(|of| label(&of.variant, &of.settings));
        let failures = failed.iter().map(|of| label(&of.variant, &of.settings));
        let width = labels
            .clone()
            .chain(failures)
            .map(|label| label.chars().count())
            .max();
        let width = width.unwrap_or(0);
        let mut order: Vec<(usize, String)> = labels.enumerate().collect();
        order.sort_by(|a, b| points[a.0].error.total_cmp(&points[b.0].error));
        let _ = writeln!(
            text,
            "    {:<width$}  {:>9}  {:>9}  {:>19}",
            "", "error [-]", "s/s", "of the repeats"
        );
        for (k, label) in order {
            let point = &points[k];
            let mark = if front.contains(&k) { "*" } else { " " };
            let [cost, low, high] = point.cost.map(short);
            let error = short(point.error);
            let _ = writeln!(
                text,
                "  {mark} {label:<width$}  {error:>9}  {cost:>9}  {:>19}",
                format!("{low} – {high}")
            );
        }
        for of in &failed {
            let label = label(&of.variant, &of.settings);
            let _ = writeln!(
                text,
                "    {label:<width$}  {}: {}",
                of.class.name(),
                of.reason
            );
        }
    }
    for note in &plan.study.notes {
        let _ = writeln!(text, "\n{note}");
    }
    text
}
