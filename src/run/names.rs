//! The names of a scene's files.

use super::{files, layers};
use crate::scene::Scene;

/// What decides the names.
#[derive(Clone, Debug)]
pub struct Names {
    /// The scene's name.
    pub scene: String,
    /// The frames of the scene, not of the call.
    pub frames: u64,
    png: bool,
    gltf: bool,
    layers: bool,
    exr: bool,
    ground_shadow: bool,
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
            layers: scene.output.layers && has_one_picture(scene),
            exr: scene.output.exr && has_one_picture(scene),
            ground_shadow: scene.output.ground_shadow && has_one_picture(scene),
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

    /// The file of a frame's light.
    pub fn exr(&self, frame: i64) -> Option<String> {
        self.exr.then(|| format!("{}.exr", files::stem(&self.scene, frame, self.frames)))
    }

    /// The file of a frame's shadow on the ground.
    pub fn ground_shadow(&self, frame: i64) -> Option<String> {
        self.ground_shadow.then(|| format!("{}.shadow.png", files::stem(&self.scene, frame, self.frames)))
    }

    /// All files of a frame.
    pub fn all(&self, frame: i64) -> Vec<String> {
        let files = self.png(frame).into_iter().chain(self.gltf(frame)).chain(self.exr(frame));
        files.chain(self.ground_shadow(frame)).chain(self.layers(frame)).collect()
    }

    /// The layers of a frame, in the order of their kinds.
    pub fn layers(&self, frame: i64) -> Vec<String> {
        let kinds = if self.layers { layers::KINDS.as_slice() } else { &[] };
        let stem = files::stem(&self.scene, frame, self.frames);
        kinds.iter().map(|kind| format!("{stem}.{kind}.png")).collect()
    }
}

/// Whether a scene's frames have a picture that is no sheet: only those have other files beside them.
fn has_one_picture(scene: &Scene) -> bool {
    scene.output.png && scene.cell_count() == 0
}
