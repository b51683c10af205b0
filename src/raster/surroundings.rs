//! What is behind everything that stands: the sky, the wood on the horizon and the ground.

use super::Prepared;
use super::distant_wood;
use crate::base::maths::mix;
use crate::base::random::hash;
use crate::base::vector::{Vec2, Vec3};
use std::f32::consts::PI;

/// Distance of the wood on the horizon for its haze, metres.
const WOOD_DISTANCE: f32 = 450.0;

impl Prepared<'_> {
    /// Radiance of the sky through a point of the picture.
    pub(super) fn sky(&self, at: [f32; 2]) -> [f32; 3] {
        let direction = self.projection.ray(at[0], at[1]);
        let above = Vec3::new(direction.x, direction.y.max(0.0), direction.z);
        let sky = self.atmosphere.radiance(above);
        let Some(ground) = &self.frame.ground else { return sky };
        let (covered, albedo) = distant_wood::met(ground, direction, 1.0 / self.projection.pixels_per_metre);
        if covered <= 0.0 {
            return sky;
        }
        // Crowns stand upright: the sun meets them as a wall that turns to it by chance, hence a quarter of its beam.
        let sun = self.frame.sun.irradiance.map(|e| e * 0.25 * self.atmosphere.sun_share());
        let open = self.atmosphere.open.mean;
        let lit: [f32; 3] = std::array::from_fn(|k| albedo[k] * (sun[k] / PI + open[k]));
        let wood = self.atmosphere.hazed(lit, WOOD_DISTANCE);
        std::array::from_fn(|k| mix(sky[k], wood[k], covered))
    }

    /// Radiance of the ground at a point of the picture below the horizon.
    pub(super) fn ground(&self, at: [f32; 2]) -> [f32; 3] {
        let Some(ground) = &self.frame.ground else { return self.sky(at) };
        let ray = self.projection.ray(at[0], at[1]);
        let eye = self.projection.eye;
        let distance = eye.y / (-ray.y).max(1e-6);
        let position = eye + ray * distance;
        let pixel = distance / self.projection.pixels_per_metre;
        let texture = &self.textures[ground.texture as usize];
        let uv = Vec2::new(position.x, position.z) / ground.tile;
        // A pixel on the ground is long and narrow; the mean of its sides keeps detail without crawling.
        let long = pixel / (-ray.y).max(1e-3);
        let footprint = (pixel * long).sqrt() / ground.tile;
        let detail = texture.sample(uv, footprint);
        // A second look at another scale and turn breaks the repeats up.
        let turned = Vec2::new(0.8 * uv.x + 0.6 * uv.y, 0.8 * uv.y - 0.6 * uv.x);
        let broad = texture.sample(turned / 7.3, footprint / 7.3);
        let mean = texture.mean();
        let albedo: [f32; 3] = std::array::from_fn(|k| detail[k] * mix(1.0, broad[k] / mean[k].max(1e-4), 0.55));
        let salt = hash(at[0] as u64, at[1] as u64);
        let sun = self.sun(position, Vec3::y(), salt);
        let height = self.frame.sun.direction.y.max(0.0);
        let ambient = self.ambient(position).irradiance(Vec3::y());
        let lit: [f32; 3] = std::array::from_fn(|k| albedo[k] * (sun[k] * height + ambient[k]) / PI);
        // The meadow ends at the wood on the horizon, so no more haze lies before it.
        let hazy = if ground.wood > 0.0 { distance.min(WOOD_DISTANCE.max(eye.y * 4.0)) } else { distance };
        self.atmosphere.hazed(lit, hazy)
    }
}
