//! The three figures of a pair of pictures.

use super::flip::flip;
use crate::base::encoding::linear_values;
use crate::base::picture::Picture;
use serde::Serialize;
use thiserror::Error;

/// How far two pictures are apart. Identical pictures give exact zeros.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Largest difference of any channel, alpha included, in 8-bit steps. Pixels that are both transparent are equal.
    pub max_difference: u8,
    /// Number of pixels that differ.
    pub differing_pixels: u64,
    /// Root mean square difference of linear sRGB, premultiplied by alpha, over all pixels and the three colours, 0..1.
    pub rmse: f64,
    /// Mean FLIP error, 0..1. Pictures with transparent pixels are laid on black and on white, and the worse one counts.
    pub flip: f64,
}

/// The pictures have different sizes, so that no figure makes sense.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("the sizes differ: {} x {} and {} x {}", .a.0, .a.1, .b.0, .b.1)]
pub struct SizesDiffer {
    /// Width and height of the first.
    pub a: (u32, u32),
    /// Width and height of the second.
    pub b: (u32, u32),
}

/// Compares two pictures.
///
/// # Errors
/// [`SizesDiffer`] when they differ in width or height, or one has not the pixels that its size promises.
pub fn compare(a: &Picture, b: &Picture) -> Result<Comparison, SizesDiffer> {
    let size = |picture: &Picture| (picture.width, picture.height);
    if size(a) != size(b) || a.pixels.len() != b.pixels.len() {
        return Err(SizesDiffer { a: size(a), b: size(b) });
    }
    let differences = a.pixels.iter().zip(&b.pixels).map(|(&p, &q)| largest_step(p, q));
    let max_difference = differences.clone().max().unwrap_or(0);
    let differing_pixels = differences.filter(|&step| step > 0).count() as u64;
    if max_difference == 0 {
        return Ok(Comparison { max_difference, differing_pixels, rmse: 0.0, flip: 0.0 });
    }
    Ok(Comparison { max_difference, differing_pixels, rmse: rmse(a, b), flip: worst_flip(a, b) })
}

fn largest_step(p: [u8; 4], q: [u8; 4]) -> u8 {
    if p[3] == 0 && q[3] == 0 {
        return 0;
    }
    (0..4).map(|channel| p[channel].abs_diff(q[channel])).fold(0, u8::max)
}

fn rmse(a: &Picture, b: &Picture) -> f64 {
    let table = linear_values();
    // Rows are summed by themselves first: short sums of like numbers lose less, and the order is fixed.
    let row_sum = |(row_a, row_b): (&[[u8; 4]], &[[u8; 4]])| {
        let squares =
            row_a.iter().zip(row_b).map(|(&p, &q)| square_distance(over(p, 0.0, &table), over(q, 0.0, &table)));
        squares.sum::<f64>()
    };
    let width = a.width.max(1) as usize;
    let sum: f64 = a.pixels.chunks(width).zip(b.pixels.chunks(width)).map(row_sum).sum();
    (sum / (3.0 * a.pixels.len() as f64)).sqrt()
}

fn square_distance(p: [f32; 3], q: [f32; 3]) -> f64 {
    (0..3).map(|c| f64::from(p[c]) - f64::from(q[c])).map(|d| d * d).sum()
}

fn worst_flip(a: &Picture, b: &Picture) -> f64 {
    let table = linear_values();
    let on = |picture: &Picture, ground| picture.pixels.iter().map(|&p| over(p, ground, &table)).collect::<Vec<_>>();
    let on_ground = |ground| flip(&on(a, ground), &on(b, ground), a.width as usize);
    let opaque = |picture: &Picture| picture.pixels.iter().all(|p| p[3] == 255);
    let on_black = on_ground(0.0);
    if opaque(a) && opaque(b) { on_black } else { on_black.max(on_ground(1.0)) }
}

/// Linear colour of a pixel laid on a grey ground. On black this is premultiplication.
fn over([r, g, b, alpha]: [u8; 4], ground: f32, table: &[f32; 256]) -> [f32; 3] {
    let alpha = f32::from(alpha) / 255.0;
    [r, g, b].map(|code| table[usize::from(code)] * alpha + ground * (1.0 - alpha))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::srgb_to_linear;

    fn noise(seed: u64, width: u32, height: u32) -> Picture {
        let byte = |i: u64, c: u64| (crate::base::random::hash(seed, i * 4 + c) >> 56) as u8;
        let pixels = (0..u64::from(width) * u64::from(height)).map(|i| [byte(i, 0), byte(i, 1), byte(i, 2), 255]);
        Picture { width, height, pixels: pixels.collect() }
    }

    #[test]
    fn identical_pictures_give_exact_zeros() {
        let picture = noise(1, 33, 21);
        let zero = Comparison { max_difference: 0, differing_pixels: 0, rmse: 0.0, flip: 0.0 };
        assert_eq!(compare(&picture, &picture), Ok(zero));
    }

    #[test]
    fn black_and_white_are_as_far_apart_as_can_be() {
        let black = Picture::filled(24, 24, [0, 0, 0, 255]);
        let white = Picture::filled(24, 24, [255; 4]);
        let found = compare(&black, &white).unwrap();
        assert_eq!((found.max_difference, found.differing_pixels, found.rmse), (255, 576, 1.0));
        assert!(found.flip > 0.9 && found.flip <= 1.0, "{found:?}");
    }

    #[test]
    fn one_step_of_one_channel_has_its_closed_form() {
        let mut picture = Picture::filled(8, 4, [100, 100, 100, 255]);
        let before = picture.clone();
        picture.pixels[9][1] = 101;
        let found = compare(&before, &picture).unwrap();
        let step = f64::from(srgb_to_linear(101.0 / 255.0)) - f64::from(srgb_to_linear(100.0 / 255.0));
        assert_eq!((found.max_difference, found.differing_pixels), (1, 1));
        assert!((found.rmse - (step * step / 96.0).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn transparent_pixels_are_equal_whatever_their_colour() {
        let (red, blue) = (Picture::filled(5, 5, [255, 0, 0, 0]), Picture::filled(5, 5, [0, 0, 255, 0]));
        assert_eq!(compare(&red, &blue).unwrap().max_difference, 0);
    }

    #[test]
    fn black_on_nothing_differs_from_nothing() {
        let (nothing, black) = (Picture::filled(20, 20, [0; 4]), Picture::filled(20, 20, [0, 0, 0, 255]));
        let found = compare(&nothing, &black).unwrap();
        assert_eq!((found.max_difference, found.rmse), (255, 0.0));
        assert!(found.flip > 0.9);
    }

    #[test]
    fn sizes_must_match() {
        let (a, b) = (Picture::filled(2, 3, [0; 4]), Picture::filled(3, 2, [0; 4]));
        assert_eq!(compare(&a, &b), Err(SizesDiffer { a: (2, 3), b: (3, 2) }));
    }
}
