//! What is behind everything that stands: the sky with its sun and clouds, the wood on the horizon and the ground.

use super::Prepared;
use crate::base::maths::{acosf, mix, smooth_step};
use crate::base::noise::Lattice;
use crate::base::random::hash;
use crate::base::vector::{Vec2, Vec3};
use crate::frame::{Background, Clouds};
use std::f32::consts::PI;

/// Cosine of the angle of the sun's disc's radius, 0.267 degrees, and that radius.
const DISC: f32 = 0.004_66;
/// Metres that one repeat of the clouds covers, for a height of 1.
const CLOUDS: f32 = 4.4;
/// Share of that which is left by the shade that blades of unlike height throw on each other (judged).
const SWARD: f32 = 0.66;
/// Transmittance of a blade of grass over its reflectance (judged; measured leaves of grasses have 0.6 to 0.9).
const BLADE: f32 = 0.75;

impl Prepared<'_> {
    /// Radiance of the sky through a point of the picture.
    pub(super) fn sky(&self, at: [f32; 2]) -> [f32; 3] {
        if let Some(plain) = self.plain() {
            return plain;
        }
        let direction = self.projection.ray(at[0], at[1]);
        let sky = self.open_sky(direction);
        match self.frame.ground.as_ref().and_then(|ground| ground.wood) {
            Some(wood) => self.before_wood(&wood, direction, sky),
            None => sky,
        }
    }

    /// The radiance that shows a plain background, where the frame has one.
    fn plain(&self) -> Option<[f32; 3]> {
        match self.frame.background {
            Background::Sky => None,
            Background::Plain(colour) => Some(colour.map(|c| c / self.frame.view.exposure)),
            Background::Transparent => Some([0.0; 3]),
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
        let covered = mix(smooth_step(from, from + 0.30, dense), 1.0, closed);
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

    /// Radiance of the ground at a point of the picture below the horizon.
    pub(super) fn ground(&self, at: [f32; 2]) -> [f32; 3] {
        let Some(ground) = self.frame.ground.as_ref().filter(|_| self.plain().is_none()) else { return self.sky(at) };
        let ray = self.projection.ray(at[0], at[1]);
        let eye = self.projection.eye;
        let distance = eye.y / (-ray.y).max(1e-6);
        let position = eye + ray * distance;
        let albedo = self.ground_albedo(position, distance, ray);
        let salt = hash(at[0] as u64, at[1] as u64);
        let sun = self.sun(position, Vec3::y(), salt);
        let meeting = mix(self.frame.sun.direction.y.max(0.0), self.sward(ray), ground.blades);
        let ambient = self.ambient(position).irradiance(Vec3::y());
        let lit: [f32; 3] = std::array::from_fn(|k| albedo[k] * (sun[k] * meeting + ambient[k]) / PI);
        let seen = self.atmosphere.hazed(lit, ray * distance);
        match ground.wood {
            // What lies beyond the wood's edge is hidden by it.
            Some(wood) if distance > wood.distance => self.before_wood(&wood, ray, seen),
            _ => seen,
        }
    }

    /// Reflectance of the ground: its texture, and patches of several sizes that do not repeat.
    fn ground_albedo(&self, position: Vec3, distance: f32, ray: Vec3) -> [f32; 3] {
        let Some(ground) = &self.frame.ground else { return [0.0; 3] };
        let pixel = distance / self.projection.pixels_per_metre;
        let texture = &self.textures[ground.texture as usize];
        let place = Vec2::new(position.x, position.z);
        let uv = place / ground.tile;
        // A pixel on the ground is long and narrow; the mean of its sides keeps detail without crawling.
        let long = pixel / (-ray.y).max(1e-3);
        let footprint = (pixel * long).sqrt() / ground.tile;
        let detail = texture.sample(uv, footprint);
        // A second look at another scale and turn breaks the repeats up.
        let turned = Vec2::new(0.8 * uv.x + 0.6 * uv.y, 0.8 * uv.y - 0.6 * uv.x);
        let broad = texture.sample(turned / 5.3, footprint / 5.3);
        let mean = texture.mean();
        let [wide, middle, small] =
            [(23.0, 1), (4.9, 2), (1.1, 3)].map(|(size, salt)| patches(place / size, salt, long / size));
        // Longer grass is darker, and where it is thin straw and soil show.
        let light = 1.0 + 0.28 * wide + 0.45 * middle + 0.40 * small;
        let dry = (0.0 + 0.50 * (0.6 * wide - 0.5 * middle + 0.6 * small)).clamp(-0.15, 0.5);
        std::array::from_fn(|k| {
            let blend = mix(detail[k], broad[k], 0.30) * light;
            (blend + mean[k] * dry * DRY[k]).max(0.15 * mean[k])
        })
    }

    /// How a meadow meets the sun where an eye sees it, as a share of the irradiance across the beam, 0 to about 2: blades that
    /// stand all ways, lit and seen through one another. Single scattering in a deep layer is mu0 / (mu0 + mu) times the
    /// leaves' phase function (Ross 1981, spherical leaf angles), 1 where sun and eye are both overhead.
    fn sward(&self, ray: Vec3) -> f32 {
        let sun = self.frame.sun.direction;
        let (in_cosine, out_cosine) = (sun.y.max(0.0), (-ray.y).max(0.0));
        if in_cosine <= 0.0 {
            return 0.0;
        }
        // The angle between the ways that light comes and goes: 0 for light that goes on, pi for light sent back.
        let cosine = -sun.dot(&ray).clamp(-1.0, 1.0);
        let angle = PI - acosf(cosine);
        let sine = (1.0 - cosine * cosine).sqrt();
        let sent_back = sine + angle * cosine;
        let let_through = sine - (PI - angle) * cosine;
        SWARD * 2.0 * in_cosine / (in_cosine + out_cosine) * (sent_back + BLADE * let_through) / PI
    }
}

/// What dryness adds to the reflectance of each channel, over the mean's.
const DRY: [f32; 3] = [0.95, 0.55, 0.40];

/// Noise of mean 0 with features one unit across, that fades out where pixels are wider.
fn patches(place: Vec2, salt: u64, pixel: f32) -> f32 {
    let seen = 1.0 - smooth_step(0.4, 1.5, pixel);
    if seen <= 0.0 { 0.0 } else { Lattice::new(salt).gradient(place.x, place.y) * seen }
}
