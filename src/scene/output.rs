//! Which files are written for each frame.

use crate::{choice, settings};

choice! {
    /// The form of the glTF file.
    pub enum Gltf {
        /// A node for each leaf.
        Nodes = "nodes",
        /// All leaves that share a texture in one mesh.
        Merged = "merged",
        /// `EXT_mesh_gpu_instancing`.
        Instanced = "instanced",
    }
}

settings! {
    /// What is written.
    pub struct Output {
        /// A picture of each frame.
        png: bool = true;
        /// A glTF file of each frame; none when absent.
        gltf: Option<Gltf> = None;
        /// One leaf enlarged in the lower right corner.
        inset: bool = false;
    }
}
