//! Values that are spelled as another language spells them: `yes`, `1e3` for a whole number, a text without quotes, a
//! name before the value of a bracket that has none, a vector without brackets.

use super::place::{NOBODY, Place, Slip, variants_of};
use crate::loading::spans::{Kind, is_name, scan};

/// Words for `true` and `false`.
const TRUE: [&str; 5] = ["true", "yes", "on", "1", "t"];
const FALSE: [&str; 6] = ["false", "no", "off", "0", "none", "f"];

/// Signs of printed text in place of those of a keyboard: `−5`, `“name”`.
pub(super) fn signs_of_print(place: &Place, value: &str) -> Option<Slip> {
    let plain: String = (value.chars())
        .map(|c| match c {
            '−' | '–' | '—' => '-',
            '“' | '”' | '„' | '«' | '»' | '‘' | '’' | '‚' => '"',
            other => other,
        })
        .collect();
    let sign = value.chars().zip(plain.chars()).find(|(a, b)| a != b)?;
    let what = format!("`{}` is another sign than `{}`", sign.0, sign.1);
    place.takes(&plain).then(|| Slip::value(what, plain))
}

pub(super) fn slip(place: &Place, value: &str) -> Option<Slip> {
    truth(place, value)
        .or_else(|| whole_number(place, value))
        .or_else(|| text(place, value))
        .or_else(|| empty_bracket(place, value))
        .or_else(|| names_within(place, value))
        .or_else(|| decimal_comma(place, value))
}

/// A word for `true` or `false`.
fn truth(place: &Place, value: &str) -> Option<Slip> {
    let word = value.trim_matches(['"', '\'']).to_lowercase();
    let meant = [("true", &TRUE[..]), ("false", &FALSE[..])]
        .into_iter()
        .find(|(_, words)| words.contains(&word.as_str()))?
        .0;
    let is_truth = place.takes("true") && place.takes("false") && !place.takes("2");
    is_truth.then(|| Slip::value("expected `true` or `false`", meant.to_owned()))
}

/// Words for whole numbers.
const WORDS: [(&str, &str); 10] = [
    ("never", "0"),
    ("none", "0"),
    ("off", "0"),
    ("no", "0"),
    ("one", "1"),
    ("two", "2"),
    ("three", "3"),
    ("1d", "1"),
    ("2d", "2"),
    ("3d", "3"),
];

/// A word in place of a whole number.
pub(super) fn whole_word(place: &Place, value: &str) -> Option<Slip> {
    let word = value.trim_matches(['"', '\'']).to_lowercase();
    let meant = WORDS.iter().find(|(known, _)| *known == word)?.1;
    let takes_whole = (place.takes("1") || place.takes("2")) && !place.takes("1.5");
    let is_right = takes_whole && !place.takes("true") && place.takes(meant);
    is_right.then(|| Slip::value("expected a whole number", meant.to_owned()))
}

/// A number with a point or an exponent in place of a whole one.
fn whole_number(place: &Place, value: &str) -> Option<Slip> {
    let number: f64 = value.parse().ok()?;
    let takes_whole = place.takes("1") || place.takes("2");
    if value.parse::<i128>().is_ok() || !takes_whole || place.takes("1.5") {
        return None;
    }
    let whole = format!("{number:.0}");
    let is_whole = number.fract() == 0.0 && number.abs() < 1e15 && place.takes(&whole);
    let what = format!("expected a whole number, found `{value}`");
    Some(match is_whole {
        true => Slip::value(what, whole),
        false => Slip { what, meant: None },
    })
}

/// A text without quotes, or in single ones, alone or as the one value of a variant.
pub(super) fn text(place: &Place, value: &str) -> Option<Slip> {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./= :".contains(c);
    let bare = value.trim_matches('\'');
    if bare.is_empty() || !bare.chars().all(is_plain) || place.takes(NOBODY) {
        return None;
    }
    let quoted = format!("{bare:?}");
    if place.takes(&quoted) {
        return Some(Slip::value("a text stands in double quotes", quoted));
    }
    let known = variants_of(place)?;
    let variant = |known: &&str| format!("{known}({quoted})");
    let meant = known.iter().map(variant).find(|meant| place.takes(meant))?;
    let what = format!("expected one of {}, found `{value}`", known.join(", "));
    Some(Slip::value(what, meant))
}

/// A bracket behind a variant that has no values: `WendlandC2()`.
fn empty_bracket(place: &Place, value: &str) -> Option<Slip> {
    let bare = value.strip_suffix("()")?;
    let is_right = is_name(bare) && place.takes(bare);
    is_right.then(|| Slip::value("no bracket belongs here", bare.to_owned()))
}

/// Names of fields before values that have none: `(x: 0, y: 1, z: 0)`, `Fixed(dt: 0.001)`.
fn names_within(place: &Place, value: &str) -> Option<Slip> {
    let tree = scan(value)?;
    let Kind::Fields(fields) = &tree.kind else {
        return None;
    };
    let values: Vec<&str> = (fields.iter())
        .map(|field| &value[field.value.span.clone()])
        .collect();
    let meant = format!("{}({})", tree.name.unwrap_or_default(), values.join(", "));
    let is_meant = !values.is_empty() && place.takes(&meant);
    is_meant.then(|| Slip::value("the values in this bracket have no names", meant))
}

/// A decimal comma among the values of a bracket: `(0, -9,81, 0)`, `Time(0,5)`.
pub(super) fn decimal_comma(place: &Place, value: &str) -> Option<Slip> {
    let (start, end) = (value.find('(')?, value.strip_suffix(')')?.len());
    let (name, inner) = (&value[..start], value.get(start + 1..end)?);
    let is_number = |part: &&str| part.trim().parse::<f64>().is_ok();
    let parts: Vec<&str> = inner.split(',').collect();
    if !(name.is_empty() || is_name(name)) || !parts.iter().all(is_number) {
        return None;
    }
    // Digits right behind a comma.
    let joined: Vec<String> = (1..parts.len())
        .filter(|&k| parts[k].bytes().all(|byte| byte.is_ascii_digit()))
        .map(|k| {
            let whole = format!("{}.{}", parts[k - 1].trim(), parts[k]);
            let with = [&parts[..k - 1], &[whole.as_str()], &parts[k + 1..]].concat();
            let with: Vec<&str> = with.iter().map(|part| part.trim()).collect();
            format!("{name}({})", with.join(", "))
        })
        .filter(|joined| place.takes(joined))
        .collect();
    match &joined[..] {
        [] => None,
        [meant] => Some(Slip::value("a number has a decimal point", meant.clone())),
        _ => Some(Slip {
            what: format!(
                "a number has a decimal point, and there are {} numbers here: one too many",
                parts.len()
            ),
            meant: None,
        }),
    }
}

/// Signs that are missing or others': `=` for `:`, `;` or blanks for commas and brackets.
pub(super) fn signs(place: &Place, value: &str) -> Option<Slip> {
    let words: Vec<&str> = (value.split([' ', ';']))
        .filter(|word| !word.is_empty())
        .collect();
    let mut tried = vec![value.replace('=', ": "), format!("({})", words.join(", "))];
    if let Some(inner) = value
        .strip_prefix('(')
        .and_then(|rest| rest.strip_suffix(')'))
    {
        let words: Vec<&str> = inner.split_whitespace().collect();
        tried.push(format!("({})", words.join(", ")));
    }
    if value.starts_with(['(', '[']) {
        tried.push(value.replace(';', ","));
    }
    if let [name, rest @ ..] = &words[..]
        && is_name(name)
    {
        tried.push(format!("{name}({})", rest.join(", ")));
    }
    let right = |tried: &String| tried != value && place.takes(tried);
    let meant = tried.into_iter().find(right)?;
    Some(Slip::value("it is written otherwise here", meant))
}
