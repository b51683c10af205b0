//! Random numbers that belong to someone. Every draw is keyed by (seed, purpose, id, event), so a leaf has the same numbers
//! whatever the thread count, the order of frames, or how many other leaves there are.
//!
//! The generator is ChaCha8 (`rand_chacha`, a named generator whose values are fixed by its specification); the mapping
//! from its words to floats is ours, because that of `rand` may change between releases.

use crate::base::maths::{cos, ln, log1p, sin};
use rand::Rng;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What a stream of numbers is for. The numbers are part of every picture: never renumber, only append.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// Choices of the L-system's derivation.
    Derivation = 1,
    /// Angles and lengths drawn by the turtle.
    Turtle = 2,
    /// Places, sizes and directions of leaves.
    LeafSite = 3,
    /// Waiting times of the season's chain.
    WaitingTime = 4,
    /// Targets of the season's jumps.
    Target = 5,
    /// Which of a state's shapes and textures a leaf wears.
    Variant = 6,
    /// Spots, blotches and noise of textures.
    Texture = 7,
    /// Small irregularities of forces on a leaf.
    Deformation = 8,
    /// Bark, ground and sky detail.
    Surroundings = 9,
    /// Where the trees of a grove stand and how they are turned.
    Planting = 16,
    /// The way down of a falling leaf.
    Flight = 20,
    /// Gusts of wind.
    Gust = 21,
    /// How a fallen leaf lies and when it goes.
    Litter = 22,
    /// When buds open.
    BudBreak = 23,
    /// How fast the leaves of a limb or of a shoot pass through their season.
    Tempo = 24,
    /// How early or late a tree is among its fellows.
    TreeTiming = 25,
}

/// A stream of numbers for one owner.
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of `id` for `purpose`; `event` tells apart successive uses by the same owner.
    #[must_use]
    pub fn new(seed: u64, purpose: Purpose, id: u64, event: u64) -> Self {
        let mut key = [0u8; 32];
        for (slot, word) in key.chunks_exact_mut(8).zip([seed, purpose as u64, id, event]) {
            slot.copy_from_slice(&word.to_le_bytes());
        }
        Self(ChaCha8Rng::from_seed(key))
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1), on the grid of 2^-53.
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Uniform in 0..count, by multiply and shift (bias below 2^-32 for counts below 2^32). `count` must not be 0.
    pub fn below(&mut self, count: u32) -> u32 {
        (((self.bits() >> 32) * u64::from(count)) >> 32) as u32
    }

    /// Exponential with mean 1: the waiting time of a unit-rate event. Finite, since `uniform` is below 1.
    pub fn exponential(&mut self) -> f64 {
        -log1p(-self.uniform())
    }

    /// Normal with mean 0 and standard deviation 1 (Box and Muller 1958; the second number is not kept).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * ln(1.0 - self.uniform())).sqrt();
        let angle = std::f64::consts::TAU * self.uniform();
        let (sine, cosine) = (sin(angle), cos(angle));
        debug_assert!(sine.is_finite());
        radius * cosine
    }
}

/// A 64-bit hash of two words (the finaliser of SplitMix64, Steele, Lea and Flood 2014), for lattice noise and for ids that
/// are derived from a parent's id.
#[must_use]
#[inline]
pub fn hash(a: u64, b: u64) -> u64 {
    let mut x = a ^ b.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31).wrapping_add(0x2545_F491_4F6C_DD1D);
    for _ in 0..2 {
        x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^= x >> 31;
    }
    x
}

/// A hash mapped to [0, 1).
#[must_use]
pub fn hash_unit(a: u64, b: u64) -> f32 {
    (hash(a, b) >> 40) as f32 * (1.0 / (1u64 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generator_has_its_known_answers() {
        let mut stream = Stream::new(1, Purpose::Derivation, 2, 3);
        let first = [stream.bits(), stream.bits()];
        let again = Stream::new(1, Purpose::Derivation, 2, 3).bits();
        assert_eq!(first[0], again);
        assert_eq!(ChaCha8Rng::seed_from_u64(42).next_u64(), 0xae90_bfb5_395d_5ba1);
    }

    #[test]
    fn keys_do_not_share_streams() {
        let keys = [(1, Purpose::Derivation, 0, 0), (0, Purpose::Derivation, 1, 0), (0, Purpose::Derivation, 0, 1)];
        let mut seen: Vec<u64> = keys.iter().map(|&(s, p, i, e)| Stream::new(s, p, i, e).bits()).collect();
        seen.push(Stream::new(0, Purpose::Turtle, 0, 0).bits());
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 4);
    }

    #[test]
    fn moments_are_those_of_the_laws() {
        let mut stream = Stream::new(7, Purpose::Texture, 0, 0);
        let count = 40_000;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let uniform: Vec<f64> = (0..count).map(|_| stream.uniform()).collect();
        let exponential: Vec<f64> = (0..count).map(|_| stream.exponential()).collect();
        let normal: Vec<f64> = (0..count).map(|_| stream.normal()).collect();
        let square: Vec<f64> = normal.iter().map(|x| x * x).collect();
        assert!((mean(&uniform) - 0.5).abs() < 0.01);
        assert!((mean(&exponential) - 1.0).abs() < 0.03);
        assert!(mean(&normal).abs() < 0.03);
        assert!((mean(&square) - 1.0).abs() < 0.05);
    }
}
