//! One cluster drawn into one tile: transform, cut where needed, decide coverage.

use super::Prepared;
use super::bins::Item;
use super::clip::{clipped, is_inside, is_outside};
use super::cluster::{Cluster, LANES};
use super::coverage::{Nearest, SIDE, Vertex, doubled_area};
use super::projection::{Lens, Projection, Screen};
use super::samples::SUBPIXEL;
use crate::base::maths::floor_to_i32;
use crate::base::vector::{Affine, Vec3};
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x8, i32x8};

/// Buffers that a tile uses again for every cluster.
#[derive(Default)]
pub(super) struct Scratch {
    mapped: Vec<Vec3>,
    corners: Corners,
    /// Places in the cluster of the triangles that won a sample, in the order of drawing.
    pub won: Vec<u16>,
}

/// Where a tile lies.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    /// Its left column of pixels.
    pub x: usize,
    /// Its top row of pixels.
    pub y: usize,
}

impl Corner {
    /// The part of an item's box that lies in the tile, relative to its corner.
    pub(super) fn clip(self, item: &Item) -> [usize; 4] {
        let within = |edge: i32, corner: usize| (edge - corner as i32).clamp(0, SIDE as i32 - 1) as usize;
        let [left, top, right, bottom] = item.bounds;
        [within(left, self.x), within(top, self.y), within(right, self.x), within(bottom, self.y)]
    }

    /// How many columns and rows of the tile lie in the picture.
    pub(super) fn extent(self, prepared: &Prepared) -> [usize; 2] {
        let view = &prepared.frame.view;
        [(view.width as usize - self.x).min(SIDE), (view.height as usize - self.y).min(SIDE)]
    }

    #[inline(always)]
    fn vertex(self, screen: Screen) -> Vertex {
        // In perspective the guard band bounds the coordinates; a parallel view holds the whole scene.
        let fixed = |pixels: f32, corner: usize| {
            let floor = floor_to_i32(pixels * SUBPIXEL as f32 + 0.5);
            floor.wrapping_sub((corner as i32).wrapping_mul(SUBPIXEL))
        };
        Vertex { x: fixed(screen.x, self.x), y: fixed(screen.y, self.y), nearness: screen.nearness }
    }
}

/// A cluster where it stands.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    /// The view that it is drawn in.
    pub projection: &'a Projection,
    /// From its model's coordinates to those of the view.
    pub map: &'a Affine,
    /// What is drawn.
    pub cluster: &'a Cluster,
    /// Whether triangles are drawn that turn their backs.
    pub two_sided: bool,
    /// Whether nothing of it needs to be cut off.
    pub is_whole: bool,
}

/// Draws a cluster, with the widest registers that the processor has. Triangles that win a sample are listed in
/// `scratch.won` and own it by numbers from `first_owner` on, in that order.
pub(super) fn cluster<const S: usize>(
    nearest: &mut Nearest<S>,
    scratch: &mut Scratch,
    placed: Placed<'_>,
    corner: Corner,
    first_owner: u32,
) {
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || compute(simd, nearest, scratch, placed, corner, first_owner)
    ));
}

#[inline(always)]
fn compute<W: Simd, const S: usize>(
    simd: W,
    nearest: &mut Nearest<S>,
    scratch: &mut Scratch,
    placed: Placed<'_>,
    corner: Corner,
    first_owner: u32,
) {
    let Placed { projection, map, cluster, two_sided, is_whole } = placed;
    scratch.won.clear();
    if is_whole {
        scratch.corners.place(simd, projection, map, cluster, corner);
        let (bounds, high) = scratch.corners.extent(simd);
        let Some(bounds) = nearest.pixels(bounds) else { return };
        if nearest.is_behind(simd, bounds, high) {
            return;
        }
        let Scratch { corners, won, .. } = scratch;
        for (number, triangle) in cluster.triangles.iter().enumerate() {
            let [a, b, c] = *triangle;
            let vertices =
                [corners.vertex(usize::from(a)), corners.vertex(usize::from(b)), corners.vertex(usize::from(c))];
            contest(simd, nearest, won, vertices, (number, first_owner), two_sided);
        }
        return;
    }
    let (near, far) = (projection.near, projection.far);
    let Scratch { mapped, won, .. } = scratch;
    mapped.clear();
    mapped.extend(cluster.positions.iter().map(|&position| map.point(position)));
    for (number, triangle) in cluster.triangles.iter().enumerate() {
        let corners = triangle.map(|v| mapped[usize::from(v)]);
        if corners.iter().all(|&p| is_inside(p, near, far)) {
            let vertices = corners.map(|p| corner.vertex(projection.screen(p)));
            contest(simd, nearest, won, vertices, (number, first_owner), two_sided);
            continue;
        }
        if is_outside(&corners, near, far) {
            continue;
        }
        let polygon = clipped(corners, near, far);
        for k in 1..polygon.len().saturating_sub(1) {
            let part = [polygon[0], polygon[k], polygon[k + 1]].map(|p| corner.vertex(projection.screen(p)));
            contest(simd, nearest, won, part, (number, first_owner), two_sided);
        }
    }
}

/// The vertices of a cluster where they lie in a tile, coordinate by coordinate.
#[derive(Default)]
struct Corners {
    x: Vec<i32>,
    y: Vec<i32>,
    nearness: Vec<f32>,
}

impl Corners {
    #[inline(always)]
    fn vertex(&self, number: usize) -> Vertex {
        Vertex { x: self.x[number], y: self.y[number], nearness: self.nearness[number] }
    }

    /// A box (left, top, right, bottom) that holds all vertices, and the largest nearness of any.
    #[inline(always)]
    fn extent<W: Simd>(&self, simd: W) -> ([i32; 4], f32) {
        let (mut low, mut high) = ([i32x8::splat(simd, i32::MAX); 2], [i32x8::splat(simd, i32::MIN); 2]);
        let mut nearest = f32x8::splat(simd, f32::MIN);
        for from in (0..self.x.len()).step_by(LANES) {
            for (axis, values) in [&self.x, &self.y].into_iter().enumerate() {
                let values = i32x8::from_slice(simd, &values[from..from + LANES]);
                low[axis] = low[axis].min(values);
                high[axis] = high[axis].max(values);
            }
            let nearness = f32x8::from_slice(simd, &self.nearness[from..from + LANES]);
            nearest = nearness.simd_gt(nearest).select(nearness, nearest);
        }
        let least = |values: i32x8<W>| <[i32; LANES]>::from(values).into_iter().fold(i32::MAX, i32::min);
        let most = |values: i32x8<W>| <[i32; LANES]>::from(values).into_iter().fold(i32::MIN, i32::max);
        let nearest = <[f32; LANES]>::from(nearest).into_iter().fold(f32::MIN, |a, b| if b > a { b } else { a });
        ([least(low[0]), least(low[1]), most(high[0]), most(high[1])], nearest)
    }

    /// Maps a cluster that needs no cutting, eight vertices at once, with the operations of `Corner::vertex`.
    #[inline(always)]
    fn place<W: Simd>(&mut self, simd: W, view: &Projection, map: &Affine, cluster: &Cluster, corner: Corner) {
        let count = cluster.coordinates[0].len();
        self.x.resize(count, 0);
        self.y.resize(count, 0);
        self.nearness.resize(count, 0.0);
        let [[a, b, c], [d, e, f], [g, h, i]] = map.linear.data.0;
        let [t, u, v]: [f32; 3] = map.translation.into();
        for from in (0..count).step_by(LANES) {
            let x = f32x8::from_slice(simd, &cluster.coordinates[0][from..from + LANES]);
            let y = f32x8::from_slice(simd, &cluster.coordinates[1][from..from + LANES]);
            let z = f32x8::from_slice(simd, &cluster.coordinates[2][from..from + LANES]);
            let across = x * a + y * d + z * g + t;
            let down = x * b + y * e + z * h + u;
            let ahead = x * c + y * f + z * i + v;
            let (across, down, nearness) = match view.lens {
                Lens::Parallel => (across, down, -ahead),
                Lens::Perspective => {
                    let nearness = f32x8::splat(simd, 1.0) / ahead;
                    (across * nearness, down * nearness, nearness)
                }
            };
            fixed(simd, across, corner.x).store_slice(&mut self.x[from..from + LANES]);
            fixed(simd, down, corner.y).store_slice(&mut self.y[from..from + LANES]);
            nearness.store_slice(&mut self.nearness[from..from + LANES]);
        }
    }
}

/// Pixels in units of 1/256 from a tile's corner.
#[inline(always)]
fn fixed<W: Simd>(simd: W, pixels: f32x8<W>, corner: usize) -> i32x8<W> {
    let floor = (pixels * SUBPIXEL as f32 + 0.5).floor().to_int::<i32x8<W>>();
    floor - i32x8::splat(simd, (corner as i32).wrapping_mul(SUBPIXEL))
}

/// Draws a triangle and lists it if it wins a sample.
#[inline(always)]
fn contest<W: Simd, const S: usize>(
    simd: W,
    nearest: &mut Nearest<S>,
    won: &mut Vec<u16>,
    triangle: [Vertex; 3],
    (number, first_owner): (usize, u32),
    two_sided: bool,
) {
    let owner = first_owner.wrapping_add(won.len() as u32);
    if (two_sided || doubled_area(&triangle) < 0) && nearest.draw(simd, triangle, owner) {
        won.push(number as u16);
    }
}
