//! Clusters sorted into the tiles that they may touch.

use super::cluster::{Cluster, ClusteredMesh};
use super::coverage::SIDE;
use super::projection::{Lens, Projection, Screen, composed};
use crate::base::vector::{Affine, Vec3};
use crate::frame::{Frame, Instance};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// How much larger the error of a coarser level may be where leaves lie on the ground: they are seen along it, a few pixels
/// high, and thousands lie on one another.
const LYING_ERROR: f32 = 4.0;
/// Parts of lying leaves that are thinner than this are left out, pixels: stalks.
const THINNEST: f32 = 0.2;
/// Instances that one task bins; fixed, so that the order of items does not depend on the threads.
const CHUNK: usize = 1024;
/// Chunks that are binned before their items are put together.
const TOGETHER: usize = 64;

/// Size up to which an item is small in the picture, pixels.
const SMALL: i32 = 48;

/// A box of pixels (left, top, right, bottom; inclusive).
type Bounds = [i32; 4];

/// A cluster of an instance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Number of the instance.
    pub instance: u32,
    /// Number of the mesh.
    pub mesh: u32,
    /// Number of the material.
    pub material: u32,
    /// Number of the mesh's level of detail.
    pub level: u16,
    /// Number of the cluster in that level.
    pub cluster: u32,
    /// Largest nearness that its sphere can have.
    pub nearness: f32,
    /// What a pixel covers where it is nearest, in the mesh's metres.
    pub pixel: f32,
    /// Whether no part of it reaches where triangles are cut.
    pub is_whole: bool,
    /// Whether it is at most [`SMALL`] pixels wide and high in the picture, taken as if it lay where it is nearest.
    pub is_small: bool,
    /// What holds it.
    pub bounds: Bounds,
}

impl Item {
    /// The cluster.
    pub(super) fn cluster_in<'a>(&self, meshes: &'a [Arc<ClusteredMesh>]) -> &'a Cluster {
        &meshes[self.mesh as usize].levels[usize::from(self.level)].clusters[self.cluster as usize]
    }
}

/// The items of every tile.
pub(super) struct Bins {
    /// Tiles in a row.
    pub columns: usize,
    /// Rows of tiles, by their numbers in the picture.
    rows: Range<usize>,
    /// All items that touch the picture.
    pub items: Vec<Item>,
    tiles: Vec<Vec<u32>>,
}

impl Bins {
    /// Bins instances of a frame's models for some rows of tiles of a picture, whose width and height are in pixels. Meshes are
    /// taken in the coarsest level that is within `lod_error` pixels.
    pub(super) fn new(
        frame: &Frame,
        instances: &[Instance],
        meshes: &[Arc<ClusteredMesh>],
        projection: &Projection,
        ([width, height], rows): ([u32; 2], Range<usize>),
        lod_error: f32,
    ) -> Self {
        let columns = tiles_across(width);
        let limits =
            [0, (rows.start * SIDE) as i32, width as i32 - 1, (rows.end * SIDE).min(height as usize) as i32 - 1];
        let fallen = frame.standing().len()..frame.instances.len();
        let mut items = Vec::new();
        // Some chunks at a time: the items of all are not held twice.
        for (group, instances) in instances.chunks(CHUNK * TOGETHER).enumerate() {
            let first = group * CHUNK * TOGETHER;
            let found: Vec<Vec<Item>> = instances
                .par_chunks(CHUNK)
                .enumerate()
                .map(|(chunk, instances)| {
                    let mut items = Vec::new();
                    for (offset, instance) in instances.iter().enumerate() {
                        let number = (first + chunk * CHUNK + offset) as u32;
                        let is_fallen = fallen.contains(&(number as usize)) && lod_error > 0.0;
                        let detail = if is_fallen { [lod_error * LYING_ERROR, THINNEST] } else { [lod_error, 0.0] };
                        push_items(frame, meshes, projection, detail, limits, (number, instance), &mut items);
                    }
                    items
                })
                .collect();
            found.into_iter().for_each(|found| items.extend(found));
        }
        let mut keyed = vec![Vec::new(); columns * rows.len()];
        for (number, item) in items.iter().enumerate() {
            let [left, top, right, bottom] = item.bounds.map(|edge| edge as usize / SIDE);
            let key = u64::from(place_by_nearness(item.nearness)) << 32 | number as u64;
            for row in top..=bottom {
                for column in left..=right {
                    keyed[(row - rows.start) * columns + column].push(key);
                }
            }
        }
        let nearest_first = |mut keys: Vec<u64>| {
            keys.sort_unstable();
            keys.into_iter().map(|key| key as u32).collect()
        };
        Self { columns, rows, items, tiles: keyed.into_par_iter().map(nearest_first).collect() }
    }

    /// Whether a tile, by its number, holds the same items in the same order as it does in other bins.
    pub(super) fn holds_as(&self, other: &Self, tile: usize, is_same: impl Fn(&Item, &Item) -> bool) -> bool {
        let (Some(these), Some(others)) = (self.tiles.get(tile), other.tiles.get(tile)) else { return false };
        let items =
            |(this, other_one): (&u32, &u32)| is_same(&self.items[*this as usize], &other.items[*other_one as usize]);
        these.len() == others.len() && these.iter().zip(others).all(items)
    }

    /// Columns and rows of all tiles, by their numbers in the picture.
    pub(super) fn places(&self) -> Vec<[usize; 2]> {
        self.rows.clone().flat_map(|row| (0..self.columns).map(move |column| [column, row])).collect()
    }

    /// The items of a tile, nearest first, ties by number.
    pub(super) fn tile(&self, column: usize, row: usize) -> &[u32] {
        &self.tiles[(row - self.rows.start) * self.columns + column]
    }
}

/// A number that falls as a nearness grows, over all of its range.
fn place_by_nearness(nearness: f32) -> u32 {
    let bits = nearness.to_bits();
    // Floats of one sign are in order by their bits, negative ones the other way round.
    if bits >> 31 == 0 { !(bits | 1 << 31) } else { bits }
}

/// How many tiles stand in a row or a column of so many pixels.
pub(super) fn tiles_across(pixels: u32) -> usize {
    (pixels as usize).div_ceil(SIDE)
}

/// The part of a box that lies within others' `limits`; none when nothing does.
fn within(bounds: [f32; 4], limits: Bounds) -> Option<Bounds> {
    let [left, top, right, bottom] = bounds.map(|edge| edge.floor() as i32);
    let is_beside = right < limits[0] || bottom < limits[1] || left > limits[2] || top > limits[3];
    (!is_beside).then(|| [left.max(limits[0]), top.max(limits[1]), right.min(limits[2]), bottom.min(limits[3])])
}

/// A box of pixels that holds what a camera sees of a cluster: of its sphere or, where that is wide, of its vertices, which may
/// lie flat or far apart in it.
fn seen_within(projection: &Projection, cluster: &Cluster, transform: &Affine, is_whole: bool) -> Option<[f32; 4]> {
    let scale = transform.linear.column(0).norm();
    let bounds = projection.tangent_bounds(transform.point(cluster.centre), cluster.radius * scale)?;
    let is_wide = bounds[2] - bounds[0] > SIDE as f32 || bounds[3] - bounds[1] > SIDE as f32;
    if !is_whole || !is_wide {
        return Some(bounds);
    }
    let map = composed(&projection.map, transform);
    let seen = cluster.positions.iter().map(|&position| projection.screen(map.point(position)));
    let none = [f32::MAX, f32::MAX, f32::MIN, f32::MIN];
    let [left, top, right, bottom] = seen.fold(none, |[left, top, right, bottom], Screen { x, y, .. }| {
        [left.min(x), top.min(y), right.max(x), bottom.max(y)]
    });
    Some([left - 1.0, top - 1.0, right + 1.0, bottom + 1.0])
}

fn push_items(
    frame: &Frame,
    meshes: &[Arc<ClusteredMesh>],
    projection: &Projection,
    [lod_error, thinnest]: [f32; 2],
    limits: Bounds,
    (number, instance): (u32, &Instance),
    items: &mut Vec<Item>,
) {
    let scale = instance.transform.linear.column(0).norm();
    let pixel = projection.metres(instance.transform.translation);
    let tolerance = pixel * lod_error / scale.max(1e-12);
    for part in &frame.models[instance.model as usize].parts {
        let mesh = &meshes[part.mesh as usize];
        if thinnest > 0.0 && mesh.width() * scale < pixel * thinnest {
            continue;
        }
        let level = mesh.level_within(tolerance);
        for (cluster_number, cluster) in mesh.levels[level].clusters.iter().enumerate() {
            let centre: Vec3 = instance.transform.point(cluster.centre);
            let Some((bounds, nearness)) = projection.sphere_bounds(centre, cluster.radius * scale) else { continue };
            let Some(around) = within(bounds, limits) else { continue };
            let is_whole = projection.holds(centre, cluster.radius * scale);
            let bounds = match projection.lens {
                Lens::Parallel => Some(around),
                Lens::Perspective => seen_within(projection, cluster, &instance.transform, is_whole)
                    .and_then(|bounds| within(bounds, limits)),
            };
            let Some(bounds) = bounds else { continue };
            items.push(Item {
                instance: number,
                mesh: part.mesh,
                material: part.material,
                level: level as u16,
                cluster: cluster_number as u32,
                nearness,
                pixel: projection.least_metres(centre, cluster.radius * scale) / scale.max(1e-12),
                is_whole,
                is_small: around[2] - around[0] <= SMALL && around[3] - around[1] <= SMALL,
                bounds,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Mesh;
    use crate::base::vector::Vec2;
    use crate::frame::Camera;

    #[test]
    fn what_is_nearer_comes_first() {
        let steps = [f32::MIN, -3.0, -1e-30, -0.0, 0.0, 1e-30, 0.02, 0.5, f32::MAX];
        let places = steps.map(place_by_nearness);
        assert!(places.windows(2).all(|pair| pair[0] > pair[1]), "{places:?}");
    }

    #[test]
    fn what_lies_flat_is_held_by_a_flat_box_and_what_is_beside_the_eye_by_one_on_its_side() {
        let corners = [[-2.0, -1.0], [2.0, -1.0], [2.0, 1.0], [-2.0, 1.0]];
        let mesh = Mesh {
            positions: corners.map(|[x, z]| Vec3::new(x, 0.0, z)).into(),
            normals: vec![Vec3::y(); 4],
            uvs: vec![Vec2::zeros(); 4],
            triangles: vec![[0, 2, 1], [0, 3, 2]],
        };
        let (position, target) = (Vec3::new(0.0, 1.6, 6.0), Vec3::new(0.0, 1.6, 0.0));
        let camera = Camera { position, target, field_of_view: 0.8, near: 0.05, far: 1e3 };
        let view = Projection::camera(&camera, 800, 600);
        let clustered = ClusteredMesh::new(&mesh);
        let cluster = &clustered.full()[0];
        let at = |place: Vec3| {
            let transform = Affine { translation: place, ..Affine::identity() };
            let is_whole = view.holds(place, cluster.radius);
            (is_whole, seen_within(&view, cluster, &transform, is_whole).expect("before the eye"))
        };
        let (is_whole, [left, top, right, bottom]) = at(Vec3::zeros());
        for place in &cluster.positions {
            let seen = view.screen(view.map.point(*place));
            assert!(seen.x > left && seen.x < right && seen.y > top && seen.y < bottom);
        }
        assert!(is_whole && right - left < 700.0 && bottom - top < 0.3 * (right - left));
        // Below the horizon, which its sphere is not.
        assert!(
            top > 300.0 && view.tangent_bounds(Vec3::zeros(), cluster.radius).is_some_and(|[_, top, ..]| top < 300.0)
        );
        let (is_whole, [left, _, right, _]) = at(Vec3::new(3.5, 0.0, 5.5));
        assert!(!is_whole && left > 400.0 && right > 1e6, "{left} {right}");
    }
}
