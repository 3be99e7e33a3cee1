//! Brackets: lists in place of vectors, vectors that are too short or too long, or in place of a number, values of a
//! vector without its name and its bracket.

use serde::de::DeserializeOwned;

use super::{
    place::{Meant, NOBODY, Place, Slip, fields_of},
    spelling,
};
use crate::loading::spans::{Kind, Node};

/// Words for a vector of zeros.
const NOTHING: [&str; 5] = ["off", "none", "no", "false", "zero"];

/// A list in place of a vector, one value in place of either, and three values without a bracket.
pub(super) fn brackets(place: &Place, value: &str) -> Option<Slip> {
    let inner = (value.strip_prefix('[')).and_then(|rest| rest.strip_suffix(']'));
    let vector = format!("({})", inner.unwrap_or(value));
    let is_vector = is_vector(place);
    if is_vector && place.takes(&vector) {
        return Some(Slip::value("a vector has round brackets", vector));
    }
    let expected = |what: &str| Slip {
        what: format!("expected {what}, found `{value}`"),
        meant: None,
    };
    if is_vector && value.starts_with('(') && value.contains(':') {
        return Some(expected("a vector of three numbers, `(x, y, z)`"));
    }
    let rows = "((0, 0, 0), (0, 0, 0), (0, 0, 0))";
    if !is_vector && !value.starts_with('(') && place.takes(rows) && !place.takes(NOBODY) {
        return Some(expected("three rows of three numbers, `((…), (…), (…))`"));
    }
    if is_vector && !value.starts_with('(') {
        let otherwise = || {
            Some(Slip {
                meant: one_number(place, value),
                ..expected("a vector of three numbers, `(x, y, z)`")
            })
        };
        return spelling::signs(place, value).or_else(otherwise);
    }
    let is_pair = place.takes("(0, 1)") && !place.takes(NOBODY);
    if is_pair && !value.starts_with('(') {
        return Some(expected("two numbers, `(from, to)`"));
    }
    let list = format!("[{value}]");
    let is_list = inner.is_none() && place.takes(&list);
    if is_list {
        return Some(Slip::value("expected a list", list));
    }
    in_place_of_number(place, value)
}

fn is_vector(place: &Place) -> bool {
    place.takes("(0, 0, 0)") && !place.takes(NOBODY)
}

/// The vector that one number, or a word for none, stands for: gravity is along −y.
fn one_number(place: &Place, value: &str) -> Option<Meant> {
    let number = value.parse::<f64>().ok();
    let vector = match number {
        Some(0.0) => "(0, 0, 0)".to_owned(),
        Some(number) if place.is_value_of("gravity") => format!("(0, {}, 0)", -number.abs()),
        Some(_) => return None,
        None if NOTHING.contains(&value.to_lowercase().as_str()) => "(0, 0, 0)".to_owned(),
        None => return None,
    };
    (place.takes(&vector)).then_some(Meant::Value(vector))
}

/// The numbers in a bracket.
pub(super) fn numbers(value: &str) -> Option<Vec<&str>> {
    let inner = (value
        .strip_prefix('(')
        .and_then(|rest| rest.strip_suffix(')')))
    .or_else(|| {
        value
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'))
    })?;
    let parts = inner.trim().trim_end_matches(',').split(',').map(str::trim);
    let parts: Vec<&str> = parts.collect();
    let are_numbers = parts.iter().all(|part| part.parse::<f64>().is_ok());
    are_numbers.then_some(parts)
}

/// A bracket in place of a number: the number in it, or the length of a vector along an axis.
fn in_place_of_number(place: &Place, value: &str) -> Option<Slip> {
    let parts = numbers(value)?;
    let is_number = place.takes("1") && !place.takes(NOBODY) && !place.takes("\"1\"");
    let mut along = parts.iter().filter(|part| part.parse() != Ok(0.0_f64));
    let meant = match (&parts[..], along.next(), along.next()) {
        (&[only], ..) => Some(only.to_owned()),
        (_, Some(only), None) => Some(only.trim_start_matches('-').to_owned()),
        _ => None,
    };
    let meant = meant.filter(|meant| is_number && place.takes(meant))?;
    Some(Slip::value(
        format!("expected a number, found `{value}`"),
        meant,
    ))
}

/// A vector of too few or too many numbers; in a plane two are enough to know the third.
pub(super) fn length(place: &Place, value: &str) -> Option<Slip> {
    let parts = numbers(value)?;
    if parts.len() == 3 || !is_vector(place) {
        return None;
    }
    let what = format!("expected 3 numbers, found {}", parts.len());
    Some(match &parts[..] {
        [x, y] => Slip::value(what, format!("({x}, {y}, 0)")),
        _ => Slip { what, meant: None },
    })
}

/// The slip in three numbers without the name of the vector that they are, or its bracket too: `Height(0.5, 0, 0.5)`,
/// `camera: (1, 1, 1)`. Also where they begin.
pub(in crate::loading) fn slip_of_vector<T: DeserializeOwned>(
    text: &str,
    around: &Node,
) -> Option<(String, usize)> {
    let Kind::Tuple(items) = &around.kind else {
        return None;
    };
    let [first, _, last] = &items[..] else {
        return None;
    };
    let is_number = |item: &Node| text[item.span.clone()].parse::<f64>().is_ok();
    if !items.iter().all(is_number) {
        return None;
    }
    let span = first.span.start..last.span.end;
    let found = &text[span.clone()];
    let place = Place::of::<T>(text, span.clone())?;
    let known = fields_of(&place, &format!("{NOBODY}: 0"))?;
    let mut named = known.iter().map(|field| format!("{field}: ({found})"));
    let meant = named.find(|named| place.takes(named))?;
    let what = format!(
        "expected the name of a field ({}) before `{found}`",
        known.join(", ")
    );
    Some((Slip::value(what, meant).in_file(found), span.start))
}
