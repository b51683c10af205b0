//! FLIP for pictures with 8 bits a channel.
//!
//! Source: P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images", Proceedings of the ACM on Computer Graphics and Interactive Techniques 3(2), 2020.
//! Written from its formulas. The two-dimensional kernels are applied as rows and columns, which is the same.

use super::colour_space::{hunt_lab, hyab, rgb_from_ycxcz, ycxcz};
use super::features::Features;
use super::filter::seen;
use super::plane::Plane;
use crate::base::maths::powf;
use rayon::prelude::*;

/// Pixels in a degree of the observer's view: the paper's screen, 3840 pixels on 0.7 m seen from 0.7 m (67.02).
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Exponent of colour differences.
const COLOUR_EXPONENT: f32 = 0.7;
/// Share of the largest colour difference that maps to `KNEE_VALUE`.
const KNEE: f32 = 0.4;
/// Where the knee maps to.
const KNEE_VALUE: f32 = 0.95;
/// Exponent of feature differences.
const FEATURE_EXPONENT: f32 = 0.5;

/// Mean FLIP error of two pictures of one size, given in linear sRGB 0..1, row by row.
pub(super) fn flip(a: &[[f32; 3]], b: &[[f32; 3]], width: usize) -> f64 {
    let rows: Vec<f64> = flip_map(a, b, width).chunks(width.max(1)).map(|row| row.iter().sum::<f64>()).collect();
    rows.iter().sum::<f64>() / a.len().max(1) as f64
}

/// FLIP error of each pixel, 0..1, of two pictures of one size, given in linear sRGB 0..1, row by row.
#[must_use]
pub fn flip_map(a: &[[f32; 3]], b: &[[f32; 3]], width: usize) -> Vec<f64> {
    if a.is_empty() || a.len() != b.len() {
        return Vec::new();
    }
    let (eye_a, eye_b) = (Seen::of(a, width), Seen::of(b, width));
    let largest = powf(hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])), COLOUR_EXPONENT);
    let error = |pixel: usize| {
        let colour = colour_error(hyab(eye_a.lab[pixel], eye_b.lab[pixel]), largest);
        let change = eye_a.features.change(&eye_b.features, pixel);
        let feature = powf(change * std::f32::consts::FRAC_1_SQRT_2, FEATURE_EXPONENT).min(1.0);
        f64::from(powf(colour, 1.0 - feature))
    };
    (0..a.len()).into_par_iter().with_min_len(width).map(error).collect()
}

/// What the observer perceives of a picture.
struct Seen {
    lab: Vec<[f32; 3]>,
    features: Features,
}

impl Seen {
    fn of(linear: &[[f32; 3]], width: usize) -> Self {
        let opponent: Vec<[f32; 3]> = linear.par_iter().map(|&rgb| ycxcz(rgb)).collect();
        let lightness = Plane::of(&opponent, width, |c| (c[0] + 16.0) / 116.0);
        let features = Features::of(&lightness, PIXELS_PER_DEGREE);
        let channel = |c: usize| seen(&Plane::of(&opponent, width, |p| p[c]), c, PIXELS_PER_DEGREE);
        let blurred = [channel(0), channel(1), channel(2)];
        let perceived = |pixel: usize| hunt_lab(rgb_from_ycxcz([0, 1, 2].map(|c: usize| blurred[c].values[pixel])));
        Self { lab: (0..linear.len()).into_par_iter().map(perceived).collect(), features }
    }
}

/// A colour distance as an error 0..1: most of the range for differences that occur, the rest compressed.
fn colour_error(distance: f32, largest: f32) -> f32 {
    let power = powf(distance, COLOUR_EXPONENT);
    let knee = KNEE * largest;
    if power < knee {
        power * KNEE_VALUE / knee
    } else {
        (KNEE_VALUE + (power - knee) / (largest - knee) * (1.0 - KNEE_VALUE)).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checks(width: usize, colours: [[f32; 3]; 2]) -> Vec<[f32; 3]> {
        (0..width * width).map(|i| colours[(i % width / 5 + i / width / 5) % 2]).collect()
    }

    #[test]
    fn the_mean_is_that_of_the_map_and_what_is_alike_has_no_error() {
        let (a, mut b) = (checks(12, [[0.1; 3], [0.7; 3]]), checks(12, [[0.1; 3], [0.7; 3]]));
        assert!(flip_map(&a, &b, 12).iter().all(|error| *error == 0.0));
        b[5] = [0.9, 0.1, 0.1];
        let map = flip_map(&a, &b, 12);
        assert!(map.len() == a.len() && map.iter().all(|error| (0.0..=1.0).contains(error)) && map[5] > 0.2);
        assert!((flip(&a, &b, 12) - map.iter().sum::<f64>() / map.len() as f64).abs() < 1e-12);
        assert!(flip_map(&a, &b[1..], 12).is_empty());
    }

    #[test]
    fn the_error_is_symmetric_and_grows_with_the_difference() {
        let plain = checks(30, [[0.2, 0.3, 0.1], [0.25, 0.3, 0.1]]);
        let near = checks(30, [[0.2, 0.3, 0.1], [0.28, 0.3, 0.1]]);
        let far = checks(30, [[0.2, 0.3, 0.1], [0.6, 0.1, 0.1]]);
        assert_eq!(flip(&plain, &near, 30), flip(&near, &plain, 30));
        assert!(flip(&plain, &plain, 30) == 0.0);
        assert!(flip(&plain, &near, 30) < 0.5 * flip(&plain, &far, 30));
    }

    #[test]
    fn the_thread_count_does_not_show() {
        let (a, b) = (checks(40, [[0.1; 3], [0.7, 0.2, 0.1]]), checks(40, [[0.12; 3], [0.7, 0.3, 0.0]]));
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| flip(&a, &b, 40)).to_bits()
        };
        assert_eq!(with(1), with(3));
    }

    #[test]
    fn the_curve_of_colour_errors_ends_at_one() {
        let largest: f32 = 41.0;
        let at = |power: f32| colour_error(powf(power, 1.0 / COLOUR_EXPONENT), largest);
        assert!((at(KNEE * largest) - KNEE_VALUE).abs() < 1e-5);
        assert!((at(largest) - 1.0).abs() < 1e-5);
        assert_eq!(at(2.0 * largest), 1.0);
    }
}
