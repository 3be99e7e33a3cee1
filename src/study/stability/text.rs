//! The results for a terminal: one table per variant.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::{Class, PlannedMap, PointOf, Reading, StabilityPlan, Values, shares_of_limits};
use crate::study::text::short;

/// The classes after the most steps, and how far what is stable goes, beside what theory says.
pub fn text_of(plan: &StabilityPlan, readings: &[Reading]) -> String {
    let study = &plan.study;
    let mut text = format!("{}\n", study.title());
    let last = study.after.last().copied().unwrap_or(0);
    for map in &plan.maps {
        let of_map = |reading: &&Reading| reading.variant == map.name && reading.after == last;
        let of_map: Vec<&Reading> = readings.iter().filter(of_map).collect();
        let _ = writeln!(text, "\n{}, after {last} steps", map.name);
        if of_map.is_empty() {
            text.push_str("  no point is finished\n");
            continue;
        }
        if !matches!(map.y.values, Values::Edge { .. }) {
            grid(&mut text, map, &of_map);
        }
        edges(&mut text, plan, map, &of_map);
    }
    for note in &study.notes {
        let _ = writeln!(text, "\n{note}");
    }
    text
}

/// Classes by value, the greatest y first.
fn grid(text: &mut String, map: &PlannedMap, readings: &[&Reading]) {
    let (xs, ys) = (map.x.known_values(), map.y.known_values());
    let heading = format!("{} \\ {}", map.y.label(), map.x.label());
    let width = heading.chars().count().max(10);
    let _ = write!(text, "  {heading:<width$}");
    for &x in &xs {
        let _ = write!(text, " {:>13}", short(x));
    }
    text.push('\n');
    for &y in ys.iter().rev() {
        let _ = write!(text, "  {:<width$}", short(y));
        for &x in &xs {
            let runs = readings
                .iter()
                .filter(|reading| reading.x == x && reading.y == y);
            let _ = write!(text, " {:>13}", cell(runs.map(|reading| reading.class)));
        }
        text.push('\n');
    }
}

/// What the runs of a point are: their class, or how many of them are stable.
fn cell(classes: impl Iterator<Item = Class>) -> String {
    let mut counts = BTreeMap::new();
    for class in classes {
        *counts.entry(class).or_insert(0) += 1;
    }
    let all: u32 = counts.values().sum();
    let most = counts.iter().max_by_key(|(_, count)| **count);
    match (counts.get(&Class::Stable), most) {
        (_, None) => "-".to_owned(),
        (Some(stable), _) if *stable < all => format!("stable {stable}/{all}"),
        (_, Some((class, _))) => class.name().to_owned(),
    }
}

/// For each x how far y is stable with every seed, and the share of the limits that this is.
fn edges(text: &mut String, plan: &StabilityPlan, map: &PlannedMap, readings: &[&Reading]) {
    for x in map.x.known_values() {
        let _ = write!(text, "  {} = {}: ", map.x.name, short(x));
        let at_x: Vec<&Reading> = readings
            .iter()
            .copied()
            .filter(|reading| reading.x == x)
            .collect();
        let Some(y) = stable_up_to(map, &at_x) else {
            text.push_str("nothing is stable\n");
            continue;
        };
        let _ = write!(text, "stable up to {} = {}", map.y.name, short(y));
        let seed = plan.seeds()[0];
        let scene = plan.scene(PointOf { map, x, y, seed });
        let shares = scene
            .map(|scene| shares_of_limits(&scene))
            .unwrap_or_default();
        for (name, share) in shares {
            let _ = write!(text, ", {share:.2} of the limit by {name}");
        }
        text.push('\n');
    }
}

/// The last y, going from the stable end, up to which all runs are stable.
pub(in crate::study) fn stable_up_to(map: &PlannedMap, readings: &[&Reading]) -> Option<f64> {
    let mut ys: Vec<f64> = readings.iter().map(|reading| reading.y).collect();
    ys.sort_by(f64::total_cmp);
    ys.dedup();
    if matches!(map.y.values, Values::Edge { stable, unstable, .. } if stable > unstable) {
        ys.reverse();
    }
    let is_stable = |y: &f64| {
        let mut runs = readings.iter().filter(|reading| reading.y == *y);
        runs.all(|reading| reading.class == Class::Stable)
    };
    ys.into_iter().take_while(is_stable).last()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_says_what_its_runs_are() {
        use Class::{Drifting, Exploded, Stable};
        for (classes, expected) in [
            (&[][..], "-"),
            (&[Stable, Stable], "stable"),
            (&[Stable, Exploded, Stable], "stable 2/3"),
            (&[Exploded, Drifting, Exploded], "exploded"),
        ] {
            assert_eq!(cell(classes.iter().copied()), expected);
        }
    }
}
