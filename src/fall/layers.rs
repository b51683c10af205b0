//! How many leaves lie over a leaf.
//!
//! Counted from the latest landing back to the first on a coarse lattice: what lies over a leaf is what landed on its place
//! after it. No heights are needed, so it is known before any leaf is laid.

use super::columns::{Cells, Columns, Extent, Patch, in_cells};
use super::litter::Landed;
use super::schedule::Schedule;
use super::shape::Shape;

/// How much wider the cells of this lattice are than those in which leaves are laid, as a power of two.
pub(super) const WIDER: u32 = 2;
/// Tells cells in which a leaf has been counted.
const COUNTED: u16 = 1 << 15;

/// Leaves over a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Over {
    /// Where there are fewest.
    pub least: u16,
    /// In the mean.
    pub mean: f32,
}

/// What lies over each leaf of a schedule, told to `keep`; `extents` and `schedule` are in cells of `side` metres, `2^bits` along
/// a block's side. The bytes of the lattice.
pub(super) fn over(
    shapes: &[&Shape],
    landed: &[Landed],
    (schedule, extents): (&Schedule, &[Extent]),
    (side, bits): (f64, u32),
    field: &mut Cells,
    keep: impl FnMut(usize, Over),
) -> u64 {
    let work = |(copy, cells): &mut (Vec<u16>, Vec<u32>), region: &mut super::columns::Region<'_>, number: usize| {
        let leaf = &landed[number];
        let Some(shape) = shapes.get(leaf.shape as usize) else { return Over::default() };
        region.open(extents[number].coarser(WIDER), copy, |mut patch| {
            cells_below(shape, leaf, side, &patch, cells);
            counted(&mut patch, cells)
        })
    };
    let mut columns = Columns::new(schedule, bits - WIDER, field);
    columns.each(schedule, true, work, keep);
    columns.bytes
}

/// The cells below a leaf, some of them more than once.
fn cells_below(shape: &Shape, leaf: &Landed, side: f64, patch: &Patch<'_>, cells: &mut Vec<u32>) {
    let [middle_x, middle_z] = patch.offset(in_cells(leaf.place, side, WIDER));
    let (sine, cosine) = crate::base::maths::sincos(leaf.yaw);
    let unit = leaf.scale / (side * f64::from(1 << WIDER));
    let (sine, cosine) = ((sine * unit) as f32, (cosine * unit) as f32);
    cells.clear();
    cells.extend(shape.rest(leaf.side).samples.iter().map(|sample| {
        let [x, z] = sample.place;
        patch.cell(middle_x + x * cosine + z * sine, middle_z + z * cosine - x * sine) as u32
    }));
}

/// How many leaves have been counted in these cells, to which one is added.
fn counted(patch: &mut Patch<'_>, cells: &[u32]) -> Over {
    let (mut least, mut sum, mut count) = (u16::MAX, 0u32, 0u32);
    for &cell in cells {
        if let Some(value) = patch.values.get_mut(cell as usize).filter(|value| **value & COUNTED == 0) {
            (least, sum, count) = (least.min(*value), sum + u32::from(*value), count + 1);
            *value |= COUNTED;
        }
    }
    for &cell in cells {
        if let Some(value) = patch.values.get_mut(cell as usize).filter(|value| **value & COUNTED != 0) {
            *value = ((*value & !COUNTED) + 1).min(COUNTED - 1);
        }
    }
    Over { least: if count == 0 { 0 } else { least }, mean: sum as f32 / count.max(1) as f32 }
}
