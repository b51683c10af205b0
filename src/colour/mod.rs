//! The colour stage: pigments -> spectra -> reflected and transmitted colour -> textures of a leaf in each state.
//!
//! A leaf's look is computed from its pigments by PROSPECT-D: never mixed from colours, since a straight line between
//! a green and a red is up to dE 11 off the colour of mixed pigments. Textures are fields of pigment content for the same reason.
//! It knows no light source but D65, no gloss lobe and no tree. Sources stand in `plate` and `spectrum`.

mod appearance;
mod check;
mod distance;
mod exponential_integral;
mod noise;
mod painting;
mod palette;
mod pigment_field;
mod plate;
mod scan;
mod spectrum;
mod surface;

pub use appearance::{Appearance, Colour, appearance, colour_difference, lab};
pub use check::check;
pub use painting::{Job, Painted, paint};

use crate::{choice, settings};
use std::collections::BTreeMap;

choice! {
    /// Resolution of the spectral table.
    pub enum Table {
        /// 39 wavelengths, 400 to 780 nm.
        Coarse = "10nm",
        /// 77 wavelengths, 400 to 780 nm.
        Fine = "5nm",
    }
}

settings! {
    /// The contents of a leaf in the sense of PROSPECT-D (Feret et al. 2017).
    pub struct Pigments {
        /// Number of plates N.
        structure: f64 = 1.5, range 1.0 => 4.0;
        /// Chlorophyll a + b.
        chlorophyll: f64 = 38.0, unit "ug/cm2", range 0.0 => 200.0;
        /// Carotenoids.
        carotenoids: f64 = 7.0, unit "ug/cm2", range 0.0 => 60.0;
        /// Anthocyanins.
        anthocyanins: f64 = 2.0, unit "ug/cm2", range 0.0 => 100.0;
        /// Brown pigments, relative.
        brown: f64 = 0.0, range 0.0 => 10.0;
        /// Equivalent water thickness.
        water: f64 = 0.01, unit "cm", range 0.0 => 0.2;
        /// Dry matter.
        dry_matter: f64 = 0.004, unit "g/cm2", range 0.0 => 0.1;
    }
}

settings! {
    /// Leaf colours and textures.
    pub struct Settings {
        /// The spectral table.
        table: Table = Table::Coarse;
        /// Pigments of each state.
        pigments: BTreeMap<String, Pigments> = BTreeMap::new();
        /// Pixels along one side of a leaf's texture; a power of two.
        size: u32 = 256, unit "px", range 16 => 4096;
        /// Different textures painted for each state.
        variants: u32 = 2, range 1 => 16;
    }
}
