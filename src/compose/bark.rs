//! The texture of a trunk: grey plates between dark, wandering fissures that run along the stem. Nothing in it is wider
//! than a few centimetres, so that its repeats do not show.

use super::noise::fractal;
use crate::base::encoding::SrgbEncoder;
use crate::base::maths::{mix, smooth_step};
use crate::base::random::hash;
use crate::frame::Texture;
use rayon::prelude::*;

/// Pixels along one side; one repeat is half a metre, so a millimetre is a pixel.
const SIZE: u32 = 512;

/// Paints bark of a mean reflectance (linear sRGB).
pub(super) fn texture(colour: [f64; 3], seed: u64) -> Texture {
    let salt = |n: u64| hash(seed, n);
    let encoder = SrgbEncoder::default();
    let texel = |index: u32| {
        let (u, v) = ((index % SIZE) as f32 / SIZE as f32, (index / SIZE) as f32 / SIZE as f32);
        let wander = (fractal(u, v, 6, 3, 2, salt(1)) - 0.5) * 0.12;
        let ridge = (fractal(u + wander, v, 15, 3, 2, salt(2)) - 0.5).abs();
        let fissure = 1.0 - smooth_step(0.0, 0.11, ridge);
        let fine = (fractal(u + wander, v, 40, 7, 2, salt(3)) - 0.5).abs();
        let cracks = 1.0 - smooth_step(0.0, 0.09, fine);
        let grain = fractal(u, v, 64, 16, 2, salt(4));
        let lichen = smooth_step(0.55, 0.75, fractal(u, v, 11, 9, 2, salt(5)));
        let light = (0.78 + 0.5 * grain) * (1.0 - 0.30 * fissure) * (1.0 - 0.45 * cracks);
        std::array::from_fn(|k| {
            let pale = [0.30, 0.33, 0.27][k];
            encoder.code(mix(colour[k] as f32, pale, lichen * 0.25) * light)
        })
    };
    let pixels: Vec<[u8; 3]> = (0..SIZE * SIZE).into_par_iter().map(texel).collect();
    Texture { name: "bark".to_owned(), width: SIZE, height: SIZE, pixels, repeat: true }
}
