//! What has changed in the litter since it was laid before.
//!
//! How a leaf lies depends on itself and on the earlier leaves that reach its cells. It lies as before if it is as before
//! and no leaf that is new, gone, changed or laid anew lies within its reach among the earlier ones; whether others hide it,
//! if there is none among all. Reaches are squares of cells, rounded outwards to parts of blocks: what is kept is surely the
//! same, not all that is laid anew would have differed.

use super::columns::Extent;
use super::litter::Kept;
use super::schedule::{PARTS_BITS, by_blocks};
use std::cmp::Ordering;
use std::collections::HashMap;
use std::ops::RangeInclusive;

/// What to do again.
pub(super) struct Changes {
    /// The place of each leaf among those before, of leaves that lie as they lay.
    pub before: Vec<Option<usize>>,
    /// Where anything has changed.
    changed: Marks,
    /// Where what lies has to be known.
    needed: Marks,
}

impl Changes {
    /// Compares two lists in the order of landings; `2^bits` cells are along the side of a block.
    pub(super) fn new(before: &[Kept], now: &[Kept], bits: u32) -> Self {
        let mut changed = Marks::new(bits);
        let mut kept = Vec::with_capacity(now.len());
        let mut old = before.iter().enumerate().peekable();
        for leaf in now {
            while let Some((_, gone)) = old.next_if(|(_, one)| landing(one, leaf).is_lt()) {
                changed.mark(gone.extent);
            }
            let same = old.next_if(|(_, one)| landing(one, leaf).is_eq());
            let is_same = |one: &Kept| one.landed == leaf.landed && one.form == leaf.form && one.extent == leaf.extent;
            let same = same.inspect(|(_, one)| {
                if !is_same(one) {
                    changed.mark(one.extent);
                }
            });
            let same = same.filter(|(_, one)| is_same(one) && !changed.meets(leaf.extent));
            if same.is_none() {
                changed.mark(leaf.extent);
            }
            kept.push(same.map(|(place, _)| place));
        }
        old.for_each(|(_, gone)| changed.mark(gone.extent));
        let mut needed = Marks::new(bits);
        now.iter().filter(|leaf| changed.meets(leaf.extent)).for_each(|leaf| needed.mark(leaf.extent));
        Self { before: kept, changed, needed }
    }

    /// Whether others may hide more or less of a leaf than before.
    pub(super) fn is_seen_anew(&self, rank: usize, leaves: &[Kept]) -> bool {
        self.changed.meets(leaves[rank].extent)
    }

    /// Whether a leaf lies where what lies has to be known.
    pub(super) fn is_needed(&self, rank: usize, leaves: &[Kept]) -> bool {
        self.needed.meets(leaves[rank].extent)
    }
}

fn landing(one: &Kept, other: &Kept) -> Ordering {
    one.landed.day.total_cmp(&other.landed.day).then(one.landed.leaf.cmp(&other.landed.leaf))
}

/// A set of parts of blocks: a bit for each.
struct Marks {
    bits: u32,
    blocks: HashMap<[u32; 2], [u16; 1 << PARTS_BITS]>,
}

impl Marks {
    fn new(bits: u32) -> Self {
        Self { bits: bits - PARTS_BITS, blocks: HashMap::new() }
    }

    fn mark(&mut self, extent: Extent) {
        for (block, rows, columns) in by_blocks(extent.coarser(self.bits)) {
            let marks = self.blocks.entry(block).or_default();
            let columns = mask(columns);
            rows.for_each(|row| marks[row] |= columns);
        }
    }

    fn meets(&self, extent: Extent) -> bool {
        let mut parts = by_blocks(extent.coarser(self.bits));
        !self.blocks.is_empty()
            && parts.any(|(block, mut rows, columns)| {
                let columns = mask(columns);
                self.blocks.get(&block).is_some_and(|marks| rows.any(|row| marks[row] & columns != 0))
            })
    }
}

/// The bits of columns.
fn mask(columns: RangeInclusive<usize>) -> u16 {
    columns.fold(0, |bits, column| bits | 1u16 << column)
}
