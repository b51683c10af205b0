//! Traced leaves: a layer that names a `leaf.file` lies over the keys of that file.

use super::super::{asset, layers, schema, text_file};
use super::Reader;
use serde_json::Value;
use std::path::Path;

/// Keys of a traced leaf that name files beside it.
const BESIDE: [&str; 3] = ["picture", "mask", "texture"];

impl Reader<'_> {
    /// Lays a layer over the traced leaf that it names, if it names one. `species` is the number of the species whose
    /// layer it is. Places of the layer's own keys stand before the file's.
    pub(super) fn with_leaf_file(&mut self, layer: Value, species: Option<usize>) -> Value {
        let Some(name) = layer.pointer("/leaf/file").and_then(Value::as_str).map(str::to_owned) else { return layer };
        let read = asset::locate(&name, &self.folder, self.roots).and_then(|path| text_file::read(&path, &name));
        match read {
            Ok((source, file)) => {
                self.files.push(file);
                let own = std::mem::take(&mut self.places);
                let (mut below, _) = self.text(&source, &schema::leaf_file(), species);
                self.places.extend(own);
                moved(&mut below, &name);
                layers::merge(&mut below, layer);
                below
            }
            Err(fault) => {
                self.refuse("leaf.file", species, fault);
                layer
            }
        }
    }
}

/// Names of files in a traced leaf are relative to its own folder; here they become relative to the scene's.
fn moved(below: &mut Value, name: &str) {
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    for key in BESIDE {
        if let Some(value) = below.pointer_mut(&format!("/leaf/{key}"))
            && let Some(path) = value.as_str()
            && !Path::new(path).is_absolute()
        {
            *value = Value::from(folder.join(path).to_string_lossy().into_owned());
        }
    }
}
