//! The texture of fair-weather clouds: how dense they are overhead, and how much of the sun reaches each part of them.

use crate::base::maths::{exp, smooth_step};
use crate::base::noise::Fractal;
use crate::base::random::hash;
use crate::frame::Texture;
use rayon::prelude::*;
use std::sync::Arc;

/// Pixels along one side.
const SIZE: usize = 512;
/// Pixels between two looks towards the sun.
const STEP: i64 = 5;
const LOOKS: i64 = 5;

/// Paints the clouds; `sun` is the direction to it over the ground (x, z), any length.
pub(super) fn texture(seed: u64, sun: [f64; 2]) -> Texture {
    let (broad, fine) = (Fractal::new(5, 5, 6, hash(seed, 31)), Fractal::new(11, 11, 4, hash(seed, 32)));
    let length = libm::hypot(sun[0], sun[1]).max(1e-9);
    let towards = sun.map(|part| part / length);
    let mut dense = vec![0.0f32; SIZE * SIZE];
    dense.par_iter_mut().enumerate().for_each(|(index, value)| {
        let (u, v) = ((index % SIZE) as f32 / SIZE as f32, (index / SIZE) as f32 / SIZE as f32);
        // Bent by a second noise, edges billow.
        let bend = 0.06 * (fine.at(u, v) - 0.5);
        *value = smooth_step(0.18, 0.82, 0.85 * broad.at(u + bend, v - bend) + 0.15 * fine.at(u, v));
    });
    let at = |x: i64, y: i64| {
        let wrapped = |place: i64| place.rem_euclid(SIZE as i64) as usize;
        dense[wrapped(y) * SIZE + wrapped(x)]
    };
    let code = |value: f32| (128.0 + 127.0 * value.clamp(0.0, 1.0)) as u8;
    let texel = |index: usize| {
        let (x, y) = ((index % SIZE) as i64, (index / SIZE) as i64);
        let before = |look: i64| {
            let [dx, dy] = towards.map(|part| (part * (look * STEP) as f64) as i64);
            f64::from((at(x + dx, y + dy) - 0.45).max(0.0))
        };
        let met: f64 = (1..=LOOKS).map(before).sum();
        let lit = exp(-1.1 * met) as f32 * (1.0 - 0.35 * smooth_step(0.6, 1.0, dense[index]));
        [code(dense[index]), code(lit), 128]
    };
    let pixels = (0..SIZE * SIZE).into_par_iter().map(texel).collect();
    Texture {
        name: "clouds".to_owned(),
        width: SIZE as u32,
        height: SIZE as u32,
        pixels: Arc::new(pixels),
        repeat: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clouds_span_the_range_and_are_brighter_towards_the_sun() {
        let [from_left, from_right] = [-1.0, 1.0].map(|x| texture(3, [x, 0.0]));
        let densities: Vec<u8> = from_left.pixels.iter().map(|pixel| pixel[0]).collect();
        assert!(densities.iter().any(|&d| d < 150) && densities.iter().any(|&d| d > 235));
        assert!(from_left.pixels.iter().zip(from_right.pixels.iter()).all(|(a, b)| a[0] == b[0]));
        // Where density grows to the right, the sun from the left shines on it.
        let mut sums = [0i64; 2];
        for (index, pixel) in from_left.pixels.iter().enumerate().filter(|(index, _)| index % SIZE + 8 < SIZE) {
            if from_left.pixels[index + 8][0].saturating_sub(pixel[0]) > 12 {
                sums[0] += i64::from(pixel[1]);
                sums[1] += i64::from(from_right.pixels[index][1]);
            }
        }
        assert!(sums[0] > sums[1], "{sums:?}");
    }
}
