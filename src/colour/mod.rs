//! The colour stage: pigments -> spectra -> reflected and transmitted colour -> textures of a leaf in each state.
//!
//! A leaf's look is computed from its pigments by PROSPECT-D: never mixed from colours, since a straight line between
//! a green and a red is up to dE 11 off the colour of mixed pigments. Textures are fields of pigment content for the same reason.
//! It knows no light source but D65, no gloss lobe and no tree. Sources stand in `plate` and `spectrum`.

mod appearance;
mod areoles;
mod check;
mod contents;
mod distance;
mod exponential_integral;
mod matching;
mod noise;
mod painting;
mod palette;
mod pigment_field;
mod plate;
mod relief;
mod scan;
mod spectra_table;
mod spectrum;
mod surface;

pub use appearance::{Appearance, Colour, appearance, colour_difference, lab};
pub use check::check;
pub use painting::{Canvas, Job, Painted, Scans, paint, paint_on};

use crate::base::settings::{Described, Kind};
use crate::{choice, settings};
use serde::{Deserialize, Serialize};
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

/// What a state's leaf holds.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum State {
    /// Its contents.
    Contents(Pigments),
    /// A plain colour, `#rrggbb`, to which contents are fitted.
    Colour(String),
}

impl Described for State {
    fn kind() -> Kind {
        Kind::Either(vec![Pigments::kind(), Kind::Text])
    }
}

settings! {
    /// A state by three sliders instead of contents; all at 0 it is the green leaf.
    pub struct Sliders {
        /// How red: anthocyanins.
        red: f64 = 0.0, range 0.0 => 1.0;
        /// How yellow: chlorophyll gone, carotenoids kept.
        yellow: f64 = 0.0, range 0.0 => 1.0;
        /// How brown: tissue dead and dry.
        brown: f64 = 0.0, range 0.0 => 1.0;
    }
}

settings! {
    /// How pigments lie in the blade.
    pub struct Painting {
        /// Softness of the borders between green and turned tissue, relative.
        softness: f64 = 1.0, range 0.1 => 10.0;
        /// How much longer tissue at the veins keeps its chlorophyll, relative.
        hold: f64 = 1.0, range 0.0 => 4.0;
        /// How far the margin is ahead of the middle.
        margin: f64 = 0.5, range -4.0 => 4.0;
        /// How unevenly patches and areoles age, relative.
        patchiness: f64 = 1.0, range 0.0 => 4.0;
        /// Widest band of dead tissue at the margin of a leaf that has lost its chlorophyll.
        scorch: f64 = 1.6, unit "mm", range 0.0 => 50.0;
        /// Mean number of dead spots on the square of the texture when the chlorophyll is gone.
        spots: f64 = 20.0, range 0.0 => 5000.0;
        /// Whether the lower side has a colour of its own, paler than the upper's. glTF files show one colour on both.
        lower_side: bool = true;
        /// Reflectance of the colourless layer on the lower side.
        pallor: f64 = 0.045, range 0.0 => 0.6;
        /// Height of the relief of veins and areoles, relative.
        relief: f64 = 1.0, range 0.0 => 5.0;
    }
}

choice! {
    /// What a leaf's texture shows.
    pub enum Detail {
        /// Veins, areoles, blotches and spots.
        Painted = "painted",
        /// The state's colour, even: for measurements of colour.
        Plain = "plain",
    }
}

settings! {
    /// Leaf colours and textures.
    pub struct Settings {
        /// The spectral table.
        table: Table = Table::Coarse;
        /// Each state's contents, or a plain colour "#rrggbb" to which contents are fitted.
        pigments: BTreeMap<String, State> = BTreeMap::new();
        /// States given by sliders; they win over contents.
        sliders: BTreeMap<String, Sliders> = BTreeMap::new();
        /// Pictures that leaves of a state wear, laid out like `leaf.texture`: each state's own scan.
        scans: BTreeMap<String, String> = BTreeMap::new();
        /// What textures show: "painted", or "plain" for the state's even colour.
        detail: Detail = Detail::Painted;
        /// Whether leaves are glossy. Their gloss is then taken off the diffuse reflectance, which holds it otherwise.
        gloss: bool = true;
        /// How pigments lie in the blade.
        painting: Painting = Painting::default();
        /// Pixels along one side of a leaf's texture; a power of two. As many as the camera can tell apart when absent: at
        /// most 256 on trees, 1024 for a leaf by itself.
        size: Option<u32> = None, unit "px", range 16 => 4096;
        /// Different textures painted for each state.
        variants: u32 = 2, range 1 => 16;
    }
}

impl Settings {
    /// Pixels along one side of a texture where nothing says how many can be seen.
    pub const USUAL_SIZE: u32 = 256;

    /// Pixels along one side of a texture.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.size.unwrap_or(Self::USUAL_SIZE)
    }

    /// The contents of a state's leaf, whether given, fitted to a colour, or set by sliders; the defaults for a state that is
    /// not named.
    #[must_use]
    pub fn contents(&self, state: &str) -> Pigments {
        contents::contents(self, &appearance::Optics::new(self.table), state).pigments
    }
}
