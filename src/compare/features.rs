//! Edges and points: what the eye notices at once when it appears or goes. First and second derivative of a Gaussian on
//! the achromatic channel, along both axes.

use super::plane::Plane;
use crate::base::maths::exp;

/// Width of the feature detector, degrees: the period to which the eye is most sensitive.
const DETECTOR_WIDTH: f64 = 0.082;

/// The strength of edges and of points at each pixel.
pub(super) struct Features {
    pub(super) edges: Vec<f32>,
    pub(super) points: Vec<f32>,
}

impl Features {
    /// The features of lightness scaled to 0..1.
    pub(super) fn of(lightness: &Plane, pixels_per_degree: f64) -> Self {
        let kernels = Kernels::new(pixels_per_degree);
        let strength = |derivative: &[f32]| {
            let across = lightness.correlated(derivative, &kernels.smooth);
            let down = lightness.correlated(&kernels.smooth, derivative);
            across.values.iter().zip(&down.values).map(|(x, y)| (x * x + y * y).sqrt()).collect()
        };
        Self { edges: strength(&kernels.first), points: strength(&kernels.second) }
    }

    /// The larger change of the two at a pixel.
    pub(super) fn change(&self, other: &Self, pixel: usize) -> f32 {
        let edge = (self.edges[pixel] - other.edges[pixel]).abs();
        edge.max((self.points[pixel] - other.points[pixel]).abs())
    }
}

/// Rows of the separable kernels: the Gaussian sums to 1; of a derivative the positive weights sum to 1, the negative to -1.
struct Kernels {
    smooth: Vec<f32>,
    first: Vec<f32>,
    second: Vec<f32>,
}

impl Kernels {
    fn new(pixels_per_degree: f64) -> Self {
        let deviation = 0.5 * DETECTOR_WIDTH * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i32;
        let row = |factor: &dyn Fn(f64) -> f64| {
            let weight = |i: i32| {
                let x = f64::from(i) / deviation;
                factor(x) * exp(-0.5 * x * x)
            };
            balanced(&(-radius..=radius).map(weight).collect::<Vec<f64>>())
        };
        Self { smooth: row(&|_| 1.0), first: row(&|x| -x), second: row(&|x| x * x - 1.0) }
    }
}

fn balanced(weights: &[f64]) -> Vec<f32> {
    let positive: f64 = weights.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = -weights.iter().filter(|w| **w < 0.0).sum::<f64>();
    weights.iter().map(|&w| (if w > 0.0 { w / positive } else { w / negative.max(f64::MIN_POSITIVE) }) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_an_edge_of_strength_one_and_flat_ground_is_nothing() {
        let values = (0..60 * 60).map(|i| if i % 60 < 30 { 0.0 } else { 1.0 }).collect();
        let found = Features::of(&Plane { width: 60, values }, 67.0);
        let at = |x: usize| (found.edges[30 * 60 + x], found.points[30 * 60 + x]);
        assert!(at(30).0 > 0.8 && at(30).0 <= 1.0 + 1e-6);
        assert!(at(5).0 < 1e-6 && at(5).1 < 1e-6);
    }
}
