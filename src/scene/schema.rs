//! The JSON schema of scene files, made from their types, so that it cannot differ from them.

use schemars::{Schema, generate::SchemaSettings};
use serde_json::Value;

use super::Scene;

impl Scene {
    /// The JSON schema (2020-12) of scene files: types, defaults, and the documentation of every field, whose unit
    /// stands in brackets, `[m]`.
    ///
    /// RON and JSON say the same with other signs. A variant `Laminar(kinematic_viscosity: 1)` is
    /// `{"Laminar": {"kinematic_viscosity": 1}}`, one without fields is its name as a text, `"Free"`; a vector is an
    /// array of three numbers; an absent value is `null`. A schema says nothing of what values make together: see
    /// [`Scene::check`].
    pub fn json_schema() -> Value {
        let generator = SchemaSettings::draft2020_12().into_generator();
        let schema: Schema = generator.into_root_schema_for::<Self>();
        let mut schema = schema.to_value();
        unescape(&mut schema);
        schema
    }
}

/// Writes `[m]` for the `\[m]` of the documentation, which would be a link there, and one line for several.
fn unescape(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            for (name, field) in fields {
                match field {
                    Value::String(text) if name == "description" => {
                        *text = text
                            .replace("\\[", "[")
                            .replace('\n', " ")
                            .replace("  ", " ");
                    }
                    _ => unescape(field),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(unescape),
        _ => {}
    }
}
