//! Clusters sorted into the tiles that they may touch.

use super::cluster::{Cluster, ClusteredMesh};
use super::coverage::SIDE;
use super::projection::Projection;
use crate::base::vector::Vec3;
use crate::frame::{Frame, Instance};
use rayon::prelude::*;
use std::sync::Arc;

/// How much larger the error of a coarser level may be where leaves lie on the ground: they are seen along it, a few pixels
/// high, and thousands lie on one another.
const LYING_ERROR: f32 = 4.0;
/// Parts of lying leaves that are thinner than this are left out, pixels: stalks.
const THINNEST: f32 = 0.2;
/// Instances that one task bins; fixed, so that the order of items does not depend on the threads.
const CHUNK: usize = 1024;

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
    /// Box of pixels that holds it: left, top, right, bottom, inclusive.
    pub bounds: [i32; 4],
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
    /// Rows of tiles.
    pub rows: usize,
    /// All items that touch the picture.
    pub items: Vec<Item>,
    tiles: Vec<Vec<u32>>,
}

impl Bins {
    /// Bins instances of a frame's models for a picture of `size` pixels. Meshes are taken in the coarsest level that is
    /// within `lod_error` pixels.
    pub(super) fn new(
        frame: &Frame,
        instances: &[Instance],
        meshes: &[Arc<ClusteredMesh>],
        projection: &Projection,
        size: [u32; 2],
        lod_error: f32,
    ) -> Self {
        let [width, height] = size;
        let (columns, rows) = ((width as usize).div_ceil(SIDE), (height as usize).div_ceil(SIDE));
        let limits = [width as i32 - 1, height as i32 - 1];
        let fallen = frame.standing().len()..frame.instances.len();
        let chunks: Vec<Vec<Item>> = instances
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, instances)| {
                let mut items = Vec::new();
                for (offset, instance) in instances.iter().enumerate() {
                    let number = (chunk * CHUNK + offset) as u32;
                    let is_fallen = fallen.contains(&(number as usize)) && lod_error > 0.0;
                    let detail = if is_fallen { [lod_error * LYING_ERROR, THINNEST] } else { [lod_error, 0.0] };
                    push_items(frame, meshes, projection, detail, limits, (number, instance), &mut items);
                }
                items
            })
            .collect();
        let items = chunks.concat();
        let mut tiles = vec![Vec::new(); columns * rows];
        for (number, item) in items.iter().enumerate() {
            let [left, top, right, bottom] = item.bounds.map(|edge| edge as usize / SIDE);
            for row in top..=bottom {
                for column in left..=right {
                    tiles[row * columns + column].push(number as u32);
                }
            }
        }
        let nearest_first =
            |a: &u32, b: &u32| items[*b as usize].nearness.total_cmp(&items[*a as usize].nearness).then(a.cmp(b));
        tiles.par_iter_mut().for_each(|tile: &mut Vec<u32>| tile.sort_unstable_by(nearest_first));
        Self { columns, rows, items, tiles }
    }

    /// Whether a tile, by its number, holds the same items in the same order as it does in other bins.
    pub(super) fn holds_as(&self, other: &Self, tile: usize, is_same: impl Fn(&Item, &Item) -> bool) -> bool {
        let (Some(these), Some(others)) = (self.tiles.get(tile), other.tiles.get(tile)) else { return false };
        let items =
            |(this, other_one): (&u32, &u32)| is_same(&self.items[*this as usize], &other.items[*other_one as usize]);
        these.len() == others.len() && these.iter().zip(others).all(items)
    }

    /// The items of a tile, nearest first, ties by number.
    pub(super) fn tile(&self, column: usize, row: usize) -> &[u32] {
        &self.tiles[row * self.columns + column]
    }
}

fn push_items(
    frame: &Frame,
    meshes: &[Arc<ClusteredMesh>],
    projection: &Projection,
    [lod_error, thinnest]: [f32; 2],
    limits: [i32; 2],
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
            let [left, top, right, bottom] = bounds.map(|edge| edge.floor() as i32);
            if right < 0 || bottom < 0 || left > limits[0] || top > limits[1] {
                continue;
            }
            items.push(Item {
                instance: number,
                mesh: part.mesh,
                material: part.material,
                level: level as u16,
                cluster: cluster_number as u32,
                nearness,
                pixel: projection.least_metres(centre, cluster.radius * scale) / scale.max(1e-12),
                is_whole: projection.holds(centre, cluster.radius * scale),
                bounds: [left.max(0), top.max(0), right.min(limits[0]), bottom.min(limits[1])],
            });
        }
    }
}
