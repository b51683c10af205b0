//! Linear light to 8-bit sRGB and back by tables: for every pixel of a picture or a texture.

use crate::base::maths::{linear_to_srgb, srgb_to_linear};

/// Steps of the table between 0 and 1; fine enough that the darkest code spans several.
const STEPS: usize = 1 << 14;

/// The linear value of each code of 8 bits.
#[must_use]
pub fn linear_values() -> [f32; 256] {
    std::array::from_fn(|code| srgb_to_linear(code as f32 / 255.0))
}

/// The codes of evenly spaced linear values. Within one code of the exact encoding.
#[derive(Clone, Debug)]
pub struct SrgbEncoder(Box<[u8; STEPS]>);

impl Default for SrgbEncoder {
    fn default() -> Self {
        let code = |step: usize| (linear_to_srgb(step as f32 / (STEPS - 1) as f32) * 255.0 + 0.5) as u8;
        Self(Box::new(std::array::from_fn(code)))
    }
}

impl SrgbEncoder {
    /// The code of a linear value, clipped to 0..1; 0 for NaN.
    #[must_use]
    pub fn code(&self, linear: f32) -> u8 {
        let [code] = self.codes([linear]);
        code
    }

    /// The codes of some linear values, each clipped to 0..1; 0 for NaN.
    #[inline(always)]
    #[must_use]
    pub fn codes<const N: usize>(&self, linear: [f32; N]) -> [u8; N] {
        let steps = linear.map(|value| (value.clamp(0.0, 1.0) * (STEPS - 1) as f32 + 0.5) as i32);
        // The mask changes nothing, but tells the compiler that every step is in the table.
        steps.map(|step| self.0[step as usize & (STEPS - 1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::linear_to_srgb8;

    #[test]
    fn codes_are_those_of_srgb() {
        let encoder = SrgbEncoder::default();
        for step in 0..=10_000u16 {
            let value = f32::from(step) / 1e4;
            assert!(encoder.code(value).abs_diff(linear_to_srgb8(value)) <= 1, "{value}");
        }
        assert_eq!([-1.0, 2.0, f32::INFINITY, f32::NAN].map(|x| encoder.code(x)), [0, 255, 255, 0]);
    }
}
