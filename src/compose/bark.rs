//! Bark: a texture for every class of girth that the tree has, painted in metres, so that a ridge is as wide on a limb as
//! on the trunk. What one texture shows depends on the species' kind of bark and on how old the girth makes it.

use super::bark_pattern::{Bark, Scale};
use crate::base::encoding::SrgbEncoder;
use crate::base::maths::srgb_to_linear;
use crate::base::random::hash;
use crate::base::vector::DVec3;
use crate::frame::Texture;
use crate::tree::{BarkKind, Settings, Wood};
use rayon::prelude::*;
use std::sync::Arc;

/// Pixels around of the thinnest and of the thickest wood's texture; twice as many along.
const LEAST: u32 = 64;
const MOST: u32 = 512;
/// Size of a pixel that is aimed at, metres.
const PIXEL: f64 = 0.0017;

/// Thinnest wood that has relief, metres of radius: finer bark shows none.
const LEAST_RADIUS: f64 = 0.02;

/// Metres by which bark of a kind rises where it is lightest over its mean, where it is old (judged: furrows of two or three
/// centimetres in old oaks, paper-thin curls in birches).
fn height(kind: BarkKind) -> f64 {
    match kind {
        BarkKind::Smooth => 0.0009,
        BarkKind::Ridged => 0.0085,
        BarkKind::Plated => 0.0050,
        BarkKind::Papery => 0.0014,
        BarkKind::Scarred => 0.0018,
    }
}

/// The relief of a bark's texture: what lies deep is dark, so its heights follow its light. None for thin wood.
pub(super) fn relief(settings: &Settings, wood: &Wood, bark: &Texture) -> Option<Texture> {
    if wood.radius < LEAST_RADIUS {
        return None;
    }
    let linear: Vec<f64> = (0..=255u8).map(|code| f64::from(srgb_to_linear(f32::from(code) / 255.0))).collect();
    let light: Vec<f64> = bark.pixels.iter().map(|pixel| linear[usize::from(pixel[1])]).collect();
    let mean = light.iter().sum::<f64>() / light.len().max(1) as f64;
    let (width, rows) = (bark.width as usize, bark.height as usize);
    // Bark's thickness grows with the wood; young bark is shallow.
    let rise = height(settings.bark_kind) * (wood.radius / 0.12).min(1.0) / mean.max(1e-6);
    let metre = f64::from(bark.width) / wood.repeat;
    let texel = |index: usize| {
        let (x, y) = (index % width, index / width);
        let at = |x: usize, y: usize| light[(y % rows) * width + x % width].min(1.6 * mean);
        let across = at(x + 1, y) - at(x + width - 1, y);
        let down = at(x, y + 1) - at(x, y + rows - 1);
        // Two pixels lie between the neighbours of one.
        let slope = 0.5 * rise * metre;
        let normal = DVec3::new(-across * slope, down * slope, 1.0).normalize();
        let normal: [f64; 3] = normal.into();
        normal.map(|part| (part * 127.0 + 128.0) as u8)
    };
    let pixels = Arc::new((0..width * rows).into_par_iter().map(texel).collect());
    Some(Texture { name: format!("{}_relief", bark.name), pixels, ..bark.clone() })
}

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
    let pixels = Arc::new((0..width * height).into_par_iter().map(texel).collect());
    Texture { name: format!("bark_{}", wood.class), width, height, pixels, repeat: true }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Mesh;
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

    #[test]
    fn reliefs_are_normals_that_lean_both_ways_and_twigs_have_none() {
        for kind in KINDS {
            let settings = Settings { bark_kind: kind, ..Settings::default() };
            let wood = wood(5);
            let bark = texture(&settings, &wood, 1);
            let relief = relief(&settings, &wood, &bark).expect("a limb has relief");
            let part = |k: usize| relief.pixels.iter().map(move |pixel| (f64::from(pixel[k]) - 128.0) / 127.0);
            let count = relief.pixels.len() as f64;
            // Over a repeat heights come back to where they began, so slopes have no mean.
            assert!((part(0).sum::<f64>() / count).abs() < 0.02 && (part(1).sum::<f64>() / count).abs() < 0.02);
            assert!(part(2).all(|out| out > 0.0) && part(0).any(|slope| slope.abs() > 0.02), "{kind:?}");
        }
        let thin = wood(1);
        let settings = Settings::default();
        assert!(relief(&settings, &thin, &texture(&settings, &thin, 1)).is_none());
    }
}
