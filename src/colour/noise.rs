//! Irregularity in the plane that does not repeat: smooth noise in octaves.

use crate::base::noise::Lattice;

/// Lattice noise of one salt. Values are functions of place and salt alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise(pub u64);

impl Noise {
    /// Three octaves, mean 0 and standard deviation about 0.5; the coarsest features are 1 / `frequency` across.
    pub(super) fn octaves(self, x: f32, y: f32, frequency: f32) -> f32 {
        let (mut sum, mut weight, mut f) = (0.0, 1.0, frequency);
        for octave in 0..3u64 {
            // Octaves are shifted against each other, or all would vanish together at lattice points.
            let shift = octave as f32 * 0.37;
            sum += weight * Lattice::new(self.0 ^ (octave << 60)).gradient(x * f + shift, y * f + shift);
            weight *= 0.5;
            f *= 2.13;
        }
        sum * 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(values: &[f32]) -> (f64, f64) {
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|&v| (f64::from(v) - mean) * (f64::from(v) - mean)).sum::<f64>();
        (mean, (square / values.len() as f64).sqrt())
    }

    fn samples(salt: u64) -> Vec<f32> {
        (0..10_000).map(|i| Noise(salt).octaves((i % 100) as f32 * 0.31, (i / 100) as f32 * 0.31, 1.0)).collect()
    }

    #[test]
    fn octaves_have_mean_zero_and_their_spread() {
        let (mean, spread) = moments(&samples(3));
        assert!(mean.abs() < 0.05 && (0.3..0.7).contains(&spread), "{mean} {spread}");
    }

    #[test]
    fn other_salts_give_other_noise() {
        let (a, b) = (samples(1), samples(2));
        let together: f64 = a.iter().zip(&b).map(|(a, b)| f64::from(a * b)).sum::<f64>() / a.len() as f64;
        assert!(together.abs() < 0.03, "{together}");
    }

    #[test]
    fn neighbours_are_near_in_value() {
        let noise = Noise(5);
        for i in 0..200 {
            let x = i as f32 * 0.173;
            assert!((noise.octaves(x, 1.0, 1.0) - noise.octaves(x + 1e-3, 1.0, 1.0)).abs() < 0.03);
        }
    }
}
