//! One tile of the picture, from its clusters to encoded pixels.

use super::atmosphere::Ambient;
use super::backdrop::Backdrop;
use super::background::Background;
use super::bins::{Bins, Item};
use super::cluster::Cluster;
pub(super) use super::coverage::SIDE;
use super::coverage::{BLOCK, Nearest};
use super::draw::{self, Corner, Placed, Scratch};
use super::ground::Sward;
use super::layers::Site;
use super::projection::{Lens, composed};
use super::samples::{SUBPIXEL, pattern};
use super::tone::{Colours, LANES};
use super::{Prepared, shade};
use crate::base::vector::{Affine, Vec3};
use crate::frame::{self, Instance, Material};
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

/// Owner of a sample that shows the sky.
const SKY: u32 = u32::MAX;
/// Owner of a sample that shows the ground.
const GROUND: u32 = u32::MAX - 1;

/// A finished tile.
pub(super) struct Pixels {
    /// Encoded colours with straight alpha, row by row.
    pub colours: Vec<[u8; 4]>,
    /// What is seen in each pixel, row by row; empty when nobody asks.
    pub sites: Vec<Site>,
    /// Exposed linear light before the tone curve and the share that shows anything, row by row; empty when nobody asks.
    pub radiance: Vec<[f32; 4]>,
    /// Estimated squared antialiasing error, summed over pixels and channels; 0 with one sample, whose spread is unknown.
    pub squared_error: f64,
}

/// An item of which a triangle won a sample, with what shading it needs again and again.
pub(super) struct Visible<'a> {
    pub item: &'a Item,
    pub cluster: &'a Cluster,
    pub instance: &'a Instance,
    pub material: &'a Material,
    /// From the item's model to the picture.
    pub map: Affine,
    /// How much larger its instance is than its mesh.
    pub scale: f32,
    /// Texture units that a metre of its mesh spans.
    pub uv_per_metre: f32,
    /// What its instance is known by.
    pub salt: u64,
    /// The light from all sides at a small item's middle, once it is known.
    pub ambient: Option<Ambient>,
    /// The sward about its middle, where it is grass, once it is known.
    pub sward: Option<Sward>,
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
pub(super) struct Workspace<'a, const S: usize> {
    nearest: Nearest<S>,
    scratch: Scratch,
    visible: Vec<Visible<'a>>,
    seen: Vec<Seen>,
    /// Of eight pixels each, row by row.
    sums: Vec<Sums>,
}

impl<'a, const S: usize> Workspace<'a, S> {
    /// Room for one tile.
    pub(super) fn new() -> Self {
        Self {
            nearest: Nearest::new(),
            scratch: Scratch::default(),
            visible: Vec::new(),
            seen: Vec::new(),
            sums: Vec::new(),
        }
    }

    /// Draws the tile at a column and row of tiles, in as many passes as its samples take.
    pub(super) fn draw(&mut self, prepared: &Prepared<'a>, bins: &'a Bins, column: usize, row: usize) -> Pixels {
        let corner = Corner { x: column * SIDE, y: row * SIDE };
        let passes = prepared.frame.view.samples / S as u32;
        self.sums.clear();
        self.sums.resize(SIDE * SIDE / LANES, Sums::default());
        let mut sites = Vec::new();
        for pass in 0..passes.max(1) {
            let pattern = pattern::<S>(passes.max(1), pass);
            self.nearest.set_pattern(&pattern);
            self.cover(prepared, bins, corner, [column, row]);
            if pass == 0 && prepared.wanted.sites {
                self.nearest.uncover([0, 0, SIDE - 1, SIDE - 1]);
                sites = self.sites(prepared, corner);
            }
            self.shade(prepared, corner, &pattern);
        }
        self.encoded(prepared, corner, passes.max(1) * S as u32, sites)
    }

    /// Finds which triangle each sample shows.
    fn cover(&mut self, prepared: &Prepared<'a>, bins: &'a Bins, corner: Corner, [column, row]: [usize; 2]) {
        let shared = prepared.shared;
        let Self { nearest, scratch, visible, seen, .. } = self;
        nearest.clear(&background(prepared, corner));
        visible.clear();
        seen.clear();
        for &number in bins.tile(column, row) {
            let item = &bins.items[number as usize];
            if nearest.hides(corner.clip(item), item.nearness) {
                continue;
            }
            let instance = &shared.instances.all[item.instance as usize];
            let material = &shared.frame.materials[item.material as usize];
            let (cluster, map) =
                (item.cluster_in(&shared.meshes), composed(&shared.projection.map, &instance.transform));
            let placed = Placed {
                projection: &shared.projection,
                map: &map,
                cluster,
                two_sided: material.two_sided,
                is_whole: item.is_whole,
            };
            draw::cluster(nearest, scratch, placed, corner, seen.len() as u32);
            if !scratch.won.is_empty() {
                let place = visible.len() as u32;
                seen.extend(scratch.won.iter().map(|&triangle| Seen { visible: place, triangle }));
                visible.push(Visible {
                    item,
                    cluster,
                    instance,
                    material,
                    map,
                    scale: instance.transform.linear.column(0).norm(),
                    uv_per_metre: shared.meshes[item.mesh as usize].uv_per_metre,
                    salt: shared.instances.salt(item.instance),
                    ambient: None,
                    sward: None,
                    air: None,
                });
            }
        }
    }

    /// Adds what the samples show to the sums of their pixels.
    fn shade(&mut self, prepared: &Prepared, corner: Corner, pattern: &[[i32; 2]; S]) {
        let is_open = prepared.frame.background != frame::Background::Sky;
        let offsets = pattern.map(|p| p.map(|step| step as f32 / SUBPIXEL as f32));
        let middle = offsets.iter().fold([0.0; 2], |[x, y], offset| [x + offset[0], y + offset[1]]);
        let [width, height] = corner.extent(prepared);
        let mut groups: Vec<Group> = Vec::with_capacity(S);
        for (top, left) in (0..height).step_by(BLOCK).flat_map(|y| (0..width).step_by(BLOCK).map(move |x| (y, x))) {
            let alone = self.nearest.alone([left / BLOCK, top / BLOCK]);
            if alone.is_some() && is_open {
                continue;
            }
            let mut backdrop = Backdrop::new(prepared, [(corner.x + left) as f32, (corner.y + top) as f32]);
            let (right, bottom) = ((left + BLOCK).min(width), (top + BLOCK).min(height));
            if alone.is_none() {
                self.nearest.uncover([left, top, right - 1, bottom - 1]);
            }
            for (y, x) in (top..bottom).flat_map(|y| (left..right).map(move |x| (y, x))) {
                let place = y * SIDE + x;
                groups.clear();
                match alone {
                    Some(owner) => groups.push(Group { key: 0, owner, samples: S as u32, x: middle[0], y: middle[1] }),
                    None => collect(&mut groups, &self.nearest.owner[place], &self.seen, &offsets, middle),
                }
                for group in groups.iter().filter(|group| !is_open || group.owner < GROUND) {
                    let share = 1.0 / group.samples as f32;
                    let at = [(corner.x + x) as f32 + group.x * share, (corner.y + y) as f32 + group.y * share];
                    let colour = match group.owner {
                        SKY => backdrop.sky(at),
                        GROUND => backdrop.ground(at),
                        owner => {
                            let Seen { visible: place, triangle } = self.seen[owner as usize];
                            shade::surface(prepared, &mut self.visible[place as usize], triangle, at)
                        }
                    };
                    let colour = colour.map(|value| value * prepared.frame.view.exposure);
                    self.sums[place / LANES].add(place % LANES, colour, group.samples as f32);
                }
            }
        }
    }

    /// The finished tile of the sums of `count` samples.
    fn encoded(&self, prepared: &Prepared, corner: Corner, count: u32, sites: Vec<Site>) -> Pixels {
        let mut pixels = Pixels { colours: vec![[0; 4]; SIDE * SIDE], sites, radiance: Vec::new(), squared_error: 0.0 };
        let plain = plain(prepared.frame);
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || {
                // Where nothing is shown the colour is the plain one everywhere, without a threshold.
                let nothing = (&[0.0; LANES], plain);
                let blank = match plain {
                    Some(_) => prepared.tone.codes(simd, &Colours::default(), nothing, 0).map(|[r, g, b]| [r, g, b, 255]),
                    None => [[0; 4]; LANES],
                };
                let eights = pixels.colours.as_chunks_mut::<LANES>().0.iter_mut().zip(&self.sums);
                for (number, (colours, sums)) in eights.enumerate() {
                    if sums.covered == [0.0; LANES] {
                        *colours = blank;
                        if prepared.wanted.radiance {
                            pixels.radiance.extend([[0.0; 4]; LANES]);
                        }
                        continue;
                    }
                    let mean = sums.mean();
                    let share = sums.covered.map(|covered| covered / count as f32);
                    let codes = prepared.tone.codes(simd, &mean, (&share, plain), corner.y + number * LANES / SIDE);
                    let alpha = share.map(|share| if plain.is_some() { 255 } else { (255.0 * share + 0.5) as u8 });
                    for lane in 0..LANES {
                        let [r, g, b] = codes[lane];
                        colours[lane] = if alpha[lane] == 0 { [0; 4] } else { [r, g, b, alpha[lane]] };
                    }
                    if prepared.wanted.radiance {
                        let light = |lane: usize| [mean[0][lane], mean[1][lane], mean[2][lane], share[lane]];
                        pixels.radiance.extend((0..LANES).map(light));
                    }
                    pixels.squared_error += sums.squared_error(&mean);
                }
            }
        ));
        pixels
    }

    /// What most samples of each pixel show.
    fn sites(&self, prepared: &Prepared, corner: Corner) -> Vec<Site> {
        let mut sites = vec![Site::default(); SIDE * SIDE];
        let [width, height] = corner.extent(prepared);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let place = y * SIDE + x;
            let owners = self.nearest.owner[place].map(|owner| match owner {
                GROUND.. => owner,
                _ => self.visible[self.seen[owner as usize].visible as usize].item.instance,
            });
            let count = |owner: u32| owners.iter().filter(|other| **other == owner).count();
            // The first of those that as many samples show.
            let sample = (0..S).rev().max_by_key(|sample| count(owners[*sample])).unwrap_or(0);
            let depth = 1.0 / self.nearest.nearness[place][sample];
            sites[place] = match self.nearest.owner[place][sample] {
                SKY => Site::default(),
                GROUND => Site { depth: depth * level_nearness(prepared), normal: Vec3::y(), ..Site::default() },
                owner => {
                    let Seen { visible, triangle } = self.seen[owner as usize];
                    let visible = &self.visible[visible as usize];
                    let at = [(corner.x + x) as f32 + 0.5, (corner.y + y) as f32 + 0.5];
                    let normal = shade::normal(prepared, visible, triangle, at);
                    Site { instance: Some(owners[sample]), depth, normal }
                }
            };
        }
        sites
    }
}

/// What the samples of some pixels in a row have shown so far.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    colour: Colours,
    squares: Colours,
    /// Number of the samples that show anything.
    covered: [f32; LANES],
}

impl Sums {
    #[inline(always)]
    fn add(&mut self, lane: usize, colour: [f32; 3], samples: f32) {
        for k in 0..3 {
            self.colour[k][lane] += colour[k] * samples;
            self.squares[k][lane] += colour[k] * colour[k] * samples;
        }
        self.covered[lane] += samples;
    }

    /// The mean of what is shown.
    #[inline(always)]
    fn mean(&self) -> Colours {
        let mut mean = self.colour;
        for channel in &mut mean {
            for lane in 0..LANES {
                channel[lane] /= self.covered[lane].max(1.0);
            }
        }
        mean
    }

    /// The squared errors of the means if the samples are independent, summed over pixels and channels; a pixel of one sample
    /// has none.
    #[inline(always)]
    fn squared_error(&self, mean: &Colours) -> f64 {
        let mut errors = [0.0f32; LANES];
        for k in 0..3 {
            for lane in 0..LANES {
                let count = self.covered[lane];
                let spread = self.squares[k][lane] - mean[k][lane] * mean[k][lane] * count;
                errors[lane] += if count < 2.0 { 0.0 } else { spread.max(0.0) / ((count - 1.0) * count) };
            }
        }
        errors.iter().map(|error| f64::from(*error)).sum()
    }
}

/// The colour that a frame is laid over.
pub(super) fn plain(frame: &frame::Frame) -> Option<[f32; 3]> {
    match frame.background {
        frame::Background::Plain(colour) => Some(colour),
        frame::Background::Sky | frame::Background::Transparent => None,
    }
}

/// How near the level ground is taken to be, over how near it is: it lies behind uneven ground, which has hollows below it.
fn level_nearness(prepared: &Prepared) -> f32 {
    let is_uneven = prepared.frame.ground.as_ref().is_some_and(|ground| ground.is_uneven);
    if is_uneven { 1e-4 } else { 1.0 }
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
    let near = level_nearness(prepared);
    Background { at: at * near, right: right * near, down: down * near, owner: GROUND, beyond: SKY }
}

/// Gathers the samples of a pixel by what they show: a cluster is shaded once, at the middle of its samples. `middle` is the
/// sum of all offsets.
fn collect<const S: usize>(
    groups: &mut Vec<Group>,
    owners: &[u32; S],
    seen: &[Seen],
    offsets: &[[f32; 2]; S],
    [x, y]: [f32; 2],
) {
    if owners.iter().all(|owner| *owner == owners[0]) {
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
