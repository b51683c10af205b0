//! Enclosed places of a blade where it does not show: gaps between lobes and holes through which the background is seen stay
//! open; small ones and pale spots are filled.

use crate::leaf::grid::{Grid, Parts};
use crate::leaf::segmentation::contrast::median;

/// Share of the leaf's area from which a gap is kept.
const SMALLEST: f64 = 0.001;
/// A gap shows the background when its middle level is below this (0 background, 1 leaf).
const SEEN_THROUGH: f32 = 0.3;
/// Fewer cells than this are noise, filled without counting.
const NOISE: usize = 9;

/// The blade with its gaps sorted out.
pub struct Gaps {
    /// The blade: filled but for the gaps that were kept.
    pub blade: Grid<bool>,
    /// How many gaps were kept.
    pub kept: usize,
    /// How many enclosed places were filled.
    pub filled: usize,
}

/// Keeps or fills the enclosed places of a blade.
pub fn sorted(blade: &Grid<bool>, level: &Grid<f32>) -> Gaps {
    let whole = blade.filled();
    let enclosed = whole.joined(blade, |whole, blade| whole && !blade);
    let parts = Parts::of(&enclosed);
    let (areas, labels) = (&parts.areas, parts.labels());
    let least = SMALLEST * whole.area() as f64;
    let mut levels: Vec<Vec<f32>> = vec![Vec::new(); areas.len()];
    for (&label, &level) in labels.cells.iter().zip(&level.cells) {
        if label != 0 && areas[label as usize] as f64 > least {
            levels[label as usize].push(level);
        }
    }
    let open: Vec<bool> = levels.into_iter().map(|l| !l.is_empty() && median(l) < SEEN_THROUGH).collect();
    let kept = open.iter().filter(|&&open| open).count();
    let counted = (1..areas.len()).filter(|&label| areas[label] >= NOISE).count();
    let closed = parts.only(|part| !open[part as usize]);
    Gaps { blade: closed.joined(blade, |closed, blade| closed || blade), kept, filled: counted - kept.min(counted) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_of_the_backgrounds_colour_stays_and_a_pale_spot_is_filled() {
        let hole = |x: usize, y: usize| (20..24).contains(&y) && (x % 20 < 4) && (20..64).contains(&x);
        let leaf = |x: usize, y: usize| (2..78).contains(&x) && (2..58).contains(&y) && !hole(x, y);
        let cells = (0..80 * 60).map(|i| leaf(i % 80, i / 80)).collect();
        let blade = Grid { width: 80, height: 60, cells };
        // the first hole shows the background, the two others are pale
        let pale = |i: usize| if i % 80 < 30 { 0.05 } else { 0.45 };
        let cells = (0..80 * 60).map(|i| if blade.cells[i] { 1.0 } else { pale(i) }).collect();
        let gaps = sorted(&blade, &Grid { width: 80, height: 60, cells });
        assert_eq!((gaps.kept, gaps.filled), (1, 2));
        assert_eq!(gaps.blade.area(), 76 * 56 - 16);
    }
}
