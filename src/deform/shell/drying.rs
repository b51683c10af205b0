//! What a drying blade would be, part by part, if nothing held its parts together: the rest lengths of its springs and the
//! rest curvatures of its triangles, at a dryness from 0 to 1.
//!
//! Two layers whose strains differ by e bend a strip of thickness h to the curvature 3 e / (2 h) when they are alike, to less
//! or as much when they are not ([`bilayer`], Timoshenko 1925); `curl` is that of equal layers where the mask is darkest. It acts across the nearest veins and, for a share, across the
//! midrib, which is stiffer than they are and makes a blade roll about itself; along the veins acts another share. Shapes of
//! one state differ by their gain, their sense, a lean to one side, a twist, and slow waves of strength and direction.

use super::energy::Rest;
use super::settings::Settings;
use super::sheet::{Sheet, Tensor};
use super::tissue::Tissue;
use crate::base::maths::{pow, sin, sincos};
use crate::base::random::{Purpose, Stream};
use crate::base::vector::DVec2;

/// How one shape differs from the next, at full variation.
#[derive(Clone, Debug, PartialEq)]
pub struct Irregularity {
    /// Of the curvature; negative curls the other way.
    gain: f64,
    /// Share of the curl that goes across the midrib.
    roll: f64,
    /// Change of the curvature per extent.
    lean: DVec2,
    /// Twisting curvature, as a share of the curl.
    twist: f64,
    /// Turn of the directions across the veins, radians.
    turn: f64,
    /// Slow waves: wave vector (radians per extent), phase, change of curvature, change of direction (radians).
    waves: [(DVec2, f64, f64, f64); 4],
}

impl Irregularity {
    /// That of a variant.
    pub fn new(settings: &Settings, seed: u64, variant: u32) -> Self {
        let mut stream = Stream::new(seed, Purpose::Deformation, u64::from(variant), 1);
        let much = settings.variation;
        let down = stream.uniform() < settings.reversed;
        let gain = (1.0 + much * stream.range(-0.2, 0.2)) * if down { -1.0 } else { 1.0 };
        let roll = (settings.roll + much * stream.range(-0.15, 0.15)).clamp(0.0, 1.0);
        let lean = DVec2::new(stream.range(-0.9, 0.9), stream.range(-0.5, 0.5)) * much;
        let twist = stream.range(-0.25, 0.25) * much;
        let turn = stream.range(-0.3, 0.3) * much;
        let waves = [0, 1, 2, 3].map(|_| {
            let (sine, cosine) = sincos(stream.range(0.0, std::f64::consts::TAU));
            let ahead = DVec2::new(cosine, sine) * stream.range(5.0, 14.0);
            let phase = stream.range(0.0, std::f64::consts::TAU);
            (ahead, phase, stream.range(0.2, 0.5) * much, stream.range(0.05, 0.25) * much)
        });
        Self { gain, roll, lean, twist, turn, waves }
    }

    /// Factor of the curvature, and turn of its direction (radians), at a place from the blade's middle.
    fn at(&self, place: DVec2) -> (f64, f64) {
        let mut factor = 1.0 + self.lean.dot(&place);
        let mut turn = self.turn;
        for (ahead, phase, strength, swing) in &self.waves {
            let wave = sin(ahead.dot(&place) + phase);
            factor += strength * wave;
            turn += swing * wave;
        }
        (self.gain * factor, turn)
    }
}

/// A blade that dries in the manner of one variant.
pub struct Drying<'a> {
    settings: &'a Settings,
    sheet: &'a Sheet,
    tissue: &'a Tissue,
    /// Curvature of each triangle where it is quite dry.
    curvatures: Vec<Tensor>,
    /// Strain by which each spring shrinks where it is quite dry.
    shrinkages: Vec<f64>,
}

impl<'a> Drying<'a> {
    /// Of a sheet and its tissue.
    pub fn new(settings: &'a Settings, sheet: &'a Sheet, tissue: &'a Tissue, irregularity: &Irregularity) -> Self {
        let curl = settings.curl * bilayer(settings.upper_thickness, settings.upper_stiffness) / bilayer(1.0, 1.0);
        let curvature = |((plate, across), &lively): ((&super::sheet::Plate, &Tensor), &f64)| {
            let (factor, turn) = irregularity.at(plate.middle(&sheet.places) - tissue.middle);
            let strength = curl * lively * factor;
            let directed = turned(sharpened(*across), turn);
            // The liveliest places are tips and margins: they hook along the veins too, the rest rolls across them.
            let share = settings.cupping * lively;
            let twist = curl * lively * irregularity.twist;
            let mixed = |k: usize, across_midrib: f64, even: f64| {
                let rolled = irregularity.roll * across_midrib + (1.0 - irregularity.roll) * directed[k];
                strength * (share * even + (1.0 - share) * rolled)
            };
            [mixed(0, 1.0, 1.0), mixed(1, 0.0, 0.0) + twist, mixed(2, 0.0, 1.0)]
        };
        let curvatures = sheet.plates.iter().zip(&tissue.across).zip(&tissue.liveliness).map(curvature).collect();
        let shrinkage = |spring: &super::sheet::Spring| {
            settings.shrink * tissue.liveliness_along(spring.ends.map(|v| sheet.places[v as usize]))
        };
        let shrinkages = sheet.springs.iter().map(shrinkage).collect();
        Self { settings, sheet, tissue, curvatures, shrinkages }
    }

    /// The rest state at a dryness, under a share of the blade's weight.
    pub fn rest(&self, dryness: f64, weight: f64) -> Rest {
        // At 0 and at 1 all places agree; between, the deep ones lag.
        let local: Vec<f64> =
            self.tissue.depth.iter().map(|depth| pow(dryness, 1.0 + self.settings.front * depth)).collect();
        let length = |(s, shrinkage): (&super::sheet::Spring, &f64)| {
            let dry = 0.5 * (local[s.ends[0] as usize] + local[s.ends[1] as usize]);
            s.length * (1.0 - dry * shrinkage)
        };
        let folds = |(number, plate): (usize, &super::sheet::Plate)| {
            let dry = plate.corners.iter().map(|&v| local[v as usize]).sum::<f64>() / 3.0;
            self.sheet.folds(number, self.curvatures[number].map(|k| k * dry))
        };
        Rest {
            lengths: self.sheet.springs.iter().zip(&self.shrinkages).map(length).collect(),
            folds: self.sheet.plates.iter().enumerate().map(folds).collect(),
            weight: self.settings.gravity * weight,
        }
    }
}

/// Curvature of a strip of two layers, times its thickness, over the difference of their strains (Timoshenko, "Analysis of
/// bi-metal thermostats", 1925): `m` the upper layer's thickness over the lower one's, `n` likewise the stiffness.
fn bilayer(m: f64, n: f64) -> f64 {
    let squared = (1.0 + m) * (1.0 + m);
    6.0 * squared / (3.0 * squared + (1.0 + m * n) * (m * m + 1.0 / (m * n)))
}

/// The square of a tensor with unit trace, over its trace: nearer to the larger axis.
fn sharpened([xx, xy, yy]: Tensor) -> Tensor {
    let (xx, xy, yy) = (xx * xx + xy * xy, xy * (xx + yy), xy * xy + yy * yy);
    [xx, xy, yy].map(|k| k / (xx + yy))
}

/// A tensor turned by an angle.
fn turned([xx, xy, yy]: Tensor, angle: f64) -> Tensor {
    let (sine, cosine) = sincos(2.0 * angle);
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let (straight, slant) = (half * cosine - xy * sine, half * sine + xy * cosine);
    [mean + straight, slant, mean - straight]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unequal_layers_bend_as_timoshenko_has_it() {
        let table = [
            (1.0, 1.0, 1.5),
            (1.0, 10.0, 0.995_850_622_4),
            (1.0, 0.1, 0.995_850_622_4),
            (0.5, 1.0, 4.0 / 3.0),
            (2.0, 1.0, 4.0 / 3.0),
            // m m n = 1 is the best there is.
            (0.5, 4.0, 1.5),
        ];
        for (m, n, expected) in table {
            assert!((bilayer(m, n) - expected).abs() < 1e-10, "{m} {n}: {}", bilayer(m, n));
        }
    }

    #[test]
    fn sharpening_keeps_the_axes_and_the_trace() {
        let sharp = sharpened([0.8, 0.0, 0.2]);
        assert!((sharp[0] - 16.0 / 17.0).abs() < 1e-15 && sharp[1] == 0.0 && (sharp[2] - 1.0 / 17.0).abs() < 1e-15);
        let slanted = turned([0.8, 0.0, 0.2], 0.4);
        let (a, b) = (sharpened(slanted), turned(sharp, 0.4));
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15), "{a:?} {b:?}");
    }

    #[test]
    fn a_quarter_turn_changes_the_axes() {
        let tensor = turned([1.0, 0.0, 0.25], std::f64::consts::FRAC_PI_2);
        assert!((tensor[0] - 0.25).abs() < 1e-15 && tensor[1].abs() < 1e-15 && (tensor[2] - 1.0).abs() < 1e-15);
        let slanted = turned([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_4);
        assert!(slanted.iter().all(|x| (x - 0.5).abs() < 1e-15), "{slanted:?}");
    }
}
