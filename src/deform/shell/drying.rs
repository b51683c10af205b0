//! What a drying blade would be, part by part, if nothing held its parts together: the rest lengths of its springs and the
//! rest curvatures of its triangles, at a dryness from 0 to 1.
//!
//! Two layers whose strains differ by e bend a strip of thickness h to the curvature 3 e / (2 h) (Timoshenko 1925, equal
//! layers); `curl` is that curvature where the mask is darkest. It acts across the nearest veins and, for a share, across the
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
        let roll = (settings.roll + much * stream.range(-0.4, 0.3)).clamp(0.0, 1.0);
        let lean = DVec2::new(stream.range(-0.7, 0.7), stream.range(-0.4, 0.4)) * much;
        let twist = stream.range(-0.18, 0.18) * much;
        let turn = stream.range(-0.25, 0.25) * much;
        let waves = [0, 1, 2, 3].map(|_| {
            let (sine, cosine) = sincos(stream.range(0.0, std::f64::consts::TAU));
            let ahead = DVec2::new(cosine, sine) * stream.range(5.0, 15.0);
            let phase = stream.range(0.0, std::f64::consts::TAU);
            (ahead, phase, stream.range(0.1, 0.3) * much, stream.range(0.05, 0.2) * much)
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
        (self.gain * factor.max(0.0), turn)
    }
}

/// A blade that dries in the manner of one variant.
pub struct Drying<'a> {
    settings: &'a Settings,
    sheet: &'a Sheet,
    tissue: &'a Tissue,
    /// Curvature of each triangle where it is quite dry.
    curvatures: Vec<Tensor>,
}

impl<'a> Drying<'a> {
    /// Of a sheet and its tissue.
    pub fn new(settings: &'a Settings, sheet: &'a Sheet, tissue: &'a Tissue, irregularity: &Irregularity) -> Self {
        let curvature = |(plate, across): (&super::sheet::Plate, &Tensor)| {
            let lively = plate.corners.iter().map(|&v| tissue.liveliness[v as usize]).sum::<f64>() / 3.0;
            let (factor, turn) = irregularity.at(plate.middle(&sheet.places) - tissue.middle);
            let strength = settings.curl * lively * factor;
            let directed = turned(*across, turn);
            let share = settings.cupping;
            let twist = settings.curl * lively * irregularity.twist;
            let mixed = |k: usize, across_midrib: f64, even: f64| {
                let rolled = irregularity.roll * across_midrib + (1.0 - irregularity.roll) * directed[k];
                strength * (share * even + (1.0 - share) * rolled)
            };
            [mixed(0, 1.0, 1.0), mixed(1, 0.0, 0.0) + twist, mixed(2, 0.0, 1.0)]
        };
        let curvatures = sheet.plates.iter().zip(&tissue.across).map(curvature).collect();
        Self { settings, sheet, tissue, curvatures }
    }

    /// The rest state at a dryness, under a share of the blade's weight.
    pub fn rest(&self, dryness: f64, weight: f64) -> Rest {
        // At 0 and at 1 all places agree; between, the deep ones lag.
        let local: Vec<f64> =
            self.tissue.depth.iter().map(|depth| pow(dryness, 1.0 + self.settings.front * depth)).collect();
        let shrunk = |v: u32| self.settings.shrink * local[v as usize] * self.tissue.liveliness[v as usize];
        let length = |s: &super::sheet::Spring| s.length * (1.0 - 0.5 * (shrunk(s.ends[0]) + shrunk(s.ends[1])));
        let folds = |(number, plate): (usize, &super::sheet::Plate)| {
            let dry = plate.corners.iter().map(|&v| local[v as usize]).sum::<f64>() / 3.0;
            self.sheet.folds(number, self.curvatures[number].map(|k| k * dry))
        };
        Rest {
            lengths: self.sheet.springs.iter().map(length).collect(),
            folds: self.sheet.plates.iter().enumerate().map(folds).collect(),
            weight: self.settings.gravity * weight,
        }
    }
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
    fn a_quarter_turn_changes_the_axes() {
        let tensor = turned([1.0, 0.0, 0.25], std::f64::consts::FRAC_PI_2);
        assert!((tensor[0] - 0.25).abs() < 1e-15 && tensor[1].abs() < 1e-15 && (tensor[2] - 1.0).abs() < 1e-15);
        let slanted = turned([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_4);
        assert!(slanted.iter().all(|x| (x - 0.5).abs() < 1e-15), "{slanted:?}");
    }
}
