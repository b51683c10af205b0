//! Masses from the mask map, equation (3) of Tang, Wu and Fan 2013.

use crate::base::maths::ln;

/// The mass of a grey (0 to 255) in the paper's unit: 0.5 at 0, ln(grey + 1) else. Between greys 0 and 1, which an 8-bit mask
/// does not have but an interpolated one has, the larger of the two, so that no vertex is lighter than the lightest.
pub fn mass(grey: f64) -> f64 {
    ln(grey.clamp(0.0, 255.0) + 1.0).max(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_have_the_papers_masses() {
        let table = [
            (0.0, 0.5),
            (1.0, std::f64::consts::LN_2),
            (2.0, 1.098_612),
            (127.0, 4.852_030),
            (254.0, 5.541_264),
            (255.0, 5.545_177),
        ];
        for (grey, expected) in table {
            assert!((mass(grey) - expected).abs() < 5e-7, "{grey}");
        }
        assert!((mass(255.0) / mass(0.0) - 11.0904).abs() < 5e-5);
    }
}
