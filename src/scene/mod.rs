//! The scene: the user's file, the species below it and `--set` above it, checked as a whole and resolved to the settings of
//! every stage. This is the only place that knows TOML, and with `species` the only one that knows where settings come from;
//! it draws nothing.
//!
//! A scene is untrusted: its size is bounded before it is read, its paths stay below its folder or an asset root, and
//! limits are asked before anything is made from its numbers.

pub mod asset;
mod assignment;
mod bounds;
pub mod camera;
mod checker;
mod complaint;
mod document;
pub mod ground;
pub mod image;
mod json_schema;
mod layers;
pub mod light;
pub mod output;
mod reader;
pub mod schema;
mod spelling;
mod starter;
mod text_file;
pub mod time;

pub use asset::{Asset, locate, read_picture};
pub use complaint::diagnostic;
pub use json_schema::json_schema;
pub use light::Light;
pub use reader::read;
pub use starter::starter;

use crate::base::diagnostic::Place;
use crate::{colour, deform, leaf, season, tree};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// A resolved scene: every setting of every stage, with what is needed to point into the user's files.
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    /// The file's name without its ending; begins the names of the frames.
    #[serde(skip)]
    pub name: String,
    /// The species as the scene names it; none with an L-system of its own.
    pub species: Option<String>,
    /// Everything random follows from it.
    pub seed: u64,
    /// The weather.
    pub climate: season::Climate,
    /// When.
    pub time: time::Time,
    /// How leaves pass from state to state.
    pub season: season::Settings,
    /// How the tree grows.
    pub tree: tree::Settings,
    /// The blade.
    pub leaf: leaf::Settings,
    /// How leaves curl.
    pub deform: deform::Settings,
    /// How leaves are coloured.
    pub colour: colour::Settings,
    /// Where the picture is taken from.
    pub camera: camera::Camera,
    /// Sun, sky and exposure.
    pub light: light::Light,
    /// Size of the picture.
    pub image: image::Image,
    /// What the tree stands on.
    pub ground: ground::Ground,
    /// Which files are written.
    pub output: output::Output,
    /// The files that the scene names, by their key; only their content's hash is part of the resolved scene.
    #[serde(serialize_with = "asset::hashes")]
    pub assets: BTreeMap<String, Asset>,
    /// The texts that were read, in order: scene, species file.
    #[serde(skip)]
    pub files: Vec<TextFile>,
    /// Where each key stands, by dotted path; entries of lists are `tree.rules.0`.
    #[serde(skip)]
    pub places: BTreeMap<String, Place>,
}

/// A text that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TextFile {
    /// The name as the user gave it.
    pub name: String,
    /// SHA-256 of its bytes in hexadecimal digits.
    pub sha256: String,
}

impl Scene {
    /// The scene as JSON with sorted keys and the hashes of the files it names: equal for equal pictures, whatever the
    /// scene file's comments, order and name. For the manifest's hash.
    #[must_use]
    pub fn resolved(&self) -> Value {
        serde_json::to_value(self).unwrap_or_default()
    }

    /// The place of a key or of its nearest table that stands in a file.
    #[must_use]
    pub fn place(&self, path: &str) -> Option<Place> {
        complaint::nearest(&self.places, path).map(|(_, place)| place.clone())
    }
}
