//! Common slips, answered in the reader's words: what was meant by a value that cannot be read.
//!
//! Option 1: a table of fields and of what people write there. Option 2: the text is read again with other values in
//! its place; what can be read then was meant. We use 2: ron itself says which variants and fields there are, so a
//! field that is added later is answered, too.

mod keys;
mod place;
mod spelling;
mod vectors;

use std::ops::Range;

use ron::error::Error;
use serde::de::DeserializeOwned;

use super::spans::{Field, Kind, is_name, scan};
use crate::scene::{elsewhere, unknown_name};
use place::{Meant, NOBODY, Place, fields_of, variants_of};

pub(super) use keys::slip_of_key;
pub(super) use place::Slip;
pub(super) use vectors::slip_of_vector;

/// The slip in the value at `span` of a text that is no `T`, if it is a known one.
pub(super) fn slip<T: DeserializeOwned>(text: &str, span: Range<usize>) -> Option<Slip> {
    let place = Place::of::<T>(text, span)?;
    let value = text[place.span.clone()].trim();
    spelling::signs_of_print(&place, value)
        .or_else(|| spelling::whole_word(&place, value))
        .or_else(|| number(&place, value))
        .or_else(|| spelling::slip(&place, value))
        .or_else(|| quotes(&place, value))
        .or_else(|| vectors::brackets(&place, value))
        .or_else(|| variants(&place, value))
        .or_else(|| fields(&place, value))
        .or_else(|| named(&place, value))
        .or_else(|| spelling::signs(&place, value))
}

/// The slip in a name that is no variant, if it is the value of one.
pub(super) fn slip_of_name<T: DeserializeOwned>(text: &str, span: Range<usize>) -> Option<Slip> {
    let place = Place::of::<T>(text, span)?;
    spelling::text(&place, text[place.span.clone()].trim())
}

/// The slip in the values of a bracket: one has a decimal comma, or one is missing or too many.
pub(super) fn slip_within<T: DeserializeOwned>(text: &str, span: Range<usize>) -> Option<Slip> {
    let place = Place::of::<T>(text, span)?;
    let value = text[place.span.clone()].trim();
    spelling::decimal_comma(&place, value).or_else(|| vectors::length(&place, value))
}

/// The slip in the number around a byte of a text that is not even RON, and where it begins: `0,05` and `1 s` are two
/// values without a name or a comma.
pub(super) fn slip_around<T: DeserializeOwned>(text: &str, byte: usize) -> Option<(String, usize)> {
    let start = 1 + text.get(..byte)?.rfind([':', '(', '[', '\n'])?;
    if let Some(found) = in_single_quotes::<T>(text, start) {
        return Some(found);
    }
    let is_part = |c: char| c.is_alphanumeric() || ",.+-% µ/^·".contains(c);
    let rest = &text[start..];
    let value = &rest[..rest.find(|c| !is_part(c)).unwrap_or(rest.len())];
    // A comment is none of it.
    let value = value.split("//").next().unwrap_or_default();
    let start = start + value.len() - value.trim_start().len();
    let value = value.trim().trim_end_matches([',', ' ']);
    if divides(value) {
        let what = "numbers are written out: there is no division";
        return Some((what.to_owned(), start));
    }
    let place = Place::of::<T>(text, start..start + value.len())?;
    let found = (number(&place, value).or_else(|| variants(&place, value)))
        .or_else(|| spelling::text(&place, value))?;
    Some((found.in_file(value), start))
}

/// Whether a text is a division of numbers, `1/1000`.
fn divides(value: &str) -> bool {
    let is_number = |text: &str| {
        text.trim()
            .starts_with(|c: char| c.is_ascii_digit() || c == '.')
    };
    value
        .split_once('/')
        .is_some_and(|(a, b)| is_number(a) && is_number(b))
}

/// A text in single quotes that begins there, and where.
fn in_single_quotes<T: DeserializeOwned>(text: &str, start: usize) -> Option<(String, usize)> {
    let rest = text[start..].trim_start();
    let length = rest.strip_prefix('\'')?.find('\'')? + 2;
    let start = text.len() - rest.len();
    let place = Place::of::<T>(text, start..start + length)?;
    let value = &rest[..length];
    Some((spelling::text(&place, value)?.in_file(value), start))
}

/// Units that people write, and what they are in SI. Of others nobody knows what was meant: 360deg are not 360 rad.
const UNITS: [(&str, f64); 35] = [
    ("s", 1.0),
    ("m", 1.0),
    ("kg", 1.0),
    ("Pa", 1.0),
    ("Hz", 1.0),
    ("N", 1.0),
    ("J", 1.0),
    ("rad", 1.0),
    ("rad/s", 1.0),
    ("1/s", 1.0),
    ("m/s", 1.0),
    ("m/s2", 1.0),
    ("m/s^2", 1.0),
    ("m/s²", 1.0),
    ("m2/s", 1.0),
    ("m^2/s", 1.0),
    ("m²/s", 1.0),
    ("kg/m3", 1.0),
    ("kg/m^3", 1.0),
    ("kg/m³", 1.0),
    ("kg/m2", 1.0),
    ("N/m", 1.0),
    ("fps", 1.0),
    ("GB", 1.0),
    ("ms", 1e-3),
    ("us", 1e-6),
    ("µs", 1e-6),
    ("min", 60.0),
    ("mm", 1e-3),
    ("cm", 1e-2),
    ("km", 1e3),
    ("kPa", 1e3),
    ("cm/s", 1e-2),
    ("g/cm3", 1e3),
    ("%", 1e-2),
];

/// A number with a decimal comma, a unit or quotes.
fn number(place: &Place, value: &str) -> Option<Slip> {
    let number = number_meant(value)?;
    if !place.takes(&number.plain) {
        return None;
    }
    Some(match number.meant {
        Some(meant) => Slip::value(number.what, meant),
        None => Slip {
            what: match number.unit {
                "" => number.what,
                unit => format!("{}, without `{unit}`", number.what),
            },
            meant: None,
        },
    })
}

/// A number as another language or a person writes it.
struct Number<'a> {
    what: String,
    unit: &'a str,
    /// Its figures alone.
    plain: String,
    /// What it is in SI units; none if its unit is not known here.
    meant: Option<String>,
}

/// What is wrong with a number, and what it is in SI units.
fn number_meant(value: &str) -> Option<Number<'_>> {
    let bare = value.trim_matches('"').trim();
    let is_exponent = |start: usize| {
        let rest = bare[start + 1..].trim_start_matches(['+', '-']);
        rest.starts_with(|c: char| c.is_ascii_digit())
    };
    let is_figure = |(k, c): (usize, char)| {
        c.is_ascii_digit() || "+-.,".contains(c) || (matches!(c, 'e' | 'E') && is_exponent(k))
    };
    let end = bare.char_indices().find(|&figure| !is_figure(figure));
    let (digits, unit) = bare.split_at(end.map_or(bare.len(), |(end, _)| end));
    let unit = unit.trim();
    let is_unit = |c: char| c.is_alphanumeric() || "/^%°·* ".contains(c);
    if !unit.chars().all(is_unit) {
        return None;
    }
    let (whole, part) = digits.split_once(',').unwrap_or((digits, ""));
    let plain = if part.is_empty() {
        whole.to_owned()
    } else if part.bytes().all(|digit| digit.is_ascii_digit()) {
        format!("{whole}.{part}")
    } else {
        return None;
    };
    let number: f64 = plain.parse().ok()?;
    // `1,000` is a thousand to some, and one to others.
    let is_group = part.len() == 3 && !whole.trim_start_matches(['+', '-']).starts_with('0');
    let factor = UNITS.iter().find(|(name, _)| *name == unit);
    let meant = match factor.map(|unit| unit.1) {
        Some(factor) if factor != 1.0 => Some((number * factor).to_string()),
        None if !unit.is_empty() => None,
        _ if is_group => None,
        _ => Some(plain.clone()),
    };
    let what = if !unit.is_empty() {
        "a number stands alone, in SI units".to_owned()
    } else if is_group {
        format!("a number has no comma: write `{plain}` or `{whole}{part}`")
    } else if digits.contains(',') {
        "a number has a decimal point".to_owned()
    } else if value.starts_with('"') {
        "a number has no quotes".to_owned()
    } else {
        return None;
    };
    Some(Number {
        what,
        unit,
        plain,
        meant,
    })
}

/// A variant or `true` in quotes, in capitals or not.
fn quotes(place: &Place, value: &str) -> Option<Slip> {
    let inner = value.strip_prefix('"')?.strip_suffix('"')?;
    let is_right = !inner.is_empty() && place.takes(inner);
    let meant = if is_right {
        inner.to_owned()
    } else {
        let known = variants_of(place)?;
        let same = |known: &&str| known.eq_ignore_ascii_case(inner);
        let Some(known) = known.iter().copied().find(same) else {
            let unknown = unknown_name("variant", inner, None, &known);
            let what = format!("no quotes belong here, and it is an {unknown}");
            return is_name(inner).then_some(Slip { what, meant: None });
        };
        if !place.takes(known) {
            let what = format!(
                "no quotes belong here, and the values of `{known}` in a bracket behind it"
            );
            return Some(Slip { what, meant: None });
        }
        known.to_owned()
    };
    Some(Slip::value("no quotes belong here", meant))
}

/// Something in place of one of some variants.
fn variants(place: &Place, value: &str) -> Option<Slip> {
    let expected = variants_of(place)?;
    if let Some(hint) = elsewhere("constant", &expected)
        && vectors::numbers(value).is_some()
    {
        let what = format!("expected one of {}: {hint}", expected.join(", "));
        return Some(Slip { what, meant: None });
    }
    let is_name = value.starts_with(|c: char| c.is_alphabetic());
    let mut meant = None;
    // With its unit, or its quotes, a number is none yet.
    let number = number_meant(value).and_then(|number| number.meant);
    let value_meant = number.as_deref().unwrap_or(value);
    for variant in expected.iter().filter(|_| !is_name) {
        let mut tried = vec![
            format!("{variant}({value_meant})"),
            format!("{variant}{value}"),
        ];
        if let Some(Error::MissingStructField { field, .. }) =
            place.refusal(&format!("{variant}()"))
        {
            tried.push(format!("{variant}({field}: {value_meant})"));
        }
        meant = tried.into_iter().find(|tried| place.takes(tried));
        if meant.is_some() {
            break;
        }
    }
    let meant = meant.or_else(|| without_bracket(place, value, &expected));
    // A name that is not known, or lacks something, has an answer of its own.
    let what = format!("expected one of {}, found `{value}`", expected.join(", "));
    let meant = meant.map(Meant::Value);
    (!is_name).then_some(Slip { what, meant })
}

/// A variant alone that has a bracket around it, with fields of its own beside it: `(shape: Tank(…), motion: …)`.
fn without_bracket(place: &Place, value: &str, expected: &[&str]) -> Option<String> {
    let tree = scan(value)?;
    let (inner, beside) = match &tree.kind {
        Kind::Tuple(items) | Kind::List(items) if items.len() == 1 => (&items[0], Vec::new()),
        // `(Fixed: 0.001)`
        Kind::Fields(fields) if fields.len() == 1 && expected.contains(&fields[0].key) => {
            let (key, inner) = (fields[0].key, &value[fields[0].value.span.clone()]);
            let meant = [format!("{key}({inner})"), format!("{key}{inner}")];
            return meant.into_iter().find(|meant| place.takes(meant));
        }
        Kind::Fields(fields) => {
            let is_variant = |field: &&Field| {
                let node = &field.value;
                let text = value[node.span.clone()].trim_matches('"');
                expected.contains(&node.name.unwrap_or(text))
            };
            let inner = fields.iter().find(is_variant)?;
            let others = fields
                .iter()
                .filter(|field| field.key_span != inner.key_span);
            let texts = others.map(|field| &value[field.key_span.start..field.value.span.end]);
            (&inner.value, texts.collect())
        }
        _ => return None,
    };
    let alone = value[inner.span.clone()].trim_matches('"');
    let meant = if beside.is_empty() {
        alone.to_owned()
    } else {
        // The variant's own bracket stays open for them.
        let open = alone
            .strip_suffix(')')
            .map_or_else(|| format!("{alone}("), str::to_owned);
        let open = open.trim_end_matches([',', ' ', '\n']);
        let comma = if open.ends_with('(') { "" } else { ", " };
        format!("{open}{comma}{})", beside.join(", "))
    };
    place.takes(&meant).then_some(meant)
}

/// One value in place of a struct that has a field for it.
fn fields(place: &Place, value: &str) -> Option<Slip> {
    let known = fields_of(place, &format!("({NOBODY}: 0)"))?;
    if value.starts_with('(') {
        return None;
    }
    if let Some((name, bare)) = value.find('(').map(|start| value.split_at(start))
        && is_name(name)
        && place.takes(bare)
    {
        let known = known.join(", ");
        let what = format!("expected `(…)` with the fields {known}, without the name `{name}`");
        return Some(Slip::value(what, bare.to_owned()));
    }
    let what = format!(
        "expected `(…)` with the fields {}, found `{value}`",
        known.join(", ")
    );
    let bare = value.trim_matches('"');
    for field in &known {
        let meant = match place.refusal(&format!("({field}: {value})")) {
            None => Some(Meant::Field((*field).to_owned())),
            // It belongs there, with another one beside it.
            Some(Error::MissingStructField { field: other, .. }) if known.contains(&other) => {
                Some(Meant::Value(format!("({field}: {value}, {other}: …)")))
            }
            Some(_) => None,
        };
        if meant.is_some() {
            return Some(Slip { what, meant });
        }
        let unquoted = format!("({field}: {bare})");
        if bare != value && !bare.is_empty() && place.takes(&unquoted) {
            return Some(Slip::value(what, unquoted));
        }
    }
    for field in &known {
        let list = format!("({field}: [{value}])");
        if place.takes(&list) {
            return Some(Slip::value(what, list));
        }
    }
    Some(Slip { what, meant: None })
}

/// A value within a bracket that lacks the name of its field.
fn named(place: &Place, value: &str) -> Option<Slip> {
    let known = fields_of(place, &format!("{NOBODY}: 0"))?;
    if known.contains(&value) || scan(value).is_none() {
        return None;
    }
    let what = format!(
        "expected the name of a field ({}) before `{value}`",
        known.join(", ")
    );
    let mut named = known.iter().map(|field| format!("{field}: {value}"));
    let meant = named.find(|named| place.takes(named)).map(Meant::Value);
    Some(Slip { what, meant })
}
