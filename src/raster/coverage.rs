//! Which samples of a tile a triangle owns, and which of them it wins by depth.

mod occlusion;

use super::background::Background;
use super::contest::{Claim, Eight, Pixel};
use super::samples::{SUBPIXEL, SUBPIXEL_BITS, pattern};
use super::setup::{EdgeValue, Edges, Plane};
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8};

/// Pixels along one side of a tile.
pub const SIDE: usize = 64;
/// Pixels along one side of a block, the unit of depth rejection.
pub(super) const BLOCK: usize = 8;
/// Samples that are decided at once.
const LANES: usize = 8;
/// Blocks along one side of a tile.
const BLOCKS: usize = SIDE / BLOCK;
/// Widest triangle, in pixels, whose edge values fit 32 bits: 2 x (64 x 256) x (65 x 256) < 2^31.
const NARROW: i32 = 64;

/// A vertex of a triangle: 1/256 pixels from the tile's upper left corner, and a nearness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vertex {
    /// To the right.
    pub x: i32,
    /// Down.
    pub y: i32,
    /// Larger is nearer; linear over the picture on a plane.
    pub nearness: f32,
}

/// What is nearest at every sample of a tile.
#[derive(Clone, Debug)]
pub(super) struct Nearest<const S: usize> {
    /// The nearness at each sample, pixel by pixel, row by row.
    pub nearness: Vec<[f32; S]>,
    /// Who it belongs to.
    pub owner: Vec<[u32; S]>,
    /// Where the samples lie in a pixel, 1/256 pixels to the right and down.
    pattern: [[i32; S]; 2],
    /// Width of a pixel's rim in which no sample lies.
    margin: i32,
    /// The smallest nearness in each block, when its bit in `stale` is clear.
    farthest: [f32; BLOCKS * BLOCKS],
    stale: u64,
    /// What stands in the blocks whose bits in `bare` are set; their samples are not written yet.
    background: Background,
    bare: u64,
}

/// The column and row at which a block of a tile begins, pixels.
fn corner(block: usize) -> [usize; 2] {
    [block % BLOCKS * BLOCK, block / BLOCKS * BLOCK]
}

fn by_axis<const S: usize>(pattern: &[[i32; 2]; S]) -> [[i32; S]; 2] {
    [0, 1].map(|axis| pattern.map(|place| place[axis]))
}

/// The widest rim of a pixel in which no sample lies.
fn margin<const S: usize>(pattern: &[[i32; 2]; S]) -> i32 {
    let rim = |place: i32| place.min(SUBPIXEL - 1 - place);
    pattern.iter().flatten().map(|&place| rim(place)).min().unwrap_or(0)
}

/// Twice the area of a triangle, positive where y points down and it winds clockwise as seen.
#[inline(always)]
pub(super) fn doubled_area([a, b, c]: &[Vertex; 3]) -> i64 {
    let side =
        |from: &Vertex, to: &Vertex| [i64::from(to.x.wrapping_sub(from.x)), i64::from(to.y.wrapping_sub(from.y))];
    let ([bx, by], [cx, cy]) = (side(a, b), side(a, c));
    bx.wrapping_mul(cy).wrapping_sub(cx.wrapping_mul(by))
}

impl<const S: usize> Nearest<S> {
    /// A tile's memory, filled by `clear`, for the only pass.
    pub(super) fn new() -> Self {
        Self {
            nearness: vec![[0.0; S]; SIDE * SIDE],
            owner: vec![[0; S]; SIDE * SIDE],
            pattern: by_axis(&pattern::<S>(1, 0)),
            margin: margin(&pattern::<S>(1, 0)),
            farthest: [0.0; BLOCKS * BLOCKS],
            stale: u64::MAX,
            background: Background::default(),
            bare: 0,
        }
    }

    /// Takes samples where they lie in one of several passes.
    pub(super) fn set_pattern(&mut self, pattern: &[[i32; 2]; S]) {
        self.pattern = by_axis(pattern);
        self.margin = margin(pattern);
    }

    /// Puts a background into the tile, which stands at every sample with the nearness and the owner that it has there.
    pub(super) fn clear(&mut self, background: &Background) {
        self.background = *background;
        self.bare = u64::MAX;
        self.farthest.fill(f32::MIN);
        self.stale = u64::MAX;
    }

    /// Who alone is seen in a block that nothing was drawn into.
    pub(super) fn alone(&self, block: [usize; 2]) -> Option<u32> {
        let block = block[1] * BLOCKS + block[0];
        if self.bare >> block & 1 == 0 {
            return None;
        }
        let [low, high] = self.background.range(corner(block));
        match (low > 0.0, high > 0.0) {
            (true, _) => Some(self.background.owner),
            (_, false) => Some(self.background.beyond),
            _ => None,
        }
    }

    /// Writes the samples of the blocks that a box of pixels (left, top, right, bottom; inclusive) touches.
    #[inline(always)]
    pub(super) fn uncover(&mut self, bounds: [usize; 4]) {
        if self.bare != 0 {
            let [left, top, right, bottom] = bounds.map(|edge| edge / BLOCK);
            let columns = (u64::MAX >> (63 - right)) & (u64::MAX << left);
            for row in top..=bottom {
                let mut blocks = self.bare & columns << (row * BLOCKS) & 0xff << (row * BLOCKS);
                while blocks != 0 {
                    self.write_background(blocks.trailing_zeros() as usize);
                    blocks &= blocks - 1;
                }
            }
        }
    }

    #[cold]
    fn write_background(&mut self, block: usize) {
        self.bare &= !(1 << block);
        let background = self.background;
        let [left, top] = corner(block);
        let offsets: [[f32; 2]; S] =
            std::array::from_fn(|s| [0, 1].map(|axis| self.pattern[axis][s] as f32 * (1.0 / SUBPIXEL as f32)));
        for (y, x) in (top..top + BLOCK).flat_map(|y| (left..left + BLOCK).map(move |x| (y, x))) {
            let (nearness, owner) = (&mut self.nearness[y * SIDE + x], &mut self.owner[y * SIDE + x]);
            let corner = background.nearness(x as f32, y as f32);
            for s in 0..S {
                let value = corner + background.right * offsets[s][0] + background.down * offsets[s][1];
                let below = value > 0.0;
                nearness[s] = if below { value } else { 0.0 };
                owner[s] = if below { background.owner } else { background.beyond };
            }
        }
    }

    /// Puts `owner` at one nearness into the whole tile.
    pub(super) fn fill(&mut self, nearness: f32, owner: u32) {
        self.nearness.fill([nearness; S]);
        self.owner.fill([owner; S]);
        self.bare = 0;
        self.farthest.fill(f32::MIN);
        self.stale = u64::MAX;
    }

    /// The pixels of the tile (left, top, right, bottom; inclusive) of which a sample may lie in a box (the same, 1/256 pixels); none
    /// where there are none.
    #[inline(always)]
    pub(super) fn pixels(&self, [left, top, right, bottom]: [i32; 4]) -> Option<[usize; 4]> {
        // No sample lies within `margin` of a pixel's sides.
        let first = |low: i32| (low.wrapping_add(self.margin) >> SUBPIXEL_BITS).max(0);
        let last = |high: i32| (high.wrapping_sub(self.margin) >> SUBPIXEL_BITS).min(SIDE as i32 - 1);
        let [left, top, right, bottom] = [first(left), first(top), last(right), last(bottom)];
        (left <= right && top <= bottom).then_some([left, top, right, bottom].map(|edge| edge as usize))
    }

    /// Draws a triangle of either winding; says whether it won a sample.
    #[inline(always)]
    pub(super) fn draw<W: Simd>(&mut self, simd: W, triangle: [Vertex; 3], owner: u32) -> bool {
        let [a, b, c] = triangle;
        let low_x = a.x.min(b.x).min(c.x);
        let high_x = a.x.max(b.x).max(c.x);
        let low_y = a.y.min(b.y).min(c.y);
        let high_y = a.y.max(b.y).max(c.y);
        let Some(bounds) = self.pixels([low_x, low_y, high_x, high_y]) else { return false };
        let doubled_area = doubled_area(&triangle);
        if doubled_area == 0 {
            return false;
        }
        let positive = if doubled_area > 0 { [a, b, c] } else { [a, c, b] };
        let high = a.nearness.max(b.nearness).max(c.nearness);
        if self.is_known_to_hide(bounds, high) {
            return false;
        }
        self.uncover(bounds);
        let narrow = NARROW * SUBPIXEL;
        let is_narrow = high_x.wrapping_sub(low_x) <= narrow && high_y.wrapping_sub(low_y) <= narrow;
        let [left, top, right, bottom] = bounds;
        let is_small = right - left < BLOCK && bottom - top < BLOCK;
        if is_narrow && (S == 1 || S < LANES && is_small) {
            self.contest_rows(simd, &positive, bounds, owner, doubled_area.abs() as f32)
        } else if is_narrow {
            let plane = Plane::new(&positive, doubled_area.abs() as f32, &self.pattern, [bounds[0], bounds[1]]);
            self.contest_pixels::<W, i32>(simd, &positive, &plane, bounds, owner)
        } else {
            let plane = Plane::new(&positive, doubled_area.abs() as f32, &self.pattern, [bounds[0], bounds[1]]);
            self.contest_pixels::<W, i64>(simd, &positive, &plane, bounds, owner)
        }
    }

    /// Eight samples of pixels that follow one another at once, where a pixel has fewer: what lies beside the box fails at the edges.
    #[inline(always)]
    fn contest_rows<W: Simd>(
        &mut self,
        simd: W,
        triangle: &[Vertex; 3],
        bounds: [usize; 4],
        owner: u32,
        doubled_area: f32,
    ) -> bool {
        let pixels = LANES / S;
        let [left, top, right, bottom] = bounds;
        let (first, last) = (left / pixels, right / pixels);
        let origin = [first * pixels, top];
        let plane = Plane::<S>::new(triangle, doubled_area, &self.pattern, origin);
        let edges = Edges::<i32, S>::new(triangle, &self.pattern, origin);
        let steps: [i32; LANES] = std::array::from_fn(|lane| (lane / S) as i32);
        let steps = i32x8::from_slice(simd, &steps);
        let mut start = [steps; 3];
        for k in 0..3 {
            let samples: [i32; LANES] =
                std::array::from_fn(|lane| edges.samples[k][lane % S].wrapping_add(edges.at[k]));
            start[k] = steps * edges.right[k] + i32x8::from_slice(simd, &samples);
        }
        let samples: [f32; LANES] = std::array::from_fn(|lane| plane.at + plane.samples[lane % S]);
        let start_nearness = steps.to_float::<f32x8<W>>() * plane.right + f32x8::from_slice(simd, &samples);
        let mut won = false;
        for (row, y) in (top..=bottom).enumerate() {
            for (column, group) in (first..=last).enumerate() {
                let (down, across) = (row as i32, (column * pixels) as i32);
                let mut outside = i32x8::splat(simd, 0);
                for k in 0..3 {
                    let right = edges.right[k].wrapping_mul(across);
                    outside |= start[k] + edges.down[k].wrapping_mul(down).wrapping_add(right);
                }
                let value = start_nearness + (plane.right * (column * pixels) as f32 + plane.down * row as f32);
                let from = (y * SIDE + group * pixels) * S;
                let eight = Eight {
                    nearness: &mut self.nearness.as_flattened_mut()[from..from + LANES],
                    owner: &mut self.owner.as_flattened_mut()[from..from + LANES],
                };
                if eight.contest(simd, outside, value, &plane, owner) {
                    won = true;
                    self.stale |= 1 << (y / BLOCK * BLOCKS + group * pixels / BLOCK);
                }
            }
        }
        won
    }

    #[inline(always)]
    fn contest_pixels<W: Simd, E: EdgeValue>(
        &mut self,
        simd: W,
        triangle: &[Vertex; 3],
        plane: &Plane<S>,
        bounds: [usize; 4],
        owner: u32,
    ) -> bool {
        let edges = Edges::<E, S>::new(triangle, &self.pattern, [bounds[0], bounds[1]]);
        let [left, top, right, bottom] = bounds;
        if right - left < BLOCK && bottom - top < BLOCK {
            return self.contest_box(simd, &edges, plane, [left, top], bounds, owner);
        }
        let mut won = false;
        for (row, column) in
            (top / BLOCK..=bottom / BLOCK).flat_map(|row| (left / BLOCK..=right / BLOCK).map(move |c| (row, c)))
        {
            let part = [
                left.max(column * BLOCK),
                top.max(row * BLOCK),
                right.min(column * BLOCK + BLOCK - 1),
                bottom.min(row * BLOCK + BLOCK - 1),
            ];
            if self.farthest[row * BLOCKS + column] < plane.high && !edges.leave_out(part, [left, top]) {
                won |= self.contest_box(simd, &edges, plane, [left, top], part, owner);
            }
        }
        won
    }

    /// The pixels of a box (left, top, right, bottom; inclusive), for edges and a plane that start at `origin`.
    #[inline(always)]
    fn contest_box<W: Simd, E: EdgeValue>(
        &mut self,
        simd: W,
        edges: &Edges<E, S>,
        plane: &Plane<S>,
        origin: [usize; 2],
        [left, top, right, bottom]: [usize; 4],
        owner: u32,
    ) -> bool {
        let mut won = false;
        for y in top..=bottom {
            let down = (y - origin[1]) as i32;
            let across = (left - origin[0]) as i32;
            let mut at = edges.moved(across, down);
            let mut nearness = plane.at + plane.right * across as f32 + plane.down * down as f32;
            for x in left..=right {
                let place = y * SIDE + x;
                let pixel = Pixel { nearness: &mut self.nearness[place], owner: &mut self.owner[place] };
                if E::contest(simd, pixel, edges, at, plane, Claim { nearness, owner }) {
                    won = true;
                    self.stale |= 1 << (y / BLOCK * BLOCKS + x / BLOCK);
                }
                for k in 0..3 {
                    at[k] = at[k].plus(edges.right[k]);
                }
                nearness += plane.right;
            }
        }
        won
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Purpose, Stream};
    use fearless_simd::{Level, dispatch};

    fn vertex(x: f64, y: f64, nearness: f32) -> Vertex {
        Vertex { x: (x * 256.0) as i32, y: (y * 256.0) as i32, nearness }
    }

    pub(super) fn draw<const S: usize>(tile: &mut Nearest<S>, triangle: [Vertex; 3], owner: u32) -> bool {
        dispatch!(Level::new(), simd => tile.draw(simd, triangle, owner))
    }

    fn count<const S: usize>(tile: &Nearest<S>, owner: u32) -> usize {
        tile.owner.iter().flatten().filter(|&&o| o == owner).count()
    }

    #[test]
    fn a_square_of_two_triangles_owns_each_sample_once() {
        for (a, b, c, d) in [
            ((3.0, 5.0), (40.5, 5.0), (40.5, 33.25), (3.0, 33.25)),
            ((-90.0, -80.0), (200.0, -80.0), (200.0, 190.0), (-90.0, 190.0)),
        ] {
            let mut tile = Nearest::<8>::new();
            let [a, b, c, d] = [a, b, c, d].map(|(x, y)| vertex(x, y, 1.0));
            assert!(draw(&mut tile, [a, b, c], 1));
            assert!(draw(&mut tile, [a, d, c], 2));
            let inside = |low: i32, high: i32| {
                let (low, high) = (low.max(0), high.min(64 * 256));
                pattern::<8>(1, 0).len() as i32 * (high - low)
            };
            let expected = i64::from(inside(a.x, c.x)) * i64::from(c.y.min(64 * 256) - a.y.max(0)) / 65536;
            let owned = (count(&tile, 1) + count(&tile, 2)) as i64;
            assert!((owned - expected).abs() <= expected / 50, "{owned} of {expected}");
            let before = tile.owner.clone();
            assert!(!draw(&mut tile, [a, b, c], 3) && !draw(&mut tile, [a, d, c], 4), "every sample is owned already");
            assert_eq!(before, tile.owner);
        }
    }

    #[test]
    fn nearer_wins_in_either_order() {
        let far = [vertex(0.0, 0.0, 1.0), vertex(64.0, 0.0, 1.0), vertex(0.0, 64.0, 1.0)];
        let near = far.map(|v| Vertex { nearness: 2.0, ..v });
        for order in [[(far, 1), (near, 2)], [(near, 2), (far, 1)]] {
            let mut tile = Nearest::<4>::new();
            for (triangle, owner) in order {
                draw(&mut tile, triangle, owner);
            }
            assert_eq!(count(&tile, 1), 0);
            assert!(count(&tile, 2) > 64 * 64);
        }
    }

    #[test]
    fn area_is_covered_to_a_thousandth() {
        let mut tile = Nearest::<16>::new();
        draw(&mut tile, [vertex(2.3, 1.7, 1.0), vertex(61.1, 12.9, 1.0), vertex(20.4, 60.6, 1.0)], 1);
        let area = ((61.1f64 - 2.3) * (60.6 - 1.7) - (20.4 - 2.3) * (12.9 - 1.7)) / 2.0;
        let measured = count(&tile, 1) as f64 / 16.0;
        assert!((measured / area - 1.0).abs() < 1e-3, "{measured} against {area}");
    }

    #[test]
    fn slanted_planes_interpolate_their_nearness() {
        let mut tile = Nearest::<1>::new();
        draw(&mut tile, [vertex(0.0, 0.0, 0.0), vertex(64.0, 0.0, 64.0), vertex(0.0, 64.0, 0.0)], 1);
        let at = tile.nearness[10 * SIDE + 20][0];
        assert!((at - 20.5).abs() < 1e-3, "{at}");
    }

    #[test]
    fn what_is_behind_a_full_block_is_hidden() {
        let mut tile = Nearest::<8>::new();
        assert!(!tile.hides([0, 0, 15, 15], 1.0));
        draw(&mut tile, [vertex(-70.0, -70.0, 2.0), vertex(90.0, -70.0, 2.0), vertex(-70.0, 90.0, 2.0)], 1);
        assert!(tile.hides([0, 0, 7, 7], 1.0));
        assert!(!tile.hides([0, 0, 7, 7], 2.5));
        assert!(!tile.hides([0, 0, 63, 63], 1.0), "the far corner is open");
    }

    #[test]
    fn degenerate_triangles_draw_nothing() {
        let mut tile = Nearest::<8>::new();
        let line = [vertex(1.0, 1.0, 1.0), vertex(9.0, 9.0, 1.0), vertex(5.0, 5.0, 1.0)];
        assert!(!draw(&mut tile, line, 1));
    }

    /// Triangles of all sizes and attitudes, from a fraction of a pixel to more than the tile.
    fn triangles() -> Vec<[Vertex; 3]> {
        let mut random = Stream::new(5, Purpose::Surroundings, 0, 0);
        (0..4000)
            .map(|number| {
                let size = [0.4, 3.0, 20.0, 150.0][number % 4];
                let (x, y) = (random.range(-10.0, 74.0), random.range(-10.0, 74.0));
                let corner = |random: &mut Stream| {
                    let place = [x + random.range(0.0, size), y + random.range(0.0, size)];
                    vertex(place[0], place[1], random.range(0.1, 3.0) as f32)
                };
                [corner(&mut random), corner(&mut random), corner(&mut random)]
            })
            .collect()
    }

    fn drawn<const S: usize>(level: Level) -> Nearest<S> {
        let mut tile = Nearest::<S>::new();
        tile.clear(&Background { owner: u32::MAX, beyond: u32::MAX, ..Background::default() });
        for (number, triangle) in triangles().into_iter().enumerate() {
            dispatch!(level, simd => tile.draw(simd, triangle, number as u32));
        }
        tile
    }

    fn all_widths_agree<const S: usize>() {
        let (widest, narrow) = (drawn::<S>(Level::new()), drawn::<S>(Level::baseline()));
        let bits = |tile: &Nearest<S>| tile.nearness.iter().flatten().map(|n| n.to_bits()).collect::<Vec<u32>>();
        assert_eq!(bits(&widest), bits(&narrow));
        assert_eq!(widest.owner, narrow.owner);
    }

    #[test]
    fn registers_of_any_width_give_the_same_bits() {
        all_widths_agree::<1>();
        all_widths_agree::<4>();
        all_widths_agree::<8>();
        all_widths_agree::<16>();
    }

    #[test]
    fn every_sample_shows_the_nearest_of_all_triangles_that_own_it() {
        let tile = drawn::<8>(Level::new());
        let places = pattern::<8>(1, 0);
        for (y, x, s) in (0..SIDE).step_by(5).flat_map(|y| (0..SIDE).step_by(3).map(move |x| (y, x, (x + y) % 8))) {
            let at = [x as i32 * SUBPIXEL + places[s][0], y as i32 * SUBPIXEL + places[s][1]];
            let best = triangles().iter().filter_map(|t| nearness_at(t, at)).fold(0.0f64, f64::max);
            let found = f64::from(tile.nearness[y * SIDE + x][s]);
            assert!((found - best).abs() < 2e-3, "pixel {x} {y}, sample {s}: {found} against {best}");
        }
    }

    /// The nearness of a triangle strictly around a place, in exact integers but for the last step.
    fn nearness_at(triangle: &[Vertex; 3], at: [i32; 2]) -> Option<f64> {
        let area = doubled_area(triangle);
        let point = Vertex { x: at[0], y: at[1], nearness: 0.0 };
        let [a, b, c] = *triangle;
        let parts = [[point, b, c], [a, point, c], [a, b, point]].map(|part| doubled_area(&part) * area.signum());
        let inside = area != 0 && parts.iter().all(|&part| part > 0);
        let weighted = parts.iter().zip([a, b, c]).map(|(&part, corner)| part as f64 * f64::from(corner.nearness));
        inside.then(|| weighted.sum::<f64>() / area.abs() as f64)
    }
}
