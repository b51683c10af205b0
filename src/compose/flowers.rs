//! Flowers of a summer's meadow: heads of daisies and buttercups over the grass before the camera, a few on some of its
//! patches. They go as the trees turn.

use super::outlook::Outlook;
use super::upright::upright;
use crate::base::maths::{cos, sin, sincos};
use crate::base::mesh::Mesh;
use crate::base::random::{Purpose, Stream, hash, hash_unit};
use crate::base::vector::{Affine, Vec2, Vec3};
use std::f64::consts::TAU;

/// A kind of flower.
pub(super) struct Kind {
    /// Name of its material and its model.
    pub name: &'static str,
    /// Diffuse reflectance (linear sRGB; white rays and yellow petals, judged).
    pub colour: [f32; 3],
    /// Heads on a patch, and the range of their radii, metres.
    heads: u64,
    radii: [f64; 2],
    /// Share of the patches that have some.
    patches: f32,
}

/// The flowers of the meadow.
pub(super) const KINDS: [Kind; 2] = [
    Kind { name: "flower_white", colour: [0.66, 0.65, 0.56], heads: 16, radii: [0.007, 0.012], patches: 0.34 },
    Kind { name: "flower_yellow", colour: [0.62, 0.44, 0.02], heads: 14, radii: [0.006, 0.010], patches: 0.30 },
];
/// How far from the eye heads can be told, metres.
const REACH: f64 = 40.0;
/// Side of the squares on which they stand, metres.
const PATCH: f64 = 2.5;
/// Corners of a head.
const CORNERS: u32 = 6;

/// Heads on a patch of meadow about the origin, in a few groups.
pub(super) fn mesh(seed: u64, number: u64) -> Mesh {
    let mut mesh = Mesh::default();
    let kind = &KINDS[number as usize % KINDS.len()];
    let mut group = [0.0; 2];
    for head in 0..kind.heads {
        let mut random = Stream::new(seed, Purpose::Surroundings, head, 5 + number);
        if head % 5 == 0 {
            group = [random.range(-0.42, 0.42) * PATCH, random.range(-0.42, 0.42) * PATCH];
        }
        let place = group.map(|side| side + 0.22 * random.normal().clamp(-2.0, 2.0));
        let middle = Vec3::new(place[0] as f32, random.range(0.07, 0.19) as f32, place[1] as f32);
        add_head(&mut mesh, &mut random, middle, kind.radii);
    }
    mesh
}

/// A flat head, turned a little from the sky, with both its sides.
fn add_head(mesh: &mut Mesh, random: &mut Stream, middle: Vec3, [small, large]: [f64; 2]) {
    let radius = random.range(small, large) as f32;
    let (tilt, turn) = (random.range(0.1, 0.7), random.range(0.0, TAU));
    let up = Vec3::new((sin(tilt) * cos(turn)) as f32, cos(tilt) as f32, (sin(tilt) * sin(turn)) as f32);
    let first = up.cross(&Vec3::x()).normalize();
    let second = up.cross(&first);
    let start = mesh.positions.len() as u32;
    mesh.positions.push(middle);
    for corner in 0..CORNERS {
        let angle = TAU * f64::from(corner) / f64::from(CORNERS);
        mesh.positions.push(middle + (first * cos(angle) as f32 + second * sin(angle) as f32) * radius);
    }
    let count = CORNERS as usize + 1;
    mesh.uvs.extend(std::iter::repeat_n(Vec2::zeros(), count));
    mesh.normals.extend(std::iter::repeat_n(up, count));
    for corner in 0..CORNERS {
        let (one, next) = (start + 1 + corner, start + 1 + (corner + 1) % CORNERS);
        mesh.triangles.extend([[start, one, next], [start, next, one]]);
    }
}

/// The squares before a camera on which flowers of a kind stand.
pub(super) fn places(seed: u64, number: u64, outlook: &Outlook) -> Vec<Affine> {
    let share = KINDS[number as usize % KINDS.len()].patches;
    let place = |(column, row): (i64, i64)| {
        let middle = [column, row].map(|square| (square as f64 + 0.5) * PATCH);
        let distance = outlook.distance(middle, PATCH)?;
        let turn = TAU * f64::from(hash_unit(seed, hash(column as u64, row as u64)));
        let place = upright(middle, sincos(turn), 1.0);
        (distance < REACH && lot(seed, number, &place) < share).then_some(place)
    };
    outlook.squares(PATCH, REACH).filter_map(place).collect()
}

/// Whether the flowers at a place still stand when grass has gone so far into its rest: they go patch by patch.
pub(super) fn stand(place: &Affine, dormant: f32) -> bool {
    lot(77, 0, place) * 0.3 + 0.02 > dormant
}

/// A patch's number in [0, 1).
fn lot(seed: u64, number: u64, place: &Affine) -> f32 {
    let [x, z] = [place.translation.x, place.translation.z].map(|side| u64::from(side.to_bits()));
    hash_unit(seed.wrapping_add(90 + number), x << 32 | z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_stand_over_the_grass_and_go_patch_by_patch() {
        for number in 0..KINDS.len() as u64 {
            let mesh = mesh(1, number);
            assert_eq!(mesh.check(), Ok(()));
            assert!(mesh.positions.iter().all(|place| (0.05..0.21).contains(&place.y)));
        }
        let all_around = Outlook::new([0.0, 1.6, 0.0], [0.0, 0.0, -1.0], std::f64::consts::PI);
        let found = places(1, 0, &all_around);
        // A third of some 800 squares.
        assert!((210..340).contains(&found.len()), "{}", found.len());
        let standing = |dormant: f32| found.iter().filter(|place| stand(place, dormant)).count();
        assert_eq!((standing(0.0), standing(0.33)), (found.len(), 0));
        assert!((1..found.len()).contains(&standing(0.15)));
    }
}
