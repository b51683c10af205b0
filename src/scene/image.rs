//! Size and antialiasing of the picture.

use crate::base::settings::Complaint;
use crate::{choice, settings};

choice! {
    /// What the surfaces of leaves show.
    pub enum Leaves {
        /// Their colours in the light of the scene.
        Lit = "lit",
        /// Plain white: for wireframes.
        White = "white",
        /// The mask map: white stays, black moves most.
        Mask = "mask",
        /// The outline's curve with its key points, on white.
        Outline = "outline",
        /// The veins, on white.
        Veins = "veins",
    }
}

choice! {
    /// What is seen where nothing stands.
    pub enum Backdrop {
        /// The sky and the ground.
        Sky = "sky",
        /// One colour, `background_colour`; the trees keep the light of their surroundings.
        Plain = "plain",
        /// Nothing: the picture is transparent there.
        Transparent = "transparent",
    }
}

settings! {
    /// The picture. Width times height is bounded by the limit `pixels`.
    pub struct Image {
        /// Pixels in a row.
        width: u32 = 1920, unit "px", range 1 => 1000000;
        /// Rows.
        height: u32 = 1080, unit "px", range 1 => 1000000;
        /// Cells in a row of a contact sheet; 0 for a grid as square as can be.
        columns: u32 = 0, range 0 => 100;
        /// Samples in each pixel: 1, 4, 8, 16, 32, 64, 128 or 256.
        samples: u32 = 8, range 1 => 256;
        /// Distance that a coarser mesh may lie from the full one where it stands; 0 draws full meshes.
        lod_error: f64 = 0.3, unit "px", range 0.0 => 100.0;
        /// What leaves show; all but "lit" are charts that no light changes.
        leaves: Leaves = Leaves::Lit;
        /// What is seen where nothing stands.
        background: Backdrop = Backdrop::Sky;
        /// Colour of a plain background, sRGB.
        background_colour: [f64; 3] = [1.0, 1.0, 1.0], range 0.0 => 1.0;
        /// Width of lines over the edges of every triangle; 0 for none.
        wireframe: f64 = 0.0, unit "px", range 0.0 => 100.0;
        /// Words in the picture's lower left corner, in a font of the program's own; a cell of a contact sheet may have its own.
        label: String = String::new();
    }
}

/// The numbers of samples for which there is a pattern.
pub const SAMPLES: [u32; 8] = [1, 4, 8, 16, 32, 64, 128, 256];

/// Most letters of a label.
const LONGEST_LABEL: usize = 200;

/// What is wrong with well-typed settings.
#[must_use]
pub fn check(image: &Image) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    if !SAMPLES.contains(&image.samples) {
        let what = format!("{} samples in a pixel have no pattern", image.samples);
        complaints.push(Complaint::new("samples", what, "write 1, 4, 8, 16, 32, 64, 128 or 256"));
    }
    let letters = image.label.chars().count();
    if letters > LONGEST_LABEL {
        let what = format!("{letters} letters are too many to be read in a corner");
        complaints.push(Complaint::new("label", what, format!("write at most {LONGEST_LABEL}")));
    }
    complaints
}

impl Image {
    /// Pixels of the picture, which may exceed 32 bits.
    #[must_use]
    pub fn pixels(&self) -> f64 {
        f64::from(self.width) * f64::from(self.height)
    }
}
