//! From radiance to 8-bit sRGB.

use crate::base::encoding::SrgbEncoder;
use crate::frame::ToneMap;

/// A tone curve with its encoding.
pub(super) struct Tone {
    map: ToneMap,
    encoder: SrgbEncoder,
}

impl Tone {
    /// Tabulates the encoding.
    pub(super) fn new(map: ToneMap) -> Self {
        Self { map, encoder: SrgbEncoder::default() }
    }

    /// The code of an exposed linear colour.
    pub(super) fn encode(&self, colour: [f32; 3]) -> [u8; 3] {
        let mapped = match self.map {
            ToneMap::Neutral => neutral(colour),
            ToneMap::None => colour,
        };
        mapped.map(|value| self.encoder.code(value))
    }
}

/// Khronos PBR Neutral (KhronosGroup/ToneMapping): takes off the usual 4 % surface reflection, keeps colours below 0.76 and
/// rolls what is brighter off towards white.
fn neutral(colour: [f32; 3]) -> [f32; 3] {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = colour[0].min(colour[1]).min(colour[2]);
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let colour = colour.map(|c| c - offset);
    let peak = colour[0].max(colour[1]).max(colour[2]);
    if peak < START {
        return colour;
    }
    let room = 1.0 - START;
    let new_peak = 1.0 - room * room / (peak + room - START);
    let weight = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    colour.map(|c| c * (new_peak / peak) * (1.0 - weight) + new_peak * weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::linear_to_srgb8;

    #[test]
    fn without_a_curve_codes_are_those_of_srgb() {
        let tone = Tone::new(ToneMap::None);
        for step in 0..=1000u16 {
            let value = f32::from(step) / 1000.0;
            let code = tone.encode([value; 3])[0];
            assert!(code.abs_diff(linear_to_srgb8(value)) <= 1, "{value}");
        }
        assert_eq!(tone.encode([-1.0, 2.0, f32::INFINITY]), [0, 255, 255]);
    }

    #[test]
    fn the_neutral_curve_keeps_the_middle_and_stays_below_white() {
        let middle = neutral([0.5, 0.3, 0.2]);
        assert!((middle[0] - 0.46).abs() < 1e-6 && (middle[2] - 0.16).abs() < 1e-6);
        for bright in [1.0, 4.0, 100.0] {
            let mapped = neutral([bright, bright * 0.5, 0.1]);
            assert!(mapped.iter().all(|c| (0.0..=1.0).contains(c)));
        }
        assert!(neutral([2.0, 2.0, 2.0])[0] < neutral([3.0, 3.0, 3.0])[0]);
    }
}
