//! From spectra to colours: what a leaf looks like in daylight, from above and against the light.

use super::plate::{self, Faces, Shares};
use super::spectrum::{WAVELENGTHS, Wavelength};
use super::{Pigments, Table};
use crate::base::maths::cbrt;

/// CIE XYZ relative to D65 with Y = 1 -> linear sRGB (IEC 61966-2-1 primaries).
const TO_SRGB: [[f64; 3]; 3] = [
    [3.240_454_162_114_105_4, -1.537_138_512_797_716_6, -0.498_531_409_556_016],
    [-0.969_266_030_505_186_8, 1.876_010_845_446_694_2, 0.041_556_017_530_349_8],
    [0.055_643_430_959_114_7, -0.204_025_913_516_753_8, 1.057_225_188_223_179_1],
];
/// Its inverse, for differences of colours that are already sRGB.
const FROM_SRGB: [[f64; 3]; 3] = [
    [0.412_456_4, 0.357_576_1, 0.180_437_5],
    [0.212_672_9, 0.715_152_2, 0.072_175_0],
    [0.019_333_9, 0.119_192_0, 0.950_304_1],
];
/// XYZ of D65.
const WHITE: [f64; 3] = [0.950_47, 1.0, 1.088_83];

/// A linear sRGB colour, unclipped.
pub type Colour = [f64; 3];

/// What a leaf looks like in the light of D65: linear sRGB, unclipped (transmitted blue may be slightly negative). The
/// reflected colour has the gloss of the surface in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Appearance {
    /// Colour of the light sent back.
    pub reflected: Colour,
    /// Colour of the light let through.
    pub transmitted: Colour,
}

/// One wavelength of a table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub wavelength: &'static Wavelength,
    pub faces: Faces,
    /// What a share of 1 at this wavelength adds to each channel.
    pub weights: Colour,
}

/// A spectral table made ready: its wavelengths, their faces, and the weights that turn spectra into colours.
#[derive(Clone, Debug)]
pub(super) struct Optics {
    samples: Vec<Sample>,
}

impl Optics {
    pub(super) fn new(table: Table) -> Self {
        let every = match table {
            Table::Coarse => 2,
            Table::Fine => 1,
        };
        let wavelengths: Vec<&'static Wavelength> = WAVELENGTHS.iter().step_by(every).collect();
        let power: f64 = wavelengths.iter().map(|w| w.light * w.matching[1]).sum();
        let weights = |w: &Wavelength| transformed(&TO_SRGB, w.matching.map(|m| m * w.light / power));
        let sample = |w| Sample { wavelength: w, faces: Faces::new(w.index), weights: weights(w) };
        Self { samples: wavelengths.into_iter().map(sample).collect() }
    }

    pub(super) fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.samples.iter()
    }

    pub(super) fn appearance(&self, pigments: &Pigments) -> Appearance {
        self.samples.iter().fold(Appearance::default(), |sum, sample| {
            let Sample { wavelength, faces, weights } = sample;
            let Shares { reflected, transmitted } = plate::leaf(wavelength, faces, pigments);
            let add = |colour: Colour, share: f64| std::array::from_fn(|c| colour[c] + weights[c] * share);
            Appearance { reflected: add(sum.reflected, reflected), transmitted: add(sum.transmitted, transmitted) }
        })
    }

    /// The part of any leaf's reflected colour that its surface sends back, about 0.034 to 0.041: the gloss lobe of a
    /// renderer stands for it.
    pub(super) fn gloss(&self) -> Colour {
        self.samples.iter().fold([0.0; 3], |sum, sample| {
            std::array::from_fn(|c| sum[c] + sample.weights[c] * (1.0 - sample.faces.entry))
        })
    }
}

/// What a leaf of these contents looks like, surface gloss included.
#[must_use]
pub fn appearance(pigments: &Pigments, table: Table) -> Appearance {
    Optics::new(table).appearance(pigments)
}

/// CIE 1976 colour difference of two linear sRGB colours seen under D65; 1 is about the least that can be seen.
#[must_use]
pub fn colour_difference(a: Colour, b: Colour) -> f64 {
    let (a, b) = (lab(a), lab(b));
    a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// CIE L*a*b* of a linear sRGB colour, relative to D65.
#[must_use]
pub fn lab(colour: Colour) -> [f64; 3] {
    let xyz = transformed(&FROM_SRGB, colour);
    let [x, y, z]: Colour = std::array::from_fn(|c| lab_root(xyz[c] / WHITE[c]));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn lab_root(ratio: f64) -> f64 {
    const KNEE: f64 = 6.0 / 29.0;
    if ratio > KNEE * KNEE * KNEE { cbrt(ratio) } else { ratio / (3.0 * KNEE * KNEE) + 4.0 / 29.0 }
}

fn transformed(matrix: &[[f64; 3]; 3], vector: Colour) -> Colour {
    std::array::from_fn(|row| matrix[row].iter().zip(&vector).map(|(m, v)| m * v).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Name, contents (structure, chlorophyll, carotenoids, anthocyanins, brown, water, dry matter), reflected and
    /// transmitted colour of the reference implementation.
    const REFERENCE: [(&str, [f64; 7], [f64; 6]); 4] = [
        (
            "green summer",
            [1.45, 38.0, 7.0, 3.6, 0.06, 0.01, 0.0025],
            [0.06687, 0.09022, 0.03631, 0.06451, 0.0873, -0.00604],
        ),
        (
            "yellow clear",
            [1.7, 0.8, 7.0, 0.0, 0.02, 0.0085, 0.0045],
            [0.56159, 0.3277, 0.03353, 0.5158, 0.27883, -0.00237],
        ),
        ("red", [1.7, 1.5, 4.0, 12.0, 0.08, 0.008, 0.005], [0.31369, 0.08361, 0.05419, 0.27995, 0.05011, 0.01648]),
        ("brown", [2.2, 0.5, 1.0, 0.5, 1.6, 0.0015, 0.0048], [0.23493, 0.14998, 0.09598, 0.12272, 0.05801, 0.0234]),
    ];

    fn contents(values: [f64; 7]) -> Pigments {
        let [structure, chlorophyll, carotenoids, anthocyanins, brown, water, dry_matter] = values;
        Pigments { structure, chlorophyll, carotenoids, anthocyanins, brown, water, dry_matter }
    }

    fn error(values: [f64; 7], expected: [f64; 6], table: Table) -> f64 {
        let found = appearance(&contents(values), table);
        let found = found.reflected.iter().chain(&found.transmitted);
        found.zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn named_leaves_have_their_colours() {
        for (name, values, expected) in REFERENCE {
            assert!(error(values, expected, Table::Fine) < 2e-5, "{name}");
            assert!(error(values, expected, Table::Coarse) < 1e-3, "{name}");
        }
    }

    #[test]
    fn every_leaf_of_the_shared_table_has_its_colours() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/optics/leaf_colours_expected.csv");
        let Ok(text) = std::fs::read_to_string(path) else { return };
        for line in text.lines().skip(1) {
            let numbers: Vec<f64> = line.split(',').skip(1).take(13).map(|field| field.parse().unwrap()).collect();
            let (values, expected) = (numbers[..7].try_into().unwrap(), numbers[7..].try_into().unwrap());
            assert!(error(values, expected, Table::Fine) < 2e-5, "{line}");
            assert!(error(values, expected, Table::Coarse) < 1e-3, "{line}");
        }
    }

    #[test]
    fn a_perfect_diffuser_is_white() {
        for table in [Table::Coarse, Table::Fine] {
            let optics = Optics::new(table);
            for channel in 0..3 {
                let white: f64 = optics.samples.iter().map(|sample| sample.weights[channel]).sum();
                assert!((white - 1.0).abs() < 3e-3, "{white}");
            }
        }
    }

    #[test]
    fn the_gloss_is_that_of_a_bare_surface() {
        let gloss = Optics::new(Table::Fine).gloss();
        for (found, expected) in gloss.iter().zip([0.034, 0.039, 0.041]) {
            assert!((found - expected).abs() < 1e-3, "{gloss:?}");
        }
    }

    #[test]
    fn extreme_leaves_stay_finite() {
        for structure in [1.0, 4.0] {
            for amount in [0.0, 1e-300, 1.0, 1e6] {
                let values = [structure, amount, amount, amount, amount, amount, amount];
                let found = appearance(&contents(values), Table::Coarse);
                assert!(found.reflected.iter().chain(&found.transmitted).all(|x| x.is_finite()), "{values:?}");
            }
        }
    }

    #[test]
    fn lab_of_white_and_grey() {
        let [l, a, b] = lab([1.0; 3]);
        assert!((l - 100.0).abs() < 1e-4 && a.abs() < 0.01 && b.abs() < 0.02);
        assert!((lab([0.184_187; 3])[0] - 50.0).abs() < 1e-3);
        assert!((colour_difference([0.184_187; 3], [1.0; 3]) - 50.0).abs() < 1e-2);
    }
}
