//! Ground in windows, so that the field of heights takes no more than a fixed memory however far leaves are scattered.
//!
//! A field over all of the litter would take memory by the area. Where that is too much, the leaves are laid window by window:
//! those of a window, those that may lie on them or hide them, and all on which these may rest. What a leaf rests on lies near
//! it: each link of such a chain is an earlier landing within reach, and the chain ends at leaves of which it is known how they
//! lie, from a window before. Every leaf finds in its window all that it would find in the whole field, hence lies the same;
//! leaves that reach into several windows are told of in their own.

use super::columns::{Extent, block_bytes, field_bytes};
use std::collections::{BTreeMap, HashMap};

/// Bytes of a field that is not cut.
pub(super) const MOST_BYTES: usize = 160 << 20;
/// Blocks along a window's side, as a power of two.
const SIDE_BITS: u32 = 3;
/// Leaves are looked for in squares of blocks over this power of two.
const PARTS_BITS: u32 = 2;
/// Extents meet where they share a cell of the coarser lattice in which leaves are counted, of this power of two of cells.
const COARSER: u32 = super::layers::WIDER;

/// What a leaf takes of a field at most, bytes: where two or three lie far apart in a block (measured: 92 kB; alone 20 to 40).
const LONE_BYTES: f64 = 1.2e5;

/// The most that the field of heights takes under so many leaves, bytes: they lie far apart, until the field is cut.
#[must_use]
pub fn most_field_bytes(leaves: f64) -> f64 {
    (leaves * LONE_BYTES).min(MOST_BYTES as f64)
}

/// Which other leaves a window has to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reason {
    /// Those that land on its leaves later are counted.
    Counted,
    /// Its leaves are laid: on earlier ones, which lie on earlier ones unless they are known; and later ones may hide them.
    Laid,
}

/// The leaves of one field.
pub(super) struct Window {
    /// All of them, by rank.
    pub leaves: Vec<u32>,
    /// Those that are told of.
    pub own: Vec<u32>,
}

impl Window {
    /// Whether a leaf is told of here.
    pub(super) fn owns(&self, rank: usize) -> bool {
        self.own.binary_search(&(rank as u32)).is_ok()
    }
}

/// Windows over leaves in the order of their landings.
pub(super) struct Windows<'a> {
    extents: &'a [Extent],
    /// Cells along a square's side, in which leaves are looked for, as a power of two.
    bits: u32,
    /// Leaves that reach into each square, by rank.
    squares: HashMap<[u32; 2], Vec<u32>>,
    /// The leaves of each window.
    own: Vec<Vec<u32>>,
}

impl<'a> Windows<'a> {
    /// Windows over the leaves of these ranks (ascending), whose `extents` are in cells, `2^bits` along a block's side; a field
    /// takes at most `most_bytes` uncut.
    pub(super) fn new(extents: &'a [Extent], leaves: &[u32], bits: u32, most_bytes: usize) -> Self {
        let mut windows = Self { extents, bits: bits - PARTS_BITS, squares: HashMap::new(), own: Vec::new() };
        let of = |rank: u32| extents[rank as usize];
        if field_bytes(leaves.iter().map(|&rank| of(rank)), bits) <= most_bytes {
            windows.own.push(leaves.to_vec());
            return windows;
        }
        // windows of the same memory as a field that is not cut, with room for as many blocks about them
        let most = most_bytes / block_bytes(bits);
        let side_bits = bits + SIDE_BITS.min((most / 4).max(1).ilog2() / 2);
        let mut own: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for &rank in leaves {
            own.entry(of(rank).low.map(|cell| cell >> side_bits)).or_default().push(rank);
            for square in cells(of(rank).coarser(windows.bits)) {
                windows.squares.entry(square).or_default().push(rank);
            }
        }
        windows.own = own.into_values().collect();
        windows
    }

    /// The windows one after another; `known` are the leaves of which it is known how they lie. Those of a window are, after it.
    pub(super) fn each(mut self, reason: Reason, mut known: Vec<bool>, mut work: impl FnMut(&Window, &[bool])) {
        let mut stamps = vec![0u32; if self.squares.is_empty() { 0 } else { self.extents.len() }];
        for (number, own) in (1..).zip(std::mem::take(&mut self.own)) {
            let leaves =
                if stamps.is_empty() { own.clone() } else { self.held(&own, reason, &known, (number, &mut stamps)) };
            let window = Window { leaves, own };
            work(&window, &known);
            if reason == Reason::Laid {
                window.leaves.iter().for_each(|&rank| known[rank as usize] = true);
            }
        }
    }

    /// All leaves that a window holds; those that carry its number are.
    fn held(&self, own: &[u32], reason: Reason, known: &[bool], (number, stamps): (u32, &mut [u32])) -> Vec<u32> {
        let mut held = own.to_vec();
        own.iter().for_each(|&rank| stamps[rank as usize] = number);
        let mut next = 0;
        while let Some(&rank) = held.get(next) {
            let is_own = next < own.len();
            next += 1;
            if !is_own && (reason == Reason::Counted || known[rank as usize]) {
                continue;
            }
            let is_held = |other: u32| match reason {
                Reason::Counted => other > rank,
                Reason::Laid => is_own || other < rank,
            };
            let extent = self.extents[rank as usize];
            for other in self.near(extent) {
                // the test of places last: most are held already
                let is_new = stamps[other as usize] != number && is_held(other);
                if is_new && meet(extent, self.extents[other as usize]) {
                    stamps[other as usize] = number;
                    held.push(other);
                }
            }
        }
        held.sort_unstable();
        held
    }

    /// The leaves that reach into the squares of an extent; some more than once.
    fn near(&self, extent: Extent) -> impl Iterator<Item = u32> {
        let squares = cells(extent.coarser(self.bits)).filter_map(|square| self.squares.get(&square));
        squares.flatten().copied()
    }
}

/// Whether two extents share a coarser cell.
fn meet(one: Extent, other: Extent) -> bool {
    let (one, other) = (one.coarser(COARSER), other.coarser(COARSER));
    (0..2).all(|axis| one.low[axis] <= other.high[axis] && other.low[axis] <= one.high[axis])
}

/// The cells of an extent, row by row.
fn cells(extent: Extent) -> impl Iterator<Item = [u32; 2]> {
    (extent.low[1]..=extent.high[1]).flat_map(move |z| (extent.low[0]..=extent.high[0]).map(move |x| [x, z]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Purpose, Stream};

    /// Extents of a few dozen cells over a square of so many.
    fn extents(count: u64, across: f64) -> Vec<Extent> {
        let extent = |leaf: u64| {
            let mut stream = Stream::new(3, Purpose::Litter, leaf, 0);
            let low = [0; 2].map(|_| 65_536 + stream.range(0.0, across) as u32);
            let size = [0; 2].map(|_| stream.range(10.0, 90.0) as u32);
            Extent { low, high: [low[0] + size[0], low[1] + size[1]] }
        };
        (0..count).map(extent).collect()
    }

    #[test]
    fn every_leaf_is_of_one_window_which_holds_all_that_it_depends_on() {
        let extents = extents(1500, 4000.0);
        let all: Vec<u32> = (0..1500).collect();
        let known: Vec<bool> = all.iter().map(|rank| rank % 7 == 0).collect();
        for reason in [Reason::Counted, Reason::Laid] {
            let (mut told, mut laid, mut windows, mut most) = (Vec::new(), 0, 0, 0);
            Windows::new(&extents, &all, 7, 64 * block_bytes(7)).each(reason, known.clone(), |window, known| {
                told.extend(window.own.clone());
                (windows, most) = (windows + 1, most.max(window.leaves.len()));
                assert!(window.leaves.is_sorted() && window.own.iter().all(|own| window.leaves.contains(own)));
                let holds = |rank: u32| window.leaves.binary_search(&rank).is_ok();
                for &rank in &window.leaves {
                    let (is_own, is_new) = (window.owns(rank as usize), !known[rank as usize]);
                    laid += u32::from(is_new);
                    for &other in all.iter().filter(|&&other| meet(extents[other as usize], extents[rank as usize])) {
                        let is_needed = match reason {
                            Reason::Counted => is_own && other > rank,
                            Reason::Laid => is_own || (is_new && other < rank),
                        };
                        assert!(!is_needed || holds(other), "{rank} {other}");
                    }
                }
            });
            told.sort_unstable();
            assert!(told == all && windows > 9 && most < 500, "{windows} {most}");
            let unknown = known.iter().filter(|is_known| !*is_known).count() as u32;
            assert!(reason == Reason::Counted || laid == unknown, "each is laid once: {laid} {unknown}");
        }
    }

    #[test]
    fn a_small_field_is_not_cut() {
        let extents = extents(300, 500.0);
        let all: Vec<u32> = (0..300).collect();
        let mut count = 0;
        Windows::new(&extents, &all, 7, 64 * block_bytes(7)).each(Reason::Laid, vec![false; 300], |window, _| {
            count += 1;
            assert!(window.leaves == all && window.own == all);
        });
        assert_eq!(count, 1);
    }
}
