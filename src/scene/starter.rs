//! The scene that `leafseason new` writes: the main keys with their defaults, units and ranges, taken from the schema.

use super::schema;
use crate::base::settings::{Key, Kind, Schema};
use serde_json::Value;
use std::fmt::Write;

/// The keys shown of each table, in order; a `#` writes the key as a comment, with an example.
const KEYS: [(&str, &[(&str, &str)]); 11] = [
    ("climate", &[("temperature", "8.0"), ("humidity", "0.7"), ("series", "#\"weather.csv\""), ("latitude", "#45.0")]),
    (
        "time",
        &[
            ("day", "40.0"),
            ("date", "#2017-10-05"),
            ("moment", "#\"peak\""),
            ("from", "#0.0"),
            ("to", "#120.0"),
            ("step", "#1.0"),
        ],
    ),
    ("season", &[("mode", "")]),
    ("tree", &[("age", "#30")]),
    ("leaf", &[("picture", "#\"leaf.png\""), ("vertices", "")]),
    ("fall", &[("wind", ""), ("direction", "#20.0"), ("slow_motion", "")]),
    ("camera", &[("field_of_view", "")]),
    ("light", &[("sun_elevation", ""), ("sun_azimuth", ""), ("exposure", "")]),
    ("image", &[("width", ""), ("height", ""), ("samples", "")]),
    ("quality", &[("error", "#0.01")]),
    ("output", &[("png", ""), ("gltf", "#\"merged\""), ("inset", "")]),
];

/// Longest line of a starter scene, in characters.
const LONGEST_LINE: usize = 120;

/// A commented scene of a species.
#[must_use]
pub fn starter(species: &str) -> String {
    let schema = schema::scene();
    let mut text = String::from("# A scene of leafseason. Keys that are left out have their defaults.\n\n");
    let _ = writeln!(text, "species = {}", Value::from(species));
    let _ = writeln!(text, "seed = 1");
    for (table, keys) in KEYS {
        let _ = writeln!(text, "\n[{table}]");
        let inner = schema.keys.iter().find(|key| key.name == table).map(|key| &key.kind);
        if let Some(Kind::Table(inner)) = inner {
            keys.iter().for_each(|(name, example)| text.push_str(&line(inner, name, example)));
        }
    }
    text
}

fn line(table: &Schema, name: &str, example: &str) -> String {
    let Some(key) = table.keys.iter().find(|key| key.name == name) else { return String::new() };
    let default = key.default.to_string();
    let (mark, value) = match example.strip_prefix('#') {
        Some(example) => ("# ", example),
        None if example.is_empty() => ("", default.as_str()),
        None => ("", example),
    };
    let pair = format!("{mark}{name} = {value}");
    let mut line = format!("{pair:<28}# {}", remark(key));
    if line.chars().count() > LONGEST_LINE {
        line = line.chars().take(LONGEST_LINE - 1).collect();
        line.push('…');
    }
    line + "\n"
}

/// Unit and range, then the first sentence of the meaning.
fn remark(key: &Key) -> String {
    let unit = if key.unit.is_empty() { String::new() } else { format!("{}, ", key.unit) };
    let sentence = key.doc.split_once(". ").map_or(key.doc.as_str(), |(first, _)| first).trim_end_matches('.');
    match (&key.kind, key.range) {
        (Kind::Choice(words), _) => format!("{}: {sentence}", words.join(" or ")),
        (_, Some((low, high))) if high < 4e9 => format!("{unit}{low} to {high}: {sentence}"),
        _ => format!("{unit}{sentence}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_named_here_is_in_the_schema() {
        let text = starter("red-maple");
        for (_, keys) in KEYS {
            for (name, _) in keys {
                assert!(text.contains(&format!("{name} = ")), "{name}");
            }
        }
    }

    #[test]
    fn a_name_with_quotes_cannot_break_out() {
        let text = starter("a\" \nseed = 3 #");
        assert!(toml::from_str::<toml::Table>(&text).is_ok());
    }
}
