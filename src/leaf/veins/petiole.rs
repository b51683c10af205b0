//! A petiole folded over the blade: brighter than the blade, as a vein is, but broader than any and without a taper.

use super::sheet::Sheet;
use crate::base::vector::DVec2;
use crate::leaf::grid::{Grid, Parts};
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
    let parts = Parts::of(&broad);
    let mut extents = vec![(f64::INFINITY, 0.0f64); parts.areas.len()];
    for (i, part) in parts.cells() {
        let distance = (middle_of(broad.width, i) - joint).norm();
        let (near, far) = &mut extents[part as usize];
        (*near, *far) = (near.min(distance), far.max(distance));
    }
    let is_petiole = |part: u32| {
        let (area, (near, far)) = (parts.areas[part as usize], extents[part as usize]);
        let length = far - near;
        near < NEAR * length && length > LENGTH * sheet.size && (area as f64) < BROADEST * sheet.size * length
    };
    parts.only(is_petiole).dilated(radius)
}
