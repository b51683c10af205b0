//! Which samples of a tile a triangle owns, and which of them it wins by depth.

use super::samples::{SUBPIXEL, SUBPIXEL_BITS, pattern};
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8, u32x8};
use std::ops::BitOr;

/// Pixels along one side of a tile.
pub(super) const SIDE: usize = 64;
/// Pixels along one side of a block, the unit of depth rejection.
const BLOCK: usize = 8;
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

/// A plane behind everything: its nearness over the tile, linear from the tile's upper left corner. Where that is not
/// positive there is nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Background {
    /// Nearness at the corner.
    pub at: f32,
    /// Its growth a pixel to the right.
    pub right: f32,
    /// Its growth a pixel down.
    pub down: f32,
    /// Who the plane is.
    pub owner: u32,
    /// Who stands where there is nothing.
    pub beyond: u32,
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
}

/// An integer wide enough for a triangle's edge values. Its operations wrap, since checks for overflow keep loops from being
/// vectorised; `Nearest::draw` picks a type in which nothing wraps.
trait EdgeValue: Copy + BitOr<Output = Self> {
    /// The samples of a pixel that are inside all edges and nearer than what stood there change hands; says whether any did.
    fn contest<W: Simd, const S: usize>(
        simd: W,
        pixel: Pixel<'_, S>,
        edges: &Edges<Self, S>,
        at: [Self; 3],
        plane: &Plane<S>,
        nearness: f32,
        owner: u32,
    ) -> bool;
    fn from_i32(value: i32) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn is_negative(self) -> bool;
}

macro_rules! edge_value {
    ($integer:ty, $lanes:expr) => {
        impl EdgeValue for $integer {
            #[inline(always)]
            fn contest<W: Simd, const S: usize>(
                simd: W,
                mut pixel: Pixel<'_, S>,
                edges: &Edges<Self, S>,
                at: [Self; 3],
                plane: &Plane<S>,
                nearness: f32,
                owner: u32,
            ) -> bool {
                $lanes(simd, &mut pixel, edges, at, plane, nearness, owner)
            }
            #[inline(always)]
            fn from_i32(value: i32) -> Self {
                Self::from(value)
            }
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }
            #[inline(always)]
            fn minus(self, other: Self) -> Self {
                self.wrapping_sub(other)
            }
            #[inline(always)]
            fn times(self, other: Self) -> Self {
                self.wrapping_mul(other)
            }
            #[inline(always)]
            fn is_negative(self) -> bool {
                self < 0
            }
        }
    };
}

edge_value!(i32, contest_in_lanes);
edge_value!(i64, contest_one_by_one);

#[inline(always)]
fn contest_in_lanes<W: Simd, const S: usize>(
    simd: W,
    pixel: &mut Pixel<'_, S>,
    edges: &Edges<i32, S>,
    at: [i32; 3],
    plane: &Plane<S>,
    nearness: f32,
    owner: u32,
) -> bool {
    if S < 8 {
        return contest_one_by_one(simd, pixel, edges, at, plane, nearness, owner);
    }
    let mut won = false;
    for from in (0..S).step_by(8) {
        won |= contest_eight(simd, from, pixel, edges, at, plane, nearness, owner);
    }
    won
}

#[inline(always)]
fn contest_one_by_one<W: Simd, E: EdgeValue, const S: usize>(
    _: W,
    pixel: &mut Pixel<'_, S>,
    edges: &Edges<E, S>,
    at: [E; 3],
    plane: &Plane<S>,
    nearness: f32,
    owner: u32,
) -> bool {
    let mut won = false;
    for s in 0..S {
        won |= contest_sample(s, pixel, edges, at, plane, nearness, owner);
    }
    won
}

/// The triangle's edges as functions that are not negative inside, at one pixel's corner, with their steps.
struct Edges<E, const S: usize> {
    at: [E; 3],
    right: [E; 3],
    down: [E; 3],
    samples: [[E; S]; 3],
}

/// The nearness over the triangle's plane.
struct Plane<const S: usize> {
    at: f32,
    right: f32,
    down: f32,
    samples: [f32; S],
    low: f32,
    high: f32,
}

/// The widest rim of a pixel in which no sample lies.
fn margin<const S: usize>(pattern: &[[i32; 2]; S]) -> i32 {
    let rim = |place: i32| place.min(SUBPIXEL - 1 - place);
    pattern.iter().flatten().map(|&place| rim(place)).min().unwrap_or(0)
}

/// Twice the area of a triangle, positive where y points down and it winds clockwise as seen.
#[inline(always)]
pub(super) fn doubled_area([a, b, c]: &[Vertex; 3]) -> i64 {
    let side = |from: &Vertex, to: &Vertex| {
        [to.x.wrapping_sub(from.x), to.y.wrapping_sub(from.y)].map(|difference| i64::from(difference))
    };
    let ([bx, by], [cx, cy]) = (side(a, b), side(a, c));
    bx.wrapping_mul(cy).wrapping_sub(cx.wrapping_mul(by))
}

impl<const S: usize> Nearest<S> {
    /// A tile's memory, filled by `clear`.
    pub(super) fn new() -> Self {
        Self {
            nearness: vec![[0.0; S]; SIDE * SIDE],
            owner: vec![[0; S]; SIDE * SIDE],
            pattern: [0, 1].map(|axis| pattern::<S>().map(|place| place[axis])),
            margin: margin(&pattern::<S>()),
            farthest: [0.0; BLOCKS * BLOCKS],
            stale: u64::MAX,
        }
    }

    /// Puts a background into the tile, which stands at every sample with the nearness and the owner that it has there.
    pub(super) fn clear(&mut self, background: &Background) {
        for y in 0..SIDE {
            for x in 0..SIDE {
                let (nearness, owner) = (&mut self.nearness[y * SIDE + x], &mut self.owner[y * SIDE + x]);
                let corner = background.at + background.right * x as f32 + background.down * y as f32;
                for s in 0..S {
                    let [sx, sy] = [0, 1].map(|axis| self.pattern[axis][s] as f32 * (1.0 / SUBPIXEL as f32));
                    let value = corner + background.right * sx + background.down * sy;
                    let below = value > 0.0;
                    nearness[s] = if below { value } else { 0.0 };
                    owner[s] = if below { background.owner } else { background.beyond };
                }
            }
        }
        self.farthest.fill(f32::MIN);
        self.stale = u64::MAX;
    }

    /// Puts `owner` at one nearness into the whole tile.
    pub(super) fn fill(&mut self, nearness: f32, owner: u32) {
        self.nearness.fill([nearness; S]);
        self.owner.fill([owner; S]);
        self.farthest.fill(f32::MIN);
        self.stale = u64::MAX;
    }

    /// Whether something no nearer than `nearness` would be hidden everywhere in a box of pixels (left, top, right,
    /// bottom; inclusive, inside the tile).
    pub(super) fn hides(&mut self, bounds: [usize; 4], nearness: f32) -> bool {
        let [left, top, right, bottom] = bounds.map(|edge| edge / BLOCK);
        (top..=bottom).all(|row| (left..=right).all(|column| self.block_farthest(row * BLOCKS + column) > nearness))
    }

    /// Whether a box of pixels in one block lies behind the nearness that all of the block had when it was last looked at;
    /// since then it can only have come nearer.
    #[inline(always)]
    fn is_known_to_hide(&self, bounds: [usize; 4], nearness: f32) -> bool {
        let [left, top, right, bottom] = bounds.map(|edge| edge / BLOCK);
        left == right && top == bottom && self.farthest[top * BLOCKS + left] >= nearness
    }

    fn block_farthest(&mut self, block: usize) -> f32 {
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

    /// Draws a triangle of either winding; says whether it won a sample.
    #[inline(always)]
    pub(super) fn draw<W: Simd>(&mut self, simd: W, triangle: [Vertex; 3], owner: u32) -> bool {
        let [a, b, c] = triangle;
        let low_x = a.x.min(b.x).min(c.x);
        let high_x = a.x.max(b.x).max(c.x);
        let low_y = a.y.min(b.y).min(c.y);
        let high_y = a.y.max(b.y).max(c.y);
        // No sample lies within `margin` of a pixel's sides.
        let last = SIDE as i32 - 1;
        let first = |low: i32| (low.wrapping_add(self.margin) >> SUBPIXEL_BITS).max(0);
        let left = first(low_x);
        let top = first(low_y);
        let right = (high_x.wrapping_sub(self.margin) >> SUBPIXEL_BITS).min(last);
        let bottom = (high_y.wrapping_sub(self.margin) >> SUBPIXEL_BITS).min(last);
        if left > right || top > bottom {
            return false;
        }
        let doubled_area = doubled_area(&triangle);
        if doubled_area == 0 {
            return false;
        }
        let positive = if doubled_area > 0 { [a, b, c] } else { [a, c, b] };
        let bounds = [left, top, right, bottom].map(|edge| edge as usize);
        let high = a.nearness.max(b.nearness).max(c.nearness);
        if self.is_known_to_hide(bounds, high) {
            return false;
        }
        let plane = self.plane(&positive, doubled_area.abs() as f32, bounds);
        let narrow = NARROW * SUBPIXEL;
        if high_x.wrapping_sub(low_x) <= narrow && high_y.wrapping_sub(low_y) <= narrow {
            self.contest_pixels::<W, i32>(simd, &positive, &plane, bounds, owner)
        } else {
            self.contest_pixels::<W, i64>(simd, &positive, &plane, bounds, owner)
        }
    }

    #[inline(always)]
    fn plane(&self, [a, b, c]: &[Vertex; 3], doubled_area: f32, bounds: [usize; 4]) -> Plane<S> {
        let (bx, by) = (b.x.wrapping_sub(a.x) as f32, b.y.wrapping_sub(a.y) as f32);
        let (cx, cy) = (c.x.wrapping_sub(a.x) as f32, c.y.wrapping_sub(a.y) as f32);
        let (bz, cz) = (b.nearness - a.nearness, c.nearness - a.nearness);
        let share = 1.0 / doubled_area;
        let right = (bz * cy - cz * by) * share;
        let down = (cz * bx - bz * cx) * share;
        let x = (bounds[0] as i32 * SUBPIXEL).wrapping_sub(a.x);
        let y = (bounds[1] as i32 * SUBPIXEL).wrapping_sub(a.y);
        let mut samples = [0.0; S];
        for s in 0..S {
            samples[s] = right * self.pattern[0][s] as f32 + down * self.pattern[1][s] as f32;
        }
        Plane {
            at: a.nearness + right * x as f32 + down * y as f32,
            right: right * SUBPIXEL as f32,
            down: down * SUBPIXEL as f32,
            samples,
            low: a.nearness.min(b.nearness).min(c.nearness),
            high: a.nearness.max(b.nearness).max(c.nearness),
        }
    }

    #[inline(always)]
    fn edges<E: EdgeValue>(&self, triangle: &[Vertex; 3], bounds: [usize; 4]) -> Edges<E, S> {
        let zero = E::from_i32(0);
        let mut edges = Edges { at: [zero; 3], right: [zero; 3], down: [zero; 3], samples: [[zero; S]; 3] };
        for k in 0..3 {
            let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
            let (dx, dy) = (to.x.wrapping_sub(from.x), to.y.wrapping_sub(from.y));
            // Top-left rule: a sample on an edge belongs to the triangle whose top or left edge it is.
            let owns = dy < 0 || (dy == 0 && dx > 0);
            let bias = E::from_i32(i32::from(!owns));
            let (dx, dy) = (E::from_i32(dx), E::from_i32(dy));
            let x = E::from_i32((bounds[0] as i32 * SUBPIXEL).wrapping_sub(from.x));
            let y = E::from_i32((bounds[1] as i32 * SUBPIXEL).wrapping_sub(from.y));
            edges.at[k] = dx.times(y).minus(dy.times(x)).minus(bias);
            edges.right[k] = zero.minus(dy.times(E::from_i32(SUBPIXEL)));
            edges.down[k] = dx.times(E::from_i32(SUBPIXEL));
            for s in 0..S {
                let [sx, sy] = [0, 1].map(|axis| E::from_i32(self.pattern[axis][s]));
                edges.samples[k][s] = dx.times(sy).minus(dy.times(sx));
            }
        }
        edges
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
        let edges = self.edges::<E>(triangle, bounds);
        let [left, top, right, bottom] = bounds;
        let mut row_at = edges.at;
        let mut row_nearness = plane.at;
        let mut won = false;
        for y in top..=bottom {
            let mut at = row_at;
            let mut nearness = row_nearness;
            for x in left..=right {
                let place = y * SIDE + x;
                let pixel = Pixel { nearness: &mut self.nearness[place], owner: &mut self.owner[place] };
                if E::contest(simd, pixel, &edges, at, plane, nearness, owner) {
                    won = true;
                    self.stale |= 1 << (y / BLOCK * BLOCKS + x / BLOCK);
                }
                at = std::array::from_fn(|k| at[k].plus(edges.right[k]));
                nearness += plane.right;
            }
            row_at = std::array::from_fn(|k| row_at[k].plus(edges.down[k]));
            row_nearness += plane.down;
        }
        won
    }
}

/// The samples of a pixel.
struct Pixel<'a, const S: usize> {
    nearness: &'a mut [f32; S],
    owner: &'a mut [u32; S],
}

/// Sample `s` of a pixel: if it is inside all edges and nearer than what stood there it changes hands.
#[inline(always)]
fn contest_sample<E: EdgeValue, const S: usize>(
    s: usize,
    pixel: &mut Pixel<'_, S>,
    edges: &Edges<E, S>,
    at: [E; 3],
    plane: &Plane<S>,
    nearness: f32,
    owner: u32,
) -> bool {
    let edge = |k: usize| at[k].plus(edges.samples[k][s]);
    let value = nearness + plane.samples[s];
    let value = if value < plane.low { plane.low } else { value };
    let value = if value > plane.high { plane.high } else { value };
    let wins = !(edge(0) | edge(1) | edge(2)).is_negative() && value > pixel.nearness[s];
    if wins {
        pixel.nearness[s] = value;
        pixel.owner[s] = owner;
    }
    wins
}

/// Samples `from` to `from` + 8 of a pixel at once, with the same operations in the same order as one by one.
#[inline(always)]
fn contest_eight<W: Simd, const S: usize>(
    simd: W,
    from: usize,
    pixel: &mut Pixel<'_, S>,
    edges: &Edges<i32, S>,
    at: [i32; 3],
    plane: &Plane<S>,
    nearness: f32,
    owner: u32,
) -> bool {
    let part = from..from + 8;
    let edge = |k: usize| i32x8::from_slice(simd, &edges.samples[k][part.clone()]) + i32x8::splat(simd, at[k]);
    let outside = edge(0) | edge(1) | edge(2);
    let value = f32x8::from_slice(simd, &plane.samples[part.clone()]) + f32x8::splat(simd, nearness);
    let (low, high) = (f32x8::splat(simd, plane.low), f32x8::splat(simd, plane.high));
    let value = value.simd_lt(low).select(low, value);
    let value = value.simd_gt(high).select(high, value);
    let stored = f32x8::from_slice(simd, &pixel.nearness[part.clone()]);
    let wins = outside.simd_ge(i32x8::splat(simd, 0)) & value.simd_gt(stored);
    if wins.any_false() && !wins.any_true() {
        return false;
    }
    wins.select(value, stored).store_slice(&mut pixel.nearness[part.clone()]);
    let owners = u32x8::from_slice(simd, &pixel.owner[part.clone()]);
    wins.select(u32x8::splat(simd, owner), owners).store_slice(&mut pixel.owner[part]);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(x: f64, y: f64, nearness: f32) -> Vertex {
        Vertex { x: (x * 256.0) as i32, y: (y * 256.0) as i32, nearness }
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
            assert!(tile.draw([a, b, c], 1));
            assert!(tile.draw([a, d, c], 2));
            let inside = |low: i32, high: i32| {
                let (low, high) = (low.max(0), high.min(64 * 256));
                pattern::<8>().len() as i32 * (high - low)
            };
            let expected = i64::from(inside(a.x, c.x)) * i64::from(c.y.min(64 * 256) - a.y.max(0)) / 65536;
            let owned = (count(&tile, 1) + count(&tile, 2)) as i64;
            assert!((owned - expected).abs() <= expected / 50, "{owned} of {expected}");
            let before = tile.owner.clone();
            assert!(!tile.draw([a, b, c], 3) && !tile.draw([a, d, c], 4), "every sample is owned already");
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
                tile.draw(triangle, owner);
            }
            assert_eq!(count(&tile, 1), 0);
            assert!(count(&tile, 2) > 64 * 64);
        }
    }

    #[test]
    fn area_is_covered_to_a_thousandth() {
        let mut tile = Nearest::<16>::new();
        tile.draw([vertex(2.3, 1.7, 1.0), vertex(61.1, 12.9, 1.0), vertex(20.4, 60.6, 1.0)], 1);
        let area = ((61.1f64 - 2.3) * (60.6 - 1.7) - (20.4 - 2.3) * (12.9 - 1.7)) / 2.0;
        let measured = count(&tile, 1) as f64 / 16.0;
        assert!((measured / area - 1.0).abs() < 1e-3, "{measured} against {area}");
    }

    #[test]
    fn slanted_planes_interpolate_their_nearness() {
        let mut tile = Nearest::<1>::new();
        tile.draw([vertex(0.0, 0.0, 0.0), vertex(64.0, 0.0, 64.0), vertex(0.0, 64.0, 0.0)], 1);
        let at = tile.nearness[10 * SIDE + 20][0];
        assert!((at - 20.5).abs() < 1e-3, "{at}");
    }

    #[test]
    fn what_is_behind_a_full_block_is_hidden() {
        let mut tile = Nearest::<8>::new();
        assert!(!tile.hides([0, 0, 15, 15], 1.0));
        tile.draw([vertex(-70.0, -70.0, 2.0), vertex(90.0, -70.0, 2.0), vertex(-70.0, 90.0, 2.0)], 1);
        assert!(tile.hides([0, 0, 7, 7], 1.0));
        assert!(!tile.hides([0, 0, 7, 7], 2.5));
        assert!(!tile.hides([0, 0, 63, 63], 1.0), "the far corner is open");
    }

    #[test]
    fn degenerate_triangles_draw_nothing() {
        let mut tile = Nearest::<8>::new();
        let line = [vertex(1.0, 1.0, 1.0), vertex(9.0, 9.0, 1.0), vertex(5.0, 5.0, 1.0)];
        assert!(!tile.draw(line, 1));
    }
}
