//! Pictures in linear light, references of many samples, and how far a picture is from them.

use crate::base::encoding::linear_values;
use crate::base::picture::Picture;
use crate::frame::Frame;
use crate::raster;

/// A picture in linear light.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue of each pixel, 0..1.
    pub pixels: Vec<[f32; 3]>,
}

/// How far a picture is from its reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    /// Root mean square difference over pixels and colours.
    pub rmse: f64,
    /// Mean of (x - r)^2 / (r^2 + 0.01), by which dark pictures count too.
    pub relative: f64,
}

impl Linear {
    /// Of an 8-bit picture.
    #[must_use]
    pub fn of(picture: &Picture) -> Self {
        let table = linear_values();
        let pixel = |pixel: &[u8; 4]| [0, 1, 2].map(|k| table[usize::from(pixel[k])]);
        Self { width: picture.width, height: picture.height, pixels: picture.pixels.iter().map(pixel).collect() }
    }

    /// Each `side` x `side` pixels averaged to one.
    #[must_use]
    pub fn averaged(&self, side: u32) -> Self {
        let (width, height) = (self.width / side, self.height / side);
        let share = 1.0 / f64::from(side * side);
        let pixel = |x: u32, y: u32| {
            let mut sum = [0.0f64; 3];
            for row in y * side..(y + 1) * side {
                let start = (row * self.width + x * side) as usize;
                for pixel in &self.pixels[start..start + side as usize] {
                    (0..3).for_each(|k| sum[k] += f64::from(pixel[k]));
                }
            }
            sum.map(|sum| (sum * share) as f32)
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        Self { width, height, pixels }
    }

    /// How far it is from a reference of the same size.
    #[must_use]
    pub fn distance(&self, reference: &Self) -> Distance {
        let (mut square, mut relative) = (0.0, 0.0);
        for (pixel, reference) in self.pixels.iter().zip(&reference.pixels) {
            for k in 0..3 {
                let (x, r) = (f64::from(pixel[k]), f64::from(reference[k]));
                square += (x - r) * (x - r);
                relative += (x - r) * (x - r) / (r * r + 0.01);
            }
        }
        let count = 3.0 * self.pixels.len().max(1) as f64;
        Distance { rmse: (square / count).sqrt(), relative: relative / count }
    }
}

/// The picture of a frame with its own samples.
#[must_use]
pub fn drawn(frame: &Frame) -> Linear {
    Linear::of(&raster::draw(frame).0)
}

/// The picture of a frame as it would be with `side` x `side` x `samples` samples: drawn so many times as large and averaged in
/// linear light after the tone curve. Meshes, textures and shading are as fine as the larger picture makes them.
#[must_use]
pub fn reference(frame: &Frame, side: u32, samples: u32) -> Linear {
    let mut large = frame.clone();
    large.view.width *= side;
    large.view.height *= side;
    large.view.samples = samples;
    large.view.lod_error = 0.0;
    drawn(&large).averaged(side)
}

/// Mean structural similarity of the luma of two pictures (Wang and others 2004): Gaussian of 1.5 pixels, 11 wide, on encoded
/// values of 0..1.
#[must_use]
pub fn structural_similarity(a: &Linear, b: &Linear) -> f64 {
    let luma = |picture: &Linear| -> Vec<f64> {
        let encoded = |value: f32| f64::from(crate::base::maths::linear_to_srgb(value));
        picture.pixels.iter().map(|p| 0.299 * encoded(p[0]) + 0.587 * encoded(p[1]) + 0.114 * encoded(p[2])).collect()
    };
    let (width, height) = (a.width as usize, a.height as usize);
    let (x, y) = (luma(a), luma(b));
    let product = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(p, q)| p * q).collect::<Vec<f64>>();
    let blur = |plane: &[f64]| blurred(plane, width, height);
    let (mean_x, mean_y) = (blur(&x), blur(&y));
    let (xx, yy, xy) = (blur(&product(&x, &x)), blur(&product(&y, &y)), blur(&product(&x, &y)));
    let similarity = |i: usize| {
        let (mx, my) = (mean_x[i], mean_y[i]);
        let (vx, vy, covariance) = (xx[i] - mx * mx, yy[i] - my * my, xy[i] - mx * my);
        (2.0 * mx * my + 1e-4) * (2.0 * covariance + 9e-4) / ((mx * mx + my * my + 1e-4) * (vx + vy + 9e-4))
    };
    (0..x.len()).map(similarity).sum::<f64>() / x.len().max(1) as f64
}

/// A plane under a Gaussian; its edge pixels go on outside.
fn blurred(plane: &[f64], width: usize, height: usize) -> Vec<f64> {
    let weights: Vec<f64> = (-5i32..=5).map(|i| crate::base::maths::exp(-f64::from(i * i) / 4.5)).collect();
    let sum: f64 = weights.iter().sum();
    let near = |at: usize, step: usize, count: usize| (at + step).saturating_sub(5).min(count.saturating_sub(1));
    let pass = |plane: &[f64], across: bool| -> Vec<f64> {
        let value = |x: usize, y: usize| {
            let taken = |(step, weight): (usize, &f64)| {
                let (x, y) = if across { (near(x, step, width), y) } else { (x, near(y, step, height)) };
                plane[y * width + x] * weight
            };
            weights.iter().enumerate().map(taken).sum::<f64>() / sum
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect()
    };
    pass(&pass(plane, true), false)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(width: u32, height: u32) -> Linear {
        let pixel = |i: u32| [i as f32 / (width * height) as f32, 0.5, 0.0];
        Linear { width, height, pixels: (0..width * height).map(pixel).collect() }
    }

    #[test]
    fn averages_are_the_means_of_their_pixels() {
        let small = ramp(4, 4).averaged(2);
        assert_eq!((small.width, small.height), (2, 2));
        assert!((small.pixels[0][0] - (1.0 + 4.0 + 5.0) / 4.0 / 16.0).abs() < 1e-6 && small.pixels[3][1] == 0.5);
    }

    #[test]
    fn distances_are_those_of_the_formulae() {
        let (a, mut b) = (ramp(4, 4), ramp(4, 4));
        assert_eq!(a.distance(&b), Distance::default());
        b.pixels[7][2] = 0.4;
        let far = b.distance(&a);
        assert!((far.rmse - 0.4 / 48f64.sqrt()).abs() < 1e-6 && (far.relative - 0.16 / 0.01 / 48.0).abs() < 1e-5);
    }

    #[test]
    fn a_picture_is_like_itself_and_less_like_another() {
        let (a, mut b) = (ramp(16, 16), ramp(16, 16));
        assert!((structural_similarity(&a, &b) - 1.0).abs() < 1e-12);
        b.pixels.iter_mut().step_by(2).for_each(|pixel| *pixel = [0.9; 3]);
        assert!(structural_similarity(&a, &b) < 0.8);
    }
}
