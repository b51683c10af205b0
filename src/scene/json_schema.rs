//! The scene file as JSON Schema (draft 2020-12), for editors: the same schema that the checker walks.

use super::schema;
use crate::base::settings::{Key, Kind, Schema};
use serde_json::{Map, Value, json};

/// The JSON Schema of a scene file.
#[must_use]
pub fn json_schema() -> Value {
    let mut root = table(&schema::scene());
    if let Value::Object(root) = &mut root {
        root.insert("$schema".to_owned(), json!("https://json-schema.org/draft/2020-12/schema"));
        root.insert("title".to_owned(), json!("leafseason scene"));
    }
    root
}

fn table(schema: &Schema) -> Value {
    let properties: Map<String, Value> = schema.keys.iter().map(|one| (one.name.to_owned(), key(one))).collect();
    json!({ "type": "object", "description": schema.doc, "properties": properties, "additionalProperties": false })
}

fn key(key: &Key) -> Value {
    let mut value = kind(&key.kind, key.range);
    if let Value::Object(value) = &mut value {
        let unit = if key.unit.is_empty() { String::new() } else { format!(" [{}]", key.unit) };
        value.insert("description".to_owned(), Value::from(format!("{}{unit}", key.doc)));
        if !key.default.is_null() {
            value.insert("default".to_owned(), key.default.clone());
        }
    }
    value
}

fn kind(of: &Kind, range: Option<(f64, f64)>) -> Value {
    match of {
        Kind::Number => number("number", range),
        Kind::Integer => number("integer", range),
        Kind::Boolean => json!({ "type": "boolean" }),
        Kind::Text => json!({ "type": "string" }),
        Kind::Choice(words) => json!({ "type": "string", "enum": words }),
        Kind::List(inner, least, most) => list(&kind(inner, range), *least, *most),
        Kind::Either(kinds) => json!({ "anyOf": kinds.iter().map(|one| kind(one, range)).collect::<Vec<_>>() }),
        Kind::Table(schema) => table(schema),
        Kind::Map(inner) => json!({ "type": "object", "additionalProperties": kind(inner, range) }),
    }
}

fn number(name: &str, range: Option<(f64, f64)>) -> Value {
    let mut value = json!({ "type": name });
    if let Some((low, high)) = range {
        value["minimum"] = bound(low);
        value["maximum"] = bound(high);
    }
    value
}

/// A bound, as a whole number where it is one: editors show `1`, not `1.0`.
fn bound(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() < 9e15 { Value::from(value as i64) } else { Value::from(value) }
}

fn list(items: &Value, least: usize, most: usize) -> Value {
    let mut value = json!({ "type": "array", "items": items });
    if least > 0 {
        value["minItems"] = Value::from(least);
    }
    if most < usize::MAX {
        value["maxItems"] = Value::from(most);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_what_the_settings_declare() {
        let schema = json_schema();
        let humidity = &schema["properties"]["climate"]["properties"]["humidity"];
        assert_eq!(humidity["minimum"], 0);
        assert_eq!(humidity["maximum"], 1);
        assert_eq!(schema["properties"]["season"]["properties"]["warm"]["default"], 25.0);
        assert_eq!(schema["properties"]["camera"]["properties"]["position"]["maxItems"], 3);
        assert_eq!(schema["properties"]["ground"]["properties"]["kind"]["enum"], json!(["grass", "soil", "none"]));
        let states = &schema["properties"]["season"]["properties"]["states"]["additionalProperties"];
        assert_eq!(states["additionalProperties"], false);
    }

    #[test]
    fn no_table_takes_unknown_keys() {
        fn walk(value: &Value) {
            if value.get("properties").is_some() {
                assert_eq!(value["additionalProperties"], false);
            }
            value.as_object().into_iter().flatten().for_each(|(_, inner)| walk(inner));
        }
        walk(&json_schema());
    }
}
