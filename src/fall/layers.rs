//! How many leaves lie over a leaf.
//!
//! Counted from the latest landing back to the first on a coarse lattice: what lies over a leaf is what landed on its place
//! after it. No heights are needed, so it is known before any leaf is laid.

use super::columns::{Columns, Patch};
use super::litter::Landed;
use super::shape::Shape;

/// Side of a cell, metres.
const CELL: f64 = 0.01;
/// Metres about a place that a leaf may reach.
const MARGIN: f64 = 0.5;

/// Leaves over a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Over {
    /// Where there are fewest.
    pub least: u16,
    /// In the mean.
    pub mean: f32,
}

/// What lies over each leaf; `order` is that of the landings.
pub(super) fn over(shapes: &[&Shape], landed: &[Landed], order: &[usize]) -> Vec<Over> {
    let mut columns = Columns::new(CELL, landed.iter().map(|leaf| leaf.place), MARGIN);
    let mut found = vec![Over::default(); landed.len()];
    let mut patch = Patch::default();
    let mut cells = Vec::new();
    for &place in order.iter().rev() {
        let leaf = &landed[place];
        let Some(shape) = shapes.get(leaf.shape as usize) else { continue };
        let rest = shape.rest(leaf.side);
        columns.lift(leaf.place, rest.reach * leaf.scale, &mut patch);
        let (sine, cosine) = crate::base::maths::sincos(leaf.yaw);
        let (sine, cosine) = ((sine * leaf.scale / CELL) as f32, (cosine * leaf.scale / CELL) as f32);
        cells.clear();
        cells.extend(rest.samples.iter().map(|sample| {
            let [x, z] = sample.place;
            patch.cell(patch.middle[0] + x * cosine + z * sine, patch.middle[1] + z * cosine - x * sine)
        }));
        cells.sort_unstable();
        cells.dedup();
        let counts = || cells.iter().map(|&cell| patch.values[cell]);
        let sum: f32 = counts().map(f32::from).sum();
        found[place] = Over { least: counts().min().unwrap_or(0), mean: sum / cells.len().max(1) as f32 };
        for &cell in &cells {
            patch.values[cell] = patch.values[cell].saturating_add(1);
        }
        columns.lower(&patch);
    }
    found
}
