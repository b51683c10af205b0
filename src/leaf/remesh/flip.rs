//! Edges flip where the two triangles beside them then cost less: Lawson's flips with the cost in place of the circle test.

use crate::leaf::remesh::relocate::Mesher;
use crate::leaf::remesh::web::NONE;

/// Passes of flipping in a round, at most.
const PASSES: u32 = 8;
/// The square of an edge may grow by this factor in a flip: a longer one is not looked at.
const LONGER: f64 = 1.6;
/// A flip must lower the cost by this.
const WORTH: f64 = 1e-6;

impl Mesher<'_> {
    /// Flips edges while that lowers the cost; how many were flipped.
    pub fn flip_all(&mut self) -> usize {
        let mut flipped = 0;
        let mut numbers: Vec<u32> = self.web.triangles().map(|(t, _)| t).collect();
        numbers.retain(|&t| self.web.corners(t).iter().any(|&v| self.awake[v as usize]));
        for _ in 0..PASSES {
            let count = self.flip_among(&numbers, |_| true);
            flipped += count;
            if count == 0 {
                break;
            }
        }
        flipped
    }

    /// Flips edges of some triangles, and of those that `may`, once each; how many were flipped.
    pub fn flip_among(&mut self, triangles: &[u32], may: impl Fn(u32) -> bool) -> usize {
        let mut flipped = 0;
        for &t in triangles {
            for i in 0..3 {
                if self.web.corners(t)[0] != NONE && self.gains_by_flip(t, i) && may(self.web.opposite(t, i)) {
                    let [a, b, c] = self.web.corners(t);
                    self.web.flip(t, i);
                    [a, b, c].iter().chain(&self.web.corners(t)).for_each(|&v| self.awake[v as usize] = true);
                    flipped += 1;
                }
            }
        }
        flipped
    }

    fn gains_by_flip(&self, t: u32, i: usize) -> bool {
        let Some((corners, _)) = self.web.diamond(t, i) else { return false };
        let [p, a, q, b] = corners.map(|v| self.web.point(v));
        if (q - p).norm_squared() > LONGER * (b - a).norm_squared() {
            return false;
        }
        let now = self.energy.of(p, a, b) + self.energy.of(q, b, a);
        self.energy.of(p, a, q) + self.energy.of(q, b, p) < now - WORTH
    }
}
