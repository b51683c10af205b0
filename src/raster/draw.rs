//! One cluster drawn into one tile: transform, cut where needed, decide coverage.

use super::bins::Item;
use super::clip::{clipped, is_inside};
use super::cluster::Cluster;
use super::coverage::{Nearest, SIDE, Vertex, doubled_area};
use super::projection::{Lens, Projection, Screen};
use super::samples::SUBPIXEL;
use crate::base::vector::{Affine, Vec3};
use fearless_simd::{Level, Simd, dispatch};

/// Buffers that a tile uses again for every cluster.
#[derive(Default)]
pub(super) struct Scratch {
    mapped: Vec<Vec3>,
    vertices: Vec<Vertex>,
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

    #[inline(always)]
    fn vertex(self, screen: Screen) -> Vertex {
        // In perspective the guard band bounds the coordinates; a parallel view holds the whole scene.
        let fixed = |pixels: f32, corner: usize| {
            let scaled = pixels * SUBPIXEL as f32 + 0.5;
            let truncated = scaled as i32;
            let floor = truncated.wrapping_sub(i32::from(truncated as f32 > scaled));
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
    let Placed { projection, map, cluster, two_sided } = placed;
    let (near, far) = (projection.near, projection.far);
    let Scratch { mapped, vertices, won } = scratch;
    won.clear();
    mapped.clear();
    let mut whole = true;
    for position in &cluster.positions {
        let point = map.point(*position);
        whole &= projection.lens == Lens::Parallel || is_inside(point, near, far);
        mapped.push(point);
    }
    if whole {
        vertices.clear();
        vertices.extend(mapped.iter().map(|&point| corner.vertex(projection.screen(point))));
        for (number, triangle) in cluster.triangles.iter().enumerate() {
            contest(simd, nearest, won, triangle.map(|v| vertices[usize::from(v)]), (number, first_owner), two_sided);
        }
        return;
    }
    for (number, triangle) in cluster.triangles.iter().enumerate() {
        let polygon = clipped(triangle.map(|v| mapped[usize::from(v)]), near, far);
        for k in 1..polygon.len().saturating_sub(1) {
            let part = [polygon[0], polygon[k], polygon[k + 1]].map(|p| corner.vertex(projection.screen(p)));
            contest(simd, nearest, won, part, (number, first_owner), two_sided);
        }
    }
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
