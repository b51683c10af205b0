//! The keys of the two kinds of file: scenes and species.

use super::{camera::Camera, ground::Ground, image::Image, light::Light, output::Output, time::Time};
use crate::base::settings::{Described, Key, Kind, Schema};
use crate::{colour, deform, leaf, season, tree};
use serde_json::Value;

/// The keys of a scene file.
#[must_use]
pub fn scene() -> Schema {
    let mut keys = vec![
        text(
            "species",
            "A built-in species, or the path of a species file; may be absent when [tree] is a whole L-system.",
        ),
        Key {
            name: "seed",
            doc: "Everything random follows from it.".to_owned(),
            unit: "",
            range: Some((0.0, u64::MAX as f64)),
            kind: Kind::Integer,
            default: Value::from(1),
        },
        table::<season::Climate>("climate"),
        table::<Time>("time"),
    ];
    keys.extend(stages());
    keys.extend([
        table::<Camera>("camera"),
        table::<Light>("light"),
        table::<Image>("image"),
        table::<Ground>("ground"),
        table::<Output>("output"),
    ]);
    Schema { doc: "A scene of leafseason: a tree in a season.".to_owned(), keys }
}

/// The keys of a species file.
#[must_use]
pub fn species() -> Schema {
    let mut keys = vec![text("name", "The species' name."), text("description", "The species in one line.")];
    keys.extend(stages());
    Schema { doc: "A species of leafseason.".to_owned(), keys }
}

/// The tables of the stages, which scenes and species share.
fn stages() -> [Key; 5] {
    [
        table::<season::Settings>("season"),
        table::<tree::Settings>("tree"),
        table::<leaf::Settings>("leaf"),
        table::<deform::Settings>("deform"),
        table::<colour::Settings>("colour"),
    ]
}

fn text(name: &'static str, doc: &str) -> Key {
    Key { name, doc: doc.to_owned(), unit: "", range: None, kind: Kind::Text, default: Value::Null }
}

fn table<T: Described>(name: &'static str) -> Key {
    let kind = T::kind();
    let doc = if let Kind::Table(schema) = &kind { schema.doc.clone() } else { String::new() };
    Key { name, doc, unit: "", range: None, kind, default: Value::Null }
}

/// The tables of a schema that have a key of this name, for keys that were written into the wrong table.
#[must_use]
pub fn homes(schema: &Schema, name: &str) -> Vec<&'static str> {
    let has = |kind: &Kind| matches!(kind, Kind::Table(inner) if inner.keys.iter().any(|key| key.name == name));
    schema.keys.iter().filter(|key| has(&key.kind)).map(|key| key.name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers_have_ranges(schema: &Schema, path: &str, bare: &mut Vec<String>) {
        for key in &schema.keys {
            let path = format!("{path}.{}", key.name);
            if key.kind == Kind::Integer && key.range.is_none() {
                bare.push(path.clone());
            }
            if let Kind::Table(inner) = &key.kind {
                numbers_have_ranges(inner, &path, bare);
            }
        }
    }

    #[test]
    fn every_whole_number_has_a_range_so_that_none_overflows() {
        let mut bare = Vec::new();
        numbers_have_ranges(&scene(), "", &mut bare);
        assert!(bare.is_empty(), "{bare:?}");
    }

    #[test]
    fn a_key_in_the_wrong_table_is_found() {
        assert_eq!(homes(&scene(), "humidity"), ["climate"]);
        assert!(homes(&scene(), "nonsense").is_empty());
    }
}
