//! A triangle made ready for a tile: its edges and its plane as functions of the place.

use super::contest::{Claim, Pixel, contest_in_lanes, contest_one_by_one};
use super::coverage::Vertex;
use super::samples::SUBPIXEL;
use fearless_simd::Simd;
use std::ops::BitOr;

/// An integer wide enough for a triangle's edge values. Its operations wrap, since checks for overflow keep loops from being
/// vectorised; whoever draws picks a type in which nothing wraps.
pub(super) trait EdgeValue: Copy + BitOr<Output = Self> {
    /// The samples of a pixel that are inside all edges and nearer than what stood there change hands; says whether any did.
    fn contest<W: Simd, const S: usize>(
        simd: W,
        pixel: Pixel<'_, S>,
        edges: &Edges<Self, S>,
        at: [Self; 3],
        plane: &Plane<S>,
        claim: Claim,
    ) -> bool;
    /// The number.
    fn from_i32(value: i32) -> Self;
    /// The sum.
    fn plus(self, other: Self) -> Self;
    /// The difference.
    fn minus(self, other: Self) -> Self;
    /// The product.
    fn times(self, other: Self) -> Self;
    /// Whether it is below zero.
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
                claim: Claim,
            ) -> bool {
                $lanes(simd, &mut pixel, edges, at, plane, claim)
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

/// The triangle's edges as functions that are not negative inside, at one pixel's corner, with their steps.
pub(super) struct Edges<E, const S: usize> {
    /// Values at the corner.
    pub at: [E; 3],
    /// Their growth a pixel to the right.
    pub right: [E; 3],
    /// Their growth a pixel down.
    pub down: [E; 3],
    /// Their growth from a pixel's corner to its samples.
    pub samples: [[E; S]; 3],
}

/// The nearness over the triangle's plane.
pub(super) struct Plane<const S: usize> {
    /// Nearness at one pixel's corner.
    pub at: f32,
    /// Its growth a pixel to the right.
    pub right: f32,
    /// Its growth a pixel down.
    pub down: f32,
    /// Its growth from a pixel's corner to its samples.
    pub samples: [f32; S],
    /// The least of the corners' nearness.
    pub low: f32,
    /// The largest of the corners' nearness.
    pub high: f32,
}

impl<E: EdgeValue, const S: usize> Edges<E, S> {
    /// The edges of a triangle that winds clockwise as seen, from the corner of the pixel at `origin` on, for samples that lie
    /// in a pixel by `pattern` (1/256 pixels to the right and down).
    #[inline(always)]
    pub(super) fn new(triangle: &[Vertex; 3], pattern: &[[i32; S]; 2], origin: [usize; 2]) -> Self {
        let zero = E::from_i32(0);
        let mut edges = Self { at: [zero; 3], right: [zero; 3], down: [zero; 3], samples: [[zero; S]; 3] };
        for k in 0..3 {
            let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
            let (dx, dy) = (to.x.wrapping_sub(from.x), to.y.wrapping_sub(from.y));
            // Top-left rule: a sample on an edge belongs to the triangle whose top or left edge it is.
            let owns = dy < 0 || (dy == 0 && dx > 0);
            let bias = E::from_i32(i32::from(!owns));
            let (dx, dy) = (E::from_i32(dx), E::from_i32(dy));
            let x = E::from_i32((origin[0] as i32 * SUBPIXEL).wrapping_sub(from.x));
            let y = E::from_i32((origin[1] as i32 * SUBPIXEL).wrapping_sub(from.y));
            edges.at[k] = dx.times(y).minus(dy.times(x)).minus(bias);
            edges.right[k] = zero.minus(dy.times(E::from_i32(SUBPIXEL)));
            edges.down[k] = dx.times(E::from_i32(SUBPIXEL));
            for s in 0..S {
                let (sx, sy) = (E::from_i32(pattern[0][s]), E::from_i32(pattern[1][s]));
                edges.samples[k][s] = dx.times(sy).minus(dy.times(sx));
            }
        }
        edges
    }

    /// The values at the corner of a pixel so many to the right and down.
    #[inline(always)]
    pub(super) fn moved(&self, right: i32, down: i32) -> [E; 3] {
        let (right, down) = (E::from_i32(right), E::from_i32(down));
        let mut at = self.at;
        for k in 0..3 {
            at[k] = at[k].plus(self.right[k].times(right)).plus(self.down[k].times(down));
        }
        at
    }

    /// Whether one edge has all of a box (left, top, right, bottom; inclusive) on its outer side.
    #[inline(always)]
    pub(super) fn leave_out(&self, [left, top, right, bottom]: [usize; 4], origin: [usize; 2]) -> bool {
        (0..3).any(|k| {
            // An edge value grows to one side and up or down, so the corner of that side is the one that is most inside.
            let across = if self.right[k].is_negative() { left } else { right + 1 };
            let down = if self.down[k].is_negative() { top } else { bottom + 1 };
            self.moved((across - origin[0]) as i32, (down - origin[1]) as i32)[k].is_negative()
        })
    }
}

impl<const S: usize> Plane<S> {
    /// The plane of a triangle of which twice the area is `doubled_area`, from the corner of the pixel at `origin` on.
    #[inline(always)]
    pub(super) fn new([a, b, c]: &[Vertex; 3], doubled_area: f32, pattern: &[[i32; S]; 2], origin: [usize; 2]) -> Self {
        let (bx, by) = (b.x.wrapping_sub(a.x) as f32, b.y.wrapping_sub(a.y) as f32);
        let (cx, cy) = (c.x.wrapping_sub(a.x) as f32, c.y.wrapping_sub(a.y) as f32);
        let (bz, cz) = (b.nearness - a.nearness, c.nearness - a.nearness);
        let share = 1.0 / doubled_area;
        let right = (bz * cy - cz * by) * share;
        let down = (cz * bx - bz * cx) * share;
        let x = (origin[0] as i32 * SUBPIXEL).wrapping_sub(a.x);
        let y = (origin[1] as i32 * SUBPIXEL).wrapping_sub(a.y);
        let mut samples = [0.0; S];
        for s in 0..S {
            samples[s] = right * pattern[0][s] as f32 + down * pattern[1][s] as f32;
        }
        Self {
            at: a.nearness + right * x as f32 + down * y as f32,
            right: right * SUBPIXEL as f32,
            down: down * SUBPIXEL as f32,
            samples,
            low: a.nearness.min(b.nearness).min(c.nearness),
            high: a.nearness.max(b.nearness).max(c.nearness),
        }
    }
}
