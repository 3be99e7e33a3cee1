//! `overfall fields` and `overfall schema`: what a scene file may say, from the types themselves.

use std::collections::{BTreeSet, VecDeque};
use std::fmt::Write as _;

use overfall::scene::Scene;
use serde_json::{Map, Value};

use super::exit::{Exit, Failure};
use super::{console, options, report};

/// Lists the fields of a scene file.
pub(super) fn fields(options: &options::Fields) -> Result<Exit, Failure> {
    if options.json {
        return schema();
    }
    let schema = Scene::json_schema();
    let mut text = list(&schema, &options.words);
    if text.is_empty() {
        // Paths as `--set` takes them: the fields of `pressure` are those of its variants.
        let last = |word: &String| word.rsplit('.').next().unwrap_or_default().to_owned();
        let words: Vec<String> = options.words.iter().map(last).collect();
        let are_names = words.iter().all(|word| !word.is_empty());
        text = if are_names {
            list(&schema, &words)
        } else {
            text
        };
    }
    if text.is_empty() {
        return Err(Failure::Refused(format!(
            "no field or variant is called like {}; `overfall fields` lists them all",
            options.words.join(" or ")
        )));
    }
    console::print(&text)?;
    Ok(Exit::Done)
}

/// Prints the JSON schema of scene files.
pub(super) fn schema() -> Result<Exit, Failure> {
    console::print(&report::pretty(&Scene::json_schema())?)?;
    Ok(Exit::Done)
}

/// All types from the scene on, each once, with their fields and variants.
fn list(schema: &Value, words: &[String]) -> String {
    let mut text = String::new();
    let mut open = VecDeque::from([("Scene".to_owned(), schema.clone())]);
    let mut seen = BTreeSet::from(["Scene".to_owned()]);
    while let Some((name, of)) = open.pop_front() {
        let mut rows = Vec::new();
        rows_of(&of, "", &mut rows);
        for referred in references(&of) {
            if let Some(found) = schema["$defs"].get(&referred)
                && seen.insert(referred.clone())
            {
                open.push_back((referred, found.clone()));
            }
        }
        let is_wanted = |row: &&Row| {
            let path = format!("{name}.{}", row.name).to_lowercase();
            words.is_empty() || words.iter().any(|word| path.contains(&word.to_lowercase()))
        };
        let wanted: Vec<&Row> = rows.iter().filter(is_wanted).collect();
        if wanted.is_empty() {
            continue;
        }
        let (sentence, _) = meaning(&of);
        let _ = writeln!(
            text,
            "{}{name}: {sentence}",
            if text.is_empty() { "" } else { "\n" }
        );
        for row in wanted {
            let Row {
                name,
                kind,
                default,
                unit,
                sentence,
            } = row;
            let _ = writeln!(
                text,
                "  {name:<26} {kind:<22} {default:<16} {unit:<8} {sentence}"
            );
        }
    }
    text
}

/// A field or a variant.
struct Row {
    name: String,
    kind: String,
    default: String,
    unit: String,
    sentence: String,
}

/// The fields of a struct, or the variants of an enum with their fields.
fn rows_of(of: &Value, indent: &str, rows: &mut Vec<Row>) {
    if let Some(properties) = of["properties"].as_object() {
        let required: Vec<&str> = (of["required"].as_array().into_iter().flatten())
            .filter_map(Value::as_str)
            .collect();
        for (name, field) in properties {
            let (sentence, unit) = meaning(field);
            rows.push(Row {
                name: format!("{indent}{name}"),
                kind: kind(field),
                default: match field.get("default") {
                    _ if required.contains(&name.as_str()) => "required".to_owned(),
                    Some(default) => ron(default),
                    None => "none".to_owned(),
                },
                unit,
                sentence,
            });
        }
    }
    for variant in ["oneOf", "anyOf"]
        .iter()
        .flat_map(|of_many| of[of_many].as_array())
        .flatten()
    {
        variant_rows(variant, indent, rows);
    }
}

fn variant_rows(variant: &Value, indent: &str, rows: &mut Vec<Row>) {
    let (sentence, unit) = meaning(variant);
    let row = |name: &str, kind: &str| Row {
        name: format!("{indent}{name}"),
        kind: kind.to_owned(),
        default: String::new(),
        unit: unit.clone(),
        sentence: sentence.clone(),
    };
    let names = variant["enum"].as_array().into_iter().flatten();
    let names = names.chain([&variant["const"]]).filter_map(Value::as_str);
    rows.extend(names.map(|name| row(name, "variant")));
    for (name, content) in variant["properties"].as_object().into_iter().flatten() {
        let fields = content["properties"].is_object();
        let name = format!("{name}(…)");
        rows.push(if fields {
            row(&name, "variant")
        } else {
            row(&name, &kind(content))
        });
        if fields {
            rows_of(content, &format!("{indent}  "), rows);
        }
    }
}

/// What a value is, in the words of a reader.
fn kind(field: &Value) -> String {
    if let Some(name) = referred(field) {
        return name;
    }
    let either = field["anyOf"]
        .as_array()
        .or(field["allOf"].as_array())
        .or(field["oneOf"].as_array());
    if let Some(kinds) = either {
        let kinds: Vec<String> = kinds
            .iter()
            .map(kind)
            .filter(|kind| kind != "none")
            .collect();
        return kinds.join(" or ");
    }
    let name = match &field["type"] {
        Value::Array(names) => names
            .iter()
            .filter_map(Value::as_str)
            .find(|name| *name != "null"),
        name => name.as_str(),
    };
    match name {
        Some("array") => {
            let items = kind(&field["items"]);
            match field["maxItems"].as_u64() {
                Some(count) => format!("({})", vec![items; count as usize].join(", ")),
                None => format!("[{items}, …]"),
            }
        }
        Some("integer") => "whole number".to_owned(),
        Some("string") => "text".to_owned(),
        Some("boolean") => "true or false".to_owned(),
        Some("null") => "none".to_owned(),
        Some(name) => name.to_owned(),
        None => "any".to_owned(),
    }
}

/// The name of the type that a schema refers to.
fn referred(field: &Value) -> Option<String> {
    let path = field["$ref"].as_str()?;
    path.strip_prefix("#/$defs/").map(str::to_owned)
}

/// All types that a schema refers to, in their order.
fn references(of: &Value) -> Vec<String> {
    match of {
        Value::Object(fields) => {
            let own = referred(of).into_iter();
            let inner = fields.iter().filter(|(name, _)| *name != "$defs");
            own.chain(inner.flat_map(|(_, field)| references(field)))
                .collect()
        }
        Value::Array(items) => items.iter().flat_map(references).collect(),
        _ => Vec::new(),
    }
}

/// The first sentence of a description, and the unit in it.
fn meaning(of: &Value) -> (String, String) {
    let text = of["description"].as_str().unwrap_or_default();
    let (mut text, mut unit) = (text.to_owned(), String::new());
    if let Some(start) = text.find('[')
        && let Some(length) = text[start..].find(']')
        && !text[start + length..].starts_with("](")
        && !text[start..].starts_with("[`")
    {
        unit = text[start + 1..start + length].to_owned();
        text.replace_range(start..=start + length, "");
        text = text
            .replace(" .", ".")
            .replace(" ,", ",")
            .replace(" :", ":")
            .replace(" ;", ";");
    }
    let end = text.find(". ").map_or(text.len(), |at| at + 1);
    (text[..end].replace("  ", " ").trim().to_owned(), unit)
}

/// A value as a scene file writes it.
fn ron(value: &Value) -> String {
    let fields = |fields: &Map<String, Value>| match fields.iter().next() {
        // A variant.
        Some((name, content)) if fields.len() == 1 && name.starts_with(char::is_uppercase) => {
            match content {
                Value::Object(_) => format!("{name}{}", short(ron(content))),
                _ => format!("{name}({})", ron(content)),
            }
        }
        _ => {
            let fields: Vec<String> = fields
                .iter()
                .map(|(name, of)| format!("{name}: {}", ron(of)))
                .collect();
            short(format!("({})", fields.join(", ")))
        }
    };
    match value {
        Value::Null => "none".to_owned(),
        Value::Object(of) => fields(of),
        Value::Array(items) if items.iter().all(Value::is_number) && !items.is_empty() => {
            let items: Vec<String> = items.iter().map(ron).collect();
            format!("({})", items.join(", "))
        }
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(ron).collect();
            format!("[{}]", items.join(", "))
        }
        Value::String(name) if name.starts_with(char::is_uppercase) => name.clone(),
        // Numbers are of single precision.
        Value::Number(number) => number
            .as_f64()
            .map_or_else(|| number.to_string(), |x| (x as f32).to_string()),
        other => other.to_string(),
    }
}

/// A bracket that is too long for a column.
fn short(text: String) -> String {
    if text.len() > 40 {
        "(…)".to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_description_is_a_sentence_and_a_unit() {
        let of = |text: &str| meaning(&serde_json::json!({ "description": text }));
        assert_eq!(
            of("Distance of the particles at rest [m]. More of it."),
            (
                "Distance of the particles at rest.".to_owned(),
                "m".to_owned()
            )
        );
        assert_eq!(
            of("See [`Scene`](x)."),
            ("See [`Scene`](x).".to_owned(), String::new())
        );
    }

    /// Every field has a meaning, and every number a unit, if only `-`.
    #[test]
    fn all_fields_are_listed_with_their_meaning() {
        let text = list(&Scene::json_schema(), &[]);
        for part in [
            "spacing ",
            "max_density_error",
            "Laminar(…)",
            "kinematic_viscosity",
            "BoundaryShape:",
            "GaugeKind:",
            "amplitude",
            "0.0001",
        ] {
            assert!(text.contains(part), "{part} is missing:\n{text}");
        }
        let bare: Vec<&str> = text
            .lines()
            .filter(|line| line.starts_with("  ") && line.trim_end().len() < 60)
            .collect();
        assert!(bare.is_empty(), "without a meaning: {bare:#?}");
        let motion = list(&Scene::json_schema(), &["oscillation".to_owned()]);
        assert!(
            motion.contains("WallMotion") && !motion.contains("spacing "),
            "{motion}"
        );
    }
}
