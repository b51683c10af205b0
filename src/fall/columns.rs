//! A field over the ground in square cells, in square blocks of them that are made when something lies in them, no wider than
//! what lies in them.
//!
//! A `Region` is two by two blocks, taken out of the field and put back. Regions that share no block are worked in at the same
//! time.

use super::schedule::{PARTS_BITS, Schedule, Task, by_blocks, reached};
use crate::base::vector::DVec2;
use rayon::prelude::*;
use std::collections::HashMap;

/// Added to cells before they are rounded towards zero, so that they are rounded down: `floor` is slow on old processors.
const OFFSET: f64 = (1u32 << 29) as f64;

/// The cells that a leaf may reach, the last ones with them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    /// The first column and row.
    pub low: [u32; 2],
    /// The last column and row.
    pub high: [u32; 2],
}

impl Extent {
    /// The cells of a side within `reach` metres of a place.
    pub(super) fn new(place: DVec2, reach: f64, side: f64) -> Self {
        let cell = |metres: f64| (metres / side + OFFSET) as u32;
        let low = [cell(place.x - reach), cell(place.y - reach)];
        Self { low, high: [cell(place.x + reach).max(low[0]), cell(place.y + reach).max(low[1])] }
    }

    /// No more than `2^bits` cells along a side of it.
    pub(super) fn within(self, bits: u32) -> Self {
        let low = self.low.map(|cell| cell.min(1 << 30));
        Self { low, high: [0, 1].map(|axis| self.high[axis].clamp(low[axis], low[axis] + (1 << bits) - 1)) }
    }

    /// What holds this and another.
    pub(super) fn with(self, other: Self) -> Self {
        Self {
            low: [0, 1].map(|axis| self.low[axis].min(other.low[axis])),
            high: [0, 1].map(|axis| self.high[axis].max(other.high[axis])),
        }
    }

    /// The same in cells that are `2^bits` times as wide.
    pub(super) fn coarser(self, bits: u32) -> Self {
        Self { low: self.low.map(|cell| cell >> bits), high: self.high.map(|cell| cell >> bits) }
    }
}

/// A place in cells of a side, or in cells that are `2^bits` times as wide.
pub(super) fn in_cells(place: DVec2, side: f64, bits: u32) -> [f64; 2] {
    [place.x, place.y].map(|metres| (metres / side + OFFSET) / f64::from(1u32 << bits))
}

/// The cells about a leaf.
pub(super) struct Patch<'a> {
    pub values: &'a mut [u16],
    /// Cells from a row to the next.
    pub stride: usize,
    /// The first column and row.
    pub first: [u32; 2],
    /// The last column and row, from the first.
    pub last: [f32; 2],
}

impl Patch<'_> {
    /// A place given in cells, from the first cell.
    pub(super) fn offset(&self, [x, z]: [f64; 2]) -> [f32; 2] {
        [(x - f64::from(self.first[0])) as f32, (z - f64::from(self.first[1])) as f32]
    }

    /// The number of the cell in which a point lies, given in cells from the first along x and z.
    #[inline]
    pub(super) fn cell(&self, x: f32, z: f32) -> usize {
        (z.min(self.last[1]) as usize) * self.stride + (x.min(self.last[0]) as usize)
    }

    /// The value of a cell.
    #[inline]
    pub(super) fn value(&self, cell: usize) -> u16 {
        self.values.get(cell).copied().unwrap_or(0)
    }
}

/// Where the middle of a cell lies along an axis, metres, by the first one of its patch.
pub(super) fn middle(first: u32, cell: usize, side: f64) -> f64 {
    (f64::from(first) + cell as f64 + 0.5 - OFFSET) * side
}

/// The cells of a block.
#[derive(Default)]
struct Block<'a> {
    /// The first column and row.
    first: [u32; 2],
    /// Cells from a row to the next.
    stride: usize,
    /// The cells: what was there before, until they are worked in.
    values: &'a mut [u16],
    is_cleared: bool,
}

impl Block<'_> {
    /// The place of a cell.
    fn at(&self, column: u32, row: u32) -> usize {
        (row - self.first[1]) as usize * self.stride + (column - self.first[0]) as usize
    }

    /// Zeros in all cells at first: by the thread that works in them, whose cache then holds them.
    fn clear(&mut self) {
        if !self.is_cleared {
            self.values.fill(0);
            self.is_cleared = true;
        }
    }
}

/// The cells of one field after another: taken anew from the system each day, they cost a tenth of a film's laying.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells(Vec<u16>);

impl Cells {
    /// At least so many cells with any values.
    fn take(&mut self, count: usize) -> &mut [u16] {
        if self.0.len() < count {
            // the old ones go first, so that both are never held
            self.0 = Vec::new();
            self.0 = vec![0; count];
        }
        &mut self.0
    }
}

/// The field.
pub(super) struct Columns<'a> {
    /// Cells along a block's side, as a power of two.
    bits: u32,
    /// The blocks by their numbers in a schedule.
    blocks: Vec<Block<'a>>,
    /// What the blocks take, bytes.
    pub bytes: u64,
}

impl<'a> Columns<'a> {
    /// A field of zeros over the blocks of a schedule, each of `2^bits` cells along a side.
    pub(super) fn new(schedule: &Schedule, bits: u32, cells: &'a mut Cells) -> Self {
        let part = bits - PARTS_BITS;
        let size = |reached: &Extent| size(reached, part);
        let count: usize = schedule.blocks.iter().map(size).map(|(stride, rows)| stride * rows).sum();
        let mut rest = cells.take(count);
        let block = |reached: &Extent| {
            let (stride, rows) = size(reached);
            let (values, others) = std::mem::take(&mut rest).split_at_mut(stride * rows);
            rest = others;
            Block { first: reached.low.map(|cell| cell << part), stride, values, is_cleared: false }
        };
        Self { bits, blocks: schedule.blocks.iter().map(block).collect(), bytes: 2 * count as u64 }
    }

    /// Does work for every leaf of a schedule; what may touch the same cells is done one after another in the schedule's
    /// order, or backwards. `keep` gets the answers.
    pub(super) fn each<S: Default, T: Send>(
        &mut self,
        schedule: &Schedule,
        is_backwards: bool,
        work: impl Fn(&mut S, &mut Region<'a>, usize) -> T + Sync,
        mut keep: impl FnMut(usize, T),
    ) {
        let phases: Vec<&[Task]> = schedule.phases().collect();
        let count = phases.len();
        for number in 0..count {
            let tasks = phases[if is_backwards { count - 1 - number } else { number }];
            let mut regions: Vec<Region<'a>> = tasks.iter().map(|task| self.take(task)).collect();
            let one = |(task, region): (&Task, &mut Region<'a>)| {
                let mut state = S::default();
                let leaves = schedule.leaves(task);
                let mut answer = |&leaf: &u32| work(&mut state, region, leaf as usize);
                if is_backwards {
                    leaves.iter().rev().map(&mut answer).collect()
                } else {
                    leaves.iter().map(&mut answer).collect::<Vec<T>>()
                }
            };
            let answers: Vec<Vec<T>> = tasks.par_iter().zip(&mut regions).map(one).collect();
            for ((task, region), mut answers) in tasks.iter().zip(regions).zip(answers) {
                if is_backwards {
                    answers.reverse();
                }
                schedule.leaves(task).iter().zip(answers).for_each(|(&leaf, answer)| keep(leaf as usize, answer));
                self.put(task, region);
            }
        }
    }

    fn take(&mut self, task: &Task) -> Region<'a> {
        let block = |number: u32| self.blocks.get_mut(number as usize).map(std::mem::take).unwrap_or_default();
        Region { bits: self.bits, corner: task.corner, blocks: task.blocks.map(block) }
    }

    fn put(&mut self, task: &Task, region: Region<'a>) {
        for (number, block) in task.blocks.into_iter().zip(region.blocks) {
            if let Some(place) = self.blocks.get_mut(number as usize) {
                *place = block;
            }
        }
    }
}

/// Two by two blocks.
pub(super) struct Region<'a> {
    bits: u32,
    /// Column and row of the first block.
    corner: [u32; 2],
    blocks: [Block<'a>; 4],
}

impl<'a> Region<'a> {
    /// Works on the cells of an extent within the region: in place, or, where they lie in several blocks, on a copy that is
    /// written back.
    pub(super) fn open<R>(&mut self, extent: Extent, copy: &mut Vec<u16>, work: impl FnOnce(Patch<'_>) -> R) -> R {
        let blocks = extent.coarser(self.bits);
        let last = [0, 1].map(|axis| (extent.high[axis] - extent.low[axis]) as f32);
        if blocks.low == blocks.high {
            let block = self.block(blocks.low);
            let start = block.at(extent.low[0], extent.low[1]);
            let stride = block.stride;
            return work(Patch { values: &mut block.values[start..], stride, first: extent.low, last });
        }
        copy.clear();
        self.rows(extent, |part| copy.extend_from_slice(part));
        let width = (extent.high[0] - extent.low[0]) as usize + 1;
        let answer = work(Patch { values: copy, stride: width, first: extent.low, last });
        let mut rest = copy.as_slice();
        self.rows(extent, |part| {
            let (these, others) = rest.split_at(part.len());
            part.copy_from_slice(these);
            rest = others;
        });
        answer
    }

    /// Visits the cells of an extent row by row, in parts that lie in one block.
    fn rows(&mut self, extent: Extent, mut visit: impl FnMut(&mut [u16])) {
        let (bits, mask) = (self.bits, (1u32 << self.bits) - 1);
        for row in extent.low[1]..=extent.high[1] {
            let mut column = extent.low[0];
            while column <= extent.high[0] {
                let end = (column | mask).min(extent.high[0]);
                let block = self.block([column >> bits, row >> bits]);
                let start = block.at(column, row);
                visit(&mut block.values[start..start + (end - column) as usize + 1]);
                column = end + 1;
            }
        }
    }

    fn block(&mut self, at: [u32; 2]) -> &mut Block<'a> {
        let [x, z] = [0, 1].map(|axis| at[axis].wrapping_sub(self.corner[axis]) as usize & 1);
        let block = &mut self.blocks[2 * z + x];
        block.clear();
        block
    }
}

/// Cells from a row to the next and rows of a block in which parts of `2^part` cells along a side are reached.
fn size(reached: &Extent, part: u32) -> (usize, usize) {
    let [width, rows] = [0, 1].map(|axis| ((reached.high[axis] - reached.low[axis] + 1) as usize) << part);
    (stride(width), rows)
}

/// What a field over leaves with these extents takes, bytes; blocks have `2^bits` cells along a side.
pub(super) fn field_bytes(extents: impl Iterator<Item = Extent>, bits: u32) -> usize {
    let part = bits - PARTS_BITS;
    let mut blocks: HashMap<[u32; 2], Extent> = HashMap::new();
    for (block, parts) in extents.flat_map(|extent| by_blocks(extent.coarser(part))).map(reached) {
        blocks.entry(block).and_modify(|known| *known = known.with(parts)).or_insert(parts);
    }
    blocks.values().map(|reached| size(reached, part)).map(|(stride, rows)| 2 * stride * rows).sum()
}

/// What a block of `2^bits` cells along its side takes at most, bytes.
pub(super) fn block_bytes(bits: u32) -> usize {
    (2 * stride(1 << bits)) << bits
}

/// Cells from a row of a block to the next: not a power of two, at which all rows would share a few lines of a cache.
fn stride(width: usize) -> usize {
    width + (width >> 3)
}
