//! Value noise that repeats, for the textures of ground and bark.

use crate::base::maths::mix;
use crate::base::random::hash_unit;

/// Smooth noise in 0..1 at (x, y) on a lattice that repeats every `columns` x `rows` cells.
pub(super) fn value(x: f32, y: f32, columns: u32, rows: u32, salt: u64) -> f32 {
    let (column, row) = (x.floor(), y.floor());
    let smooth = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (tx, ty) = (smooth(x - column), smooth(y - row));
    let at = |dx: i64, dy: i64| {
        let c = (column as i64 + dx).rem_euclid(i64::from(columns)) as u64;
        let r = (row as i64 + dy).rem_euclid(i64::from(rows)) as u64;
        hash_unit(salt, r << 32 | c)
    };
    mix(mix(at(0, 0), at(1, 0), tx), mix(at(0, 1), at(1, 1), tx), ty)
}

/// The sum of `octaves` noises, each of twice the frequency and half the weight, in 0..1. `u` and `v` run from 0 to 1 over
/// one repeat, `columns` and `rows` are the cells of the coarsest.
pub(super) fn fractal(u: f32, v: f32, columns: u32, rows: u32, octaves: u32, salt: u64) -> f32 {
    let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let (c, r) = (columns << octave, rows << octave);
        sum += weight * value(u * c as f32, v * r as f32, c, r, salt.wrapping_add(u64::from(octave)));
        total += weight;
        weight *= 0.5;
    }
    sum / total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_repeats_and_stays_in_range() {
        for step in 0..50 {
            let v = step as f32 * 0.02;
            let (a, b) = (fractal(0.0, v, 4, 6, 3, 9), fractal(1.0, v, 4, 6, 3, 9));
            assert!((a - b).abs() < 1e-5);
            assert!((0.0..=1.0).contains(&fractal(v * 0.7, v, 4, 6, 3, 9)));
        }
    }
}
