//! Veins of a blade: seen in its scan, or grown from its outline when there is nothing to see.

mod branching;
mod forking;
mod grown;
mod line;
mod lobes;
mod paths;
mod petiole;
mod ridge;
mod rungs;
mod scanned;
pub mod score;
mod sheet;
mod skeleton;
mod tree;
mod width;

pub use grown::grown;
pub use scanned::scanned;

#[cfg(test)]
mod tests;
