//! One cluster drawn into one tile: transform, cut where needed, decide coverage.

use super::bins::Item;
use super::clip::{clipped, is_inside};
use super::cluster::Cluster;
use super::coverage::{Nearest, SIDE, Vertex};
use super::projection::{Lens, Projection, Screen, composed};
use super::samples::SUBPIXEL;
use crate::base::vector::{Affine, Vec3};

/// Buffers that a tile uses again for every cluster.
#[derive(Default)]
pub(super) struct Scratch {
    mapped: Vec<Vec3>,
    vertices: Vec<Vertex>,
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

    fn vertex(self, screen: Screen) -> Vertex {
        // In perspective the guard band bounds the coordinates; a parallel view holds the whole scene.
        let fixed =
            |pixels: f32, corner: usize| (pixels * SUBPIXEL as f32 + 0.5).floor() as i32 - corner as i32 * SUBPIXEL;
        Vertex { x: fixed(screen.x, self.x), y: fixed(screen.y, self.y), nearness: screen.nearness }
    }
}

/// A cluster where it stands.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    /// The view that it is drawn in.
    pub projection: &'a Projection,
    /// From its model's to the world's coordinates.
    pub transform: &'a Affine,
    /// The cluster.
    pub cluster: &'a Cluster,
    /// Whether triangles are drawn that show their backs.
    pub two_sided: bool,
}

/// Draws a cluster. `owner` is the number that its triangles are to carry, given the triangle's number in the cluster; it
/// is called only for triangles that may be seen, and `won` is told when one has won a sample.
pub(super) fn cluster<const S: usize>(
    nearest: &mut Nearest<S>,
    scratch: &mut Scratch,
    placed: Placed<'_>,
    corner: Corner,
    mut seen: impl FnMut(u16, &mut dyn FnMut(u32) -> bool),
) {
    let Placed { projection, transform, cluster, two_sided } = placed;
    let map = composed(&projection.map, transform);
    let (near, far) = (projection.near, projection.far);
    scratch.mapped.clear();
    scratch.mapped.extend(cluster.positions.iter().map(|&p| map.point(p)));
    let whole = projection.lens == Lens::Parallel || scratch.mapped.iter().all(|&p| is_inside(p, near, far));
    scratch.vertices.clear();
    if whole {
        scratch.vertices.extend(scratch.mapped.iter().map(|&p| corner.vertex(projection.screen(p))));
    }
    for (number, triangle) in cluster.triangles.iter().enumerate() {
        let number = number as u16;
        if whole {
            let vertices = triangle.map(|v| scratch.vertices[usize::from(v)]);
            if two_sided || is_front(&vertices) {
                seen(number, &mut |owner| nearest.draw(vertices, owner));
            }
            continue;
        }
        let polygon = clipped(triangle.map(|v| scratch.mapped[usize::from(v)]), near, far);
        for k in 1..polygon.len().saturating_sub(1) {
            let vertices = [polygon[0], polygon[k], polygon[k + 1]].map(|p| corner.vertex(projection.screen(p)));
            if two_sided || is_front(&vertices) {
                seen(number, &mut |owner| nearest.draw(vertices, owner));
            }
        }
    }
}

/// Whether a triangle's front is seen: counter-clockwise, which is negative where y points down.
fn is_front([a, b, c]: &[Vertex; 3]) -> bool {
    i64::from(b.x - a.x) * i64::from(c.y - a.y) < i64::from(c.x - a.x) * i64::from(b.y - a.y)
}
