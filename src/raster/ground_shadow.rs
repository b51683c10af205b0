//! The shadow on level ground as a layer of its own, to be laid under a picture that has no ground.

use super::samples::{SUBPIXEL, pattern};
use super::{Prepared, Shared};
use crate::base::encoding::luminance;
use crate::base::random::hash;
use crate::base::vector::Vec3;
use rayon::prelude::*;

/// Places in a pixel at which the shadow is found.
const PLACES: usize = 4;

impl Shared<'_> {
    /// The share of its light that the ground at height 0 loses to what stands on it, as a code of 8 bits for each pixel, row by
    /// row: 0 in the open and where no ground is seen.
    pub(super) fn ground_shadow(&self) -> Vec<u8> {
        let (width, height) = (self.frame.view.width, self.frame.view.height);
        let offsets = pattern::<PLACES>(1, 0).map(|place| place.map(|step| step as f32 / SUBPIXEL as f32));
        let open = self.light_from_above(self.atmosphere.open.irradiance(Vec3::y()), 1.0);
        let pixel = |prepared: &Prepared<'_>, (y, x): (u32, u32)| {
            let lost = |(number, [dx, dy]): (usize, [f32; 2])| {
                let ray = self.projection.ray(x as f32 + dx, y as f32 + dy);
                let eye = self.projection.eye;
                if ray.y >= 0.0 || eye.y <= 0.0 || open <= 0.0 {
                    return 0.0;
                }
                let place = eye - ray * (eye.y / ray.y);
                let salt = hash(u64::from(y) << 32 | u64::from(x), number as u64);
                let lit = prepared.shade(place, Vec3::y(), salt);
                let here = self.light_from_above(prepared.ambient(place).irradiance(Vec3::y()), lit);
                (1.0 - here / open).clamp(0.0, 1.0)
            };
            let sum: f32 = offsets.into_iter().enumerate().map(lost).sum();
            (sum / PLACES as f32 * 255.0 + 0.5) as u8
        };
        let row = |y: u32| {
            let prepared = Prepared::new(self);
            (0..width).map(|x| pixel(&prepared, (y, x))).collect::<Vec<u8>>()
        };
        (0..height).into_par_iter().flat_map_iter(row).collect()
    }

    /// Luminance of the light on level ground: from all sides, and from the share of the sun's disc that is seen.
    fn light_from_above(&self, ambient: [f32; 3], lit: f32) -> f32 {
        let sun = &self.frame.sun;
        let beam = sun.direction.y.max(0.0) * lit * self.atmosphere.sun_share();
        luminance(std::array::from_fn(|k| ambient[k] + sun.irradiance[k] * beam))
    }
}
