//! Noise on a lattice of hashed nodes: smooth values, gradients, cells, and sums of octaves. Everything is a function of
//! place and salt; with periods the plane repeats, for textures that tile and for what goes around.

use crate::base::maths::mix;
use crate::base::random::hash;

/// The quintic 6t^5 - 15t^4 + 10t^3 (Perlin 2002): 0 to 1 with no slope or curvature at the ends.
#[must_use]
pub fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

/// A lattice of nodes one unit apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    salt: u64,
    /// Nodes after which each coordinate repeats; 0 for never.
    periods: [i64; 2],
}

/// The nodes around the place that was asked for last: places close together share them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nodes {
    /// The lattice and the least of the nodes, once one was asked for.
    of: Option<(Lattice, i64, i64)>,
    /// Their bits, row by row.
    bits: [u64; 4],
}

/// Where a point lies in a Voronoi tessellation of jittered lattice points (Worley 1996).
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Uniform in [0, 1), one number for each cell.
    pub value: f32,
    /// Distance to the nearest centre, in lattice widths.
    pub distance: f32,
    /// Distance to the second nearest centre less that to the nearest, in lattice widths; 0 on the border of two cells.
    pub clearance: f32,
}

impl Lattice {
    /// A lattice that never repeats.
    #[must_use]
    pub fn new(salt: u64) -> Self {
        Self { salt, periods: [0; 2] }
    }

    /// A lattice that repeats after so many nodes along each coordinate; 0 for never.
    #[must_use]
    pub fn periodic(salt: u64, periods: [u32; 2]) -> Self {
        Self { salt, periods: periods.map(i64::from) }
    }

    /// The 64 bits of a node.
    #[inline]
    fn node(&self, x: i64, y: i64) -> u64 {
        let [x, y] = if self.periods == [0; 2] { [x, y] } else { self.wrapped(x, y) };
        hash(self.salt, (x as u64) << 32 ^ (y as u64 & 0xffff_ffff))
    }

    fn wrapped(&self, x: i64, y: i64) -> [i64; 2] {
        // Nearly all that is asked for lies within the first repeat, where no division is needed.
        let is_within = |place: i64, period: i64| (place as u64) < period as u64;
        let wrap = |place: i64, period: i64| match period {
            0 => place,
            _ if is_within(place, period) => place,
            _ => place.rem_euclid(period),
        };
        [wrap(x, self.periods[0]), wrap(y, self.periods[1])]
    }

    /// A node's number in [0, 1).
    fn unit(&self, x: i64, y: i64) -> f32 {
        unit(self.node(x, y))
    }

    /// The bits of the four nodes from a least one on, found anew only where they are not those of the last place.
    #[inline]
    fn around(&self, nodes: &mut Nodes, i: i64, j: i64) -> [u64; 4] {
        let of = Some((*self, i, j));
        if nodes.of != of {
            let bits = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(x, y)| self.node(x, y));
            *nodes = Nodes { of, bits };
        }
        nodes.bits
    }

    /// Value noise in 0..1, features one unit across.
    #[must_use]
    pub fn value(&self, x: f32, y: f32) -> f32 {
        self.value_by(&mut Nodes::default(), x, y)
    }

    /// `value`, by nodes that are kept from place to place.
    #[must_use]
    pub fn value_by(&self, nodes: &mut Nodes, x: f32, y: f32) -> f32 {
        let (i, j, dx, dy) = split(x, y);
        let (u, v) = (fade(dx), fade(dy));
        let [a, b, c, d] = self.around(nodes, i, j).map(unit);
        mix(mix(a, b, u), mix(c, d, u), v)
    }

    /// Gradient noise (Perlin 2002) with mean 0, about -0.7 to 0.7, features one unit across.
    #[must_use]
    pub fn gradient(&self, x: f32, y: f32) -> f32 {
        self.gradient_by(&mut Nodes::default(), x, y)
    }

    /// `gradient`, by nodes that are kept from place to place.
    #[must_use]
    pub fn gradient_by(&self, nodes: &mut Nodes, x: f32, y: f32) -> f32 {
        let (i, j, dx, dy) = split(x, y);
        let (u, v) = (fade(dx), fade(dy));
        let [a, b, c, d] = self.around(nodes, i, j);
        let upper = mix(slope(a, dx, dy), slope(b, dx - 1.0, dy), u);
        let lower = mix(slope(c, dx, dy - 1.0), slope(d, dx - 1.0, dy - 1.0), u);
        mix(upper, lower, v)
    }

    /// The cell of a point.
    #[must_use]
    pub fn cell(&self, x: f32, y: f32) -> Cell {
        let (i, j, dx, dy) = split(x, y);
        let (mut first, mut second, mut owner) = (f32::INFINITY, f32::INFINITY, 0);
        for cy in -1..=1 {
            for cx in -1..=1 {
                let bits = self.node(i + cx, j + cy);
                let jitter = |shift: u32| ((bits >> shift & 0xffff) as f32 + 0.5) / 65536.0;
                let (ox, oy) = (cx as f32 + jitter(0) - dx, cy as f32 + jitter(16) - dy);
                let square = ox * ox + oy * oy;
                if square < first {
                    (second, first, owner) = (first, square, bits);
                } else if square < second {
                    second = square;
                }
            }
        }
        let value = unit(hash(owner, 1));
        Cell { value, distance: first.sqrt(), clearance: second.sqrt() - first.sqrt() }
    }
}

/// Bits as a number in [0, 1).
#[inline(always)]
fn unit(bits: u64) -> f32 {
    (bits >> 40) as f32 * (1.0 / (1u64 << 24) as f32)
}

/// What a node's gradient, told from its bits, comes to so far from it.
#[inline(always)]
fn slope(bits: u64, dx: f32, dy: f32) -> f32 {
    // A gradient from a square of side 2: cheaper than a circle, and its bias is lost in the octaves.
    let gx = ((bits & 0xffff) as f32 + 0.5) / 32768.0 - 1.0;
    let gy = ((bits >> 16 & 0xffff) as f32 + 0.5) / 32768.0 - 1.0;
    gx * dx + gy * dy
}

/// The node below a point and the way from it. Quicker than `floor`, which old processors lack.
#[inline]
fn split(x: f32, y: f32) -> (i64, i64, f32, f32) {
    let below = |t: f32| {
        let whole = t as i64;
        if whole as f32 > t { whole - 1 } else { whole }
    };
    let (i, j) = (below(x), below(y));
    (i, j, x - i as f32, y - j as f32)
}

/// Octaves of value noise over one repeat of a texture, each of twice the frequency and half the weight, in tables: for
/// reading at every texel.
#[derive(Clone, Debug)]
pub struct Fractal {
    octaves: Vec<Octave>,
    total: f32,
}

#[derive(Clone, Debug)]
struct Octave {
    columns: usize,
    rows: usize,
    weight: f32,
    values: Vec<f32>,
}

impl Fractal {
    /// Noise whose coarsest features are one of `columns` across and one of `rows` high; neither may be 0.
    #[must_use]
    pub fn new(columns: u32, rows: u32, octaves: u32, salt: u64) -> Self {
        let octave = |number: u32| {
            let (columns, rows) = (columns << number, rows << number);
            let lattice = Lattice::new(salt.wrapping_add(u64::from(number)));
            let row = |row: u32| (0..columns).map(move |column| lattice.unit(i64::from(row), i64::from(column)));
            let values = (0..rows).flat_map(row).collect();
            Octave { columns: columns as usize, rows: rows as usize, weight: 1.0 / (1u64 << number) as f32, values }
        };
        let octaves: Vec<Octave> = (0..octaves).map(octave).collect();
        let total = octaves.iter().map(|octave| octave.weight).sum();
        Self { octaves, total }
    }

    /// The noise in 0..1 at a place of the repeat, which runs from 0 to 1 both ways; beyond, it repeats.
    #[must_use]
    pub fn at(&self, u: f32, v: f32) -> f32 {
        let (u, v) = (fraction(u), fraction(v));
        self.octaves.iter().map(|octave| octave.weight * octave.at(u, v)).sum::<f32>() / self.total
    }
}

/// What a number has beyond the whole number below it, 0 to 1. Quicker than `floor`, which old processors lack.
fn fraction(t: f32) -> f32 {
    let rest = t - t as i32 as f32;
    if rest < 0.0 { rest + 1.0 } else { rest }
}

impl Octave {
    fn at(&self, u: f32, v: f32) -> f32 {
        let (x, y) = (u * self.columns as f32, v * self.rows as f32);
        // At 1 itself, which rounding may give, the last cell ends.
        let (column, row) = ((x as usize).min(self.columns - 1), (y as usize).min(self.rows - 1));
        let (tx, ty) = (fade(x - column as f32), fade(y - row as f32));
        let right = if column + 1 == self.columns { 0 } else { column + 1 };
        let (upper, lower) = (row * self.columns, if row + 1 == self.rows { 0 } else { row + 1 } * self.columns);
        let [a, b, c, d] = [upper + column, upper + right, lower + column, lower + right].map(|at| self.values[at]);
        mix(mix(a, b, tx), mix(c, d, tx), ty)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_that_are_kept_change_no_bit() {
        let lattices = [Lattice::new(3), Lattice::periodic(3, [5, 0]), Lattice::new(8)];
        let mut kept = Nodes::default();
        for step in 0..600 {
            // Back and forth, over nodes, and from lattice to lattice at one place.
            let (x, y) = ((step % 37) as f32 * 0.31 - 4.0, (step % 53) as f32 * 0.17 - 3.0);
            for lattice in lattices {
                for _ in 0..2 {
                    let found = lattice.gradient_by(&mut kept, x, y);
                    assert_eq!(found.to_bits(), lattice.gradient(x, y).to_bits());
                    let found = lattice.value_by(&mut kept, x, y);
                    assert_eq!(found.to_bits(), lattice.value(x, y).to_bits());
                }
            }
        }
        let [a, b, _] = lattices.map(|lattice| lattice.gradient(-3.3, 0.4));
        assert!(a != b);
    }

    #[test]
    fn all_kinds_repeat_after_their_periods_and_keep_their_range() {
        let lattice = Lattice::periodic(5, [4, 6]);
        let fractal = Fractal::new(4, 6, 3, 9);
        for step in 0..200 {
            // Eighths are exact, so that equal places are equal to the bit.
            let (x, y) = ((step % 31) as f32 * 0.125, (step % 47) as f32 * 0.125);
            for (dx, dy) in [(4.0, 0.0), (0.0, 6.0), (-8.0, 12.0)] {
                assert_eq!(lattice.value(x, y), lattice.value(x + dx, y + dy));
                assert_eq!(lattice.gradient(x, y), lattice.gradient(x + dx, y + dy));
                assert_eq!(lattice.cell(x, y).value, lattice.cell(x + dx, y + dy).value);
            }
            assert!((0.0..=1.0).contains(&lattice.value(x, y)) && lattice.gradient(x, y).abs() <= 1.0);
            let (u, v) = (x / 8.0, y / 8.0);
            assert_eq!(fractal.at(u, v), fractal.at(u + 1.0, v - 2.0));
            assert!((0.0..=1.0).contains(&fractal.at(u, v)));
        }
    }

    #[test]
    fn one_octave_in_a_table_is_the_lattice_s_own_noise() {
        let (table, lattice) = (Fractal::new(5, 7, 1, 3), Lattice::periodic(3, [7, 5]));
        for step in 0..100 {
            let (u, v) = (step as f32 * 0.0371 % 1.0, step as f32 * 0.0127 % 1.0);
            assert!((table.at(u, v) - lattice.value(v * 7.0, u * 5.0)).abs() < 1e-5);
        }
    }

    #[test]
    fn without_periods_places_differ() {
        let lattice = Lattice::new(5);
        let same = (0..100).filter(|&i| lattice.value(0.5 + i as f32, 0.5) == lattice.value(100.5 + i as f32, 0.5));
        assert_eq!(same.count(), 0);
    }
}
