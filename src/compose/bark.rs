//! Bark: a texture for every class of girth that the tree has, painted in metres, so that a ridge is as wide on a limb as
//! on the trunk. What one texture shows depends on the species' kind of bark and on how old the girth makes it.

use super::bark_pattern::{Bark, Scale};
use crate::base::encoding::SrgbEncoder;
use crate::base::random::hash;
use crate::frame::Texture;
use crate::tree::{Settings, Wood};
use rayon::prelude::*;

/// Pixels around of the thinnest and of the thickest wood's texture; twice as many along.
const LEAST: u32 = 64;
const MOST: u32 = 512;
/// Size of a pixel that is aimed at, metres.
const PIXEL: f64 = 0.0017;

/// The texture of the wood of one class of girth.
pub(super) fn texture(settings: &Settings, wood: &Wood, seed: u64) -> Texture {
    let encoder = SrgbEncoder::default();
    let width = ((wood.repeat / PIXEL) as u32).next_power_of_two().clamp(LEAST, MOST);
    let height = width * 2;
    let scale = Scale { around: wood.repeat, along: wood.repeat * 2.0 };
    let bark = Bark::new(settings, wood.radius, scale, hash(seed, 0xBA4C + wood.class as u64));
    let texel = |index: u32| {
        let (column, row) = (index % width, index / width);
        let (u, v) = ((column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32);
        bark.colour(u, v).map(|value| encoder.code(value))
    };
    let pixels = (0..width * height).into_par_iter().map(texel).collect();
    Texture { name: format!("bark_{}", wood.class), width, height, pixels, repeat: true }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::srgb_to_linear;
    use crate::base::mesh::Mesh;
    use crate::tree::BarkKind;
    use std::sync::Arc;

    fn wood(class: usize) -> Wood {
        let radius = 0.00425 * f64::from(1u32 << class);
        let repeat = std::f64::consts::TAU * radius.min(0.14);
        Wood { class, mesh: Arc::new(Mesh::default()), radius, repeat }
    }

    const KINDS: [BarkKind; 5] =
        [BarkKind::Smooth, BarkKind::Ridged, BarkKind::Plated, BarkKind::Papery, BarkKind::Scarred];

    /// Mean and deviation of the green of a texture, linear.
    fn moments(texture: &Texture) -> (f64, f64) {
        let values: Vec<f64> = texture.pixels.iter().map(|p| srgb_to_linear(f32::from(p[1]) / 255.0).into()).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        (mean, (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count).sqrt())
    }

    #[test]
    fn textures_tile() {
        // The step over the rim is no larger than the steps inside: there is no seam.
        for kind in KINDS {
            let settings = Settings { bark_kind: kind, ..Settings::default() };
            let texture = texture(&settings, &wood(4), 1);
            let (width, height) = (texture.width as usize, texture.height as usize);
            let step = |a: usize, b: usize| {
                let [a, b] = [a, b].map(|at| texture.pixels[at].map(i32::from));
                (0..3).map(|k| (a[k] - b[k]).abs()).sum::<i32>() as f64
            };
            let columns =
                |a: usize, b: usize| (0..height).map(|row| step(row * width + a, row * width + b)).sum::<f64>();
            let rows =
                |a: usize, b: usize| (0..width).map(|column| step(a * width + column, b * width + column)).sum::<f64>();
            let inside =
                |f: &dyn Fn(usize, usize) -> f64, count: usize| (1..count).map(|at| f(at - 1, at)).fold(0.0, f64::max);
            assert!(columns(width - 1, 0) <= 1.3 * inside(&columns, width), "{kind:?}");
            assert!(rows(height - 1, 0) <= 1.3 * inside(&rows, height), "{kind:?}");
        }
    }

    #[test]
    fn old_bark_breaks_up_and_twigs_have_their_own_colour() {
        for kind in [BarkKind::Ridged, BarkKind::Plated, BarkKind::Papery] {
            let settings = Settings { bark_kind: kind, ..Settings::default() };
            let textures = [0, 3, 6].map(|class| texture(&settings, &wood(class), 1));
            let [twig, young, old] = [0, 1, 2].map(|at| moments(&textures[at]));
            assert!((twig.0 / settings.twig_bark[1] - 1.0).abs() < 0.2, "{kind:?} {twig:?}");
            assert!(old.1 / old.0 > 1.3 * young.1 / young.0, "{kind:?} {young:?} {old:?}");
        }
    }

    #[test]
    fn a_pixel_is_a_millimetre_or_two() {
        for class in 2..9 {
            let wood = wood(class);
            let texture = texture(&Settings::default(), &wood, 1);
            let pixel = wood.repeat / f64::from(texture.width);
            assert!((0.0003..0.002).contains(&pixel), "{pixel}");
        }
    }
}
