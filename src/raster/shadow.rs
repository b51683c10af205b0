//! The sun's view of the scene as a map of distances (Williams 1978), with a penumbra as wide as the sun's disc makes it.

use super::bins::Bins;
use super::cluster::ClusteredMesh;
use super::coverage::{Nearest, SIDE};
use super::draw::{self, Corner, Placed, Scratch};
use super::last::Same;
use super::projection::{Projection, composed};
use super::reads::Reads;
use super::rooms::Rooms;
use crate::base::maths::{floor_to_i32, sincosf};
use crate::base::random::hash;
use crate::base::vector::Vec3;
use crate::frame::Frame;
use rayon::prelude::*;
use std::f32::consts::TAU;
use std::sync::Arc;

/// Error in texels that a coarser level of a mesh may make: the penumbra is wider.
const LOD_ERROR: f32 = 1.5;
/// Places looked up for one shadow.
const TAPS: usize = 12;
/// Radius of the penumbra a metre of distance to what casts the shadow: the sun's angular radius, 0.265 degrees.
const SUN_RADIUS: f32 = 0.004_63;
/// Different turns of the taps.
const TURNS: usize = 64;
/// Texels along one side of a block: about as wide as what is searched for the edge of a shadow.
const BLOCK: usize = 8;
/// Blocks along one side of a tile.
const BLOCKS: usize = SIDE / BLOCK;
/// Turn between successive taps of a Vogel spiral (the golden angle).
const GOLDEN_ANGLE: f32 = 2.399_963;

/// The nearest distance to the sun over a square of the world.
pub(super) struct ShadowMap {
    projection: Projection,
    size: usize,
    /// What each tile holds, where the map may serve the next frame, and how many tiles are in a row.
    bins: Option<Bins>,
    columns: usize,
    /// The tiles, row by row; empty where nothing stands.
    tiles: Vec<Arc<[f32]>>,
    /// The largest nearness in each block of texels, row by row: where it is below a point's, nothing shades the point.
    nearest_in_blocks: Vec<f32>,
    /// Where the taps lie in a disc of radius 1, in each of their turns.
    turns: Vec<[[f32; 2]; TAPS]>,
}

impl ShadowMap {
    /// Draws the map, but for tiles that are the same in the map of the last frame; `None` without sun, without instances or with a
    /// size of 0.
    pub(super) fn new(
        frame: &Frame,
        meshes: &[Arc<ClusteredMesh>],
        same: Option<&Same>,
        is_kept: bool,
    ) -> Option<Self> {
        let size = frame.view.shadow_size as usize;
        let dark = frame.sun.irradiance.iter().all(|&e| e <= 0.0) || frame.sun.direction.y <= 0.0;
        if size == 0 || dark {
            return None;
        }
        let (centre, radius) = bounding_sphere(frame, meshes)?;
        let projection = Projection::parallel(-frame.sun.direction, centre, radius * 1.01, size as u32);
        let bins = Bins::new(frame, &frame.instances, meshes, &projection, [size as u32; 2], LOD_ERROR);
        let last = same.and_then(|same| Some((same, same.shadow()?)));
        let last = last.filter(|(_, map)| map.size == size && map.projection == projection);
        let rooms = Rooms::new(|| (Nearest::<1>::new(), Scratch::default()));
        let tile = |number: usize| {
            let known = last.filter(|(same, map)| {
                map.bins.as_ref().is_some_and(|known| same.is_shadow_tile([&bins, known], number))
            });
            if let Some((_, map)) = known {
                return map.tiles[number].clone();
            }
            let (column, row) = (number % bins.columns, number / bins.columns);
            if bins.tile(column, row).is_empty() {
                return Arc::from([]);
            }
            rooms.with(|(nearest, scratch)| {
                draw_tile(nearest, scratch, (frame, meshes, &projection, &bins), column, row);
                Arc::from(nearest.nearness.as_flattened())
            })
        };
        let tiles: Vec<Arc<[f32]>> = (0..bins.rows * bins.columns).into_par_iter().with_max_len(1).map(tile).collect();
        let nearest_in_blocks = nearest_in_blocks(&tiles, bins.columns);
        let (columns, bins) = (bins.columns, is_kept.then_some(bins));
        Some(Self { projection, size, bins, columns, tiles, nearest_in_blocks, turns: turns() })
    }

    /// The largest nearness, in either map, of what is not the same in each tile of another map of the same places; none where the
    /// maps are not of the same places.
    pub(super) fn changes(&self, other: &Self) -> Option<Vec<f32>> {
        let is_alike = self.size == other.size && self.projection == other.projection;
        let tiles = self.tiles.par_iter().zip(&other.tiles);
        is_alike.then(|| tiles.map(|(now, then)| largest_change(now, then)).collect())
    }

    /// The lit share at a point of a surface with this unit normal; `salt` turns the taps, so that neighbouring pixels
    /// do not repeat a pattern. What it takes is noted.
    pub(super) fn lit(&self, point: Vec3, normal: Vec3, salt: u64, reads: &mut Reads) -> f32 {
        let texel = 1.0 / self.projection.pixels_per_metre;
        let lifted = point + normal * (1.5 * texel);
        let screen = self.projection.screen(self.projection.map.point(lifted));
        let nearness = screen.nearness + 0.5 * texel;
        let search = (4.0 * SUN_RADIUS * self.projection.pixels_per_metre).max(1.0);
        self.note([screen.x, screen.y], search, nearness, reads);
        if !self.may_be_shaded([screen.x, screen.y], search, nearness) {
            return 1.0;
        }
        reads.salt = true;
        let turned = &self.turns[hash(salt, 0) as usize % TURNS];
        let centre = [screen.x, screen.y];
        // A first look finds how far what casts the shadow is; that sets the penumbra of the second.
        let (mut count, mut gap) = (0.0f32, 0.0f32);
        self.each(turned.iter().step_by(2), (centre, search), |found| {
            let above = found - nearness;
            if above > 0.0 {
                count += 1.0;
                gap += above;
            }
        });
        if count == 0.0 {
            return 1.0;
        }
        let radius = (gap / count * SUN_RADIUS * self.projection.pixels_per_metre).clamp(0.7, 40.0);
        self.note(centre, radius, nearness, reads);
        let mut lit = 0u32;
        self.each(turned.iter(), (centre, radius), |found| lit += u32::from(found <= nearness));
        lit as f32 / TAPS as f32
    }

    /// Looks up the nearness at each of some taps of a disc, in their order.
    #[inline(always)]
    fn each<'a>(
        &self,
        taps: impl Iterator<Item = &'a [f32; 2]>,
        (centre, radius): ([f32; 2], f32),
        mut look: impl FnMut(f32),
    ) {
        match self.alone(centre, radius) {
            // Nothing but places in the tile is asked for, so that its corner needs no taking off.
            Some(Some(tile)) => {
                for tap in taps {
                    let [x, y] = [0, 1].map(|axis| floor_to_i32(centre[axis] + tap[axis] * radius) as usize % SIDE);
                    look(tile[y * SIDE + x]);
                }
            }
            Some(None) => taps.for_each(|_| look(f32::MIN)),
            None => taps.for_each(|tap| look(self.at(centre, tap, radius))),
        }
    }

    /// The texels of the tile that holds a disc, none in it where nothing stands there; none where the disc lies in several
    /// or beside the map.
    #[inline(always)]
    fn alone(&self, centre: [f32; 2], radius: f32) -> Option<Option<&[f32; SIDE * SIDE]>> {
        let tiles = |place: f32| {
            let ends = [place - radius, place + radius];
            let is_within = ends[0] >= 0.0 && ends[1] < self.size as f32;
            let [first, last] = ends.map(|end| end as usize / SIDE);
            (is_within && first == last).then_some(first)
        };
        let (column, row) = (tiles(centre[0])?, tiles(centre[1])?);
        Some(self.tiles[row * self.columns + column].first_chunk())
    }

    /// Notes the tiles within `reach` texels of a place; beside the map, those at its rim.
    #[inline(always)]
    fn note(&self, [x, y]: [f32; 2], reach: f32, nearness: f32, reads: &mut Reads) {
        let tile = |place: f32| ((place / SIDE as f32) as i32).clamp(0, self.columns as i32 - 1) as usize;
        let (left, right) = (tile(x - reach), tile(x + reach));
        for row in tile(y - reach)..=tile(y + reach) {
            for column in left..=right {
                reads.note_shadow(row * self.columns + column, nearness);
            }
        }
    }

    /// Whether something nearer to the sun than `nearness` lies within `reach` texels of a place.
    fn may_be_shaded(&self, [x, y]: [f32; 2], reach: f32, nearness: f32) -> bool {
        let width = self.columns * BLOCKS;
        let block = |place: f32| ((place / BLOCK as f32) as i32).clamp(0, width as i32 - 1) as usize;
        let (columns, rows) = (block(x - reach)..=block(x + reach), block(y - reach)..=block(y + reach));
        rows.into_iter()
            .any(|row| columns.clone().any(|column| self.nearest_in_blocks[row * width + column] > nearness))
    }

    /// The nearness at a tap of a disc; what lies beside the map is never near.
    #[inline(always)]
    fn at(&self, [x, y]: [f32; 2], tap: &[f32; 2], radius: f32) -> f32 {
        let (x, y) = (floor_to_i32(x + tap[0] * radius), floor_to_i32(y + tap[1] * radius));
        // A negative place is a large one.
        let (x, y) = (x as u32 as usize, y as u32 as usize);
        if x >= self.size || y >= self.size {
            return f32::MIN;
        }
        let tile = &self.tiles[y / SIDE * self.columns + x / SIDE];
        tile.get(y % SIDE * SIDE + x % SIDE).copied().unwrap_or(f32::MIN)
    }
}

/// Places that fill a disc of radius 1 evenly, a Vogel spiral, in each of some even turns of it.
fn turns() -> Vec<[[f32; 2]; TAPS]> {
    let place = |turn: usize, index: usize| {
        let angle = GOLDEN_ANGLE * index as f32 + turn as f32 / TURNS as f32 * TAU;
        let (sine, cosine) = sincosf(angle);
        let radius = ((index as f32 + 0.5) / TAPS as f32).sqrt();
        [cosine * radius, sine * radius]
    };
    (0..TURNS).map(|turn| std::array::from_fn(|index| place(turn, index))).collect()
}

/// The largest nearness of texels that are not the same in two tiles, each empty where nothing stands.
fn largest_change(now: &Arc<[f32]>, then: &Arc<[f32]>) -> f32 {
    if Arc::ptr_eq(now, then) {
        return f32::MIN;
    }
    let larger = |a: f32, b: f32| if b > a { b } else { a };
    let change = |(now, then): (&f32, &f32)| if now == then { f32::MIN } else { larger(*now, *then) };
    match (now.is_empty(), then.is_empty()) {
        (false, false) => now.iter().zip(then.iter()).map(change).fold(f32::MIN, larger),
        _ => now.iter().chain(then.iter()).copied().fold(f32::MIN, larger),
    }
}

/// The largest nearness in each block of all tiles, row by row.
fn nearest_in_blocks(tiles: &[Arc<[f32]>], columns: usize) -> Vec<f32> {
    let width = columns * BLOCKS;
    let mut nearest = vec![f32::MIN; tiles.len() * BLOCKS * BLOCKS];
    nearest.par_chunks_mut(width * BLOCKS).zip(tiles.par_chunks(columns)).for_each(|(nearest, tiles)| {
        for (column, tile) in tiles.iter().enumerate() {
            for (y, row) in tile.chunks(SIDE).enumerate() {
                for (x, texels) in row.chunks(BLOCK).enumerate() {
                    let nearest = &mut nearest[y / BLOCK * width + column * BLOCKS + x];
                    *nearest = texels.iter().fold(*nearest, |a, &b| if b > a { b } else { a });
                }
            }
        }
    });
    nearest
}

fn draw_tile(
    nearest: &mut Nearest<1>,
    scratch: &mut Scratch,
    (frame, meshes, projection, bins): (&Frame, &[Arc<ClusteredMesh>], &Projection, &Bins),
    column: usize,
    row: usize,
) {
    let corner = Corner { x: column * SIDE, y: row * SIDE };
    nearest.fill(f32::MIN, 0);
    for &number in bins.tile(column, row) {
        let item = &bins.items[number as usize];
        if nearest.hides(corner.clip(item), item.nearness) {
            continue;
        }
        let map = composed(&projection.map, &frame.instances[item.instance as usize].transform);
        let placed =
            Placed { projection, map: &map, cluster: item.cluster_in(meshes), two_sided: true, is_whole: true };
        draw::cluster(nearest, scratch, placed, corner, 0);
    }
}

/// A sphere about everything that stands in the frame; what has fallen far away gives no shadow and takes no detail.
fn bounding_sphere(frame: &Frame, meshes: &[Arc<ClusteredMesh>]) -> Option<(Vec3, f32)> {
    let mut spheres = frame.standing().iter().flat_map(|instance| {
        let scale = instance.transform.linear.column(0).norm();
        frame.models[instance.model as usize].parts.iter().flat_map(move |part| {
            let clusters = meshes[part.mesh as usize].full();
            clusters.iter().map(move |c| (instance.transform.point(c.centre), c.radius * scale))
        })
    });
    let (first, radius) = spheres.next()?;
    let around = |r: f32| Vec3::repeat(r);
    let start = (first - around(radius), first + around(radius));
    let (low, high) =
        spheres.fold(start, |(low, high), (c, r)| (low.inf(&(c - around(r))), high.sup(&(c + around(r)))));
    Some(((low + high) * 0.5, (high - low).norm() * 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::hash_unit;

    #[test]
    fn taps_in_one_tile_are_those_of_the_whole_map() {
        // Two by two tiles of uneven nearness, the last of them empty.
        let texel = |tile: u64| move |place: u64| hash_unit(tile, place);
        let tiles = (0..4u64).map(|tile| match tile {
            3 => Arc::from([]),
            _ => (0..(SIDE * SIDE) as u64).map(texel(tile)).collect(),
        });
        let map = ShadowMap {
            projection: Projection::parallel(-Vec3::y(), Vec3::zeros(), 1.0, 2 * SIDE as u32),
            size: 2 * SIDE,
            bins: None,
            columns: 2,
            tiles: tiles.collect(),
            nearest_in_blocks: Vec::new(),
            turns: turns(),
        };
        let mut alone = [0; 3];
        for step in 0..2000u64 {
            let place = |axis: u64| -6.0 + 140.0 * hash_unit(step, axis);
            let (centre, radius) = ([place(1), place(2)], 0.7 + 20.0 * hash_unit(step, 3));
            let taps = &map.turns[step as usize % TURNS];
            let mut found = Vec::new();
            map.each(taps.iter(), (centre, radius), |nearness| found.push(nearness));
            let expected: Vec<f32> = taps.iter().map(|tap| map.at(centre, tap, radius)).collect();
            assert_eq!(found, expected, "{centre:?} {radius}");
            alone[match map.alone(centre, radius) {
                Some(Some(_)) => 0,
                Some(None) => 1,
                None => 2,
            }] += 1;
        }
        assert!(alone.iter().all(|count| *count > 100), "{alone:?}");
    }
}
