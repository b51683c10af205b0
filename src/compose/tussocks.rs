//! Tussocks: rank grass with its bents, in loose groups over the meadow, as beasts leave it standing. They carry the eye from
//! the sward at hand to the far meadow, where single blades are too fine to be drawn.

use super::blades;
use super::outlook::Outlook;
use super::upright::{GOLDEN_ANGLE, upright};
use crate::base::maths::sincos;
use crate::base::mesh::Mesh;
use crate::base::noise::Fractal;
use crate::base::random::{Purpose, Stream, hash};
use crate::base::vector::Affine;

/// Blades of a tussock, their range of heights and half a blade's width, metres.
const BLADES: u64 = 80;
const BLADE_HEIGHTS: [f64; 2] = [0.08, 0.26];
const BLADE_HALF: f64 = 0.0024;
/// Bents, the stems that have flowered: straw, thin and taller than the blades.
const BENTS: u64 = 16;
const BENT_HEIGHTS: [f64; 2] = [0.22, 0.42];
const BENT_HALF: f64 = 0.0011;
/// Spread of the feet about a tussock's middle, metres (one standard deviation).
const SPREAD: f64 = 0.075;
/// Squares of which each bears one tussock or none, metres.
const CELL: f64 = 1.5;
/// How far from the eye tussocks stand, metres; beyond, they are lost in the meadow's grain.
const REACH: f64 = 80.0;
/// Side of the noise that groups them, metres.
const GROUPS: f64 = 70.0;
/// Room that is kept about trunks and before the eye, metres.
const CLEAR: f64 = 2.6;

/// A tussock about the origin.
pub(super) fn mesh(seed: u64) -> Mesh {
    let mut mesh = Mesh::default();
    for number in 0..BLADES + BENTS {
        let mut random = Stream::new(seed, Purpose::Surroundings, number, 8);
        let foot = [0, 1].map(|_| SPREAD * random.normal().clamp(-2.2, 2.2));
        let is_bent = number >= BLADES;
        let [low, high] = if is_bent { BENT_HEIGHTS } else { BLADE_HEIGHTS };
        let hue = if is_bent { random.range(0.7, 0.99) } else { 0.6 * random.uniform() * random.uniform() };
        let half = if is_bent { BENT_HALF } else { BLADE_HALF };
        let height = random.range(low, high);
        blades::add(&mut mesh, &mut random, foot, [height, hue, half]);
    }
    mesh
}

/// Where tussocks stand before a camera, clear of trunks (x, z).
pub(super) fn places(seed: u64, outlook: &Outlook, trees: &[[f64; 2]]) -> Vec<Affine> {
    let groups = Fractal::new(9, 9, 3, hash(seed, 0x7055));
    let place = |(column, row): (i64, i64)| {
        let mut random = Stream::new(seed, Purpose::Surroundings, hash(column as u64, row as u64), 9);
        let place = [column, row].map(|cell| (cell as f64 + random.uniform()) * CELL);
        let distance = outlook.distance(place, CELL)?;
        let is_clear = |tree: &[f64; 2]| libm::hypot(tree[0] - place[0], tree[1] - place[1]) > CLEAR;
        if !(CLEAR..REACH).contains(&distance) || !trees.iter().all(is_clear) {
            return None;
        }
        let [u, v] = place.map(|side| (side / GROUPS - (side / GROUPS).floor()) as f32);
        // One square in eight on the average, half of them in the thick of a group.
        let share = (2.4 * (f64::from(groups.at(u, v)) - 0.47)).clamp(0.015, 0.55);
        let (lot, scale) = (random.uniform(), random.range(0.55, 1.15));
        (lot < share).then(|| upright(place, sincos(GOLDEN_ANGLE * (column as f64 + 31.0 * row as f64)), scale))
    };
    outlook.squares(CELL, REACH).filter_map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bents_stand_over_the_blades() {
        let tussock = mesh(1);
        assert_eq!(tussock.check(), Ok(()));
        assert_eq!(tussock.triangles.len() as u64, BLADES + BENTS);
        let tips: Vec<f32> = tussock.positions.chunks(3).map(|blade| blade[2].y).collect();
        let (blades, bents) = tips.split_at(BLADES as usize);
        let mean = |heights: &[f32]| heights.iter().sum::<f32>() / heights.len() as f32;
        assert!(mean(bents) > 1.5 * mean(blades));
        assert!(tips.iter().all(|tip| (0.05..0.45).contains(tip)));
    }

    #[test]
    fn tussocks_stand_before_the_camera_in_groups_and_clear_of_trunks() {
        let trees = [[0.0, 0.0], [3.0, -9.0]];
        let found = places(1, &Outlook::new([1.0, 1.6, 20.0], [0.0, 0.0, -1.0], 0.4), &trees);
        assert!((60..600).contains(&found.len()), "{}", found.len());
        for place in &found {
            let [x, z] = [place.translation.x, place.translation.z].map(f64::from);
            assert!(libm::hypot(x - 1.0, z - 20.0) < REACH && z < 20.0, "{place:?}");
            assert!(trees.iter().all(|tree| libm::hypot(tree[0] - x, tree[1] - z) > CLEAR - 1e-3));
        }
        // In groups: the numbers in squares of twelve metres vary more than those of a random scatter, whose variance is
        // their mean.
        let all = places(1, &Outlook::new([0.0, 1.6, 0.0], [0.0, 0.0, -1.0], std::f64::consts::PI), &[]);
        let count = |x: i32, z: i32| {
            let inside = |place: &&Affine| {
                [(place.translation.x, x), (place.translation.z, z)]
                    .iter()
                    .all(|(p, k)| (p / 12.0).floor() as i32 == *k)
            };
            all.iter().filter(inside).count() as f64
        };
        let counts: Vec<f64> = (-4..4).flat_map(|x| (-4..4).map(move |z| (x, z))).map(|(x, z)| count(x, z)).collect();
        let mean = counts.iter().sum::<f64>() / counts.len() as f64;
        let variance = counts.iter().map(|n| (n - mean) * (n - mean)).sum::<f64>() / counts.len() as f64;
        assert!(variance > 2.0 * mean, "{variance} {mean}");
    }
}
