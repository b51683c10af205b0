//! One tile of the picture, from its clusters to encoded pixels.

use super::bins::Bins;
use super::coverage::Nearest;
pub(super) use super::coverage::SIDE;
use super::draw::{self, Corner, Placed, Scratch};
use super::projection::Lens;
use super::samples::{SUBPIXEL, pattern};
use super::{Prepared, shade};
use crate::frame::Frame;

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

/// A triangle that won a sample at some time.
#[derive(Clone, Copy)]
struct Seen {
    item: u32,
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

/// Draws the tile at a column and row of tiles.
pub(super) fn draw<const S: usize>(prepared: &Prepared, bins: &Bins, column: usize, row: usize) -> Pixels {
    let corner = Corner { x: column * SIDE, y: row * SIDE };
    let mut nearest = Nearest::<S>::new(background(prepared, corner));
    let mut seen: Vec<Seen> = Vec::new();
    let mut scratch = Scratch::default();
    for &number in bins.tile(column, row) {
        let item = &bins.items[number as usize];
        if nearest.hides(corner.clip(item), item.nearness) {
            continue;
        }
        let cluster = item.cluster_in(&prepared.meshes);
        let transform = &prepared.instances[item.instance as usize].transform;
        let two_sided = prepared.frame.materials[item.material as usize].two_sided;
        let mut visit = |triangle: u16, draw: &mut dyn FnMut(u32) -> bool| {
            if draw(seen.len() as u32) {
                seen.push(Seen { item: number, triangle });
            }
        };
        let placed = Placed { projection: &prepared.projection, transform, cluster, two_sided };
        draw::cluster(&mut nearest, &mut scratch, placed, corner, &mut visit);
    }
    resolve(prepared, bins, corner, &nearest, &seen)
}

/// The ground as a plane at height 0, whose nearness is linear over the picture; the sky above the horizon.
fn background(prepared: &Prepared, corner: Corner) -> impl Fn(f32, f32) -> (f32, u32) {
    let projection = prepared.projection;
    let has_ground = prepared.frame.ground.is_some() && projection.eye.y > 0.0;
    debug_assert!(projection.lens == Lens::Perspective);
    // A ray (x, y, focal) in the camera's axes meets height 0 at the distance w where eye.y + w * slope = 0.
    let axes = projection.axes;
    let (right, down, forward) = (axes[(0, 1)], axes[(1, 1)], axes[(2, 1)]);
    move |x, y| {
        let dx = (x + corner.x as f32 - projection.centre[0]) / projection.pixels_per_metre;
        let dy = (y + corner.y as f32 - projection.centre[1]) / projection.pixels_per_metre;
        let slope = right * dx + down * dy + forward;
        if has_ground && slope < -1e-6 { (-slope / projection.eye.y, GROUND) } else { (0.0, SKY) }
    }
}

fn resolve<const S: usize>(
    prepared: &Prepared,
    bins: &Bins,
    corner: Corner,
    nearest: &Nearest<S>,
    seen: &[Seen],
) -> Pixels {
    let frame: &Frame = prepared.frame;
    let offsets = pattern::<S>().map(|p| p.map(|step| step as f32 / SUBPIXEL as f32));
    let mut pixels = Pixels { colours: vec![[0; 3]; SIDE * SIDE], squared_error: 0.0 };
    let width = (frame.view.width as usize - corner.x).min(SIDE);
    let height = (frame.view.height as usize - corner.y).min(SIDE);
    let mut groups: Vec<Group> = Vec::with_capacity(S);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let place = y * SIDE + x;
        collect(&mut groups, &nearest.owner[place], seen, &offsets);
        let mut sum = [0.0f32; 3];
        let mut squares = [0.0f32; 3];
        for group in &groups {
            let weight = group.samples as f32;
            let at = [(corner.x + x) as f32 + group.x / weight, (corner.y + y) as f32 + group.y / weight];
            let colour = match group.owner {
                SKY => prepared.sky(at),
                GROUND => prepared.ground(at),
                owner => {
                    let found = seen[owner as usize];
                    shade::surface(prepared, &bins.items[found.item as usize], found.triangle, at)
                }
            };
            for k in 0..3 {
                let value = colour[k] * frame.view.exposure;
                sum[k] += value * weight;
                squares[k] += value * value * weight;
            }
        }
        let count = S as f32;
        let mean = sum.map(|s| s / count);
        if S > 1 {
            for k in 0..3 {
                let spread = (squares[k] - mean[k] * mean[k] * count).max(0.0);
                pixels.squared_error += f64::from(spread / ((count - 1.0) * count));
            }
        }
        pixels.colours[place] = prepared.tone.encode_at(mean, corner.x + x, corner.y + y);
    }
    pixels
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
        let key = if *owner >= GROUND { *owner } else { seen[*owner as usize].item };
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
