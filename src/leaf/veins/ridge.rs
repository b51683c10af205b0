//! How much every place of a scan looks like a vein: lightness and redness against their surroundings, and second derivatives
//! across lines at several widths (Sato et al. 1998, "Three-dimensional multi-scale line filter"; the difference of both
//! curvatures, after Frangi et al. 1998, keeps spots from passing for lines).

use super::sheet::Sheet;
use crate::leaf::field::{blurred, quantile, widely_blurred};
use crate::leaf::grid::Grid;

/// Standard deviations of the filters, shares of the blade's size.
const WIDTHS: [f64; 3] = [0.0025, 0.004, 0.006];
/// Deviation of the local mean, share of the size; that of the local contrast is twice as wide.
const SURROUNDINGS: f64 = 0.03;
/// How much of the curvature along a line counts against it.
const BLOB: f32 = 0.5;

/// Which veins are sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polarity {
    /// Veins lighter (or redder) than the blade.
    Bright,
    /// Veins darker than the blade.
    Dark,
}

/// The tone of a sheet less its local mean, divided by its local contrast; 0 off the leaf. Borders are handled by normalised
/// convolution (Knutsson and Westin 1993): means are taken over the leaf alone.
pub fn flattened(sheet: &Sheet) -> Grid<f32> {
    let weight = sheet.sure.map(|c| f32::from(u8::from(c)));
    let deviation = SURROUNDINGS * sheet.size;
    let near = widely_blurred(&weight, deviation);
    let mean = widely_blurred(&product(&sheet.tone, &weight), deviation);
    let mut level = Grid { cells: vec![0.0f32; weight.cells.len()], ..weight };
    for i in 0..level.cells.len() {
        level.cells[i] = (sheet.tone.cells[i] - mean.cells[i] / near.cells[i].max(1e-3)) * weight.cells[i];
    }
    let far = widely_blurred(&weight, 2.0 * deviation);
    let square = widely_blurred(&product(&level, &level), 2.0 * deviation);
    for i in 0..level.cells.len() {
        let contrast = (square.cells[i].max(0.0) / far.cells[i].max(1e-3)).sqrt();
        level.cells[i] /= contrast.max(LEAST_CONTRAST);
    }
    level
}

/// Contrast (standard deviation of the tone, about Lab units) below which nothing is amplified: the noise of an 8-bit scan.
const LEAST_CONTRAST: f32 = 0.4;

fn product(a: &Grid<f32>, b: &Grid<f32>) -> Grid<f32> {
    Grid { cells: a.cells.iter().zip(&b.cells).map(|(a, b)| a * b).collect(), ..*a }
}

/// Ridge strength of bright and of dark lines, at least 0; 0 near the margin, where the blade's edge would pass for one.
pub fn ridges(sheet: &Sheet, level: &Grid<f32>) -> [Grid<f32>; 2] {
    let weight = sheet.sure.map(|c| f32::from(u8::from(c)));
    let mut strengths = [0, 1].map(|_| Grid { cells: vec![0.0f32; level.cells.len()], ..*level });
    for share in WIDTHS {
        // Half a cell is the narrowest kernel that a grid can hold.
        let deviation = (share * sheet.size).max(0.5);
        let smooth = normalised(&blurred(level, deviation), &blurred(&weight, deviation));
        gather(&smooth, sheet, (deviation * deviation) as f32, &mut strengths);
    }
    strengths
}

fn normalised(sum: &Grid<f32>, weight: &Grid<f32>) -> Grid<f32> {
    Grid { cells: sum.cells.iter().zip(&weight.cells).map(|(s, w)| s / w.max(0.05)).collect(), ..*sum }
}

/// Raises the strengths to those of one width.
fn gather(smooth: &Grid<f32>, sheet: &Sheet, variance: f32, strengths: &mut [Grid<f32>; 2]) {
    let (width, height) = (smooth.width, smooth.height);
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            let cell = y * width + x;
            if sheet.inner.cells[cell] {
                let [low, high] = curvatures(&smooth.cells, cell, width);
                let bright = (-low - BLOB * high.abs()) * variance;
                let dark = (high - BLOB * low.abs()) * variance;
                strengths[0].cells[cell] = strengths[0].cells[cell].max(bright);
                strengths[1].cells[cell] = strengths[1].cells[cell].max(dark);
            }
        }
    }
}

/// The eigenvalues of the Hessian by central differences, smaller first.
fn curvatures(values: &[f32], cell: usize, width: usize) -> [f32; 2] {
    let at = |i: usize| values[i];
    let (up, down) = (cell - width, cell + width);
    let xx = at(cell - 1) - 2.0 * at(cell) + at(cell + 1);
    let yy = at(up) - 2.0 * at(cell) + at(down);
    let xy = 0.25 * (at(up - 1) - at(up + 1) - at(down - 1) + at(down + 1));
    let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let root = (half * half + xy * xy).sqrt();
    [middle - root, middle + root]
}

/// The strength that a share of the blade exceeds.
pub fn exceeded_by(strength: &Grid<f32>, sheet: &Sheet, share: f64) -> f32 {
    let within = strength.cells.iter().zip(&sheet.inside.cells).filter(|(_, inside)| **inside);
    quantile(within.map(|(s, _)| *s).collect(), 1.0 - share)
}
