//! One tile of the picture, from its clusters to encoded pixels.

use super::atmosphere::Ambient;
use super::backdrop::Backdrop;
use super::bins::Bins;
pub(super) use super::coverage::SIDE;
use super::coverage::{BLOCK, Background, Nearest};
use super::draw::{self, Corner, Placed, Scratch};
use super::projection::{Lens, composed};
use super::samples::{SUBPIXEL, pattern};
use super::{Prepared, shade};
use crate::base::vector::Affine;

/// Owner of a sample that shows the sky.
const SKY: u32 = u32::MAX;
/// Owner of a sample that shows the ground.
const GROUND: u32 = u32::MAX - 1;

/// A finished tile.
pub(super) struct Pixels {
    /// Encoded colours, row by row.
    pub colours: Vec<[u8; 3]>,
    /// Estimated squared antialiasing error, summed over pixels and channels; 0 with one sample, whose spread is unknown.
    pub squared_error: f64,
}

/// An item of which a triangle won a sample, with what shading it needs again and again.
pub(super) struct Visible {
    /// Number of the item.
    pub item: u32,
    /// From the item's model to the picture.
    pub map: Affine,
    /// The light from all sides at a small item's middle, once it is known.
    pub ambient: Option<Ambient>,
    /// What the air before a small item keeps of each channel's radiance and what it adds, once they are known.
    pub air: Option<[[f32; 2]; 3]>,
}

/// A triangle that won a sample at some time.
#[derive(Clone, Copy)]
struct Seen {
    /// Place in the list of visible items.
    visible: u32,
    triangle: u16,
}

/// Samples of one pixel that show the same thing.
#[derive(Clone, Copy)]
struct Group {
    key: u32,
    owner: u32,
    samples: u32,
    x: f32,
    y: f32,
}

/// What a task uses again from tile to tile.
pub(super) struct Workspace<const S: usize> {
    nearest: Nearest<S>,
    scratch: Scratch,
    visible: Vec<Visible>,
    seen: Vec<Seen>,
}

impl<const S: usize> Workspace<S> {
    /// Room for one tile.
    pub(super) fn new() -> Self {
        Self { nearest: Nearest::new(), scratch: Scratch::default(), visible: Vec::new(), seen: Vec::new() }
    }

    /// Draws the tile at a column and row of tiles.
    pub(super) fn draw(&mut self, prepared: &Prepared, bins: &Bins, column: usize, row: usize) -> Pixels {
        let corner = Corner { x: column * SIDE, y: row * SIDE };
        let Self { nearest, scratch, visible, seen } = self;
        nearest.clear(&background(prepared, corner));
        visible.clear();
        seen.clear();
        for &number in bins.tile(column, row) {
            let item = &bins.items[number as usize];
            if nearest.hides(corner.clip(item), item.nearness) {
                continue;
            }
            let transform = &prepared.instances[item.instance as usize].transform;
            let map = composed(&prepared.projection.map, transform);
            let placed = Placed {
                projection: &prepared.projection,
                map: &map,
                cluster: item.cluster_in(&prepared.meshes),
                two_sided: prepared.frame.materials[item.material as usize].two_sided,
                is_whole: item.is_whole,
            };
            draw::cluster(nearest, scratch, placed, corner, seen.len() as u32);
            if !scratch.won.is_empty() {
                let place = visible.len() as u32;
                seen.extend(scratch.won.iter().map(|&triangle| Seen { visible: place, triangle }));
                visible.push(Visible { item: number, map, ambient: None, air: None });
            }
        }
        resolve(prepared, bins, corner, nearest, seen, visible)
    }
}

/// The ground as a plane at height 0, whose nearness is linear over the picture; the sky above the horizon.
fn background(prepared: &Prepared, corner: Corner) -> Background {
    let projection = prepared.projection;
    debug_assert!(projection.lens == Lens::Perspective);
    if prepared.frame.ground.is_none() || projection.eye.y <= 0.0 {
        return Background { owner: GROUND, beyond: SKY, ..Background::default() };
    }
    // A ray (x, y, focal) in the camera's axes meets height 0 at the distance w where eye.y + w * slope = 0.
    let axes = projection.axes;
    let scale = -1.0 / (projection.pixels_per_metre * projection.eye.y);
    let (right, down) = (axes[(0, 1)] * scale, axes[(1, 1)] * scale);
    let (x, y) = (corner.x as f32 - projection.centre[0], corner.y as f32 - projection.centre[1]);
    let at = right * x + down * y - axes[(2, 1)] / projection.eye.y;
    Background { at, right, down, owner: GROUND, beyond: SKY }
}

fn resolve<const S: usize>(
    prepared: &Prepared,
    bins: &Bins,
    corner: Corner,
    nearest: &Nearest<S>,
    seen: &[Seen],
    visible: &mut [Visible],
) -> Pixels {
    let view = &prepared.frame.view;
    let offsets = pattern::<S>().map(|p| p.map(|step| step as f32 / SUBPIXEL as f32));
    let mut pixels = Pixels { colours: vec![[0; 3]; SIDE * SIDE], squared_error: 0.0 };
    let width = (view.width as usize - corner.x).min(SIDE);
    let height = (view.height as usize - corner.y).min(SIDE);
    let mut groups: Vec<Group> = Vec::with_capacity(S);
    for (top, left) in (0..height).step_by(BLOCK).flat_map(|y| (0..width).step_by(BLOCK).map(move |x| (y, x))) {
        let mut backdrop = Backdrop::new(prepared, [(corner.x + left) as f32, (corner.y + top) as f32]);
        let (right, bottom) = ((left + BLOCK).min(width), (top + BLOCK).min(height));
        for (y, x) in (top..bottom).flat_map(|y| (left..right).map(move |x| (y, x))) {
            let place = y * SIDE + x;
            collect(&mut groups, &nearest.owner[place], seen, &offsets);
            let mut shade = |group: &Group| {
                let share = 1.0 / group.samples as f32;
                let at = [(corner.x + x) as f32 + group.x * share, (corner.y + y) as f32 + group.y * share];
                let colour = match group.owner {
                    SKY => backdrop.sky(at),
                    GROUND => backdrop.ground(at),
                    owner => {
                        let Seen { visible: place, triangle } = seen[owner as usize];
                        shade::surface(prepared, bins, &mut visible[place as usize], triangle, at)
                    }
                };
                colour.map(|value| value * view.exposure)
            };
            let mean = match groups.as_slice() {
                [group] => shade(group),
                groups => {
                    let (mean, squared_error) = mean::<S>(groups, shade);
                    pixels.squared_error += squared_error;
                    mean
                }
            };
            pixels.colours[place] = prepared.tone.encode_at(mean, corner.x + x, corner.y + y);
        }
    }
    pixels
}

/// The mean colour of a pixel's groups, and the squared error that it has if its samples are independent, summed over the
/// channels.
fn mean<const S: usize>(groups: &[Group], mut shade: impl FnMut(&Group) -> [f32; 3]) -> ([f32; 3], f64) {
    let count = S as f32;
    let mut sum = [0.0f32; 3];
    let mut squares = [0.0f32; 3];
    for group in groups {
        let (colour, weight) = (shade(group), group.samples as f32);
        for k in 0..3 {
            sum[k] += colour[k] * weight;
            squares[k] += colour[k] * colour[k] * weight;
        }
    }
    let mean = sum.map(|s| s / count);
    let spread = |k: usize| (squares[k] - mean[k] * mean[k] * count).max(0.0) / ((count - 1.0) * count);
    (mean, (0..3).map(|k| f64::from(spread(k))).sum())
}

/// Gathers the samples of a pixel by what they show: a cluster is shaded once, at the middle of its samples.
fn collect<const S: usize>(groups: &mut Vec<Group>, owners: &[u32; S], seen: &[Seen], offsets: &[[f32; 2]; S]) {
    groups.clear();
    if owners.iter().all(|owner| *owner == owners[0]) {
        let (x, y) = offsets.iter().fold((0.0, 0.0), |(x, y), offset| (x + offset[0], y + offset[1]));
        groups.push(Group { key: 0, owner: owners[0], samples: S as u32, x, y });
        return;
    }
    for (owner, offset) in owners.iter().zip(offsets) {
        let key = if *owner >= GROUND { *owner } else { seen[*owner as usize].visible };
        match groups.iter_mut().find(|group| group.key == key) {
            Some(group) => {
                group.samples += 1;
                group.x += offset[0];
                group.y += offset[1];
            }
            None => groups.push(Group { key, owner: *owner, samples: 1, x: offset[0], y: offset[1] }),
        }
    }
}
