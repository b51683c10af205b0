//! Who gets the samples of a pixel: what lies inside all edges and nearer than what was there. Decided for eight samples at
//! once or one by one, with the same operations on each and so with the same bits.

use super::setup::{EdgeValue, Edges, Plane};
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8, u32x8};

/// What a triangle brings to a pixel.
#[derive(Clone, Copy)]
pub(super) struct Claim {
    /// Its nearness at the pixel's corner.
    pub nearness: f32,
    /// Who it is.
    pub owner: u32,
}

/// The samples of a pixel.
pub(super) struct Pixel<'a, const S: usize> {
    /// Their nearness.
    pub nearness: &'a mut [f32; S],
    /// Who they belong to.
    pub owner: &'a mut [u32; S],
}

/// Sample `s` of a pixel: if it is inside all edges and nearer than what stood there it changes hands.
#[inline(always)]
fn contest_sample<E: EdgeValue, const S: usize>(
    s: usize,
    pixel: &mut Pixel<'_, S>,
    edges: &Edges<E, S>,
    at: [E; 3],
    plane: &Plane<S>,
    claim: Claim,
) -> bool {
    let edge = |k: usize| at[k].plus(edges.samples[k][s]);
    let value = claim.nearness + plane.samples[s];
    let value = if value < plane.low { plane.low } else { value };
    let value = if value > plane.high { plane.high } else { value };
    let wins = !(edge(0) | edge(1) | edge(2)).is_negative() && value > pixel.nearness[s];
    if wins {
        pixel.nearness[s] = value;
        pixel.owner[s] = claim.owner;
    }
    wins
}

/// Eight samples, or eight pixels of one sample, that change hands at once.
pub(super) struct Eight<'a> {
    /// Their nearness.
    pub nearness: &'a mut [f32],
    /// Who they belong to.
    pub owner: &'a mut [u32],
}

impl Eight<'_> {
    /// Gives `owner` those that no edge value leaves outside (`outside` is not negative) and whose stored nearness is below
    /// `value`, kept within the triangle's corners: the operations of one sample, in the same order.
    #[inline(always)]
    pub(super) fn contest<W: Simd, const S: usize>(
        self,
        simd: W,
        outside: i32x8<W>,
        value: f32x8<W>,
        plane: &Plane<S>,
        owner: u32,
    ) -> bool {
        let (low, high) = (f32x8::splat(simd, plane.low), f32x8::splat(simd, plane.high));
        let value = value.simd_lt(low).select(low, value);
        let value = value.simd_gt(high).select(high, value);
        let stored = f32x8::from_slice(simd, self.nearness);
        let wins = outside.simd_ge(i32x8::splat(simd, 0)) & value.simd_gt(stored);
        if !wins.any_true() {
            return false;
        }
        wins.select(value, stored).store_slice(self.nearness);
        let owners = u32x8::from_slice(simd, self.owner);
        wins.select(u32x8::splat(simd, owner), owners).store_slice(self.owner);
        true
    }
}

/// Samples `from` to `from` + 8 of a pixel at once.
#[inline(always)]
fn contest_eight<W: Simd, const S: usize>(
    simd: W,
    from: usize,
    pixel: &mut Pixel<'_, S>,
    edges: &Edges<i32, S>,
    at: [i32; 3],
    plane: &Plane<S>,
    claim: Claim,
) -> bool {
    let part = from..from + 8;
    let mut outside = i32x8::splat(simd, 0);
    for k in 0..3 {
        let samples = i32x8::from_slice(simd, &edges.samples[k][part.clone()]);
        outside |= samples + i32x8::splat(simd, at[k]);
    }
    let value = f32x8::from_slice(simd, &plane.samples[part.clone()]) + f32x8::splat(simd, claim.nearness);
    let eight = Eight { nearness: &mut pixel.nearness[part.clone()], owner: &mut pixel.owner[part] };
    eight.contest(simd, outside, value, plane, claim.owner)
}

/// The samples of a pixel, eight at once where there are as many.
#[inline(always)]
pub(super) fn contest_in_lanes<W: Simd, const S: usize>(
    simd: W,
    pixel: &mut Pixel<'_, S>,
    edges: &Edges<i32, S>,
    at: [i32; 3],
    plane: &Plane<S>,
    claim: Claim,
) -> bool {
    if S < 8 {
        return contest_one_by_one(simd, pixel, edges, at, plane, claim);
    }
    let mut won = false;
    for from in (0..S).step_by(8) {
        won |= contest_eight(simd, from, pixel, edges, at, plane, claim);
    }
    won
}

/// The samples of a pixel, one after another.
#[inline(always)]
pub(super) fn contest_one_by_one<W: Simd, E: EdgeValue, const S: usize>(
    _: W,
    pixel: &mut Pixel<'_, S>,
    edges: &Edges<E, S>,
    at: [E; 3],
    plane: &Plane<S>,
    claim: Claim,
) -> bool {
    let mut won = false;
    for s in 0..S {
        won |= contest_sample(s, pixel, edges, at, plane, claim);
    }
    won
}
