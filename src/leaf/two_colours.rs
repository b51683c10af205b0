//! The margin of a leaf, found anew between the colours of the leaf and of the background as they are on the spot: one
//! threshold for a whole picture lies too near the paper where there is a shadow, and too near the leaf where it is pale.

use crate::leaf::contrast::Contrast;
use crate::leaf::grid::Grid;

/// Share of the picture's longer side that the margin may move.
const REACH: f64 = 0.004;
/// Blocks on the longer side over which colours are gathered, and how many on each side of a block its means take in.
const BLOCKS: usize = 200;
const WINDOW: usize = 4;
/// The whole picture's mean counts as much as this share of a block, for where a window has little of a class.
const PRIOR: f64 = 0.25;

/// The mask with every pixel near its margin given to the nearer of the two colours, and the level of those pixels: their
/// place on the way from the background's colour (0) to the leaf's (1).
pub fn refined(lab: &Grid<[f32; 3]>, contrast: &mut Contrast, mask: &Grid<bool>) {
    let side = lab.width.max(lab.height);
    let reach = (REACH * side as f64).max(3.0);
    let inner = mask.eroded(reach);
    let near = mask.dilated(reach);
    let block = (side / BLOCKS).max(4);
    let weights = contrast.weights;
    let leaf = Means::of(lab, &inner, block);
    let paper = Means::of(lab, &mask.dilated(1.5 * reach).map(|c| !c), block);
    let level = &mut contrast.level;
    for (i, cell) in lab.cells.iter().enumerate().filter(|(i, _)| near.cells[*i] && !inner.cells[*i]) {
        let (x, y) = (i % lab.width, i / lab.width);
        let (there, here) = (leaf.at(x, y), paper.at(x, y));
        level.cells[i] = between(*cell, here, there, weights);
    }
}

/// The place of a colour's projection on the way from `start` to `end`, in the weighted space.
fn between(colour: [f32; 3], start: [f32; 3], end: [f32; 3], weights: [f32; 3]) -> f32 {
    let [way, from] = [end, colour].map(|c| [0, 1, 2].map(|i| weights[i] * (c[i] - start[i])));
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    dot(from, way) / dot(way, way).max(1e-6)
}

/// Mean colours of a class round every block.
struct Means {
    block: usize,
    columns: usize,
    cells: Vec<[f32; 3]>,
}

impl Means {
    fn of(lab: &Grid<[f32; 3]>, class: &Grid<bool>, block: usize) -> Self {
        let (columns, rows) = (lab.width.div_ceil(block), lab.height.div_ceil(block));
        // sums of L, a, b and the count
        let mut sums = vec![[0.0f64; 4]; columns * rows];
        for (y, row) in lab.cells.chunks_exact(lab.width).enumerate() {
            let start = y / block * columns;
            for (x, cell) in row.iter().enumerate().filter(|(x, _)| class.at(*x, y)) {
                let sum = &mut sums[start + x / block];
                (0..3).for_each(|c| sum[c] += f64::from(cell[c]));
                sum[3] += 1.0;
            }
        }
        let all = sums.iter().fold([0.0; 4], added);
        let weight = PRIOR * (block * block) as f64;
        let prior = all.map(|sum| sum * weight / all[3].max(1.0));
        let along = windowed(&sums, 1, columns, columns);
        let round = windowed(&along, columns, rows, columns);
        let mean = |sum: &[f64; 4]| {
            let [l, a, b, count] = added(*sum, &prior);
            [l, a, b].map(|c| (c / count.max(1e-9)) as f32)
        };
        Self { block, columns, cells: round.iter().map(mean).collect() }
    }

    /// The mean round the block of a pixel.
    fn at(&self, x: usize, y: usize) -> [f32; 3] {
        self.cells[y / self.block * self.columns + x / self.block]
    }
}

fn added(a: [f64; 4], b: &[f64; 4]) -> [f64; 4] {
    [0, 1, 2, 3].map(|i| a[i] + b[i])
}

/// Sums over a window along one axis, whose neighbours lie `step` cells apart and which has `length` of them.
fn windowed(sums: &[[f64; 4]], step: usize, length: usize, columns: usize) -> Vec<[f64; 4]> {
    let sum = |i: usize| {
        let place = if step == 1 { i % columns } else { i / columns };
        let (low, high) = (place.saturating_sub(WINDOW), (place + WINDOW).min(length - 1));
        (low..=high).map(|k| sums[i + k * step - place * step]).fold([0.0; 4], |a, b| added(a, &b))
    };
    (0..sums.len()).map(sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_projection_lies_between_its_ends() {
        let (start, end) = ([10.0, 0.0, 0.0], [50.0, 20.0, -10.0]);
        let middle = [30.0, 10.0, -5.0];
        for weights in [[1.0; 3], [0.25, 1.0, 1.0], [0.0, 1.0, 1.0]] {
            assert!(between(start, start, end, weights).abs() < 1e-6);
            assert!((between(middle, start, end, weights) - 0.5).abs() < 1e-6);
            assert!((between(end, start, end, weights) - 1.0).abs() < 1e-6);
        }
        assert_eq!(between(middle, start, start, [1.0; 3]), 0.0);
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
        let mut contrast = Contrast { weights: [0.25, 1.0, 1.0], level };
        refined(&lab, &mut contrast, &mask);
        assert_eq!(contrast.level.map(|t| t > 0.5).area(), 50 * 60);
    }
}
