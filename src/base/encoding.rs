//! Linear light to 8-bit sRGB and back by tables: for every pixel of a picture or a texture.

use crate::base::maths::{linear_to_srgb, srgb_to_linear};
use fearless_simd::prelude::*;
use fearless_simd::{f32x8, i32x8};

/// Steps of the table between 0 and 1; fine enough that the darkest code spans several.
const STEPS: usize = 1 << 14;

/// The linear value of each code of 8 bits.
#[must_use]
pub fn linear_values() -> [f32; 256] {
    std::array::from_fn(|code| srgb_to_linear(code as f32 / 255.0))
}

/// Luminance of a linear sRGB colour (ITU-R BT.709).
#[must_use]
pub fn luminance([red, green, blue]: [f32; 3]) -> f32 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
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
        self.code_at((linear.clamp(0.0, 1.0) * (STEPS - 1) as f32 + 0.5) as i32)
    }

    /// Where the codes of eight linear values stand.
    #[inline(always)]
    pub fn places<W: Simd>(&self, simd: W, linear: f32x8<W>) -> [i32; 8] {
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        // A NaN is not above 0.
        let clipped = linear.simd_gt(zero).select(linear, zero);
        let clipped = clipped.simd_gt(one).select(one, clipped);
        (clipped * (STEPS - 1) as f32 + 0.5).to_int::<i32x8<W>>().into()
    }

    /// The code at such a place.
    #[inline(always)]
    #[must_use]
    pub fn code_at(&self, place: i32) -> u8 {
        // The mask changes nothing, but tells the compiler that every step is in the table.
        self.0[place as usize & (STEPS - 1)]
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
