//! The net of the finest veins: areoles, the fields between veinlets, gathered into patches that stronger veinlets bound.
//!
//! Areoles are cells of jittered points (Worley 1996). Each belongs to the patch whose seed is nearest to its middle
//! without a main or secondary vein between, so that what differs from patch to patch ends at veins as in a real blade.

use crate::base::random::{hash, hash_unit};
use crate::base::vector::Vec2;

/// Width of an areole on the blade, millimetres, and of a patch in areoles.
const AREOLE: f64 = 0.62;
const PATCH: f32 = 4.6;
/// The least width of an areole in texels: finer ones would be noise.
const LEAST: f32 = 3.0;
/// Distance by which a vein between makes a patch's seed seem farther, in patch widths.
const BARRIER: f32 = 2.0;

/// An areole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Areole {
    /// Its seed, texture coordinates.
    pub place: Vec2,
    /// Number of its patch.
    pub patch: u32,
}

/// Where a point lies in the net.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// Number of the areole, and of the one beyond the nearest veinlet.
    pub areole: u32,
    pub next: u32,
    /// Distance to the nearest veinlet, texture widths.
    pub veinlet: f32,
    /// Whether that veinlet bounds a patch.
    pub strong: bool,
}

/// The net over a whole texture.
#[derive(Clone, Debug)]
pub(super) struct Net {
    /// Areoles along each side of the texture, rim included.
    count: usize,
    /// Width of an areole, texture widths.
    pub width: f32,
    pub areoles: Vec<Areole>,
}

impl Net {
    /// A net for a blade drawn at `scale` texture widths a metre and `size` texels. `blocked` tells whether a main or
    /// secondary vein passes near a place, and within which distance.
    pub(super) fn new(scale: f64, size: usize, blocked: impl Fn(Vec2, f32) -> bool) -> Self {
        let width = ((AREOLE * 1e-3 * scale) as f32).max(LEAST / size as f32).min(0.25);
        // One areole more on each side, so that every texel has all its neighbours.
        let count = (1.0 / width) as usize + 4;
        let seed = |number: usize| seed(1, number % count, number / count, width);
        let patch_width = PATCH * width;
        let patch = |place: Vec2| nearest_patch(place, patch_width, &blocked);
        let areole = |number| Areole { place: seed(number), patch: patch(seed(number)) };
        Self { count, width, areoles: (0..count * count).map(areole).collect() }
    }

    /// The areole of a place and the way to its rim: exact distances to the lines halfway between seeds.
    #[inline]
    pub(super) fn at(&self, place: Vec2) -> Spot {
        let cell = |value: f32| (value / self.width + 1.0).max(1.0) as usize;
        let (column, row) = (cell(place.x).min(self.count - 2), cell(place.y).min(self.count - 2));
        let (mut first, mut second, mut owner, mut next) = (f32::INFINITY, f32::INFINITY, 0, 0);
        for j in row - 1..=row + 1 {
            let line = j * self.count + column - 1;
            for (offset, areole) in self.areoles[line..line + 3].iter().enumerate() {
                let square = (areole.place - place).norm_squared();
                if square < first {
                    (second, next) = (first, owner);
                    (first, owner) = (square, line + offset);
                } else if square < second {
                    (second, next) = (square, line + offset);
                }
            }
        }
        let apart = (self.areoles[owner].place - self.areoles[next].place).norm();
        Spot {
            areole: owner as u32,
            next: next as u32,
            veinlet: (second - first) / (2.0 * apart).max(1e-6),
            strong: self.areoles[owner].patch != self.areoles[next].patch,
        }
    }

    /// Numbers of the areoles whose seeds may lie within `reach` of a place.
    pub(super) fn around(&self, place: Vec2, reach: f32) -> impl Iterator<Item = usize> {
        let cell = |value: f32| ((value / self.width + 1.0).max(0.0) as usize).min(self.count - 1);
        let rows = cell(place.y - reach - self.width)..=cell(place.y + reach + self.width);
        let (left, right) = (cell(place.x - reach - self.width), cell(place.x + reach + self.width));
        let count = self.count;
        rows.flat_map(move |row| (left..=right).map(move |column| row * count + column))
    }
}

/// The seed of a cell of a lattice one cell larger than the texture on each side.
fn seed(salt: u64, column: usize, row: usize, width: f32) -> Vec2 {
    let bits = hash(salt, (column as u64) << 32 | row as u64);
    let jitter = |shift: u32| 0.1 + 0.8 * (bits >> shift & 0xffff) as f32 / 65536.0;
    Vec2::new((column as f32 - 1.0 + jitter(0)) * width, (row as f32 - 1.0 + jitter(16)) * width)
}

/// The patch of an areole's seed.
fn nearest_patch(place: Vec2, width: f32, blocked: &impl Fn(Vec2, f32) -> bool) -> u32 {
    const STEPS: usize = 6;
    let (column, row) = ((place.x / width + 1.0).max(1.0) as usize, (place.y / width + 1.0).max(1.0) as usize);
    let (mut best, mut patch) = (f32::INFINITY, 0);
    for j in row - 1..=row + 1 {
        for i in column - 1..=column + 1 {
            let seed = seed(2, i, j, width);
            let way = seed - place;
            let length = way.norm();
            // Too far to win even without a vein between.
            if length >= best {
                continue;
            }
            let within = 0.5 * length / STEPS as f32;
            let barred = (1..STEPS).any(|step| blocked(place + way * (step as f32 / STEPS as f32), within));
            let far = length + if barred { BARRIER * width } else { 0.0 };
            if far < best {
                (best, patch) = (far, (j * 4096 + i) as u32);
            }
        }
    }
    patch
}

/// A number in 0..1 that belongs to an areole or a patch in one texture.
pub(super) fn own(salt: u64, number: u32) -> f32 {
    hash_unit(salt, u64::from(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn net() -> Net {
        // A vein upright through the middle.
        Net::new(12.5, 256, |place, within| (place.x - 0.5).abs() < within)
    }

    #[test]
    fn the_nearest_seed_owns_a_place() {
        let net = net();
        for step in 0..300u16 {
            let place = Vec2::new(f32::from(step * 37 % 300) / 300.0, f32::from(step) / 300.0);
            let spot = net.at(place);
            let square = |areole: &Areole| (areole.place - place).norm_squared();
            let least = net.areoles.iter().map(square).fold(f32::INFINITY, f32::min);
            assert_eq!(square(&net.areoles[spot.areole as usize]), least);
            assert!((0.0..net.width).contains(&spot.veinlet));
        }
    }

    #[test]
    fn patches_hold_several_areoles_and_seldom_cross_a_vein() {
        let net = net();
        let mut sides = std::collections::BTreeMap::<u32, [usize; 2]>::new();
        for areole in &net.areoles {
            sides.entry(areole.patch).or_default()[usize::from(areole.place.x > 0.5)] += 1;
        }
        let crossing = sides.values().filter(|[left, right]| left.min(right) > &1).count();
        assert!(net.areoles.len() > 5 * sides.len());
        assert!(crossing * 50 < sides.len(), "{crossing} of {}", sides.len());
    }
}
