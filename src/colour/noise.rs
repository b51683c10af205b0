//! Irregularity in the plane that does not repeat: smooth noise in octaves, and cells.

use crate::base::random::{hash, hash_unit};

/// Lattice noise of one salt. Values are functions of place and salt alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise(pub u64);

/// Where a point lies in a Voronoi tessellation of jittered lattice points (Worley 1996).
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Uniform in [0, 1), one number for each cell.
    pub value: f32,
    /// Distance to the second nearest centre less that to the nearest, in lattice widths; 0 on the border of two cells.
    pub clearance: f32,
}

fn lattice(floor: f32) -> i64 {
    floor as i64
}

impl Noise {
    fn at(self, x: i64, y: i64) -> u64 {
        hash(self.0, (x as u64) << 32 ^ (y as u64 & 0xffff_ffff))
    }

    /// Gradient noise (Perlin 2002) with mean 0, about -0.7 to 0.7, features one unit across.
    fn gradient(self, x: f32, y: f32) -> f32 {
        let (fx, fy) = (x.floor(), y.floor());
        let (ix, iy) = (lattice(fx), lattice(fy));
        let (dx, dy) = (x - fx, y - fy);
        let corner = |cx: i64, cy: i64| {
            let bits = self.at(ix + cx, iy + cy);
            // A gradient from a square of side 2: cheaper than a circle, and its bias is lost in the octaves.
            let gx = ((bits & 0xffff) as f32 + 0.5) / 32768.0 - 1.0;
            let gy = ((bits >> 16 & 0xffff) as f32 + 0.5) / 32768.0 - 1.0;
            gx * (dx - cx as f32) + gy * (dy - cy as f32)
        };
        let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        let (u, v) = (fade(dx), fade(dy));
        let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
        let (low, high) = (a + (b - a) * u, c + (d - c) * u);
        low + (high - low) * v
    }

    /// Three octaves, mean 0 and standard deviation about 0.5; the coarsest features are 1 / `frequency` across.
    pub(super) fn octaves(self, x: f32, y: f32, frequency: f32) -> f32 {
        let (mut sum, mut weight, mut f) = (0.0, 1.0, frequency);
        for octave in 0..3u64 {
            // Octaves are shifted against each other, or all would vanish together at lattice points.
            let shift = octave as f32 * 0.37;
            sum += weight * Self(self.0 ^ (octave << 60)).gradient(x * f + shift, y * f + shift);
            weight *= 0.5;
            f *= 2.13;
        }
        sum * 2.0
    }

    /// The cell of a point; cells are 1 / `frequency` across.
    pub(super) fn cell(self, x: f32, y: f32, frequency: f32) -> Cell {
        let (x, y) = (x * frequency, y * frequency);
        let (ix, iy) = (lattice(x.floor()), lattice(y.floor()));
        let (mut first, mut second, mut owner) = (f32::INFINITY, f32::INFINITY, 0);
        for cy in iy - 1..=iy + 1 {
            for cx in ix - 1..=ix + 1 {
                let bits = self.at(cx, cy);
                let jitter = |shift: u32| ((bits >> shift & 0xffff) as f32 + 0.5) / 65536.0;
                let (dx, dy) = (cx as f32 + jitter(0) - x, cy as f32 + jitter(16) - y);
                let square = dx * dx + dy * dy;
                if square < first {
                    (second, first, owner) = (first, square, bits);
                } else if square < second {
                    second = square;
                }
            }
        }
        Cell { value: hash_unit(owner, 1), clearance: second.sqrt() - first.sqrt() }
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

    #[test]
    fn a_cell_has_one_value_up_to_its_border() {
        let noise = Noise(9);
        let mut last = noise.cell(0.0, 0.4, 4.0);
        for i in 1..4000 {
            let here = noise.cell(i as f32 * 1e-3, 0.4, 4.0);
            assert!(here.value == last.value || here.clearance < 0.02);
            last = here;
        }
    }
}
