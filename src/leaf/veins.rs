//! Veins of a blade: seen in its scan, or grown from its outline when there is nothing to see.

mod branching;
mod field;
mod grown;
mod paths;
mod petiole;
mod ridge;
mod scanned;
pub mod score;
mod sheet;
mod skeleton;
mod tree;
mod width;

pub use grown::{from_vein, grown};
pub use scanned::{Evidence, scanned};
