//! The clear sky of Hosek and Wilkie 2012, ready for millions of looks. The formula of equation 8 is
//! (1 + A exp(B / (cos theta + 0.01))) (C + D exp(E gamma) + F cos^2 gamma + G chi + I sqrt(cos theta)): one factor depends on
//! the height alone and, but for the last summand, the other on the angle from the sun alone. Both are tabulated.

use crate::base::maths::{asinf, cosf, expf, mix};
use crate::base::vector::Vec3;
use crate::frame::ClearSky;

/// Steps of the tables.
const STEPS: usize = 512;

/// A clear sky about a sun.
pub(super) struct ClearTable {
    sun: Vec3,
    /// The factor of the height over the square root of its sine.
    by_height: Vec<[f32; 3]>,
    /// What depends on the angle from the sun, over the sine of its half.
    by_angle: Vec<[f32; 3]>,
    zenith: [f32; 3],
}

impl ClearTable {
    /// Tabulates a sky about a unit vector to the sun.
    pub(super) fn new(sky: &ClearSky, sun: Vec3) -> Self {
        let place = |step: usize| step as f32 / (STEPS - 1) as f32;
        let of_channels = |f: &dyn Fn(usize, f32) -> f32, at: f32| std::array::from_fn(|channel| f(channel, at));
        let height = |channel: usize, root: f32| {
            let c = &sky.coefficients[channel];
            sky.radiance[channel] * (1.0 + c[0] * expf(c[1] / (root * root + 0.01)))
        };
        let angle = |channel: usize, half: f32| around(&sky.coefficients[channel], 2.0 * asinf(half.min(1.0)));
        Self {
            sun,
            by_height: (0..STEPS).map(|step| of_channels(&height, place(step))).collect(),
            by_angle: (0..STEPS).map(|step| of_channels(&angle, place(step))).collect(),
            zenith: std::array::from_fn(|channel| sky.coefficients[channel][7]),
        }
    }

    /// Radiance from a unit direction; below the horizon that of the horizon.
    pub(super) fn radiance(&self, direction: Vec3) -> [f32; 3] {
        let root = direction.y.clamp(0.0, 1.0).sqrt();
        let half = ((1.0 - direction.dot(&self.sun)) * 0.5).clamp(0.0, 1.0).sqrt();
        let (height, angle) = (looked_up(&self.by_height, root), looked_up(&self.by_angle, half));
        std::array::from_fn(|k| (height[k] * (angle[k] + self.zenith[k] * root)).max(0.0))
    }
}

fn around(c: &[f32; 9], gamma: f32) -> f32 {
    let cosine = cosf(gamma);
    let base = 1.0 + c[8] * c[8] - 2.0 * c[8] * cosine;
    let lobe = (1.0 + cosine * cosine) / (base * base.sqrt());
    c[2] + c[3] * expf(c[4] * gamma) + c[5] * cosine * cosine + c[6] * lobe
}

fn looked_up(table: &[[f32; 3]], at: f32) -> [f32; 3] {
    let place = at * (STEPS - 1) as f32;
    let first = (place as usize).min(STEPS - 2);
    let part = place - first as f32;
    std::array::from_fn(|k| mix(table[first][k], table[first + 1][k], part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_give_the_formula() {
        // A clear sky of turbidity 2 with the sun at 40 degrees.
        let red = [-1.07448, -0.16771, 1.89997, 1.70056, -3.48099, 1.5455, 0.06654, 0.51084, 0.69447];
        let sky = ClearSky { coefficients: [red; 3], radiance: [5.621_498; 3] };
        let sun = Vec3::new(0.6, 0.64, 0.48).normalize();
        let table = ClearTable::new(&sky, sun);
        for direction in
            [Vec3::y(), Vec3::new(1.0, 0.05, 0.2), Vec3::new(-0.3, 0.4, 0.9), sun, Vec3::new(-1.0, 0.002, 0.0)]
        {
            let direction = direction.normalize();
            let gamma = libm::acosf(direction.dot(&sun).min(1.0));
            let rise = 1.0 + red[0] * expf(red[1] / (direction.y + 0.01));
            let expected = 5.621_498 * rise * (around(&red, gamma) + red[7] * direction.y.sqrt());
            let found = table.radiance(direction)[0];
            assert!((found / expected - 1.0).abs() < 2e-3, "{direction:?}: {found} {expected}");
        }
        // The zenith, from the published data in double precision.
        let zenith = ClearTable::new(&sky, Vec3::new(0.766_044, 0.642_788, 0.0)).radiance(Vec3::y())[0];
        assert!((zenith - 1.6876).abs() < 3e-3, "{zenith}");
    }
}
