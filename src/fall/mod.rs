//! The fall: a leaf that left its twig -> where it is and how it lies at any later time.
//!
//! 1. `flight`: the way down, a closed form of the time since the leaf let go: descent at the speed of its mass and area,
//!    flutter, tumbling or a spiral by its Froude number, wind and gusts (`wind`) integrated exactly;
//! 2. `fate`: whether it hangs, flies, lies (as it fell, brown, flat) or has decayed;
//! 3. `landing`, `drift` and `ground`: where it comes to rest: its way ends where it first meets the ground; gusts of later days
//!    roll it along, litter gathers in patches, slides off steep slopes and does not lie within trunks;
//! 4. `litter`: how it lies on the ground and on what lies there already: on three points of its shape (`shape`, `support`)
//!    down to the first contact (`contact`), pressed by what lies over it (`layers`). Leaves that do not meet are laid at the
//!    same time (`schedule`), what lies as it lay in the frame before is kept (`changes`), and scattered litter is laid in
//!    `windows`, one after another, for the memory's sake.
//!
//! Every result is a function of the seed, the leaf and the time; the litter of a time is made from all earlier falls, in
//! the order in which they landed. No step follows from a step before, so a frame alone equals the same frame of a run.
//! It does not know why a leaf falls, what it looks like or which mesh is drawn. Not an aerodynamic simulation: the motions
//! are those that falling plates and leaves are seen to make, with measured or judged sizes, and leaves do not meet in the air.
//!
//! Lengths are metres, y is up, times are seconds within a flight and days elsewhere.

mod changes;
mod check;
mod columns;
mod contact;
mod descent;
mod drift;
mod fate;
mod flight;
mod footprint;
mod ground;
mod heights;
mod landing;
mod layers;
mod lines;
mod litter;
#[cfg(test)]
mod pile_tests;
mod schedule;
mod settings;
mod shape;
mod support;
#[cfg(test)]
mod tests;
mod wind;
mod windows;

pub use check::{check, check_decay};
pub use descent::{Descent, froude, terminal_speed};
pub use fate::{Counts, Course, Fate};
pub use flight::{Flight, Motion};
pub use ground::{Ground, Trunk};
pub use heights::HeightMap;
pub use landing::Slopes;
pub use litter::{Laid, Landed, Litter, lot, settle};
pub use settings::{Decay, Settings};
pub use shape::{Shape, Side, Stalk};
pub use wind::Wind;
pub use windows::most_field_bytes;

use crate::base::vector::DVec3;

/// A leaf that has left its twig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fallen {
    /// The leaf's stable id.
    pub leaf: u64,
    /// Which of the falls from this site it is; the leaves of other years have other numbers and other ways down.
    pub year: u64,
    /// When it let go, days.
    pub day: f64,
    /// Where it hung: the foot of its petiole, metres.
    pub twig: DVec3,
    /// Mass over area of one side when it let go, g/m2.
    pub mass_per_area: f64,
    /// Length of its blade, metres.
    pub length: f64,
}

/// Seconds of a day.
pub(crate) const DAY: f64 = 86_400.0;
