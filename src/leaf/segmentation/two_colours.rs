//! The margin of a leaf, found anew between the colours of the leaf and of the background as they are on the spot: one
//! threshold for a whole picture lies too near the paper where there is a shadow, and too near the leaf where it is pale.

use crate::leaf::grid::Grid;
use crate::leaf::segmentation::contrast::{Contrast, distance};

/// Share of the picture's longer side that the margin may move.
const REACH: f64 = 0.004;
/// Spread of the lightness that shadows and folds give one colour, Lab units.
const SHADE: f32 = 12.0;
/// Where the margin lies on the way from the background's colour to the leaf's. The shadow and the scattered light beside a
/// leaf draw the paper's colour towards the leaf's, never the other way, so it is a little more than half.
const MIDDLE: f32 = 0.57;
/// Blocks on the longer side over which colours are gathered, and how many on each side of a block its means take in.
const BLOCKS: usize = 200;
const WINDOW: usize = 4;
/// The whole picture's mean counts as much as this share of a block, for where a window has little of a class.
const PRIOR: f64 = 0.25;
/// Cube root of the share of light in the deepest shadow.
const DARKEST: f32 = 0.6;
/// Paper is gathered where the whole picture's level is below this, without lines and petioles.
const PLAIN: f32 = 0.3;
/// What is this share of the threshold away from the paper, lightness counting twice as much as for the blade since a petiole
/// may have about the paper's hue, and from the paper in shadow, is not paper.
const OTHER: f32 = 0.52;
const UNSHADED: f32 = 0.45;

/// What is not paper.
pub struct Strange {
    /// Of another colour than the paper.
    pub other: Grid<bool>,
    /// Of another colour than the paper in any shadow.
    pub unshaded: Grid<bool>,
}

/// Gives every pixel near the margin of a mask the level of its colour: its place on the way from the background's colour on
/// the spot (0) to the leaf's (1). Also tells what else is not paper: petioles, and veins whose colour is far from the blade's.
pub fn refined(lab: &Grid<[f32; 3]>, contrast: &mut Contrast, mask: &Grid<bool>) -> Strange {
    let side = lab.width.max(lab.height);
    let reach = (REACH * side as f64).max(3.0);
    let inner = mask.eroded(reach);
    let near = mask.dilated(reach);
    let block = (side / BLOCKS).max(4);
    let weights = contrast.weights;
    let strange_weights = [(2.0 * weights[0]).min(1.0), weights[1], weights[2]];
    let leaf = Classes::of(lab, &inner, block);
    let plain = contrast.level.map(|t| t < PLAIN);
    let away = mask.dilated(1.5 * reach).joined(&plain, |near, plain| plain && !near);
    let paper = Classes::of(lab, &away, block);
    let mut strange = Strange { other: mask.clone(), unshaded: mask.clone() };
    for (i, &cell) in lab.cells.iter().enumerate().filter(|(i, _)| !inner.cells[*i]) {
        let (x, y) = (i % lab.width, i / lab.width);
        let here = paper.at(x, y);
        if near.cells[i] {
            contrast.level.cells[i] = 0.5 / MIDDLE * between(cell, &here, &leaf.at(x, y), weights);
        }
        strange.other.cells[i] = distance(cell, here.mean, strange_weights) > OTHER * contrast.threshold;
        strange.unshaded.cells[i] = from_shadow(cell, here.mean, weights) > UNSHADED * contrast.threshold;
    }
    strange
}

/// Weighted distance of a colour from those that a shadow gives the paper. With lightness counted from -16, CIELAB of a
/// colour scales as the cube root of the light that falls on it.
fn from_shadow(colour: [f32; 3], paper: [f32; 3], weights: [f32; 3]) -> f32 {
    let lit = |c: [f32; 3]| [c[0] + 16.0, c[1], c[2]];
    let (colour, paper) = (lit(colour), lit(paper));
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let dim = (dot(colour, paper) / dot(paper, paper).max(1e-6)).clamp(DARKEST, 1.0);
    distance(colour, paper.map(|c| c * dim), weights)
}

/// The place of a colour on the way from one class (0) to another (1), by Fisher's linear discriminant (1936): each channel
/// counts as its means differ, over its variance within the classes. Channels of weight 0 are left out.
fn between(colour: [f32; 3], start: &Class, end: &Class, weights: [f32; 3]) -> f32 {
    let (mut place, mut way) = (0.0, 0.0);
    for i in (0..3).filter(|&i| weights[i] > 0.0) {
        let shade = if i == 0 { SHADE * SHADE } else { 0.0 };
        let factor = (end.mean[i] - start.mean[i]) / (start.variance[i] + end.variance[i] + shade + 1.0);
        place += factor * (colour[i] - start.mean[i]);
        way += factor * (end.mean[i] - start.mean[i]);
    }
    place / way.max(1e-6)
}

/// Mean and variance of the colours of a class.
#[derive(Clone, Copy)]
struct Class {
    mean: [f32; 3],
    variance: [f32; 3],
}

/// Sums over some pixels: L, a, b, their squares, and the count.
type Sums = [f64; 7];

/// The colours of a class round every block.
struct Classes {
    block: usize,
    columns: usize,
    cells: Vec<Class>,
}

impl Classes {
    fn of(lab: &Grid<[f32; 3]>, class: &Grid<bool>, block: usize) -> Self {
        let (columns, rows) = (lab.width.div_ceil(block), lab.height.div_ceil(block));
        let mut sums: Vec<Sums> = vec![[0.0; 7]; columns * rows];
        for (y, row) in lab.cells.chunks_exact(lab.width).enumerate() {
            let start = y / block * columns;
            let flags = &class.cells[y * lab.width..(y + 1) * lab.width];
            for (x, cell) in row.iter().enumerate().filter(|(x, _)| flags[*x]) {
                let [l, a, b] = cell.map(f64::from);
                sums[start + x / block] = added(sums[start + x / block], &[l, a, b, l * l, a * a, b * b, 1.0]);
            }
        }
        let all = sums.iter().fold([0.0; 7], added);
        let weight = PRIOR * (block * block) as f64;
        let prior = all.map(|sum| sum * weight / all[6].max(1.0));
        let along = windowed(&sums, 1, columns, columns);
        let round = windowed(&along, columns, rows, columns);
        Self { block, columns, cells: round.into_iter().map(|sum| class_of(&added(sum, &prior))).collect() }
    }

    /// The class round the block of a pixel.
    fn at(&self, x: usize, y: usize) -> Class {
        self.cells[y / self.block * self.columns + x / self.block]
    }
}

fn class_of(sums: &Sums) -> Class {
    let count = sums[6].max(1e-9);
    let mean = [0, 1, 2].map(|i| sums[i] / count);
    let variance = [0, 1, 2].map(|i| (sums[i + 3] / count - mean[i] * mean[i]).max(0.0) as f32);
    Class { mean: mean.map(|m| m as f32), variance }
}

fn added(a: Sums, b: &Sums) -> Sums {
    [0, 1, 2, 3, 4, 5, 6].map(|i| a[i] + b[i])
}

/// Sums over a window along one axis, whose neighbours lie `step` cells apart and which has `length` of them.
fn windowed(sums: &[Sums], step: usize, length: usize, columns: usize) -> Vec<Sums> {
    let sum = |i: usize| {
        let place = if step == 1 { i % columns } else { i / columns };
        let (low, high) = (place.saturating_sub(WINDOW), (place + WINDOW).min(length - 1));
        (low..=high).map(|k| sums[i + k * step - place * step]).fold([0.0; 7], |a, b| added(a, &b))
    };
    (0..sums.len()).map(sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_halfway_lies_halfway_whatever_the_variances() {
        let class = |mean: [f32; 3], variance: [f32; 3]| Class { mean, variance };
        let (start, end) = (class([10.0, 0.0, 0.0], [4.0, 1.0, 9.0]), class([50.0, 20.0, -10.0], [0.0, 30.0, 1.0]));
        for weights in [[1.0; 3], [0.25, 1.0, 1.0], [1.0, 0.0, 0.0]] {
            assert!(between(start.mean, &start, &end, weights).abs() < 1e-6);
            assert!((between([30.0, 10.0, -5.0], &start, &end, weights) - 0.5).abs() < 1e-6);
            assert!((between(end.mean, &start, &end, weights) - 1.0).abs() < 1e-6);
        }
        assert_eq!(between([30.0, 10.0, -5.0], &start, &start, [1.0; 3]), 0.0);
    }

    #[test]
    fn a_class_has_the_mean_and_variance_of_its_pixels() {
        let cells: Vec<[f32; 3]> = (0..64 * 48).map(|i| [(i % 2) as f32 * 10.0, 5.0, -3.0]).collect();
        let lab = Grid { width: 64, height: 48, cells };
        let classes = Classes::of(&lab, &lab.map(|_| true), 8);
        let class = classes.at(33, 17);
        assert!((class.mean[0] - 5.0).abs() < 1e-4 && (class.variance[0] - 25.0).abs() < 1e-3);
        assert!((class.mean[2] + 3.0).abs() < 1e-5 && class.variance[1].abs() < 1e-4);
    }

    #[test]
    fn a_shadow_beside_the_leaf_goes_back_to_the_paper() {
        // leaf up to column 50, its shadow up to column 53: nearer to the paper, but beyond half of the mask's threshold
        let colour = |x: usize| match x {
            0..50 => [40.0, -20.0, 30.0],
            50..53 => [60.0, -6.0, 8.0],
            _ => [92.0, 1.0, 2.0],
        };
        let cells: Vec<[f32; 3]> = (0..100 * 60).map(|i| colour(i % 100)).collect();
        let lab = Grid { width: 100, height: 60, cells };
        let mask = Grid { width: 100, height: 60, cells: (0..6000).map(|i| i % 100 < 53).collect() };
        let level = mask.map(|c| if c { 1.0 } else { 0.0 });
        let mut contrast = Contrast { weights: [0.25, 1.0, 1.0], threshold: 10.0, level };
        refined(&lab, &mut contrast, &mask);
        assert_eq!(contrast.level.map(|t| t > 0.5).area(), 50 * 60);
    }
}
