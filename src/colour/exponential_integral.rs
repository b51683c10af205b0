//! The exponential integral E1, which no library in use offers: what is left of diffuse light behind a layer needs it.

use crate::base::maths::{exp, ln};

/// Euler's constant.
const EULER: f64 = 0.577_215_664_901_532_9;
/// Below this the series converges fast, above it the continued fraction.
const SERIES_END: f64 = 1.5;
/// Enough terms of either for a relative error below 1e-13.
const SERIES_TERMS: u32 = 24;
const FRACTION_TERMS: u32 = 60;

/// E1(x), the integral of exp(-t)/t from x to infinity, for x > 0. Power series and Legendre's continued fraction
/// (Abramowitz and Stegun 5.1.11 and 5.1.22), relative error below 1e-12.
pub(super) fn exponential_integral(x: f64) -> f64 {
    if x < SERIES_END { series(x) } else { exp(-x) * fraction(x) }
}

fn series(x: f64) -> f64 {
    let (mut sum, mut power) = (-EULER - ln(x), 1.0);
    for n in 1..=SERIES_TERMS {
        let n = f64::from(n);
        power *= -x / n;
        sum -= power / n;
    }
    sum
}

/// exp(x) E1(x) = 1/(x + 1 - 1/(x + 3 - 4/(x + 5 - ...))), from its far end.
fn fraction(x: f64) -> f64 {
    let mut tail = 0.0;
    for n in (1..=FRACTION_TERMS).rev() {
        let n = f64::from(n);
        tail = n * n / (x + 2.0 * n + 1.0 - tail);
    }
    1.0 / (x + 1.0 - tail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_values_are_met() {
        // Abramowitz and Stegun table 5.1, digits beyond theirs from 50-digit arithmetic.
        for (x, expected) in [
            (0.01, 4.037_929_576_538_114),
            (0.1, 1.822_923_958_419_390_7),
            (0.5, 0.559_773_594_776_160_8),
            (1.0, 0.219_383_934_395_520_27),
            (2.0, 0.048_900_510_708_061_12),
            (5.0, 0.001_148_295_591_275_325_8),
            (10.0, 4.156_968_929_685_324e-6),
        ] {
            assert!((exponential_integral(x) / expected - 1.0).abs() < 1e-12, "E1({x})");
        }
    }

    #[test]
    fn series_and_fraction_agree_where_they_meet() {
        for x in [1.3, 1.5, 1.7, 2.0] {
            assert!((series(x) / (exp(-x) * fraction(x)) - 1.0).abs() < 1e-12, "at {x}");
        }
    }
}
