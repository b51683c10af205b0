//! What can keep a picture or a frame from being written.

use crate::base::mesh::MeshFault;
use thiserror::Error;

/// Why an output cannot be made. All but [`ExportError::TooLarge`] mean that an earlier stage broke a contract.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The number of pixels is not width times height, or one of them is 0.
    #[error("{what}: {pixels} pixels do not make a picture of {width} x {height}")]
    Size {
        /// The picture or texture.
        what: String,
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Pixels present.
        pixels: usize,
    },
    /// The PNG encoder failed.
    #[error("cannot encode a PNG: {0}")]
    Png(#[from] ::png::EncodingError),
    /// The OpenEXR encoder failed, or the program has none.
    #[error("cannot encode an EXR: {0}")]
    Exr(String),
    /// The JSON half of the GLB could not be made.
    #[error("cannot encode glTF JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Something refers to a mesh, texture, material or model that is not there.
    #[error("{what} refers to {kind} {number}, which is not there")]
    Missing {
        /// What refers.
        what: String,
        /// The kind of thing.
        kind: &'static str,
        /// Its number.
        number: u32,
    },
    /// A mesh is not sound.
    #[error("mesh {mesh}: {fault}")]
    Mesh {
        /// Its number.
        mesh: usize,
        /// What is wrong.
        fault: MeshFault,
    },
    /// A number is NaN or infinite; JSON would write it as null.
    #[error("{what} is not finite")]
    NotFinite {
        /// Whose number it is.
        what: String,
    },
    /// A transform has shear, uneven scale, a mirror or no size, so that no glTF node can stand for it.
    #[error("the transform of instance {instance} is not a rotation with one scale (off by {residual:.1e})")]
    NotSimilar {
        /// Number of the instance.
        instance: usize,
        /// Largest entry of the difference, relative to the scale.
        residual: f64,
    },
    /// A GLB counts its bytes in 32 bits.
    #[error("the GLB would take {bytes} bytes; the format ends at 4294967295 (the layout `instanced` is the smallest)")]
    TooLarge {
        /// Bytes needed.
        bytes: u64,
    },
}
