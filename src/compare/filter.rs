//! What the eye blurs: the contrast sensitivity of each opponent channel as a sum of Gaussians, after Johnson and Fairchild
//! as fitted in the FLIP paper (its Table 1).

use super::plane::Plane;
use crate::base::maths::exp;
use std::f64::consts::PI;

/// A Gaussian of the contrast sensitivity function: height and the exponent's width, in degrees squared.
type Term = (f64, f64);

/// Terms for the achromatic, red-green and blue-yellow channel.
const SENSITIVITY: [&[Term]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];

/// A channel (0 achromatic, 1 red-green, 2 blue-yellow) as the eye sees it at a distance.
pub(super) fn seen(plane: &Plane, channel: usize, pixels_per_degree: f64) -> Plane {
    let terms = SENSITIVITY[channel];
    let kernels: Vec<(f64, Vec<f32>)> = terms.iter().map(|&term| kernel(term, pixels_per_degree)).collect();
    let total: f64 = kernels.iter().map(|(weight, _)| weight).sum();
    let mut sum = Plane { width: plane.width, values: vec![0.0; plane.values.len()] };
    for (weight, row) in &kernels {
        let blurred = plane.correlated(row, row);
        let share = (weight / total) as f32;
        sum.values.iter_mut().zip(&blurred.values).for_each(|(s, v)| *s += share * v);
    }
    sum
}

/// The whole weight of a term's square kernel, and its row normalised to 1. A Gaussian in two dimensions is the product of
/// its row and its column.
fn kernel((height, width): Term, pixels_per_degree: f64) -> (f64, Vec<f32>) {
    // Three standard deviations of the widest term, for all channels alike.
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
    let value = |i: i32| {
        let degrees = f64::from(i) / pixels_per_degree;
        exp(-PI * PI * degrees * degrees / width)
    };
    let row: Vec<f64> = (-radius..=radius).map(value).collect();
    let sum: f64 = row.iter().sum();
    (height * (PI / width).sqrt() * sum * sum, row.iter().map(|v| (v / sum) as f32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_channel_stays_as_it_is() {
        let plane = Plane { width: 9, values: vec![3.5; 81] };
        for channel in 0..3 {
            assert!(seen(&plane, channel, 67.0).values.iter().all(|v| (v - 3.5).abs() < 1e-5));
        }
    }

    #[test]
    fn colour_is_blurred_more_than_lightness() {
        let mut values = vec![0.0; 441];
        values[220] = 1.0;
        let plane = Plane { width: 21, values };
        let peaks: Vec<f32> = (0..3).map(|channel| seen(&plane, channel, 67.0).values[220]).collect();
        assert!(peaks[0] > peaks[1] && peaks[1] > 2.0 * peaks[2], "{peaks:?}");
    }
}
