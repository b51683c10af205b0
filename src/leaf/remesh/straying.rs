//! What it costs that the outline strays from a chord of the rim.
//!
//! The square of the straying alone would leave a few deep teeth cut off among many chords that are near. The rim is as far
//! from the outline as its worst chord, so beyond what is enough the cost is steep.

/// When the rim is planned: against the squared misses of lengths, in spacings, and of angles, in thirds of pi.
pub const PLANNED: Straying = Straying { weight: 4.3, enough: 0.115, steep: 200.0 };
/// When its vertices slide: against the cost of the triangles.
pub const SLID: Straying = Straying { weight: 10.0, enough: 0.12, steep: 350.0 };
/// A mesh of fewer vertices than this may stray by more of its spacing.
const FINE: f64 = 1000.0;

/// The cost of straying, in spacings.
#[derive(Clone, Copy, Debug)]
pub struct Straying {
    /// Weight of the square.
    pub weight: f64,
    /// How much is enough: up to it there is no further cost.
    pub enough: f64,
    /// Weight of the square of the rest.
    pub steep: f64,
}

impl Straying {
    /// The cost for a mesh of about this many vertices: the coarser it is, the more teeth are too small for it, and what is
    /// enough grows by the square root of the spacing.
    pub fn among(self, vertices: usize) -> Self {
        let coarseness = (FINE / vertices.max(3) as f64).sqrt();
        Self { enough: self.enough * coarseness.sqrt().max(1.0), ..self }
    }

    /// The cost of straying this far.
    pub fn of(&self, straying: f64) -> f64 {
        let rest = (straying - self.enough).max(0.0);
        self.weight * straying * straying + self.steep * rest * rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straying_costs_steeply_beyond_what_is_enough() {
        let straying = Straying { weight: 2.0, enough: 0.5, steep: 100.0 };
        assert_eq!([0.0, 0.5, 1.0].map(|x| straying.of(x)), [0.0, 0.5, 27.0]);
        assert_eq!(straying.among(4000).of(1.0), 27.0);
        // 16 times fewer vertices: 4 times the spacing, twice as much is enough.
        assert!((straying.among(FINE as usize / 16).enough - 1.0).abs() < 0.01);
    }
}
