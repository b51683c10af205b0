//! The texture of a trunk: grey plates between dark, wandering fissures that run along the stem.

use super::noise::fractal;
use crate::base::maths::{linear_to_srgb8, mix, smooth_step};
use crate::base::random::hash;
use crate::frame::Texture;

/// Pixels along one side; one repeat is half a metre, so a millimetre is a pixel.
const SIZE: u32 = 512;

/// Paints bark of a mean reflectance (linear sRGB).
pub(super) fn texture(colour: [f64; 3], seed: u64) -> Texture {
    let salt = |n: u64| hash(seed, n);
    let mut pixels = Vec::with_capacity((SIZE * SIZE) as usize);
    for (row, column) in (0..SIZE).flat_map(|row| (0..SIZE).map(move |column| (row, column))) {
        let (u, v) = (column as f32 / SIZE as f32, row as f32 / SIZE as f32);
        let wander = (fractal(u, v, 5, 4, 3, salt(1)) - 0.5) * 0.10;
        let ridge = (fractal(u + wander, v, 22, 4, 2, salt(2)) - 0.5).abs();
        let fissure = 1.0 - smooth_step(0.0, 0.075, ridge);
        let across = (fractal(u, v + wander, 6, 26, 2, salt(3)) - 0.5).abs();
        let crack = 0.4 * (1.0 - smooth_step(0.0, 0.03, across));
        let grain = fractal(u, v, 48, 12, 3, salt(4));
        let lichen = smooth_step(0.56, 0.72, fractal(u, v, 5, 5, 4, salt(5)));
        let light = (0.75 + 0.5 * grain) * (1.0 - 0.62 * fissure) * (1.0 - crack * 0.6);
        let texel = std::array::from_fn(|k| {
            let pale = [0.30, 0.33, 0.27][k];
            linear_to_srgb8(mix(colour[k] as f32, pale, lichen * 0.35) * light)
        });
        pixels.push(texel);
    }
    Texture { name: "bark".to_owned(), width: SIZE, height: SIZE, pixels, repeat: true }
}
