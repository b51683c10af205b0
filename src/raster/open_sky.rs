//! The sky with its sun and its clouds, and the wood on the horizon before it.

use super::Prepared;
use crate::base::maths::{mix, smooth_step};
use crate::base::vector::{Vec2, Vec3};
use crate::frame::Clouds;
use std::f32::consts::PI;

/// Cosine of the angle of the sun's disc's radius, 0.267 degrees, and that radius.
const DISC: f32 = 0.004_66;
/// Metres that one repeat of the clouds covers, for a height of 1.
const CLOUDS: f32 = 4.4;

impl Prepared<'_> {
    /// Radiance of the sky through a point of the picture.
    pub(super) fn sky(&self, at: [f32; 2]) -> [f32; 3] {
        let direction = self.projection.ray(at[0], at[1]);
        let sky = self.open_sky(direction);
        match self.frame.ground.as_ref().and_then(|ground| ground.wood) {
            Some(wood) => self.before_wood(&wood, direction, sky),
            None => sky,
        }
    }

    /// The sky with its sun and its clouds.
    fn open_sky(&self, direction: Vec3) -> [f32; 3] {
        let sky = self.atmosphere.sky(direction);
        let clear = match &self.frame.sky.clouds {
            Some(clouds) if clouds.cover > 0.0 && direction.y > 0.0 => self.clouded(clouds, direction, sky),
            _ => sky,
        };
        let off = (direction - self.frame.sun.direction).norm();
        if off > 1.5 * DISC || self.frame.ground.is_none() {
            return clear;
        }
        let disc = (1.0 - smooth_step(0.9 * DISC, 1.1 * DISC, off)) / (PI * DISC * DISC);
        std::array::from_fn(|k| clear[k] + self.frame.sun.irradiance[k] * disc)
    }

    /// Clouds before a sky of which they have been mixed into the mean.
    fn clouded(&self, clouds: &Clouds, direction: Vec3, sky: [f32; 3]) -> [f32; 3] {
        // The clouds' plane curves down with the earth, else it would be endless at the horizon.
        let reach = 1.0 / (direction.y + 0.045);
        let uv = Vec2::new(direction.x, direction.z) * (reach / CLOUDS);
        let footprint = reach * reach / (self.projection.pixels_per_metre * CLOUDS);
        let [dense, lit, _] = self.textures[clouds.texture as usize].sample(uv, footprint);
        let from = 1.0 - 1.05 * clouds.cover;
        let closed = smooth_step(0.75, 1.0, clouds.cover);
        let covered = mix(smooth_step(from, from + 0.42, dense), 1.0, closed);
        let far = smooth_step(0.0, 0.10, direction.y);
        let open = 1.0 / (1.0 - clouds.cover).max(0.05);
        std::array::from_fn(|k| {
            let cloud = mix(clouds.shaded[k], clouds.lit[k], lit);
            let overcast = sky[k] * (0.86 + 0.28 * lit);
            let cloud = mix(cloud, overcast, closed.max(1.0 - far));
            let clear = mix((sky[k] - self.frame.sky.horizon[k]) * open, sky[k], closed.max(clouds.cover));
            mix(clear, cloud, covered * mix(0.35, 1.0, far))
        })
    }
}
