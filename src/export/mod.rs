//! Outputs: a [`Picture`](crate::base::picture::Picture) becomes a PNG file, a [`Frame`](crate::frame::Frame) a GLB file,
//! both as bytes in memory. Nothing here touches the disk, and the same input gives the same bytes: no time, host or path
//! is written.
//!
//! The GLB follows the glTF 2.0 specification (Khronos, ISO/IEC 12113:2022), with `EXT_mesh_gpu_instancing` for the
//! instanced layout and the release candidate `KHR_materials_diffuse_transmission` as an optional extra. It holds the tree
//! only: no ground, camera or lights.

mod buffer;
mod check;
mod document;
mod error;
mod exr;
mod geometry;
mod glb;
mod layouts;
mod materials;
mod names;
mod placement;
mod png;

pub use error::ExportError;
pub use exr::exr;
pub use glb::{Layout, glb};
pub use placement::Placement;
pub use png::{grey_8, grey_16, plain, png, png_16};
