//! The error that the author allows, from which the program chooses what pictures are made with.

use crate::settings;

settings! {
    /// The error that a picture may have. Given it, the program chooses the vertices of leaves, the tolerance of their
    /// shapes, levels of detail and the samples of a pixel, and the report states what was reached, stage by stage.
    pub struct Quality {
        /// Root mean square error of the picture in linear light, of 0..1. What is chosen for it stands before `image.samples`,
        /// `image.lod_error`, `leaf.vertices` and `deform.shell.tolerance`. 0.03 does for a preview, 0.01 for a final frame.
        error: Option<f64> = None, range 1e-3 => 0.5;
    }
}
