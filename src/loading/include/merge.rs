//! Puts values and fields of fragments where a text names them.

use super::mapped::Mapped;
use super::{Source, WORD, included, includes};
use crate::loading::spans::{Field, Kind, Node, scan};
use crate::scene::SceneError;

impl Source {
    /// Appends a value, fragments put in.
    pub(super) fn put(
        &mut self,
        from: &Mapped,
        node: &Node,
        out: &mut Mapped,
        within: &mut Vec<usize>,
    ) -> Result<(), SceneError> {
        if let Some(path) = included(node) {
            let fragment = self.fragment((from, path), within)?;
            out.append(&fragment);
            return Ok(());
        }
        if !includes(node) {
            out.copy(from, node.span.clone());
            return Ok(());
        }
        let mut done = node.span.start;
        match &node.kind {
            Kind::Leaf => {}
            Kind::Fields(fields) => {
                return match fields.iter().filter(|field| field.key == WORD).count() {
                    0 => {
                        for field in fields {
                            out.copy(from, done..field.value.span.start);
                            self.put(from, &field.value, out, within)?;
                            done = field.value.span.end;
                        }
                        out.copy(from, done..node.span.end);
                        Ok(())
                    }
                    1 => self.put_fields(from, (node, fields), out, within),
                    _ => {
                        let twice = fields.iter().rfind(|field| field.key == WORD);
                        let at = twice.map_or(node.span.start, |field| field.key_span.start);
                        let message = "`include` is given twice; write a list, `include: [\"a.ron\", \"b.ron\"]`";
                        self.refuse(from.origin(at), message.to_owned())
                    }
                };
            }
            Kind::Tuple(items) | Kind::List(items) => {
                let is_list = matches!(node.kind, Kind::List(_));
                for item in items {
                    out.copy(from, done..item.span.start);
                    done = item.span.end;
                    match included(item) {
                        Some(path) if is_list => {
                            let fragment = self.fragment((from, path), within)?;
                            if !put_entries(&fragment, out) {
                                done = after_comma(&from.text, done);
                            }
                        }
                        _ => self.put(from, item, out, within)?,
                    }
                }
            }
        }
        out.copy(from, done..node.span.end);
        Ok(())
    }

    /// Appends a bracket with the fields of its fragments.
    fn put_fields(
        &mut self,
        from: &Mapped,
        (node, fields): (&Node, &[Field]),
        out: &mut Mapped,
        within: &mut Vec<usize>,
    ) -> Result<(), SceneError> {
        let mut fragments = Vec::new();
        let mut own = Vec::new();
        let mut at = from.origin(node.span.start);
        for field in fields {
            if field.key != WORD {
                let mut value = Mapped::default();
                self.put(from, &field.value, &mut value, within)?;
                own.push((
                    field.key.to_owned(),
                    value,
                    from.origin(field.key_span.start),
                ));
                continue;
            }
            at = from.origin(field.key_span.start);
            let paths = match &field.value.kind {
                Kind::List(items) => items.iter().collect(),
                _ => vec![&field.value],
            };
            for path in paths {
                let place = from.origin(path.span.start);
                fragments.push((self.fragment((from, path), within)?, place));
            }
        }
        let mut all: Vec<(String, Mapped, (usize, usize))> = Vec::new();
        for (fragment, place) in &fragments {
            let tree = scan(&fragment.text);
            let Some(Kind::Fields(fields)) = tree.as_ref().map(|tree| &tree.kind) else {
                let message = "a file of `include: …` holds fields, `(name: value, …)`; for a value write \
                               `field: include(\"…\")`";
                return self.refuse(*place, message.to_owned());
            };
            for field in fields {
                let mut value = Mapped::default();
                value.copy(fragment, field.value.span.clone());
                all.push((
                    field.key.to_owned(),
                    value,
                    fragment.origin(field.key_span.start),
                ));
            }
        }
        all.extend(own);
        // The name of a struct or a variant, and its bracket.
        let head = from.text[node.span.clone()].find('(').unwrap_or_default() + 1;
        out.copy(from, node.span.start..node.span.start + head);
        let mut keys: Vec<&str> = Vec::new();
        for (key, ..) in &all {
            if !keys.contains(&key.as_str()) {
                keys.push(key);
            }
        }
        for key in keys {
            let given: Vec<_> = all.iter().filter(|field| field.0 == key).collect();
            self.put_field(key, &given, out)?;
        }
        out.glue(")", at);
        Ok(())
    }

    /// Appends a field that is given once, or in lists that are joined.
    fn put_field(
        &self,
        key: &str,
        given: &[&(String, Mapped, (usize, usize))],
        out: &mut Mapped,
    ) -> Result<(), SceneError> {
        let Some((_, first, place)) = given.first() else {
            return Ok(());
        };
        out.glue(&format!("{key}: "), *place);
        if given.len() == 1 {
            out.append(first);
        } else {
            out.glue("[", *place);
            let is_list = |value: &Mapped| {
                scan(&value.text).is_some_and(|tree| matches!(tree.kind, Kind::List(_)))
            };
            if let [(_, _, first), .., (_, _, last)] = given
                && !given.iter().all(|field| is_list(&field.1))
            {
                let other = self.place(first.0, first.1);
                let message = format!(
                    "the field `{key}` is given here, and in {other}; keep one (lists alone are joined)"
                );
                return self.refuse(*last, message);
            }
            for (_, value, place) in given {
                if put_entries(value, out) {
                    out.glue(", ", *place);
                }
            }
            out.glue("]", *place);
        }
        out.glue(",\n", *place);
        Ok(())
    }
}

/// Appends the entries of a fragment that is a list, or the one that it is; whether there are any.
fn put_entries(fragment: &Mapped, out: &mut Mapped) -> bool {
    let tree = scan(&fragment.text);
    match tree.as_ref().map(|tree| &tree.kind) {
        Some(Kind::List(items)) => match (items.first(), items.last()) {
            (Some(first), Some(last)) => {
                out.copy(fragment, first.span.start..last.span.end);
                true
            }
            _ => false,
        },
        _ => {
            out.append(fragment);
            true
        }
    }
}

/// The byte after the comma that follows a value, if one does.
fn after_comma(text: &str, end: usize) -> usize {
    let rest = &text[end..];
    let trimmed = rest.trim_start();
    if trimmed.starts_with(',') {
        end + rest.len() - trimmed.len() + 1
    } else {
        end
    }
}
