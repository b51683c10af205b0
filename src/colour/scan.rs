//! A user's scan as a source of detail: how each place differs from the leaf's mean colour.

use super::Colour;
use super::surface::Surface;
use crate::base::maths::srgb_to_linear;
use crate::base::picture::Picture;

/// Detail is held within these factors: spots and gloss of a scan would else burn out or go black in another state.
const DETAIL: (f32, f32) = (0.3, 2.2);

/// A scan at the resolution of the texture.
#[derive(Clone, Debug)]
pub(super) struct Scan {
    /// Linear colour of each pixel inside the blade, in their order.
    pub colours: Vec<[f32; 3]>,
    /// Their mean.
    pub mean: Colour,
}

impl Scan {
    /// Reads a scan that is laid out by texture coordinates, whatever its size. `None` for an empty picture.
    pub(super) fn new(picture: &Picture, surface: &Surface) -> Option<Self> {
        if picture.width == 0 || picture.height == 0 {
            return None;
        }
        let inside = (0..surface.inside.len()).filter(|&pixel| surface.inside[pixel]);
        let colours: Vec<[f32; 3]> = inside.map(|pixel| averaged(picture, surface, pixel)).collect();
        let mut mean = [0.0; 3];
        for (sum, channel) in mean.iter_mut().zip(0..3) {
            *sum = colours.iter().map(|c| f64::from(c[channel])).sum::<f64>() / colours.len().max(1) as f64;
        }
        Some(Self { colours, mean })
    }

    /// Each pixel's factors on the mean colour, clipped.
    pub(super) fn detail(&self, pixel: usize) -> [f32; 3] {
        std::array::from_fn(|c| (self.colours[pixel][c] / (self.mean[c] as f32).max(1e-3)).clamp(DETAIL.0, DETAIL.1))
    }
}

/// The mean linear colour of the part of the picture that a texel covers.
fn averaged(picture: &Picture, surface: &Surface, pixel: usize) -> [f32; 3] {
    let size = surface.size as u64;
    let part = |index: usize, extent: u32| {
        let first = (index as u64 * u64::from(extent) / size) as u32;
        let end = ((index as u64 + 1) * u64::from(extent)).div_ceil(size) as u32;
        first..end.max(first + 1).min(extent)
    };
    let mut sum = [0.0f32; 3];
    let (columns, rows) = (part(pixel % surface.size, picture.width), part(pixel / surface.size, picture.height));
    let count = columns.len() * rows.len();
    for row in rows {
        for column in columns.clone() {
            let [red, green, blue, _] = picture.at(column, row);
            for (total, code) in sum.iter_mut().zip([red, green, blue]) {
                *total += srgb_to_linear(f32::from(code) / 255.0);
            }
        }
    }
    sum.map(|total| total / count as f32)
}
