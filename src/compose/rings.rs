//! Rings of long grass about trunks' feet, which no mower and few feet reach: a trunk stands in the meadow and not on it.

use super::blades;
use super::upright::{GOLDEN_ANGLE, upright};
use crate::base::maths::{cos, sin, sincos};
use crate::base::mesh::Mesh;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::Affine;
use std::f64::consts::TAU;

/// Blades in a ring, and how far it goes, metres.
const BLADES: u64 = 2100;
const REACH: f64 = 0.85;
/// Radius of the trunk that the ring is made for, metres.
const TRUNK: f32 = 0.14;
/// Most rings of a scene.
const MOST: usize = 400;

/// Where rings of long grass stand about trunks (x, z, radius), as large as the trunks are thick; none about a shoot.
pub(super) fn places(feet: &[[f32; 3]]) -> Vec<Affine> {
    let place = |(number, [x, z, radius]): (usize, &[f32; 3])| {
        let scale = (radius / TRUNK).min(1.5);
        let unit = upright([*x, *z].map(f64::from), sincos(number as f64 * GOLDEN_ANGLE), 1.0);
        (scale > 0.3).then(|| Affine { linear: unit.linear * scale, ..unit })
    };
    feet.iter().enumerate().filter_map(place).take(MOST).collect()
}

/// Long grass about a trunk's foot, in tufts that grow shorter and fewer outwards.
pub(super) fn mesh(seed: u64) -> Mesh {
    const IN_A_TUFT: u64 = 15;
    let mut mesh = Mesh::default();
    for tuft in 0..BLADES / IN_A_TUFT {
        let mut random = Stream::new(seed, Purpose::Surroundings, tuft, 3);
        let out = random.uniform();
        let (away, turn) = (0.10 + (REACH - 0.10) * out * out.sqrt(), random.range(0.0, TAU));
        let tall = random.range(0.12, 0.30) * (1.0 - 0.55 * out);
        let hue = random.uniform();
        for _ in 0..IN_A_TUFT {
            let foot = [cos(turn), sin(turn)].map(|side| away * side + 0.05 * random.normal().clamp(-2.0, 2.0));
            let own = (0.7 * hue + 0.4 * random.uniform()).min(0.999);
            let height = tall * random.range(0.45, 1.0);
            blades::add(&mut mesh, &mut random, foot, [height, own * own, 0.0032]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_grass_grows_with_the_trunk_and_leaves_shoots_alone() {
        let ring = mesh(1);
        assert_eq!(ring.check(), Ok(()));
        assert!(ring.positions.iter().all(|p| (0.0..0.31).contains(&p.y)));
        let places = places(&[[0.0, 0.0, 0.004], [2.0, 1.0, 0.07], [5.0, 0.0, 2.0]]);
        let scales: Vec<f32> = places.iter().map(|place| place.linear.column(0).norm()).collect();
        assert_eq!(places.len(), 2);
        assert!((scales[0] - 0.5).abs() < 1e-5 && (scales[1] - 1.5).abs() < 1e-5, "{scales:?}");
    }
}
