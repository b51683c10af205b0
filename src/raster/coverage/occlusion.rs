//! Whether something is hidden by what a tile holds already: by the depths of its blocks, or sample by sample.

use super::{BLOCK, BLOCKS, LANES, Nearest, SIDE, corner};
use fearless_simd::f32x8;
use fearless_simd::prelude::*;

impl<const S: usize> Nearest<S> {
    /// Whether something no nearer than `nearness` would be hidden everywhere in a box of pixels (left, top, right,
    /// bottom; inclusive, inside the tile).
    pub(in crate::raster) fn hides(&mut self, bounds: [usize; 4], nearness: f32) -> bool {
        let [left, top, right, bottom] = bounds.map(|edge| edge / BLOCK);
        (top..=bottom).all(|row| (left..=right).all(|column| self.block_farthest(row * BLOCKS + column) > nearness))
    }

    /// Whether something no nearer than `nearness` would win no sample in a box of pixels (left, top, right, bottom; inclusive, inside
    /// the tile), sample by sample: foliage has holes, so that few blocks are hidden as a whole.
    #[inline(always)]
    pub(in crate::raster) fn is_behind<W: Simd>(
        &self,
        simd: W,
        [left, top, right, bottom]: [usize; 4],
        nearness: f32,
    ) -> bool {
        let limit = f32x8::splat(simd, nearness);
        let samples = self.nearness.as_flattened();
        for (row, column) in
            (top / BLOCK..=bottom / BLOCK).flat_map(|row| (left / BLOCK..=right / BLOCK).map(move |c| (row, c)))
        {
            let block = row * BLOCKS + column;
            if self.farthest[block] >= nearness {
                continue;
            }
            if self.bare >> block & 1 == 1 {
                if self.background.range(corner(block))[0].max(0.0) < nearness {
                    return false;
                }
                continue;
            }
            let (first, last) = (left.max(column * BLOCK), right.min(column * BLOCK + BLOCK - 1));
            for y in top.max(row * BLOCK)..=bottom.min(row * BLOCK + BLOCK - 1) {
                let from = (y * SIDE + first) * S / LANES * LANES;
                let end = (y * SIDE + last + 1) * S;
                for eight in samples[from..end.next_multiple_of(LANES)].chunks_exact(LANES) {
                    if f32x8::from_slice(simd, eight).simd_lt(limit).any_true() {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Whether a box of pixels in one block lies behind the nearness that all of the block had when it was last looked at;
    /// since then it can only have come nearer.
    #[inline(always)]
    pub(super) fn is_known_to_hide(&self, bounds: [usize; 4], nearness: f32) -> bool {
        let [left, top, right, bottom] = bounds;
        let (left, top, right, bottom) = (left / BLOCK, top / BLOCK, right / BLOCK, bottom / BLOCK);
        left == right && top == bottom && self.farthest[top * BLOCKS + left] >= nearness
    }

    fn block_farthest(&mut self, block: usize) -> f32 {
        if self.bare >> block & 1 == 1 {
            return self.background.range(corner(block))[0].max(0.0);
        }
        if self.stale >> block & 1 == 1 {
            let first = block / BLOCKS * BLOCK * SIDE + block % BLOCKS * BLOCK;
            let mut low = [f32::MAX; S];
            for row in 0..BLOCK {
                for pixel in &self.nearness[first + row * SIDE..][..BLOCK] {
                    for (least, value) in low.iter_mut().zip(pixel) {
                        *least = if value < least { *value } else { *least };
                    }
                }
            }
            self.farthest[block] = low.iter().copied().fold(f32::MAX, f32::min);
            self.stale &= !(1 << block);
        }
        self.farthest[block]
    }
}
