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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Purpose, Stream};
    use crate::raster::background::Background;
    use crate::raster::coverage::Vertex;
    use crate::raster::coverage::tests::draw;
    use fearless_simd::{Level, dispatch};

    /// Whether two triangles over all of a box of pixels win no sample.
    fn wins_nothing<const S: usize>(tile: &Nearest<S>, bounds: [usize; 4], nearness: f32) -> bool {
        let [left, top, right, bottom] = bounds.map(|edge| edge as i32 * 256);
        let corner = |x: i32, y: i32| Vertex { x, y, nearness };
        let (right, bottom) = (right + 256, bottom + 256);
        let corners = [corner(left, top), corner(right, top), corner(right, bottom), corner(left, bottom)];
        let [a, b, c, d] = corners;
        let mut tile = tile.clone();
        let won = [draw(&mut tile, [a, b, c], 1), draw(&mut tile, [a, c, d], 1)];
        won == [false; 2]
    }

    fn what_is_behind_wins_nothing<const S: usize>() {
        let mut random = Stream::new(5, Purpose::Derivation, S as u64, 0);
        let mut below = |limit: u64| random.bits() % limit;
        let mut tile = Nearest::<S>::new();
        tile.clear(&Background { at: 0.2, down: 0.001, owner: 7, beyond: 8, ..Background::default() });
        let mut counts = [0; 2];
        for step in 0..600 {
            let mut vertex = || Vertex {
                x: below(80 * 256) as i32 - 2048,
                y: below(80 * 256) as i32 - 2048,
                nearness: 0.1 + below(1000) as f32 * 1e-3,
            };
            let triangle = [vertex(), vertex(), vertex()];
            draw(&mut tile, triangle, step);
            let (left, top) = (below(58) as usize, below(58) as usize);
            let bounds = [left, top, left + below(6) as usize, top + below(6) as usize];
            let nearness = below(1200) as f32 * 1e-3;
            let is_behind = dispatch!(Level::new(), simd => tile.is_behind(simd, bounds, nearness));
            let expected = wins_nothing(&tile, bounds, nearness);
            // Fewer samples than a register holds are looked at with those of the pixels beside.
            assert!(!is_behind || expected, "{bounds:?} {nearness}");
            assert!(S < LANES || is_behind == expected, "{bounds:?} {nearness}");
            counts[usize::from(is_behind)] += 1;
        }
        assert!(counts.iter().all(|&count| count > 50), "{counts:?}");
    }

    #[test]
    fn what_is_behind_wins_no_sample() {
        what_is_behind_wins_nothing::<1>();
        what_is_behind_wins_nothing::<4>();
        what_is_behind_wins_nothing::<8>();
        what_is_behind_wins_nothing::<16>();
    }
}
