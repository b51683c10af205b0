//! The JSON Schema of scenes: sound in itself, and it knows every key that the scenes of the repository and the starter
//! use. And the built-in species: each file is listed.

use leafseason::{scene, species};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Walks a schema: `visit` gets each key's dotted path and its schema; names of the user's choice are `*`.
fn each(schema: &Value, path: &str, visit: &mut impl FnMut(&str, &Value)) {
    visit(path, schema);
    let below = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    for (name, inner) in schema["properties"].as_object().into_iter().flatten() {
        each(inner, &below(name), visit);
    }
    if schema["additionalProperties"].is_object() {
        each(&schema["additionalProperties"], &below("*"), visit);
    }
    if schema["items"].is_object() {
        each(&schema["items"], &below("[]"), visit);
    }
    for inner in schema["anyOf"].as_array().into_iter().flatten() {
        each(inner, path, visit);
    }
}

/// What keeps a value from meeting a schema: the words of draft 2020-12 that ours uses.
fn faults(value: &Value, schema: &Value, path: &str, list: &mut Vec<String>) {
    if let Some(kinds) = schema["anyOf"].as_array() {
        let meets = |kind: &Value| {
            let mut list = Vec::new();
            faults(value, kind, path, &mut list);
            list.is_empty()
        };
        if !kinds.iter().any(meets) {
            list.push(format!("{path}: {value} is of no kind"));
        }
        return;
    }
    let is_of_type = match schema["type"].as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("boolean") => value.is_boolean(),
        Some("integer") => value.is_i64() || value.is_u64(),
        Some("number") => value.is_number(),
        _ => false,
    };
    let number = value.as_f64();
    let bounds = (schema["minimum"].as_f64(), schema["maximum"].as_f64());
    let inside = number.is_none_or(|n| bounds.0.is_none_or(|low| n >= low) && bounds.1.is_none_or(|high| n <= high));
    let known = schema["enum"].as_array().is_none_or(|words| words.contains(value));
    if !(is_of_type && inside && known) {
        list.push(format!("{path}: {value} against {schema}"));
    }
    for (name, inner) in value.as_object().into_iter().flatten() {
        let key = schema["properties"].get(name).or(Some(&schema["additionalProperties"]).filter(|s| s.is_object()));
        match key {
            Some(key) => faults(inner, key, &format!("{path}.{name}"), list),
            None => list.push(format!("{path}.{name} is not in the schema")),
        }
    }
    value.as_array().into_iter().flatten().for_each(|inner| faults(inner, &schema["items"], path, list));
}

#[test]
fn every_key_has_a_type_that_can_be_met_and_a_default_that_meets_it() {
    let schema = scene::json_schema();
    let mut wrong = Vec::new();
    let mut keys = 0;
    each(&schema, "", &mut |path, key| {
        keys += 1;
        let typed = key["type"].is_string() || key["anyOf"].as_array().is_some_and(|kinds| kinds.len() > 1);
        if !typed {
            wrong.push(format!("{path}: {key}"));
        }
        if key["minimum"].as_f64() > key["maximum"].as_f64() || key["enum"].as_array().is_some_and(Vec::is_empty) {
            wrong.push(format!("{path}: nothing can meet it"));
        }
        if let Some(default) = key.get("default") {
            faults(default, key, path, &mut wrong);
        }
    });
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
    assert!(keys > 80, "{keys}");
}

#[test]
fn every_key_has_a_description() {
    let mut bare = Vec::new();
    each(&scene::json_schema(), "", &mut |path, schema| {
        for (name, key) in schema["properties"].as_object().into_iter().flatten() {
            if key["description"].as_str().is_none_or(|text| text.trim().len() < 4) {
                bare.push(format!("{path}.{name}"));
            }
        }
    });
    assert!(bare.is_empty(), "{bare:?}");
}

fn faults_of_text(text: &str) -> Vec<String> {
    let table: toml::Table = toml::from_str(text).unwrap();
    let mut list = Vec::new();
    faults(&serde_json::to_value(table).unwrap(), &scene::json_schema(), "", &mut list);
    list
}

#[test]
fn the_starter_and_every_scene_of_the_repository_meet_the_schema() {
    assert_eq!(faults_of_text(&scene::starter("red-maple")), Vec::<String>::new());
    let entries = fs::read_dir(root().join("scenes")).unwrap().map(|entry| entry.unwrap().path());
    let scenes: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect();
    assert!(!scenes.is_empty());
    for path in scenes {
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(faults_of_text(&text), Vec::<String>::new(), "{}", path.display());
    }
}

#[test]
fn the_schema_refuses_what_is_wrong() {
    for text in ["tree = { branches = 3 }", "climate = { humidity = 1.2 }", "output = { gltf = \"fbx\" }", "seed = 1.5"]
    {
        assert_eq!(faults_of_text(text).len(), 1, "{text}");
    }
}

/// The species files: `NAME.toml`, without the parts `NAME.STAGE.toml`.
fn species_files(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter_map(|name| name.strip_suffix(".toml").map(str::to_owned)).collect();
    names.retain(|name| !name.contains('.'));
    names.sort();
    names
}

#[test]
fn the_list_of_species_names_every_built_in_one() {
    let listed: Vec<&str> = species::list().iter().map(|(name, _)| *name).collect();
    assert_eq!(listed, species_files(&root().join("src/species")));
    assert!(species::list().iter().all(|(_, line)| !line.is_empty()));
}
