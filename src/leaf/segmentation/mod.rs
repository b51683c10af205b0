//! Leaf or background, for every pixel of a scan: the alpha channel where there is one, else the contrast with the
//! background, found anew near the margin between the colours of leaf and background on the spot. The largest part is the
//! leaf; its petiole is cut, its gaps are kept or filled, and a border that cuts it off is refused.

mod border;
mod contrast;
mod gaps;
mod lab;
pub(in crate::leaf) mod petiole;
mod two_colours;

use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::LeafError;
use crate::leaf::grid::{Grid, Parts};
use crate::leaf::segmentation::contrast::contrast;
use crate::leaf::segmentation::lab::lab_of;
use crate::leaf::segmentation::petiole::{Cut, Petiole};

/// Share of the picture that a leaf must cover.
const SMALLEST: f64 = 0.002;
/// Smallest side of a picture, and smallest area of a leaf, pixels.
const LEAST_SIDE: u32 = 16;
const LEAST_AREA: usize = 150;
/// Share of the pixels that must be see-through for the alpha channel to tell the leaf.
const SEE_THROUGH: f64 = 0.005;
/// Parts of at least this share of the largest one's area are further leaves.
const FURTHER: f64 = 0.1;
/// Radius of the opening that takes threads and ruled lines away, share of the longer side; and least, pixels.
const THREAD: f64 = 0.002;
/// Half width of the thinnest petiole that is looked for where its colour is near the paper's, share of the square root of
/// the leaf's area.
const STRAND: f64 = 0.0075;
/// Most half width of what lies over the blade and is not paper, such as a folded petiole, and the least, under which it may be
/// a line on the paper; shares of the square root of the leaf's area.
const BRIDGE: f64 = 0.012;
const BROAD: f64 = 0.006;

/// The blade in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// True on the blade, without petiole and see-through gaps.
    pub blade: Grid<bool>,
    /// True where the blade's own colour shows: the blade without small holes and pale spots.
    pub shown: Grid<bool>,
    /// The petiole that was cut off.
    pub petiole: Option<Petiole>,
    /// Where the petiole, or a stump of it, meets the blade, pixels.
    pub joint: Option<DVec2>,
    /// See-through gaps that were kept.
    pub gaps: usize,
    /// Enclosed places that were filled.
    pub filled: usize,
    /// Further leaves on the sheet.
    pub others: usize,
}

/// Finds the blade.
///
/// # Errors
/// [`LeafError::Picture`] when nothing stands out from the background, the leaf is too small, or the border cuts it off.
pub fn segmented(picture: &Picture) -> Result<Segment, LeafError> {
    if picture.width.min(picture.height) < LEAST_SIDE {
        let (width, height) = (picture.width, picture.height);
        return Err(LeafError::picture(&format!(
            "the picture of {width} x {height} pixels is too small to trace; give one of at least {LEAST_SIDE} on each side"
        )));
    }
    let (mask, wide, level, others) = if is_cut_out(picture) { opaque(picture)? } else { coloured(picture)? };
    let Cut { blade, petiole, joint } = petiole::cut(&mask, &wide);
    border::whole(&blade)?;
    let gaps = gaps::sorted(&blade, &level);
    let shown = gaps.blade.joined(&mask, |blade, mask| blade && mask);
    Ok(Segment { blade: gaps.blade, shown, petiole, joint, gaps: gaps.kept, filled: gaps.filled, others })
}

/// Whether the alpha channel tells the leaf.
fn is_cut_out(picture: &Picture) -> bool {
    let clear = picture.pixels.iter().filter(|p| p[3] < 128).count();
    clear as f64 > SEE_THROUGH * picture.pixels.len() as f64
}

/// The leaf, the leaf with all that hangs on it and is not paper, the level of every pixel (0 background, 1 leaf), and the
/// number of further leaves.
type Found = (Grid<bool>, Grid<bool>, Grid<f32>, usize);

fn opaque(picture: &Picture) -> Result<Found, LeafError> {
    let cells = picture.pixels.iter().map(|p| f32::from(p[3]) / 255.0).collect();
    let level = Grid { width: picture.width as usize, height: picture.height as usize, cells };
    let mask = level.map(|t| t > 0.5);
    let (leaf, others) = largest(&mask.opened(thread(&mask)))?;
    Ok((leaf.clone(), leaf, level, others))
}

fn coloured(picture: &Picture) -> Result<Found, LeafError> {
    let lab = lab_of(picture);
    let mut contrast = contrast(&lab)?;
    let mask = contrast.level.map(|t| t > 0.5);
    let (leaf, others) = largest(&mask.opened(thread(&mask)))?;
    let strange = two_colours::refined(&lab, &mut contrast, &leaf);
    let near = leaf.dilated(thread(&mask) * 2.0);
    let mask = contrast.level.map(|t| t > 0.5).joined(&near, |m, n| m && n);
    let size = (leaf.area() as f64).sqrt();
    let bridges = closed(&mask, BRIDGE * size).joined(&mask, |c, m| c && !m);
    let bridges = bridges.joined(&strange.unshaded, |b, u| b && u).opened((BROAD * size).max(1.0));
    let mask = mask.joined(&bridges, |m, b| m || b);
    let (leaf, _) = largest(&mask.opened(1.0))?;
    let other = strange.other.opened((STRAND * size).max(thread(&mask)));
    let wide = holding(&other.joined(&leaf, |o, l| o || l), &leaf);
    Ok((leaf, wide, contrast.level, others))
}

/// Closing by a disc: what a disc of this radius cannot pass from outside.
fn closed(mask: &Grid<bool>, radius: f64) -> Grid<bool> {
    let rim = radius.ceil() as usize + 1;
    mask.padded(rim).dilated(radius).eroded(radius).trimmed(rim)
}

/// The part of a mask that holds a leaf.
fn holding(mask: &Grid<bool>, leaf: &Grid<bool>) -> Grid<bool> {
    let parts = Parts::of(mask);
    let held = leaf.cells.iter().position(|&c| c).map_or(0, |cell| parts.at(cell));
    parts.only(|part| part == held)
}

/// Radius of the opening of a mask of this size.
fn thread(mask: &Grid<bool>) -> f64 {
    (THREAD * mask.width.max(mask.height) as f64).max(1.0)
}

/// The largest part, and how many others are leaves too.
///
/// # Errors
/// [`LeafError::Picture`] when it is too small for a leaf, or fills the picture.
fn largest(mask: &Grid<bool>) -> Result<(Grid<bool>, usize), LeafError> {
    let parts = Parts::of(mask);
    let area = |part: &u32| parts.areas[*part as usize];
    let Some(best) =
        parts.largest().filter(|l| area(l) >= LEAST_AREA && area(l) as f64 >= SMALLEST * mask.cells.len() as f64)
    else {
        return Err(LeafError::picture(
            "no leaf stands out from the background; lay it flat on plain paper of another colour and fill the picture with it",
        ));
    };
    if area(&best) as f64 > 0.99 * mask.cells.len() as f64 {
        return Err(LeafError::picture("the leaf fills the whole picture; leave background on every side"));
    }
    let further = (1..=parts.count()).filter(|l| *l != best && area(l) as f64 >= FURTHER * area(&best) as f64).count();
    Ok((parts.only(|part| part == best), further))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_colour_is_refused() {
        let plain = Picture::filled(64, 64, [120, 130, 140, 255]);
        assert!(matches!(segmented(&plain), Err(LeafError::Picture { .. })));
    }
}
