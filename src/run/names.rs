//! The names of a scene's files.

use super::{files, layers};
use crate::scene::Scene;

/// What decides the names.
pub struct Names {
    /// The scene's name.
    pub scene: String,
    /// The frames of the scene, not of the call.
    pub frames: u64,
    png: bool,
    gltf: bool,
    layers: bool,
}

impl Names {
    /// The names of a scene's files.
    pub fn new(scene: &Scene) -> Self {
        let frames = scene.time.count() as u64;
        Self {
            scene: scene.name.clone(),
            frames,
            png: scene.output.png,
            gltf: scene.output.gltf.is_some(),
            layers: has_layers(scene),
        }
    }

    /// The picture of a frame.
    pub fn png(&self, frame: i64) -> Option<String> {
        self.png.then(|| format!("{}.png", files::stem(&self.scene, frame, self.frames)))
    }

    /// The glTF file of a frame.
    pub fn gltf(&self, frame: i64) -> Option<String> {
        self.gltf.then(|| format!("{}.glb", files::stem(&self.scene, frame, self.frames)))
    }

    /// All files of a frame.
    pub fn all(&self, frame: i64) -> Vec<String> {
        self.png(frame).into_iter().chain(self.gltf(frame)).chain(self.layers(frame)).collect()
    }

    /// The layers of a frame, in the order of their kinds.
    pub fn layers(&self, frame: i64) -> Vec<String> {
        let kinds = if self.layers { layers::KINDS.as_slice() } else { &[] };
        let stem = files::stem(&self.scene, frame, self.frames);
        kinds.iter().map(|kind| format!("{stem}.{kind}.png")).collect()
    }
}

/// Whether a scene's frames have layers: pictures that are no sheets do, where they are asked for.
fn has_layers(scene: &Scene) -> bool {
    scene.output.layers && scene.output.png && scene.cell_count() == 0
}
