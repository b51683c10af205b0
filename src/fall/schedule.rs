//! Which leaves may be laid at the same time.
//!
//! What a leaf finds depends only on the earlier leaves that reach its cells. The ground is cut into blocks, and leaves are
//! laid in phases: in each, regions of two by two blocks are worked in independently, every region in the leaves' order.
//! The regions of successive phases are shifted by a block along x, z or both, so that each leaf lies wholly within a region
//! of some of them. A leaf's phase is the first one that fits it and is not before that of any earlier leaf that it meets.
//! Any number of threads thus does the same, and a region's cells stay in the cache while hundreds of leaves are laid in it.

use super::columns::Extent;
use std::collections::HashMap;
use std::ops::{Range, RangeInclusive};

/// Parts of a block along its side, as a power of two, on which leaves are taken to meet.
pub(super) const PARTS_BITS: u32 = 4;
/// No block.
const NONE: u32 = u32::MAX;

/// Leaves of one region in one phase.
#[derive(Clone, Debug)]
pub(super) struct Task {
    phase: u32,
    /// Column and row of the region's first block.
    pub corner: [u32; 2],
    /// Numbers of its blocks, row by row.
    pub blocks: [u32; 4],
    leaves: Range<usize>,
}

/// Leaves in tasks, tasks in phases.
pub(super) struct Schedule {
    /// The parts that leaves reach into of each block.
    pub blocks: Vec<Extent>,
    tasks: Vec<Task>,
    leaves: Vec<u32>,
}

impl Schedule {
    /// A schedule of leaves with these numbers and extents, in their order; blocks have `2^bits` cells along a side, and no
    /// extent is longer than that.
    pub(super) fn new(leaves: impl Iterator<Item = (u32, Extent)>, bits: u32) -> Self {
        let mut blocks = Blocks::default();
        let mut placed: Vec<(u32, [u32; 2], u32)> = Vec::new();
        for (leaf, extent) in leaves {
            let parts = extent.coarser(bits - PARTS_BITS);
            blocks.reach(parts);
            let of = parts.coarser(PARTS_BITS);
            let phase = shifted(blocks.latest(parts), of);
            blocks.mark(parts, phase);
            placed.push((phase, corner(phase, of.low), leaf));
        }
        // stable: the leaves of a task stay in their order
        placed.sort_by_key(|&(phase, corner, _)| (phase, corner));
        let mut tasks: Vec<Task> = Vec::new();
        for (place, &(phase, corner, _)) in placed.iter().enumerate() {
            match tasks.last_mut() {
                Some(task) if (task.phase, task.corner) == (phase, corner) => task.leaves.end = place + 1,
                _ => tasks.push(Task { phase, corner, blocks: blocks.of(corner), leaves: place..place + 1 }),
            }
        }
        Self { blocks: blocks.reached, tasks, leaves: placed.iter().map(|(.., leaf)| *leaf).collect() }
    }

    /// The tasks of each phase.
    pub(super) fn phases(&self) -> impl Iterator<Item = &[Task]> {
        self.tasks.chunk_by(|a, b| a.phase == b.phase)
    }

    /// The leaves of a task, in their order.
    pub(super) fn leaves(&self, task: &Task) -> &[u32] {
        &self.leaves[task.leaves.clone()]
    }
}

/// By how many blocks the regions of a phase are shifted along x and z.
fn shift(phase: u32) -> [u32; 2] {
    [phase & 1, phase >> 1 & 1]
}

/// The first block of the region that a block lies in.
fn corner(phase: u32, block: [u32; 2]) -> [u32; 2] {
    let shift = shift(phase);
    [0, 1].map(|axis| ((block[axis] + shift[axis]) & !1).wrapping_sub(shift[axis]))
}

/// The first phase from `phase` in which a region holds these blocks.
fn shifted(phase: u32, blocks: Extent) -> u32 {
    let fits = |phase: &u32| corner(*phase, blocks.low) == corner(*phase, blocks.high);
    (phase..phase + 4).find(fits).unwrap_or(phase)
}

/// The blocks that parts lie in, with the rows and the columns of the parts in each.
pub(super) fn by_blocks(
    parts: Extent,
) -> impl Iterator<Item = ([u32; 2], RangeInclusive<usize>, RangeInclusive<usize>)> {
    const LAST: u32 = (1 << PARTS_BITS) - 1;
    let blocks = parts.coarser(PARTS_BITS);
    let range = move |axis: usize, block: u32| {
        let first = block << PARTS_BITS;
        let [from, to] = [parts.low[axis].max(first), parts.high[axis].min(first | LAST)];
        (from & LAST) as usize..=(to & LAST) as usize
    };
    (blocks.low[1]..=blocks.high[1])
        .flat_map(move |z| (blocks.low[0]..=blocks.high[0]).map(move |x| ([x, z], range(1, z), range(0, x))))
}

/// A block with the extent of rows and columns of its parts.
pub(super) fn reached(
    (block, rows, columns): ([u32; 2], RangeInclusive<usize>, RangeInclusive<usize>),
) -> ([u32; 2], Extent) {
    let at =
        |row: &usize, column: &usize| [block[0] << PARTS_BITS | *column as u32, block[1] << PARTS_BITS | *row as u32];
    (block, Extent { low: at(rows.start(), columns.start()), high: at(rows.end(), columns.end()) })
}

/// The latest phase that meets each part of the blocks.
#[derive(Default)]
struct Blocks {
    numbers: HashMap<[u32; 2], u32>,
    /// The parts of each block that leaves reach into, from the first to the last.
    reached: Vec<Extent>,
    phases: Vec<[u32; 1 << (2 * PARTS_BITS)]>,
}

impl Blocks {
    /// Makes the blocks of parts, and room in them.
    fn reach(&mut self, parts: Extent) {
        for (block, parts) in by_blocks(parts).map(reached) {
            let number = *self.numbers.entry(block).or_insert(self.phases.len() as u32) as usize;
            match self.reached.get_mut(number) {
                Some(reached) => *reached = reached.with(parts),
                None => {
                    self.reached.push(parts);
                    self.phases.push([0; 1 << (2 * PARTS_BITS)]);
                }
            }
        }
    }

    fn latest(&mut self, parts: Extent) -> u32 {
        let mut latest = 0;
        self.visit(parts, |phase| latest = latest.max(*phase));
        latest
    }

    fn mark(&mut self, parts: Extent, phase: u32) {
        self.visit(parts, |latest| *latest = phase);
    }

    fn visit(&mut self, parts: Extent, mut visit: impl FnMut(&mut u32)) {
        for (block, rows, columns) in by_blocks(parts) {
            let number = self.numbers.get(&block).map_or(usize::MAX, |number| *number as usize);
            let Some(phases) = self.phases.get_mut(number) else { continue };
            for row in rows {
                let [from, to] = [*columns.start(), *columns.end()].map(|column| row << PARTS_BITS | column);
                phases[from..=to].iter_mut().for_each(&mut visit);
            }
        }
    }

    /// The numbers of the blocks of a region.
    fn of(&self, corner: [u32; 2]) -> [u32; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, z]| {
            let at = [corner[0].wrapping_add(x), corner[1].wrapping_add(z)];
            self.numbers.get(&at).copied().unwrap_or(NONE)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Purpose, Stream};

    #[test]
    fn leaves_that_meet_are_laid_in_their_order_and_regions_of_a_phase_share_no_block() {
        let extents: Vec<Extent> = (0..3000)
            .map(|leaf| {
                let mut stream = Stream::new(1, Purpose::Litter, leaf, 0);
                let low = [0; 2].map(|_| 4096 + stream.range(0.0, 1500.0) as u32);
                let size = [0; 2].map(|_| stream.range(1.0, 100.0) as u32);
                Extent { low, high: [low[0] + size[0], low[1] + size[1]] }
            })
            .collect();
        let schedule = Schedule::new((0..).zip(extents.iter().copied()), 7);
        let mut at = vec![(0, 0); extents.len()];
        for (phase, tasks) in schedule.phases().enumerate() {
            let mut taken: Vec<u32> =
                tasks.iter().flat_map(|task| task.blocks).filter(|&block| block != NONE).collect();
            let count = taken.len();
            taken.sort_unstable();
            taken.dedup();
            assert_eq!(taken.len(), count);
            for task in tasks {
                for (rank, &leaf) in schedule.leaves(task).iter().enumerate() {
                    at[leaf as usize] = (phase, rank);
                    let blocks = extents[leaf as usize].coarser(7);
                    for axis in 0..2 {
                        assert!(blocks.low[axis] >= task.corner[axis] && blocks.high[axis] <= task.corner[axis] + 1);
                    }
                }
            }
        }
        let meet = |a: &Extent, b: &Extent| (0..2).all(|k| a.low[k] <= b.high[k] && b.low[k] <= a.high[k]);
        for (late, extent) in extents.iter().enumerate() {
            for early in (0..late).filter(|&early| meet(&extents[early], extent)) {
                assert!(at[early] < at[late], "{early} {late}");
            }
        }
        assert!(schedule.phases().count() > 4 && schedule.phases().next().unwrap().len() > 4);
    }
}
