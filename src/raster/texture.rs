//! Textures as pyramids of linear colour (Williams 1983), as fine as a frame can show and no finer.

use crate::base::encoding::linear_values;
use crate::base::maths::floor_to_i32;
use crate::base::vector::Vec2;
use crate::frame::{Material, Texture};
use std::sync::Arc;

/// Largest stored value of a texel.
const FULL: f32 = 65535.0;

/// Mean slope of normals below which they are taken to be upright: it changes what is lit aslant by some two percent.
const FLAT: f32 = 0.02;

/// What the codes of a texture stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Codes {
    /// sRGB: colour.
    Colour,
    /// Numbers from -1 to 1: normals, and what stands for no colour.
    Plain,
}

/// A texture with its halvings, without those finer than are needed.
#[derive(Clone, Debug)]
pub(super) struct MipMap {
    /// Side of the whole texture, texels (the geometric mean of both).
    side: f32,
    /// How often the finest of `levels` was halved.
    first: u32,
    levels: Vec<Level>,
    repeat: bool,
    codes: Codes,
    mean: [f32; 3],
    /// The first of `levels` from which on normals are as good as upright.
    flat: usize,
}

#[derive(Clone, Debug)]
struct Level {
    width: i32,
    height: i32,
    /// Three channels and one unused, which makes a texel as wide as a register's part.
    texels: Vec<[u16; 4]>,
}

/// Where and with what weights a place is read, in any texture of the same layout.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taps {
    level: usize,
    towards_coarse: f32,
    fine: Corners,
    coarse: Corners,
}

#[derive(Clone, Copy, Debug)]
struct Corners {
    texels: [usize; 4],
    weights: [f32; 4],
}

/// log2 between whole powers by a line: within 0.09, and even from level to level.
#[inline(always)]
fn rough_log2(x: f32) -> f32 {
    let bits = x.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    exponent as f32 + (bits & 0x7f_ffff) as f32 / 8_388_608.0
}

/// How often a texture may be halved before a place of `footprint` (texture units) is seen blurred.
pub(super) fn halvings(texture: &Texture, footprint: f32) -> u32 {
    let texels = footprint * side(texture);
    if texels > 1.0 { rough_log2(texels) as u32 } else { 0 }
}

fn side(texture: &Texture) -> f32 {
    (texture.width as f32 * texture.height as f32).sqrt()
}

impl MipMap {
    /// Decodes a texture (sides are powers of two), halved `first` times, and halves it on down to one texel. A texel of any
    /// level is the rounded mean of all that it stands for, so `first` changes none.
    pub(super) fn new(texture: &Texture, codes: Codes, first: u32) -> Self {
        let whole = [texture.width, texture.height];
        let first = first.min(texture.width.max(texture.height).ilog2());
        let mut size = whole.map(|side| (side >> first).max(1));
        let mut sums = reduced(texture, codes, size);
        let mut levels = vec![Level::new(size, whole, &sums)];
        while size != [1, 1] {
            (sums, size) = halved(&sums, size);
            levels.push(Level::new(size, whole, &sums));
        }
        let count = f64::from(texture.width) * f64::from(texture.height);
        let mean = sums[0].map(|sum| codes.decoded((sum as f64 / count) as f32));
        let rough = levels.iter().rposition(|level| level.slope(codes) > FLAT);
        let flat = rough.map_or(0, |level| level + 1);
        Self { side: side(texture), first, levels, repeat: texture.repeat, codes, mean, flat }
    }

    /// How often the finest level was halved.
    pub(super) fn first(&self) -> u32 {
        self.first
    }

    /// What the texture stands for.
    pub(super) fn codes(&self) -> Codes {
        self.codes
    }

    /// Where to read for `uv`, averaged over about `footprint` (in texture units), between the two nearest levels.
    #[inline(always)]
    pub(super) fn taps(&self, uv: Vec2, footprint: f32) -> Taps {
        let texels = footprint * self.side;
        let level = if texels > 1.0 { rough_log2(texels) } else { 0.0 };
        let level = (level - self.first as f32).max(0.0);
        let last = self.levels.len() - 1;
        let lower = (level as usize).min(last);
        // Into one repeat first: a long branch counts thousands of them, and texels would lose their fractions.
        let uv = if self.repeat {
            uv.map(|c| c - floor_to_i32(c) as f32)
        } else {
            Vec2::new(uv.x.clamp(0.0, 1.0), uv.y.clamp(0.0, 1.0))
        };
        Taps {
            level: lower,
            towards_coarse: (level - lower as f32).clamp(0.0, 1.0),
            fine: self.levels[lower].corners(uv, self.repeat),
            coarse: self.levels[(lower + 1).min(last)].corners(uv, self.repeat),
        }
    }

    /// Whether places of another texture hold in this one.
    #[inline(always)]
    pub(super) fn is_laid_out_like(&self, other: &Self) -> bool {
        let size = |map: &Self| (map.levels[0].width, map.levels[0].height, map.first, map.repeat);
        size(self) == size(other)
    }

    /// The colour (linear sRGB) or normal at places found by `taps` in a texture of the same layout.
    #[inline(always)]
    pub(super) fn read(&self, taps: &Taps) -> [f32; 3] {
        let last = self.levels.len() - 1;
        let fine = self.levels[taps.level].read(&taps.fine);
        let coarse = self.levels[(taps.level + 1).min(last)].read(&taps.coarse);
        let raw: [f32; 3] = std::array::from_fn(|k| fine[k] + (coarse[k] - fine[k]) * taps.towards_coarse);
        raw.map(|value| self.codes.decoded(value))
    }

    /// `read` at the places of `taps`.
    pub(super) fn sample(&self, uv: Vec2, footprint: f32) -> [f32; 3] {
        self.read(&self.taps(uv, footprint))
    }

    /// Whether normals read by `taps` are as good as upright.
    #[inline(always)]
    pub(super) fn is_flat(&self, taps: &Taps) -> bool {
        taps.level >= self.flat
    }

    /// The mean of the whole texture.
    pub(super) fn mean(&self) -> [f32; 3] {
        self.mean
    }
}

impl Codes {
    /// What each code stands for, 0 to `FULL`.
    fn table(self) -> [u16; 256] {
        let shares = match self {
            Self::Colour => linear_values(),
            Self::Plain => std::array::from_fn(|code| ((code as f32 - 128.0) / 127.0 + 1.0) * 0.5),
        };
        shares.map(|share| (share.clamp(0.0, 1.0) * FULL + 0.5) as u16)
    }

    /// The colour or number that a stored value stands for.
    #[inline(always)]
    fn decoded(self, stored: f32) -> f32 {
        match self {
            Self::Colour => stored * (1.0 / FULL),
            Self::Plain => stored * (2.0 / FULL) - 1.0,
        }
    }
}

/// The sums of a texture over the texels of a smaller one.
fn reduced(texture: &Texture, codes: Codes, [width, height]: [u32; 2]) -> Vec<[u64; 3]> {
    let table = codes.table();
    let (across, down) = ((texture.width / width) as usize, (texture.height / height) as usize);
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for rows in texture.pixels.chunks_exact(texture.width as usize * down) {
        let first = texels.len();
        texels.resize(first + width as usize, [0u64; 3]);
        for row in rows.chunks_exact(texture.width as usize) {
            for (sum, pixels) in texels[first..].iter_mut().zip(row.chunks_exact(across)) {
                // A row of one texel is at most 2^16 pixels of 2^16.
                let mut part = [0u32; 3];
                for pixel in pixels {
                    for k in 0..3 {
                        part[k] = part[k].wrapping_add(u32::from(table[usize::from(pixel[k])]));
                    }
                }
                *sum = std::array::from_fn(|k| sum[k] + u64::from(part[k]));
            }
        }
    }
    texels
}

/// The sums of a level of half the size, with its size.
fn halved(sums: &[[u64; 3]], [width, height]: [u32; 2]) -> (Vec<[u64; 3]>, [u32; 2]) {
    let size = [(width / 2).max(1), (height / 2).max(1)];
    let (across, down) = (width / size[0], height / size[1]);
    let mut smaller = Vec::with_capacity(size[0] as usize * size[1] as usize);
    for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
        let mut sum = [0u64; 3];
        for (dy, dx) in (0..down).flat_map(|dy| (0..across).map(move |dx| (dy, dx))) {
            let texel = sums[((y * down + dy) * width + x * across + dx) as usize];
            sum = std::array::from_fn(|k| sum[k] + texel[k]);
        }
        smaller.push(sum);
    }
    (smaller, size)
}

impl Level {
    fn new([width, height]: [u32; 2], whole: [u32; 2], sums: &[[u64; 3]]) -> Self {
        let count = u64::from(whole[0] / width) * u64::from(whole[1] / height);
        let stored = |sum: &[u64; 3]| {
            let [r, g, b] = sum.map(|sum| ((sum + count / 2) / count) as u16);
            [r, g, b, 0]
        };
        Self { width: width as i32, height: height as i32, texels: sums.iter().map(stored).collect() }
    }

    /// How far normals lean on average: the root of the mean square of their slopes.
    fn slope(&self, codes: Codes) -> f32 {
        let squared = |texel: &[u16; 4]| {
            let [x, y, z] = [0, 1, 2].map(|k| codes.decoded(f32::from(texel[k])));
            (x * x + y * y) / (z * z).max(1e-6)
        };
        (self.texels.iter().map(squared).sum::<f32>() / self.texels.len() as f32).sqrt()
    }

    /// The four texels around a place, whose coordinates lie in 0..=1.
    #[inline(always)]
    fn corners(&self, uv: Vec2, repeat: bool) -> Corners {
        let x = uv.x * self.width as f32 - 0.5;
        let y = uv.y * self.height as f32 - 0.5;
        let (x0, y0) = (floor_to_i32(x), floor_to_i32(y));
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let place = |index: i32, size: i32| if repeat { index & (size - 1) } else { index.clamp(0, size - 1) };
        let (left, right) = (place(x0, self.width), place(x0.wrapping_add(1), self.width));
        let (up, down) = (place(y0, self.height) * self.width, place(y0.wrapping_add(1), self.height) * self.width);
        Corners {
            texels: [up + left, up + right, down + left, down + right].map(|texel| texel as usize),
            weights: [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy],
        }
    }

    #[inline(always)]
    fn read(&self, corners: &Corners) -> [f32; 4] {
        let mut sum = [0.0f32; 4];
        for (texel, weight) in corners.texels.iter().zip(corners.weights) {
            let texel = self.texels[*texel];
            for k in 0..4 {
                sum[k] += f32::from(texel[k]) * weight;
            }
        }
        sum
    }
}

/// Mean reflectance and transmittance of a material.
pub(super) fn optics(material: &Material, textures: &[Arc<MipMap>]) -> ([f32; 3], [f32; 3]) {
    let mean = |factor: [f32; 3], texture: Option<u32>| -> [f32; 3] {
        let colour = texture.map_or([1.0; 3], |number| textures[number as usize].mean());
        std::array::from_fn(|k| factor[k] * colour[k])
    };
    (mean(material.colour, material.reflected), mean(material.transmission, material.transmitted))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checks() -> Texture {
        let pixels = (0..16).map(|i| if (i % 4 + i / 4) % 2 == 0 { [255; 3] } else { [0; 3] }).collect();
        Texture { name: "checks".into(), width: 4, height: 4, pixels: Arc::new(pixels), repeat: true }
    }

    #[test]
    fn the_mean_is_linear_light() {
        let map = MipMap::new(&checks(), Codes::Colour, 0);
        assert!((map.mean()[0] - 0.5).abs() < 1e-6);
        assert!((map.sample(Vec2::new(0.3, 0.7), 4.0)[1] - 0.5).abs() < 1e-4);
    }

    #[test]
    fn texel_centres_are_exact_and_the_rim_wraps() {
        let map = MipMap::new(&checks(), Codes::Colour, 0);
        assert_eq!(map.sample(Vec2::new(0.125, 0.125), 0.0), [1.0; 3]);
        assert_eq!(map.sample(Vec2::new(1.375, -0.875), 0.0), [0.0; 3]);
    }

    #[test]
    fn a_texture_without_its_finest_levels_reads_the_same_bits() {
        let mut pixels = Vec::new();
        for (y, x) in (0..32u8).flat_map(|y| (0..64u8).map(move |x| (y, x))) {
            pixels.push([x * 4, y * 8, 255 - x * 3]);
        }
        let texture = Texture { name: "slope".into(), width: 64, height: 32, pixels: Arc::new(pixels), repeat: false };
        let (whole, coarse) = (MipMap::new(&texture, Codes::Colour, 0), MipMap::new(&texture, Codes::Colour, 2));
        let footprint = 5.0 / side(&texture);
        assert_eq!(halvings(&texture, footprint), 2);
        for place in [[0.1, 0.2], [0.93, 0.6], [0.5, 1.0]] {
            let [a, b] = [&whole, &coarse].map(|map| map.sample(Vec2::from(place), footprint));
            assert_eq!(a, b);
        }
    }

    #[test]
    fn normals_are_flat_where_none_of_their_slopes_is_left() {
        // Ridges four texels wide of slope 0.5, whose sides are upright together.
        let ridge = |x: usize| if (x / 2).is_multiple_of(2) { [184, 128, 240] } else { [71, 128, 240] };
        let pixels = (0..256).map(|place| ridge(place % 16)).collect();
        let texture = Texture { name: "ridges".into(), width: 16, height: 16, pixels: Arc::new(pixels), repeat: true };
        let map = MipMap::new(&texture, Codes::Plain, 0);
        let is_flat = |texels: f32| map.is_flat(&map.taps(Vec2::new(0.4, 0.4), texels / 16.0));
        assert_eq!([1.0, 2.0, 3.9, 4.0, 16.0].map(is_flat), [false, false, false, true, true]);
    }

    #[test]
    fn rough_logarithms_are_exact_at_powers_and_grow() {
        let steps: Vec<f32> = (1..4000).map(|i| rough_log2(i as f32 * 0.01)).collect();
        assert!(steps.windows(2).all(|pair| pair[0] < pair[1]));
        for power in -3..12 {
            let value = if power < 0 { 1.0 / (1 << -power) as f32 } else { (1 << power) as f32 };
            assert_eq!(rough_log2(value), power as f32);
        }
    }
}
