//! Leaf or background, for every pixel of a scan: the alpha channel where there is one, else the distance in CIELAB from the
//! median colour of the picture's rim, divided by Otsu's threshold (1979). Lightness counts a quarter, which lets shadows
//! pass for paper; it counts in full when the picture has no colour. Then the largest part, its holes filled, and the
//! petiole cut off by an opening.

use crate::base::maths::cbrt;
use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::LeafError;
use crate::leaf::grid::Grid;
use rayon::prelude::*;

/// Weight of lightness against colour.
const LIGHTNESS_WEIGHT: f32 = 0.25;
/// Below this colour distance (Lab units, 99.5th percentile) the picture counts as grey.
const COLOURLESS: f32 = 4.0;
/// Radius of the petiole's opening, share of the square root of the leaf's area.
const STALK_RADIUS: f64 = 0.02;
/// A thin part longer than this many radii is a stalk; shorter ones are teeth.
const STALK_LENGTH: usize = 5;
/// Share of the picture that a leaf must cover.
const SMALLEST: f64 = 0.002;

/// The blade in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// True on the blade, petiole excluded, holes filled.
    pub blade: Grid<bool>,
    /// True where the blade's own colour shows: the blade without holes and gaps between overlapping lobes.
    pub shown: Grid<bool>,
    /// Where the cut petiole met the blade, pixels (centre of the top left pixel at 0.5, 0.5).
    pub joint: Option<DVec2>,
}

/// Finds the blade.
///
/// # Errors
/// [`LeafError::Picture`] when nothing stands out from the background or the leaf fills the whole picture.
pub fn segmented(picture: &Picture) -> Result<Segment, LeafError> {
    let mask = if picture.pixels.iter().any(|p| p[3] < 250) { opaque(picture) } else { coloured(picture)? };
    let side = picture.width.max(picture.height) as f64;
    let leaf = mask.opened((0.002 * side).max(1.0)).largest_part().filled();
    let share = leaf.area() as f64 / leaf.cells.len().max(1) as f64;
    if share < SMALLEST {
        return Err(LeafError::picture("no leaf stands out from the background"));
    }
    if share > 0.99 {
        return Err(LeafError::picture("the leaf fills the whole picture; leave background on every side"));
    }
    Ok(without_petiole(&leaf, &mask))
}

fn opaque(picture: &Picture) -> Grid<bool> {
    let cells = picture.pixels.iter().map(|p| p[3] > 127).collect();
    Grid { width: picture.width as usize, height: picture.height as usize, cells }
}

fn coloured(picture: &Picture) -> Result<Grid<bool>, LeafError> {
    let lab = lab_of(picture);
    let background = rim_median(&lab);
    let distance = |weight: f32| -> Vec<f32> {
        let far = |c: &[f32; 3]| {
            let [l, a, b] = [0, 1, 2].map(|i| c[i] - background[i]);
            (weight * weight * l * l + a * a + b * b).sqrt()
        };
        lab.cells.iter().map(far).collect()
    };
    let colour = distance(0.0);
    let far = if percentile(&colour, 0.995) < COLOURLESS { distance(1.0) } else { distance(LIGHTNESS_WEIGHT) };
    let top = percentile(&far, 0.995);
    if top < 1.0 {
        return Err(LeafError::picture("the picture is of one colour"));
    }
    let level = |d: f32| (d * 255.0 / top).min(255.0) as u8;
    let threshold = otsu(far.iter().map(|&d| level(d)));
    let cells = far.iter().map(|&d| level(d) > threshold).collect();
    Ok(Grid { width: lab.width, height: lab.height, cells })
}

/// CIELAB (D65) of the picture, blurred by a binomial filter of variance 1 against noise and JPEG blocks.
fn lab_of(picture: &Picture) -> Grid<[f32; 3]> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let linear: Vec<f32> = (0..256).map(|i| crate::base::maths::srgb_to_linear(i as f32 / 255.0)).collect();
    let row = |y: usize| -> Vec<[f32; 3]> {
        let rows = [-2i64, -1, 0, 1, 2].map(|d| (y as i64 + d).clamp(0, height as i64 - 1) as usize * width);
        let sums: Vec<[u32; 3]> = (0..width)
            .map(|x| {
                [0, 1, 2].map(|c| {
                    let [a, b, m, d, e] = rows.map(|r| u32::from(picture.pixels[r + x][c]));
                    a + 4 * b + 6 * m + 4 * d + e
                })
            })
            .collect();
        let at = |x: i64| sums[x.clamp(0, width as i64 - 1) as usize];
        (0..width as i64)
            .map(|x| {
                let taps = [at(x - 2), at(x - 1), at(x), at(x + 1), at(x + 2)];
                let code =
                    |c: usize| (taps[0][c] + 4 * taps[1][c] + 6 * taps[2][c] + 4 * taps[3][c] + taps[4][c]) / 256;
                lab([0, 1, 2].map(|c| linear[code(c).min(255) as usize]))
            })
            .collect()
    };
    let cells = (0..height).into_par_iter().flat_map_iter(row).collect();
    Grid { width, height, cells }
}

/// CIELAB of linear sRGB, white D65 (CIE 15; matrix of IEC 61966-2-1).
fn lab([r, g, b]: [f32; 3]) -> [f32; 3] {
    let x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
    let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
    let [x, y, z] = [x, y, z].map(|t| if t > 0.008_856 { cbrt(f64::from(t)) as f32 } else { 7.787 * t + 16.0 / 116.0 });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Median of each channel over a rim of a fortieth of the picture.
fn rim_median(lab: &Grid<[f32; 3]>) -> [f32; 3] {
    let rim = (lab.width.min(lab.height) / 40).max(3);
    let inner = |i: usize, size: usize| i >= rim && i + rim < size;
    let cells = lab.cells.iter().enumerate();
    let kept: Vec<[f32; 3]> = cells
        .filter(|(i, _)| !(inner(i % lab.width, lab.width) && inner(i / lab.width, lab.height)))
        .map(|(_, c)| *c)
        .collect();
    [0, 1, 2].map(|c| percentile(&kept.iter().map(|p| p[c]).collect::<Vec<f32>>(), 0.5))
}

fn percentile(values: &[f32], share: f64) -> f32 {
    let mut sorted = values.to_vec();
    let rank = ((sorted.len() as f64 - 1.0) * share) as usize;
    *sorted.select_nth_unstable_by(rank, f32::total_cmp).1
}

/// The level that divides a histogram into the two classes farthest apart.
fn otsu(levels: impl Iterator<Item = u8>) -> u8 {
    let mut counts = [0u64; 256];
    for level in levels {
        counts[level as usize] += 1;
    }
    let total: u64 = counts.iter().sum();
    let moment: u64 = (0..256).map(|i| i as u64 * counts[i]).sum();
    let (mut below, mut below_moment) = (0u64, 0u64);
    let (mut best, mut threshold) = (-1.0, 0);
    for (level, count) in counts.iter().enumerate().take(255) {
        below += count;
        below_moment += level as u64 * count;
        if below == 0 || below == total {
            continue;
        }
        let (low, high) = (below as f64, (total - below) as f64);
        let gap = below_moment as f64 / low - (moment - below_moment) as f64 / high;
        let between = low * high * gap * gap;
        if between > best {
            (best, threshold) = (between, level as u8);
        }
    }
    threshold
}

/// Cuts long thin parts off; the longest of them tells where the petiole was joined.
fn without_petiole(leaf: &Grid<bool>, mask: &Grid<bool>) -> Segment {
    let radius = (STALK_RADIUS * (leaf.area() as f64).sqrt()).max(2.0);
    let core = leaf.opened(radius).largest_part();
    let cells = leaf.cells.iter().zip(&core.cells).map(|(&l, &c)| l && !c).collect();
    let thin = Grid { width: leaf.width, height: leaf.height, cells };
    let (labels, count) = thin.parts();
    let boxes = boxes(&labels, count);
    let long = |label: u32| boxes[label as usize].length() > STALK_LENGTH * radius as usize;
    let stalk = (1..=count).filter(|&l| long(l)).max_by_key(|&l| (boxes[l as usize].length(), std::cmp::Reverse(l)));
    let keep = |i: usize| core.cells[i] || (thin.cells[i] && !long(labels.cells[i]));
    let blade = Grid { width: leaf.width, height: leaf.height, cells: (0..leaf.cells.len()).map(keep).collect() };
    let joint = stalk.and_then(|label| contact(&labels, label, &core));
    let blade = blade.largest_part().filled();
    let cells = blade.cells.iter().zip(&mask.cells).map(|(&b, &m)| b && m).collect();
    Segment { shown: Grid { cells, ..blade.clone() }, blade, joint }
}

/// A bounding box in pixels.
#[derive(Clone, Copy)]
struct Extent {
    low: [usize; 2],
    high: [usize; 2],
}

impl Extent {
    fn length(self) -> usize {
        (0..2).map(|i| (self.high[i] + 1).saturating_sub(self.low[i])).max().unwrap_or(0)
    }
}

fn boxes(labels: &Grid<u32>, count: u32) -> Vec<Extent> {
    let mut boxes = vec![Extent { low: [usize::MAX; 2], high: [0; 2] }; count as usize + 1];
    for (i, &label) in labels.cells.iter().enumerate() {
        let extent = &mut boxes[label as usize];
        for (axis, place) in [i % labels.width, i / labels.width].into_iter().enumerate() {
            extent.low[axis] = extent.low[axis].min(place);
            extent.high[axis] = extent.high[axis].max(place);
        }
    }
    boxes
}

/// Middle of the pixels of a part that touch the blade.
fn contact(labels: &Grid<u32>, label: u32, blade: &Grid<bool>) -> Option<DVec2> {
    let touches = |&i: &usize| labels.cells[i] == label && blade.neighbours(i).any(|n| blade.cells[n]);
    let touching: Vec<usize> = (0..labels.cells.len()).filter(touches).collect();
    let place = |&i: &usize| DVec2::new((i % labels.width) as f64 + 0.5, (i / labels.width) as f64 + 0.5);
    (!touching.is_empty()).then(|| touching.iter().map(place).sum::<DVec2>() / touching.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_and_grey_have_their_lab() {
        let [l, a, b] = lab([1.0; 3]);
        assert!((l - 100.0).abs() < 0.01 && a.abs() < 0.05 && b.abs() < 0.05);
        let [l, ..] = lab([0.184_187; 3]);
        assert!((l - 50.0).abs() < 0.01);
    }

    #[test]
    fn otsu_divides_two_heaps() {
        let levels = [10u8, 11, 12, 12, 200, 201, 205].into_iter();
        assert!((12..200).contains(&otsu(levels)));
    }

    #[test]
    fn one_colour_is_refused() {
        let plain = Picture::filled(64, 64, [120, 130, 140, 255]);
        assert!(matches!(segmented(&plain), Err(LeafError::Picture { .. })));
    }
}
