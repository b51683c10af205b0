//! What stands out from the background: the distance in CIELAB of every pixel from the median colour of the picture's rim,
//! divided by Otsu's threshold (1979). Lightness counts a quarter, which lets shadows pass for paper; it counts alone in
//! full when the picture has no colour.

use crate::leaf::LeafError;
use crate::leaf::grid::Grid;

/// Weight of lightness against colour.
const LIGHTNESS_WEIGHT: f32 = 0.25;
/// Below this colour distance (Lab units, 99.5th percentile) the picture counts as grey.
const COLOURLESS: f32 = 4.0;
/// Below this distance (Lab units, 99.5th percentile) nothing is to be seen.
const FLAT: f32 = 3.0;
/// Steps of a Lab unit in the histograms, and their number.
const STEPS: f32 = 8.0;
const BINS: usize = 2048;

/// How far each pixel stands out.
pub struct Contrast {
    /// Factors of L, a and b before distances are taken.
    pub weights: [f32; 3],
    /// Otsu's threshold, Lab units.
    pub threshold: f32,
    /// Weighted distance from the background's colour over twice the threshold: more than 0.5 is leaf.
    pub level: Grid<f32>,
}

/// The contrast of a picture with its background.
///
/// # Errors
/// [`LeafError::Picture`] when all of it has about one colour.
pub fn contrast(lab: &Grid<[f32; 3]>) -> Result<Contrast, LeafError> {
    let background = rim_median(lab);
    let mut weights = [LIGHTNESS_WEIGHT, 1.0, 1.0];
    let colours = histogram(lab.cells.iter().map(|c| distance(*c, background, [0.0, 1.0, 1.0])));
    if percentile(&colours, 0.995) < COLOURLESS {
        weights = [1.0, 0.0, 0.0];
    }
    let far = lab.map(|c| distance(c, background, weights));
    let counts = histogram(far.cells.iter().copied());
    let top = percentile(&counts, 0.995);
    if top < FLAT {
        return Err(LeafError::picture(
            "no leaf stands out: the picture is nearly of one colour; lay the leaf on paper of another colour",
        ));
    }
    let threshold = otsu(&clipped(&counts, top));
    Ok(Contrast { weights, threshold, level: far.map(|d| 0.5 * d / threshold) })
}

/// Weighted distance of two colours.
pub fn distance(a: [f32; 3], b: [f32; 3], weights: [f32; 3]) -> f32 {
    let [l, a, b] = [0, 1, 2].map(|i| weights[i] * (a[i] - b[i]));
    (l * l + a * a + b * b).sqrt()
}

/// Median of each channel over a rim of a fortieth of the picture.
fn rim_median(lab: &Grid<[f32; 3]>) -> [f32; 3] {
    let rim = (lab.width.min(lab.height) / 40).max(3);
    let mut kept: Vec<[f32; 3]> = Vec::new();
    for (y, row) in lab.cells.chunks_exact(lab.width).enumerate() {
        if y < rim || y + rim >= lab.height || lab.width <= 2 * rim {
            kept.extend(row);
        } else {
            kept.extend(&row[..rim]);
            kept.extend(&row[lab.width - rim..]);
        }
    }
    [0, 1, 2].map(|c| median(kept.iter().map(|p| p[c]).collect()))
}

/// The middle value (the lower of two), 0 of none.
pub fn median(mut values: Vec<f32>) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = (values.len() - 1) / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

fn histogram(distances: impl Iterator<Item = f32>) -> Vec<u64> {
    let mut counts = vec![0u64; BINS];
    for distance in distances {
        counts[((distance * STEPS) as usize).min(BINS - 1)] += 1;
    }
    counts
}

/// The upper end of the bin where `share` of the counts lies at or below.
fn percentile(counts: &[u64], share: f64) -> f32 {
    let wanted = (counts.iter().sum::<u64>() as f64 * share).ceil();
    let mut below = 0;
    let bin = counts.iter().position(|count| {
        below += count;
        below as f64 >= wanted
    });
    (bin.unwrap_or(0) + 1) as f32 / STEPS
}

/// With everything above `top` counted there, so that a few odd pixels do not draw the threshold up.
fn clipped(counts: &[u64], top: f32) -> Vec<u64> {
    let last = ((top * STEPS) as usize).clamp(1, counts.len() - 1);
    let mut clipped = counts[..last].to_vec();
    clipped.push(counts[last..].iter().sum());
    clipped
}

/// The distance that divides a histogram into the two classes farthest apart.
fn otsu(counts: &[u64]) -> f32 {
    let total: u64 = counts.iter().sum();
    let moment: u64 = counts.iter().enumerate().map(|(bin, count)| bin as u64 * count).sum();
    let (mut below, mut below_moment) = (0u64, 0u64);
    let (mut best, mut threshold) = (-1.0, 0);
    for (bin, count) in counts.iter().enumerate() {
        below += count;
        below_moment += bin as u64 * count;
        if below == 0 || below == total {
            continue;
        }
        let (low, high) = (below as f64, (total - below) as f64);
        let gap = below_moment as f64 / low - (moment - below_moment) as f64 / high;
        let between = low * high * gap * gap;
        if between > best {
            (best, threshold) = (between, bin);
        }
    }
    (threshold + 1) as f32 / STEPS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn otsu_divides_two_heaps() {
        let mut counts = vec![0u64; 300];
        for bin in [10, 11, 12, 12, 200, 201, 205] {
            counts[bin] += 1;
        }
        assert!((12.0 / STEPS..200.0 / STEPS).contains(&otsu(&counts)));
    }

    #[test]
    fn percentiles_are_those_of_the_sorted_values() {
        let counts = histogram((0..1000).map(|i| i as f32 / 100.0));
        assert!((percentile(&counts, 0.5) - 5.0).abs() <= 1.0 / STEPS);
        assert!((percentile(&counts, 0.995) - 9.95).abs() <= 1.0 / STEPS);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
    }

    #[test]
    fn lightness_counts_alone_on_a_grey_picture() {
        let mut lab = Grid { width: 40, height: 40, cells: vec![[90.0, 0.0, 0.0]; 1600] };
        (0..400).for_each(|i| lab.cells[600 + i] = [30.0, 0.0, 0.0]);
        let found = contrast(&lab).map(|c| (c.weights, c.level.map(|t| t > 0.5).area()));
        assert_eq!(found, Ok(([1.0, 0.0, 0.0], 400)));
        lab.cells.fill([50.0, 1.0, 1.0]);
        assert!(contrast(&lab).is_err());
    }
}
