//! The transcendental functions that may reach an output. All are libm's: std's call the C library of the machine, whose
//! last bits differ between processors (`clippy.toml` bans them). `+ - * / sqrt abs floor` are exact everywhere.

pub use libm::{acos, asin, atan, atan2, cbrt, cos, exp, expm1, hypot, log as ln, log1p, pow, sin, sincos, tan};
pub use libm::{acosf, asinf, atan2f, cosf, exp2f, expf, log2f, logf as lnf, powf, sincosf, sinf, tanf};

/// Linear interpolation from `a` (at 0) to `b` (at 1).
#[must_use]
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// 0 below `low`, 1 above `high`, the cubic 3t^2 - 2t^3 between.
#[must_use]
pub fn smooth_step(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The linear value (0..1) of an encoded sRGB value (0..1), IEC 61966-2-1.
#[must_use]
pub fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { powf((encoded + 0.055) / 1.055, 2.4) }
}

/// The encoded sRGB value (0..1) of a linear value (clipped to 0..1), IEC 61966-2-1.
#[must_use]
pub fn linear_to_srgb(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * powf(linear, 1.0 / 2.4) - 0.055 }
}

/// The nearest 8-bit sRGB code of a linear value (clipped to 0..1).
#[must_use]
pub fn linear_to_srgb8(linear: f32) -> u8 {
    (linear_to_srgb(linear) * 255.0 + 0.5) as u8
}

/// The largest whole number that is not above `x`, saturating; std's is a call where the processor's baseline has no such
/// instruction.
#[must_use]
#[inline(always)]
pub fn floor_to_i32(x: f32) -> i32 {
    let truncated = x as i32;
    truncated.wrapping_sub(i32::from(truncated as f32 > x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_codes_survive_a_round_trip() {
        for code in 0..=255u8 {
            assert_eq!(linear_to_srgb8(srgb_to_linear(f32::from(code) / 255.0)), code);
        }
    }

    #[test]
    fn smooth_step_meets_its_ends() {
        assert_eq!(smooth_step(1.0, 3.0, 0.0), 0.0);
        assert_eq!(smooth_step(1.0, 3.0, 2.0), 0.5);
        assert_eq!(smooth_step(1.0, 3.0, 9.0), 1.0);
    }
}
