//! How far two pictures are apart: the largest difference of a channel, the root mean square in linear light, and FLIP,
//! which weighs differences as an observer flipping between the two would notice them.
//!
//! Not a judgement: which figure must stay below what is the caller's business.

mod colour_space;
mod comparison;
mod features;
mod filter;
mod flip;
mod plane;

pub use comparison::{Comparison, SizesDiffer, compare};
pub use flip::{PIXELS_PER_DEGREE, flip_map};
