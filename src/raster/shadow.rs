//! The sun's view of the scene as a map of distances (Williams 1978), with a penumbra as wide as the sun's disc makes it.

use super::bins::{Bins, tiles_across};
use super::cluster::ClusteredMesh;
use super::coverage::{Nearest, SIDE};
use super::draw::{self, Corner, Placed, Scratch};
use super::last::{Same, are_tiles_kept};
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
/// Places looked up for one shadow, and for how far it falls.
const TAPS: usize = 12;
const FIRST: usize = TAPS / 2;
/// Radius of the penumbra a metre of distance to what casts the shadow: the sun's angular radius, 0.265 degrees.
const SUN_RADIUS: f32 = 0.004_63;
/// Different turns of the taps.
const TURNS: usize = 64;
/// Texels along one side of a block: about as wide as what is searched for the edge of a shadow.
const BLOCK: usize = 8;
/// Blocks along one side of a tile.
const BLOCKS: usize = SIDE / BLOCK;
/// Rows of tiles that are binned at once where there are too many instances for all.
const STRIP: usize = 8;
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
    /// The least nearness in each: where it is above a point's all around, the point is in full shadow.
    farthest_in_blocks: Vec<f32>,
    /// Where the taps lie in a disc of radius 1, in each of their turns.
    turns: Vec<Turn>,
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
        let columns = tiles_across(size as u32);
        // Of a million leaves the items of all tiles would stand beside those of the picture.
        let at_once = if are_tiles_kept(frame.instances.len()) { columns } else { STRIP };
        let last = same.and_then(|same| Some((same, same.shadow()?)));
        let last = last.filter(|(_, map)| map.size == size && map.projection == projection && at_once == columns);
        let rooms = Rooms::new(|| (Nearest::<1>::new(), Scratch::default()));
        let (mut tiles, mut kept) = (Vec::with_capacity(columns * columns), None);
        for first in (0..columns).step_by(at_once) {
            let part = ([size as u32; 2], first..(first + at_once).min(columns));
            let bins = Bins::new(frame, &frame.instances, meshes, &projection, part, LOD_ERROR);
            let tile = |(number, [column, row]): (usize, [usize; 2])| {
                let known = last.filter(|(same, map)| {
                    map.bins.as_ref().is_some_and(|known| same.is_shadow_tile([&bins, known], number))
                });
                if let Some((_, map)) = known {
                    return map.tiles[number].clone();
                }
                if bins.tile(column, row).is_empty() {
                    return Arc::from([]);
                }
                rooms.with(|(nearest, scratch)| {
                    draw_tile(nearest, scratch, (frame, meshes, &projection, &bins), column, row);
                    Arc::from(nearest.nearness.as_flattened())
                })
            };
            tiles.par_extend(bins.places().into_par_iter().enumerate().with_max_len(1).map(tile));
            kept = is_kept.then_some(bins);
        }
        let [farthest_in_blocks, nearest_in_blocks] = by_blocks(&tiles, columns);
        Some(Self {
            projection,
            size,
            bins: kept,
            columns,
            tiles,
            nearest_in_blocks,
            farthest_in_blocks,
            turns: turns(),
        })
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
        let centre = [screen.x, screen.y];
        self.note(centre, search, nearness, reads);
        let nearest = self.largest_in_blocks(&self.nearest_in_blocks, centre, search);
        if nearest <= nearness {
            return 1.0;
        }
        let penumbra = |gap: f32| (gap * SUN_RADIUS * self.projection.pixels_per_metre).clamp(0.7, 40.0);
        // Where everything within the widest penumbra lies nearer to the sun, every tap finds it so; none does beside the map.
        let widest = penumbra(nearest - nearness).max(search);
        let is_within = centre.iter().all(|&place| place - widest >= 0.0 && place + widest < self.size as f32);
        let is_beyond = |row: &[f32]| row.iter().all(|&farthest| farthest > nearness);
        if is_within && self.in_blocks(&self.farthest_in_blocks, centre, widest).all(is_beyond) {
            self.note(centre, widest, nearness, reads);
            return 0.0;
        }
        reads.salt = true;
        let turned = &self.turns[hash(salt, 0) as usize % TURNS];
        // A first look finds how far what casts the shadow is; that sets the penumbra of the second.
        let (mut count, mut gap) = (0.0f32, 0.0f32);
        for found in &self.found(&turned.first, centre, search) {
            let above = found - nearness;
            if above > 0.0 {
                count += 1.0;
                gap += above;
            }
        }
        if count == 0.0 {
            return 1.0;
        }
        let radius = penumbra(gap / count);
        if radius > search {
            self.note(centre, radius, nearness, reads);
        }
        let lit: u32 = self.found(&turned.all, centre, radius).iter().map(|&found| u32::from(found <= nearness)).sum();
        lit as f32 / TAPS as f32
    }

    /// The nearness at each of some taps of a disc.
    #[inline(always)]
    fn found<const N: usize>(&self, taps: &Taps<N>, centre: [f32; 2], radius: f32) -> [f32; N] {
        match self.alone(centre, radius) {
            Some(Some(tile)) => {
                // Nothing but places in the tile is asked for, so that its corner needs no taking off and no place is below 0.
                let mut places = [0i32; N];
                for (k, place) in places.iter_mut().enumerate() {
                    let column = (centre[0] + taps.0[0][k] * radius) as i32 & (SIDE as i32 - 1);
                    let row = (centre[1] + taps.0[1][k] * radius) as i32 & (SIDE as i32 - 1);
                    *place = row * SIDE as i32 + column;
                }
                let mut found = [0.0; N];
                for (found, place) in found.iter_mut().zip(&places) {
                    *found = tile[*place as usize & (SIDE * SIDE - 1)];
                }
                found
            }
            Some(None) => [f32::MIN; N],
            None => std::array::from_fn(|k| self.at(centre, taps.0.map(|axis| axis[k]), radius)),
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
        for row in tile(y - reach)..tile(y + reach) + 1 {
            for column in left..right + 1 {
                reads.note_shadow(row * self.columns + column, nearness);
            }
        }
    }

    /// The rows of blocks within `reach` texels of a place, each by what is `told` of its blocks; beside the map, of those at its
    /// rim.
    #[inline(always)]
    fn in_blocks<'a>(&self, told: &'a [f32], [x, y]: [f32; 2], reach: f32) -> impl Iterator<Item = &'a [f32]> {
        let width = self.columns * BLOCKS;
        let block = |place: f32| ((place / BLOCK as f32) as i32).clamp(0, width as i32 - 1) as usize;
        let (left, right) = (block(x - reach), block(x + reach) + 1);
        (block(y - reach)..block(y + reach) + 1).map(move |row| &told[row * width + left..row * width + right])
    }

    /// The largest of what is told of the blocks within `reach` texels of a place.
    #[inline(always)]
    fn largest_in_blocks(&self, told: &[f32], centre: [f32; 2], reach: f32) -> f32 {
        let mut largest = f32::MIN;
        for row in self.in_blocks(told, centre, reach) {
            for &one in row {
                largest = larger(largest, one);
            }
        }
        largest
    }

    /// The nearness at a tap of a disc; what lies beside the map is never near.
    #[inline(always)]
    fn at(&self, [x, y]: [f32; 2], tap: [f32; 2], radius: f32) -> f32 {
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

/// Places in a disc of radius 1, by their axes.
struct Taps<const N: usize>([[f32; N]; 2]);

/// Places that fill a disc of radius 1 evenly, a Vogel spiral.
struct Turn {
    all: Taps<TAPS>,
    /// Every second of them.
    first: Taps<FIRST>,
}

/// The taps in each of some even turns of the disc.
fn turns() -> Vec<Turn> {
    let place = |turn: usize, index: usize| {
        let angle = GOLDEN_ANGLE * index as f32 + turn as f32 / TURNS as f32 * TAU;
        let (sine, cosine) = sincosf(angle);
        let radius = ((index as f32 + 0.5) / TAPS as f32).sqrt();
        [cosine * radius, sine * radius]
    };
    let turn = |turn: usize| Turn {
        all: Taps([0, 1].map(|axis| std::array::from_fn(|index| place(turn, index)[axis]))),
        first: Taps([0, 1].map(|axis| std::array::from_fn(|index| place(turn, 2 * index)[axis]))),
    };
    (0..TURNS).map(turn).collect()
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// The largest nearness of texels that are not the same in two tiles, each empty where nothing stands.
fn largest_change(now: &Arc<[f32]>, then: &Arc<[f32]>) -> f32 {
    if Arc::ptr_eq(now, then) {
        return f32::MIN;
    }
    let change = |(now, then): (&f32, &f32)| if now == then { f32::MIN } else { larger(*now, *then) };
    match (now.is_empty(), then.is_empty()) {
        (false, false) => now.iter().zip(then.iter()).map(change).fold(f32::MIN, larger),
        _ => now.iter().chain(then.iter()).copied().fold(f32::MIN, larger),
    }
}

/// The least and the largest nearness in each block of all tiles, row by row.
fn by_blocks(tiles: &[Arc<[f32]>], columns: usize) -> [Vec<f32>; 2] {
    let width = columns * BLOCKS;
    let [mut farthest, mut nearest] = [0, 1].map(|_| vec![f32::MIN; tiles.len() * BLOCKS * BLOCKS]);
    let rows = farthest.par_chunks_mut(width * BLOCKS).zip(nearest.par_chunks_mut(width * BLOCKS));
    rows.zip(tiles.par_chunks(columns)).for_each(|((farthest, nearest), tiles)| {
        for (column, tile) in tiles.iter().enumerate() {
            for (y, rows) in tile.chunks_exact(BLOCK * SIDE).enumerate() {
                for x in 0..BLOCKS {
                    // Column by column of the block first, which takes a register.
                    let (mut low, mut high) = ([f32::MAX; BLOCK], [f32::MIN; BLOCK]);
                    for row in rows.chunks_exact(SIDE) {
                        for (k, &texel) in row[x * BLOCK..][..BLOCK].iter().enumerate() {
                            (low[k], high[k]) = (smaller(low[k], texel), larger(high[k], texel));
                        }
                    }
                    let block = y * width + column * BLOCKS + x;
                    farthest[block] = low.into_iter().fold(f32::MAX, smaller);
                    nearest[block] = high.into_iter().fold(f32::MIN, larger);
                }
            }
        }
    });
    [farthest, nearest]
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
    fn blocks_tell_of_shadow_and_light_what_all_taps_tell() {
        // Plates of several heights with holes between them, over 128 texels of 2 metres.
        let texel = |tile: u64, place: u64| {
            let (x, y) = (place % SIDE as u64 + tile % 2 * SIDE as u64, place / SIDE as u64 + tile / 2 * SIDE as u64);
            let is_hole = hash_unit(x / 3 + 1000 * (y / 3), 5) < 0.01;
            if is_hole { f32::MIN } else { hash_unit(x / 20 + 1000 * (y / 20), 6) }
        };
        let tiles = (0..4).map(|tile| (0..(SIDE * SIDE) as u64).map(|place| texel(tile, place)).collect());
        let tiles: Vec<Arc<[f32]>> = tiles.collect();
        let [farthest_in_blocks, nearest_in_blocks] = by_blocks(&tiles, 2);
        let mut map = ShadowMap {
            projection: Projection::parallel(-Vec3::y(), Vec3::zeros(), 1.0, 2 * SIDE as u32),
            size: 2 * SIDE,
            bins: None,
            columns: 2,
            tiles,
            nearest_in_blocks,
            farthest_in_blocks,
            turns: turns(),
        };
        let lit = |map: &ShadowMap| -> Vec<(f32, bool)> {
            let one = |step: u64| {
                let place = [0, 1, 2].map(|axis| 2.2 * hash_unit(step, axis) - 1.1);
                let mut reads = Reads::default();
                (map.lit(Vec3::from(place), Vec3::y(), step, &mut reads), reads.salt)
            };
            (0..4000).map(one).collect()
        };
        let by_the_blocks = lit(&map);
        map.farthest_in_blocks.fill(f32::MIN);
        map.nearest_in_blocks.fill(f32::MAX);
        let by_taps = lit(&map);
        let is_told =
            |share: f32| by_the_blocks.iter().zip(&by_taps).filter(|(told, _)| !told.1 && told.0 == share).count();
        assert!(by_the_blocks.iter().zip(&by_taps).all(|(told, tapped)| told.0 == tapped.0));
        assert!(is_told(0.0) > 100 && is_told(1.0) > 100, "{} {}", is_told(0.0), is_told(1.0));
    }

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
            farthest_in_blocks: Vec::new(),
            turns: turns(),
        };
        let mut alone = [0; 3];
        for step in 0..2000u64 {
            let place = |axis: u64| -6.0 + 140.0 * hash_unit(step, axis);
            let (centre, radius) = ([place(1), place(2)], 0.7 + 20.0 * hash_unit(step, 3));
            let taps = &map.turns[step as usize % TURNS].all;
            let found = map.found(taps, centre, radius);
            let expected = std::array::from_fn(|k| map.at(centre, taps.0.map(|axis| axis[k]), radius));
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
