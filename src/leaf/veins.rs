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
pub use scanned::{Evidence, scanned};

use crate::base::blade::Vein;
use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::Venation;
use crate::leaf::trace::Trace;

/// Where veins come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// They are seen in the scan.
    Scan(Evidence),
    /// There is a scan, but it shows none: they are grown from the outline.
    Unseen(Evidence),
    /// There is no scan: they are grown from the outline.
    Outline,
}

impl Source {
    /// For reports: "scan", "outline, none seen in the scan" or "outline".
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Scan(_) => "scan",
            Self::Unseen(_) => "outline, none seen in the scan",
            Self::Outline => "outline",
        }
    }
}

/// The veins of a blade, thick ones first: those that its scan shows, else those grown from its outline (metres, dense,
/// counter-clockwise, the joint at the origin).
#[must_use]
pub fn found(outline: &[DVec2], venation: Venation, scan: Option<(&Picture, &Trace)>) -> (Vec<Vein>, Source) {
    match scan.map(|(picture, trace)| scanned(picture, trace)) {
        Some((veins, evidence)) if evidence.suffices() => (veins, Source::Scan(evidence)),
        Some((_, evidence)) => (grown(outline, venation), Source::Unseen(evidence)),
        None => (grown(outline, venation), Source::Outline),
    }
}

#[cfg(test)]
mod tests;
