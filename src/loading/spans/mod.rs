//! Where in a RON text a field stands.
//!
//! ron gives positions for what it cannot parse, but a value that parses and makes no sense has lost its place.
//! This is a scanner of RON's shape alone (brackets, names, commas) that keeps the byte range of every value.
//! Option 1: a position beside every field of the scene types. Option 2: a second, small reading of the text. We use
//! 2: it leaves the types plain, and it also finds where a `--set` override goes.

mod scan;

pub(in crate::loading) use scan::scan;

use std::ops::Range;

/// A value in the text.
#[derive(Debug, PartialEq)]
pub(in crate::loading) struct Node<'a> {
    /// Its bytes, from its first to its last character.
    pub(in crate::loading) span: Range<usize>,
    /// Name of a struct or variant.
    pub(in crate::loading) name: Option<&'a str>,
    pub(in crate::loading) kind: Kind<'a>,
}

#[derive(Debug, PartialEq)]
pub(in crate::loading) enum Kind<'a> {
    /// `(name: value, …)`
    Fields(Vec<Field<'a>>),
    /// `(value, …)`, with or without a name before it.
    Tuple(Vec<Node<'a>>),
    /// `[value, …]`
    List(Vec<Node<'a>>),
    /// A number, a string, a name, or a map (scenes have none).
    Leaf,
}

#[derive(Debug, PartialEq)]
pub(in crate::loading) struct Field<'a> {
    pub(in crate::loading) key: &'a str,
    pub(in crate::loading) key_span: Range<usize>,
    pub(in crate::loading) value: Node<'a>,
}

/// Why a path leads to no value.
#[derive(Debug, PartialEq)]
pub(in crate::loading) enum Lost<'t, 'a> {
    /// The struct `at` has no field of this name.
    NoField {
        at: &'t Node<'a>,
        known: Vec<&'a str>,
    },
    /// The list has only so many entries.
    NoEntry { length: usize },
    /// `at` is a single value, with nothing inside.
    NothingInside { at: &'t Node<'a> },
}

impl<'a> Node<'a> {
    /// Follows `path` as far as it leads: the last value found, the number of steps that led there, and why the next
    /// step leads nowhere, if there is one. Newtype variants and `Some` are walked through without a step.
    pub(in crate::loading) fn follow<'t>(
        &'t self,
        path: &[&str],
    ) -> (&'t Self, usize, Option<Lost<'t, 'a>>) {
        let mut node = self;
        for (done, step) in path.iter().enumerate() {
            match node.step(step) {
                Ok(next) => node = next,
                Err(lost) => return (node, done, Some(lost)),
            }
        }
        (node, path.len(), None)
    }

    fn step<'t>(&'t self, step: &str) -> Result<&'t Self, Lost<'t, 'a>> {
        match &self.kind {
            Kind::Fields(fields) => fields
                .iter()
                .find(|field| field.key == step)
                .map(|field| &field.value)
                .ok_or_else(|| Lost::NoField {
                    at: self,
                    known: fields.iter().map(|field| field.key).collect(),
                }),
            Kind::Tuple(items) | Kind::List(items) => {
                let vector = self.name.is_none() && matches!(self.kind, Kind::Tuple(_));
                let index = match step {
                    "x" if vector => Some(0),
                    "y" if vector => Some(1),
                    "z" if vector => Some(2),
                    _ => step.parse::<usize>().ok(),
                };
                match (index, items.as_slice()) {
                    (None, [inner]) if self.name.is_some() => inner.step(step),
                    (Some(index), items) => items.get(index).ok_or(Lost::NoEntry {
                        length: items.len(),
                    }),
                    (None, items) => Err(Lost::NoEntry {
                        length: items.len(),
                    }),
                }
            }
            Kind::Leaf => Err(Lost::NothingInside { at: self }),
        }
    }

    /// Calls `visit` with the path and the node of every leaf.
    pub(in crate::loading) fn leaves(&self, path: &str, visit: &mut impl FnMut(&str, &Self)) {
        let join = |step: &str| {
            if path.is_empty() {
                step.to_owned()
            } else {
                format!("{path}.{step}")
            }
        };
        match &self.kind {
            Kind::Fields(fields) => fields
                .iter()
                .for_each(|field| field.value.leaves(&join(field.key), visit)),
            Kind::Tuple(items) | Kind::List(items) => items
                .iter()
                .enumerate()
                .for_each(|(index, item)| item.leaves(&join(&index.to_string()), visit)),
            Kind::Leaf => visit(path, self),
        }
    }

    /// The innermost value whose range (its end included) holds the byte `at`.
    pub(in crate::loading) fn innermost(&self, at: usize) -> Option<&Self> {
        if at < self.span.start || at > self.span.end {
            return None;
        }
        let inner = self.children().find_map(|child| child.innermost(at));
        inner.or(Some(self))
    }

    /// The name that stands alone as a value and ends at the byte `at`.
    pub(in crate::loading) fn name_that_ends(&self, at: usize, text: &str) -> Option<&Self> {
        let mut inner = self
            .children()
            .filter_map(|child| child.name_that_ends(at, text));
        let is_it =
            self.kind == Kind::Leaf && self.span.end == at && is_name(&text[self.span.clone()]);
        inner.next().or_else(|| is_it.then_some(self))
    }

    /// The name that stands alone as a value, and is the last before the byte `at`.
    pub(in crate::loading) fn name_before<'t>(&self, at: usize, text: &'t str) -> Option<&'t str> {
        let mut last: Option<Range<usize>> = None;
        self.leaves("", &mut |_, leaf| {
            if leaf.span.end <= at && last.as_ref().is_none_or(|last| last.end < leaf.span.end) {
                last = Some(leaf.span.clone());
            }
        });
        let name = &text[last?];
        is_name(name).then_some(name)
    }

    /// The innermost value in brackets that is still open at the byte `at`.
    pub(in crate::loading) fn bracket(&self, at: usize) -> Option<&Self> {
        if self.kind == Kind::Leaf || !self.span.contains(&at) {
            return None;
        }
        let inner = self.children().find_map(|child| child.bracket(at));
        inner.or(Some(self))
    }

    /// The last key `name` that ends at or before the byte `at`.
    pub(in crate::loading) fn last_key(&self, name: &str, at: usize) -> Option<Range<usize>> {
        let fields: &[Field] = match &self.kind {
            Kind::Fields(fields) => fields,
            _ => &[],
        };
        let own = (fields.iter())
            .filter(|field| field.key == name)
            .map(|field| field.key_span.clone());
        let inner = self.children().filter_map(|child| child.last_key(name, at));
        own.chain(inner)
            .filter(|span| span.end <= at)
            .max_by_key(|span| span.end)
    }

    fn children(&self) -> impl Iterator<Item = &Self> {
        let (fields, items): (&[Field], &[Self]) = match &self.kind {
            Kind::Fields(fields) => (fields, &[]),
            Kind::Tuple(items) | Kind::List(items) => (&[], items),
            Kind::Leaf => (&[], &[]),
        };
        fields.iter().map(|field| &field.value).chain(items)
    }
}

/// Whether the text of a value is a name, and no number, text or word of RON.
pub(in crate::loading) fn is_name(value: &str) -> bool {
    value.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && value.chars().all(|c| c.is_alphanumeric() || c == '_')
        && !matches!(value, "true" | "false" | "None" | "inf" | "NaN")
}

/// Line and column, both from 1, of a byte of the text; columns count characters.
pub(in crate::loading) fn line_column(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte).unwrap_or(text);
    let line = 1 + before.matches('\n').count();
    let column = 1 + before.chars().rev().take_while(|&c| c != '\n').count();
    (line, column)
}

/// The byte of a line and column, both from 1.
pub(in crate::loading) fn byte_at(text: &str, line: usize, column: usize) -> usize {
    let start = match line {
        0 | 1 => 0,
        _ => text
            .match_indices('\n')
            .nth(line - 2)
            .map_or(text.len(), |(at, _)| at + 1),
    };
    let rest = &text[start..];
    rest.char_indices()
        .nth(column.saturating_sub(1))
        .map_or(text.len(), |(at, _)| start + at)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r##"#![enable(implicit_some)]
// A comment with a ( and a "
(
    name: "a \" ( quoted", /* nested /* ( */ */
    raw: r#"raw " ("#,
    list: [Box(min: (0, -1.5e3, NaN)), Ball],
    method: Pcisph((error: 0.01, mode: Largest)),
    maybe: Some((x: 1)),
    c: '(',
)"##;

    fn at(path: &str) -> &'static str {
        let tree = scan(TEXT).expect("well formed");
        let steps: Vec<&str> = path.split('.').collect();
        let (node, _, lost) = tree.follow(&steps);
        assert_eq!(lost, None, "{path}");
        &TEXT[node.span.clone()]
    }

    #[test]
    fn a_path_leads_to_the_bytes_of_its_value() {
        assert_eq!(at("name"), r#""a \" ( quoted""#);
        assert_eq!(at("raw"), r##"r#"raw " ("#"##);
        assert_eq!(at("list.0"), "Box(min: (0, -1.5e3, NaN))");
        assert_eq!(at("list.0.min.y"), "-1.5e3");
        assert_eq!(at("list.0.min.2"), "NaN");
        assert_eq!(at("list.1"), "Ball");
        assert_eq!(at("c"), "'('");
    }

    #[test]
    fn newtype_variants_and_some_need_no_step() {
        assert_eq!(at("method.error"), "0.01");
        assert_eq!(at("method.mode"), "Largest");
        assert_eq!(at("maybe.x"), "1");
    }

    #[test]
    fn a_path_that_ends_early_says_where_and_why() {
        let tree = scan(TEXT).expect("well formed");
        let (node, done, lost) = tree.follow(&["method", "eror"]);
        assert_eq!((done, node.name), (1, Some("Pcisph")));
        assert!(matches!(lost, Some(Lost::NoField { known, .. }) if known == ["error", "mode"]));
        let (_, _, lost) = tree.follow(&["list", "2"]);
        assert_eq!(lost, Some(Lost::NoEntry { length: 2 }));
    }

    #[test]
    fn line_and_column_count_characters_and_lead_back_to_the_byte() {
        let text = "α: 1,\nβγ: 2";
        let byte = text.find('2').expect("there");
        assert_eq!(line_column(text, byte), (2, 5));
        assert_eq!(byte_at(text, 2, 5), byte);
        assert_eq!(byte_at(text, 9, 9), text.len());
    }
}
