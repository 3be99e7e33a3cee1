//! Slips in the names of fields: a value without its name, a name of a deeper or another level.

use serde::de::DeserializeOwned;

use super::{
    named,
    place::{NOBODY, Place, fields_of, variants_of},
};
use crate::{
    loading::spans::{Field, Kind, Node},
    scene::known_as,
};

/// The slip at a name that no struct has, of a text that is well formed; `known` are the fields that there are.
pub(in crate::loading) fn slip_of_key<T: DeserializeOwned>(
    text: &str,
    tree: &Node,
    start: usize,
    known: &[&str],
) -> Option<String> {
    match place_at(tree, start)? {
        // `(Box(…))`, `(UniformGrid)`: the name is a value.
        At::Value(node) => {
            let place = Place::of::<T>(text, node.span.clone())?;
            let value = &text[node.span.clone()];
            Some(named(&place, value)?.in_file(value))
        }
        At::Field(field, beside) => {
            let (key, value) = (field.key, &text[field.value.span.clone()]);
            let span = field.key_span.start..field.value.span.end;
            let place = Place::of::<T>(text, span)?;
            let inner_of = |outer: &str| {
                let unknown = format!("({NOBODY}: 0)");
                match beside.iter().find(|field| field.key == outer) {
                    Some(field) => {
                        fields_of(&Place::of::<T>(text, field.value.span.clone())?, &unknown)
                    }
                    None => fields_of(&place, &format!("{outer}: {unknown}")),
                }
            };
            let meant = deeper(inner_of, key, value, known)
                .or_else(|| another(&place, value, beside, known));
            let Some(meant) = meant else {
                return in_variants::<T>(text, field, known);
            };
            Some(format!(
                "unknown field `{key}` here; did you mean `{meant}`?"
            ))
        }
    }
}

/// What begins at a byte.
enum At<'t, 'a> {
    /// A field, and those around it.
    Field(&'t Field<'a>, &'t [Field<'a>]),
    /// A value.
    Value(&'t Node<'a>),
}

fn place_at<'t, 'a>(node: &'t Node<'a>, start: usize) -> Option<At<'t, 'a>> {
    match &node.kind {
        Kind::Fields(fields) => {
            let own = fields.iter().find(|field| field.key_span.start == start);
            let inner = || {
                fields
                    .iter()
                    .find_map(|field| place_at(&field.value, start))
            };
            own.map(|own| At::Field(own, fields)).or_else(inner)
        }
        Kind::Tuple(items) | Kind::List(items) => items.iter().find_map(|item| {
            let own = (item.span.start == start && !matches!(node.kind, Kind::List(_)))
                .then_some(At::Value(item));
            own.or_else(|| place_at(item, start))
        }),
        Kind::Leaf => None,
    }
}

/// A field of a deeper level: `viscosity: 0.1` for `fluid: (viscosity: 0.1)`.
fn deeper(
    inner_of: impl Fn(&str) -> Option<Vec<&'static str>>,
    key: &str,
    value: &str,
    known: &[&str],
) -> Option<String> {
    let found = known.iter().filter_map(|outer| {
        let inner = inner_of(outer)?;
        let name = inner.iter().find(|inner| **inner == key).copied();
        let name = name.or_else(|| known_as(key, &inner))?;
        Some(format!("{outer}: ({name}: {value})"))
    });
    let found: Vec<String> = found.collect();
    match &found[..] {
        [only] => Some(only.clone()),
        _ => None,
    }
}

/// A field of variants of one of the fields: `Sesph(stiffness: 1000)` for `Sesph(equation: Tait(stiffness: 1000))`.
fn in_variants<T: DeserializeOwned>(text: &str, field: &Field, known: &[&str]) -> Option<String> {
    let (key, value) = (field.key, &text[field.value.span.clone()]);
    let span = field.key_span.start..field.value.span.end;
    let place = Place::of::<T>(text, span)?;
    let of_outer = |outer: &&str| {
        let inner = Place::of::<T>(text, place.span.clone())?.within(outer);
        let variants = variants_of(&inner).unwrap_or_default().into_iter();
        let has_it = |variant: &&str| {
            fields_of(&inner, &format!("{variant}({NOBODY}: 0)"))
                .is_some_and(|of| of.contains(&key))
        };
        let places = variants.filter(has_it);
        Some(
            places
                .map(|variant| format!("`{outer}: {variant}({key}: {value})`"))
                .collect(),
        )
    };
    let found: Vec<String> = (known.iter().filter_map(of_outer))
        .flat_map(|places: Vec<String>| places)
        .collect();
    match &found[..] {
        [] => None,
        [only] => Some(format!("unknown field `{key}` here; did you mean {only}?")),
        several => Some(format!(
            "unknown field `{key}` here; it is one of {}",
            several.join(", ")
        )),
    }
}

/// The one field that takes a value that has a name: `type: Sphere(…)` for `shape: Sphere(…)`.
fn another(place: &Place, value: &str, beside: &[Field], known: &[&str]) -> Option<String> {
    if !value.starts_with(|c: char| c.is_ascii_uppercase()) {
        return None;
    }
    let free = |name: &&&str| !beside.iter().any(|field| field.key == **name);
    let meant = known.iter().filter(free);
    let meant = meant.map(|name| format!("{name}: {value}"));
    let found: Vec<String> = meant.filter(|meant| place.takes(meant)).collect();
    match &found[..] {
        [only] => Some(only.clone()),
        _ => None,
    }
}
