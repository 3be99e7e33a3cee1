//! The JSON schema of scenes says of every shipped scene what the reader says.

use std::fs;
use std::path::Path;

use overfall::scene::Scene;
use serde_json::{Value, json};

/// What is wrong with a value by a schema, of the words that schemas of Rust types have; none if nothing is.
fn refusal(value: &Value, schema: &Value, root: &Value, path: &str) -> Option<String> {
    if let Some(name) = schema["$ref"].as_str() {
        let name = name.strip_prefix("#/$defs/").expect("a definition");
        assert!(!root["$defs"][name].is_null(), "no definition of {name}");
        if let Some(refusal) = refusal(value, &root["$defs"][name], root, path) {
            return Some(refusal);
        }
    }
    let of_type = |name: &str| match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        other => panic!("type {other}"),
    };
    let has_type = match &schema["type"] {
        Value::Null => true,
        Value::String(name) => of_type(name),
        Value::Array(names) => names.iter().filter_map(Value::as_str).any(of_type),
        other => panic!("type {other}"),
    };
    if !has_type {
        return Some(format!("{path}: {value} is no {}", schema["type"]));
    }
    if !schema["const"].is_null() && schema["const"] != *value {
        return Some(format!("{path}: not {}", schema["const"]));
    }
    if schema["enum"]
        .as_array()
        .is_some_and(|names| !names.contains(value))
    {
        return Some(format!("{path}: none of {}", schema["enum"]));
    }
    for (word, exactly) in [("oneOf", true), ("anyOf", false)] {
        let Some(ways) = schema[word].as_array() else {
            continue;
        };
        let found: Vec<_> = ways
            .iter()
            .map(|way| refusal(value, way, root, path))
            .collect();
        let fits = found.iter().filter(|refusal| refusal.is_none()).count();
        if fits == 0 || (exactly && fits > 1) {
            return Some(format!("{path}: {fits} of {word} fit: {found:?}"));
        }
    }
    if let Value::Array(items) = value {
        let count = items.len() as u64;
        let fewest = schema["minItems"].as_u64().unwrap_or(0);
        if !(fewest..=schema["maxItems"].as_u64().unwrap_or(u64::MAX)).contains(&count) {
            return Some(format!("{path}: {count} items"));
        }
        let of = |(k, item)| refusal(item, &schema["items"], root, &format!("{path}.{k}"));
        return items.iter().enumerate().find_map(of);
    }
    let Value::Object(fields) = value else {
        return None;
    };
    let properties = &schema["properties"];
    let closed = schema["additionalProperties"] == json!(false);
    let mut required = schema["required"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_str);
    if let Some(name) = required.find(|name| !fields.contains_key(*name)) {
        return Some(format!("{path}: no {name}"));
    }
    fields.iter().find_map(|(name, field)| {
        if closed && properties[name].is_null() {
            return Some(format!("{path}: unknown {name}"));
        }
        refusal(field, &properties[name], root, &format!("{path}.{name}"))
    })
}

fn shipped() -> Vec<Scene> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files: Vec<_> = ["assets/scenes", "assets/cases", "tests/corpus/scenes"]
        .iter()
        .flat_map(|folder| fs::read_dir(root.join(folder)).expect("a folder"))
        .map(|entry| entry.expect("an entry").path())
        .map(|path| {
            if path.is_dir() {
                path.join("scene.ron")
            } else {
                path
            }
        })
        .filter(|path| path.extension().is_some_and(|extension| extension == "ron"))
        .collect();
    files.sort();
    let scenes: Vec<Scene> = files
        .iter()
        .filter_map(|file| Scene::load(file, &[]).ok())
        .collect();
    assert!(scenes.len() >= 15, "{} scenes", scenes.len());
    scenes
}

#[test]
fn every_shipped_scene_fits_the_schema() {
    let schema = Scene::json_schema();
    for scene in shipped() {
        let value = serde_json::to_value(&scene).expect("JSON");
        assert_eq!(
            refusal(&value, &schema, &schema, ""),
            None,
            "{}",
            scene.name
        );
        // And the reader takes what fits.
        let read: Scene = serde_json::from_value(value).expect("a scene");
        assert_eq!(read, scene);
    }
}

/// A field of no name, and a text for any number, fit no more than they can be read.
#[test]
fn what_cannot_be_read_does_not_fit() {
    let schema = Scene::json_schema();
    let mut spoilt = 0;
    for scene in shipped().into_iter().take(8) {
        let whole = serde_json::to_value(&scene).expect("JSON");
        for pointer in pointers(&whole, String::new()) {
            let mut value = whole.clone();
            match value.pointer_mut(&pointer) {
                Some(Value::Object(fields)) => {
                    fields.insert("no_such_field".to_owned(), json!(1));
                }
                Some(number @ Value::Number(_)) => *number = json!("a text"),
                _ => continue,
            }
            spoilt += 1;
            let fits = refusal(&value, &schema, &schema, "").is_none();
            let is_read = serde_json::from_value::<Scene>(value).is_ok();
            assert_eq!(fits, is_read, "{}: {pointer}", scene.name);
        }
    }
    assert!(spoilt > 200, "{spoilt}");
}

/// Pointers to all values within a value.
fn pointers(value: &Value, at: String) -> Vec<String> {
    let inner: Vec<(String, &Value)> = match value {
        Value::Object(fields) => fields
            .iter()
            .map(|(name, field)| (name.clone(), field))
            .collect(),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .map(|(k, item)| (k.to_string(), item))
            .collect(),
        _ => Vec::new(),
    };
    let of = |(name, value): (String, &Value)| pointers(value, format!("{at}/{name}"));
    let mut all: Vec<String> = inner.into_iter().flat_map(of).collect();
    all.push(at);
    all
}

/// Every field is documented, and every default can be read.
#[test]
fn fields_have_meanings() {
    let schema = Scene::json_schema();
    let mut bare = Vec::new();
    for pointer in pointers(&schema, String::new()) {
        let Some(fields) = pointer
            .ends_with("/properties")
            .then(|| schema.pointer(&pointer))
            .flatten()
        else {
            continue;
        };
        for (name, field) in fields.as_object().into_iter().flatten() {
            let is_variant = name.starts_with(char::is_uppercase);
            if !is_variant && field["description"].as_str().is_none_or(str::is_empty) {
                bare.push(format!("{pointer}/{name}"));
            }
        }
    }
    assert!(bare.is_empty(), "{bare:#?}");
}
