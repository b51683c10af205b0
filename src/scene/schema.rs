//! The keys of the two kinds of file: scenes and species.

use super::{
    camera::Camera, ground::Ground, image::Image, light::Light, output::Output, planting, quality::Quality, sheet, time,
};
use crate::base::settings::{Described, Key, Kind, Schema};
use crate::{colour, deform, fall, leaf, season, tree};
use serde_json::Value;

/// The keys of a scene file.
#[must_use]
pub fn scene() -> Schema {
    let mut scene = cell();
    let doc = "A contact sheet of variations: each entry is a table of keys of the scene (without `cells`, and only the \
               sheet's `output` counts), laid over it and drawn in a cell of one picture of the image's size, row by row.";
    let kind = Kind::List(Box::new(Kind::Table(cell())), 1, sheet::MOST_CELLS);
    let key = Key { name: "cells", doc: doc.to_owned(), unit: "", range: None, kind, default: Value::Null };
    scene.keys.push(seeds());
    scene.keys.push(key);
    scene
}

/// The key of a contact sheet of seeds.
fn seeds() -> Key {
    Key {
        name: "seeds",
        doc: "A contact sheet to choose from: the scene once with each of these seeds, in the cells of one picture of \
              the image's size, the seed in each cell's corner. Stands before `seed`; no glTF file is written. To draw the one \
              that is chosen, write `--set seed=N`."
            .to_owned(),
        unit: "",
        range: Some((0.0, u64::MAX as f64)),
        kind: Kind::List(Box::new(Kind::Integer), 1, sheet::MOST_CELLS),
        default: Value::Null,
    }
}

/// The keys of a scene that is no sheet of cells.
fn cell() -> Schema {
    let mut keys = vec![
        text(
            "species",
            "A built-in species, or the path of a species file; that of the trees of [[trees]] which name none. May be \
             absent when every tree names its own, or [tree] is a whole L-system.",
        ),
        Key {
            name: "seed",
            doc: "Everything random follows from it.".to_owned(),
            unit: "",
            range: Some((0.0, u64::MAX as f64)),
            kind: Kind::Integer,
            default: Value::from(1),
        },
        trees(),
        table::<season::Climate>("climate"),
        table::<time::Settings>("time"),
    ];
    keys.extend(stages());
    keys.extend([
        table::<Camera>("camera"),
        table::<Light>("light"),
        table::<Image>("image"),
        table::<Ground>("ground"),
        table::<fall::Settings>("fall"),
        table::<Quality>("quality"),
        table::<Output>("output"),
    ]);
    Schema { doc: "A scene of leafseason: a tree in a season.".to_owned(), keys }
}

/// The keys of a species file.
#[must_use]
pub fn species() -> Schema {
    let mut keys = vec![text("name", "The species' name."), text("description", "The species in one line.")];
    keys.extend(stages());
    keys.push(table::<fall::Decay>("fall"));
    Schema { doc: "A species of leafseason.".to_owned(), keys }
}

/// The keys of a traced leaf's file: those of `[leaf]` but that which names such a file.
#[must_use]
pub fn leaf_file() -> Schema {
    let mut inner = leaf::Settings::schema();
    inner.keys.retain(|key| key.name != "file");
    let key = Key { kind: Kind::Table(inner), ..table::<leaf::Settings>("leaf") };
    Schema { doc: "A traced leaf of leafseason.".to_owned(), keys: vec![key] }
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

/// The key of `[[trees]]`.
fn trees() -> Key {
    let entry = planting::schema();
    let doc =
        format!("The trees of the scene; without them one of `species` stands at the origin. An entry: {}", entry.doc);
    let kind = Kind::List(Box::new(Kind::Table(entry)), 1, planting::MOST_ENTRIES);
    Key { name: "trees", doc, unit: "", range: None, kind, default: Value::Null }
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
    let has = |kind: &Kind| matches!(table_of(kind), Some(inner) if inner.keys.iter().any(|key| key.name == name));
    schema.keys.iter().filter(|key| key.name != "cells" && has(&key.kind)).map(|key| key.name).collect()
}

/// The keys of a table, or of the tables of a list.
fn table_of(kind: &Kind) -> Option<&Schema> {
    match kind {
        Kind::Table(inner) => Some(inner),
        Kind::List(inner, ..) => table_of(inner),
        _ => None,
    }
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
            if let Some(inner) = table_of(&key.kind) {
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
        assert_eq!(homes(&scene(), "spacing"), ["trees"]);
        assert!(homes(&scene(), "nonsense").is_empty());
    }
}
