//! Pictures of what the leaf stage found and made: the scan laid out as a texture, charts for the surfaces of leaves, and a
//! preview of everything side by side.

pub(in crate::leaf) mod canvas;
pub(in crate::leaf) mod chart;
pub(in crate::leaf) mod preview;
pub(in crate::leaf) mod texture;
