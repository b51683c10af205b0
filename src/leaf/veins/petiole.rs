//! A petiole folded over the blade: brighter than the blade, as a vein is, but broader than any and without a taper.

use super::sheet::Sheet;
use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;
use crate::leaf::raster::middle_of;

/// Tone, in local contrasts, above which a cell may be of a petiole.
const BRIGHT: f32 = 0.6;
/// Half the width of the slenderest petiole that is told from a vein, share of the size.
const HALF_WIDTH: f64 = 0.009;
/// Length from the joint outwards of the shortest petiole told, share of the size.
const LENGTH: f64 = 0.18;
/// How near to the joint it begins, share of its length.
const NEAR: f64 = 0.6;
/// Broadest mean width, share of the size: broader ones are blotches.
const BROADEST: f64 = 0.035;

/// The cells over which the petiole lies, with a rim of its half width; `level` is the flattened tone, `joint` a place in cells.
pub fn folded(sheet: &Sheet, level: &Grid<f32>, joint: DVec2) -> Grid<bool> {
    let radius = (HALF_WIDTH * sheet.size).max(1.0);
    // A petiole may be nearer to the background's colour than to the leaf's, and count as hidden in parts.
    let odd = |i: usize| level.cells[i] > BRIGHT || (sheet.inside.cells[i] && !sheet.sure.cells[i]);
    let cells = (0..level.cells.len()).map(odd).collect();
    let broad = Grid { cells, width: level.width, height: level.height }.opened(radius);
    let (labels, count) = broad.parts();
    let mut extents = vec![(0usize, f64::INFINITY, 0.0f64); count as usize + 1];
    for (i, &label) in labels.cells.iter().enumerate().filter(|(_, label)| **label > 0) {
        let distance = (middle_of(labels.width, i) - joint).norm();
        let (area, near, far) = &mut extents[label as usize];
        (*area, *near, *far) = (*area + 1, near.min(distance), far.max(distance));
    }
    let is_petiole = |&(area, near, far): &(usize, f64, f64)| {
        let length = far - near;
        near < NEAR * length && length > LENGTH * sheet.size && (area as f64) < BROADEST * sheet.size * length
    };
    let strip = labels.map(|label| label > 0 && is_petiole(&extents[label as usize]));
    strip.squared_distances().map(|d| d <= radius * radius)
}
