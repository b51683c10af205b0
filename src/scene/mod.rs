//! The scene: the user's file, the species below it and `--set` above it, checked as a whole and resolved to the settings of
//! every stage. This is the only place that knows TOML, and with `species` the only one that knows where settings come from;
//! it draws nothing.
//!
//! A scene is untrusted: its size is bounded before it is read, its paths stay below its folder or an asset root, and
//! limits are asked before anything is made from its numbers.

pub mod asset;
mod assignment;
mod bounds;
mod calendar;
pub mod camera;
mod checker;
mod complaint;
mod document;
pub mod ground;
pub mod image;
mod json_schema;
mod layers;
mod leaf_arguments;
pub mod light;
pub mod output;
mod places;
pub mod planting;
pub mod quality;
mod reader;
pub mod schema;
pub mod sheet;
mod spelling;
mod starter;
mod text_file;
pub mod time;

pub use asset::{Asset, locate, read_picture};
pub use json_schema::json_schema;
pub use leaf_arguments::leaf_settings;
pub use light::Light;
pub use places::Places;
pub use planting::{Planted, Standing};
pub use reader::read;
pub use starter::starter;

use crate::base::diagnostic::Place;
use crate::{colour, deform, fall, leaf, season, tree};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// A resolved scene: every setting of every stage, with what is needed to point into the user's files.
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    /// The file's name without its ending; begins the names of the frames.
    #[serde(skip)]
    pub name: String,
    /// Everything random follows from it.
    pub seed: u64,
    /// The seeds of a contact sheet, in the order of its cells; empty for a scene that is no sheet.
    pub seeds: Vec<u64>,
    /// The cells of a contact sheet that varies other keys, each a scene of its own, in order.
    pub cells: Vec<Scene>,
    /// The weather of every day.
    pub weather: season::Weather,
    /// When.
    pub time: time::Time,
    /// The species of its trees, in the order in which trees name them; at least one.
    pub species: Vec<Species>,
    /// The trees; without `[[trees]]` one of the only species at the origin.
    pub trees: Vec<Planted>,
    /// Where the picture is taken from.
    pub camera: camera::Camera,
    /// Sun, sky and exposure.
    pub light: light::Light,
    /// Size of the picture.
    pub image: image::Image,
    /// What the trees stand on.
    pub ground: ground::Ground,
    /// How leaves fall.
    pub fall: fall::Settings,
    /// The error that pictures may have.
    pub quality: quality::Quality,
    /// Which files are written.
    pub output: output::Output,
    /// The texts that were read, in order: scene, species files.
    #[serde(skip)]
    pub files: Vec<TextFile>,
    /// Where each key of the scene and of the assignments stands.
    #[serde(skip)]
    pub places: Places,
}

/// A species in this scene: its own tables below those of the scene.
#[derive(Clone, Debug, Serialize)]
pub struct Species {
    /// As the scene names it; none with an L-system of the scene's own.
    pub name: Option<String>,
    /// How leaves pass from state to state.
    pub season: season::Settings,
    /// How its trees grow, at the age that no tree of the scene need have.
    pub tree: tree::Settings,
    /// The blade.
    pub leaf: leaf::Settings,
    /// How leaves curl.
    pub deform: deform::Settings,
    /// How leaves are coloured.
    pub colour: colour::Settings,
    /// How its litter goes.
    pub fall: fall::Decay,
    /// The files that its tables name, by their key; only their content's hash is part of the resolved scene.
    #[serde(serialize_with = "asset::hashes")]
    pub assets: BTreeMap<String, Asset>,
    /// Where each key stands: in the scene and the assignments, else in the species file.
    #[serde(skip)]
    pub places: Places,
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

    /// Whether leaves that have fallen are seen: as the scene says, else where there is a ground to lie on.
    #[must_use]
    pub fn leaves_fall(&self) -> bool {
        let seen = self.camera.subject == camera::Subject::Trees;
        seen && self.fall.on.unwrap_or(self.ground.kind != ground::Cover::None)
    }

    /// The place of a key or of its nearest table that stands in the scene or an assignment.
    #[must_use]
    pub fn place(&self, path: &str) -> Option<Place> {
        self.places.of(path)
    }
}

impl Species {
    /// A name for messages and reports.
    #[must_use]
    pub fn label(&self) -> &str {
        self.name.as_deref().unwrap_or("tree")
    }

    /// Number of garments of each state: shapes and textures vary together, so that a model is one of each.
    #[must_use]
    pub fn variants(&self) -> u32 {
        self.deform.shapes.max(self.colour.variants)
    }
}
