//! A user's scan: its colours where a state wears it, and its pigments, found place by place, where it ages.
//!
//! Each place is taken for tissue of the contents whose colour is nearest; what pigments cannot say, light and shade, stays
//! as a factor. In another state the place leads or lags as it did in the scan: where it was greener than the rest it stays
//! green longer, where it was redder it turns redder, and what was dead stays dead.

use super::Colour;
use super::palette::Palette;
use super::surface::{Surface, Tissue};
use crate::base::encoding::{linear_values, luminance};
use crate::base::maths::{expf, lnf, smooth_step};
use crate::base::picture::Picture;

/// Bits of each channel by which colours are told apart when pigments are sought.
const BITS: u32 = 5;
/// The least and largest factor of light and shade.
const LIGHT: (f32, f32) = (0.55, 1.7);
/// Brown pigment beyond which tissue is dead, and the most that is taken for it.
const DEAD: (f32, f32) = (0.6, 2.6);

/// A scan at the resolution of the texture.
#[derive(Clone, Debug)]
pub(super) struct Scan {
    /// Linear colour of each pixel inside the blade, in their order.
    pub colours: Vec<[f32; 3]>,
    /// Their mean.
    pub mean: Colour,
}

impl Scan {
    /// Reads a scan that is laid out by texture coordinates, whatever its size. `None` for an empty or a clear picture.
    pub(super) fn new(picture: &Picture, surface: &Surface) -> Option<Self> {
        if picture.width == 0 || picture.height == 0 {
            return None;
        }
        let table = linear_values();
        let found: Vec<Option<[f32; 3]>> =
            surface.pixels().map(|pixel| averaged(picture, &table, surface.size, pixel)).collect();
        let count = found.iter().flatten().count();
        if count == 0 {
            return None;
        }
        let sum = |c: usize| found.iter().flatten().map(|colour| f64::from(colour[c])).sum::<f64>();
        let mean: Colour = [0, 1, 2].map(|c| sum(c) / count as f64);
        let fill = mean.map(|c| c as f32);
        Some(Self { colours: found.into_iter().map(|colour| colour.unwrap_or(fill)).collect(), mean })
    }

    /// Writes what the scan shows of each place's past into its tissue. The palette is that of the state whose colour is
    /// nearest to the scan's.
    pub(super) fn age(&self, palette: &Palette, tissue: &mut [Tissue]) {
        let mut known = vec![None; 1 << (3 * BITS)];
        let contents: Vec<[f32; 3]> = self
            .colours
            .iter()
            .map(|colour| *known[code(colour)].get_or_insert_with(|| palette.nearest(rounded(colour))))
            .collect();
        let mean = |k: usize| {
            (contents.iter().map(|found| f64::from(found[k])).sum::<f64>() / contents.len().max(1) as f64) as f32
        };
        let means = [mean(0), mean(1), mean(2)];
        for ((tissue, colour), found) in tissue.iter_mut().zip(&self.colours).zip(&contents) {
            let ratio = |k: usize, floor: f32| lnf((found[k] + floor) / (means[k] + floor)).clamp(-1.5, 1.5);
            tissue.lead = -0.35 * ratio(0, 1.0);
            tissue.redness = expf(0.7 * ratio(1, 1.0));
            let look = palette.at(*found);
            // Dead tissue is brown, or dark without being green.
            let dark =
                1.0 - smooth_step(0.3, 0.6, luminance(*colour) / luminance(self.mean.map(|c| c as f32)).max(1e-3));
            let dark = if colour[0] > 0.9 * colour[1] { DEAD.1 * dark } else { 0.0 };
            tissue.brown = (found[2] - means[2] - DEAD.0).max(dark).clamp(0.0, DEAD.1);
            let expected = luminance([look[0], look[1], look[2]]);
            tissue.light = (luminance(*colour) / expected.max(1e-3)).clamp(LIGHT.0, LIGHT.1);
        }
    }
}

/// The number of a colour among those told apart: steps are even in the square root, about as the eye sees them.
fn code(colour: &[f32; 3]) -> usize {
    let top = ((1 << BITS) - 1) as f32;
    colour.iter().fold(0, |code, channel| code << BITS | (channel.clamp(0.0, 1.0).sqrt() * top + 0.5) as usize)
}

/// The middle of the colours of one number.
fn rounded(colour: &[f32; 3]) -> [f32; 3] {
    let top = ((1 << BITS) - 1) as f32;
    colour.map(|channel| {
        let step = (channel.clamp(0.0, 1.0).sqrt() * top + 0.5).floor() / top;
        step * step
    })
}

/// The mean linear colour of the part of the picture that a texel covers, where it is opaque.
fn averaged(picture: &Picture, table: &[f32], size: usize, pixel: usize) -> Option<[f32; 3]> {
    let size64 = size as u64;
    let part = |index: usize, extent: u32| {
        let first = (index as u64 * u64::from(extent) / size64) as u32;
        let end = ((index as u64 + 1) * u64::from(extent)).div_ceil(size64) as u32;
        first..end.max(first + 1).min(extent)
    };
    let (mut sum, mut count) = ([0.0f32; 3], 0u32);
    let (columns, rows) = (part(pixel % size, picture.width), part(pixel / size, picture.height));
    for row in rows {
        for column in columns.clone() {
            let [red, green, blue, alpha] = picture.at(column, row);
            if alpha < 128 {
                continue;
            }
            count += 1;
            for (total, code) in sum.iter_mut().zip([red, green, blue]) {
                *total += table[usize::from(code)];
            }
        }
    }
    (count > 0).then(|| sum.map(|total| total / count as f32))
}
