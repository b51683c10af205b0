//! Light that comes from far away: the sky, the haze, and the mean light of an open place.

use super::texture::MipMap;
use crate::base::maths::{expf, smooth_step};
use crate::base::vector::Vec3;
use crate::frame::Frame;
use std::f32::consts::PI;
use std::sync::Arc;

/// The 26 directions of a cube's faces, edges and corners with the weights that integrate polynomials up to degree 7 over
/// the sphere (Lebedev 1976).
pub(super) fn directions() -> [(Vec3, f32); 26] {
    let mut directions = [(Vec3::zeros(), 0.0); 26];
    let mut next = 0;
    for (x, y, z) in (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| (x, y, z)))) {
        let weight = match i32::abs(x) + i32::abs(y) + i32::abs(z) {
            0 => continue,
            1 => 1.0 / 21.0,
            2 => 4.0 / 105.0,
            _ => 9.0 / 280.0,
        };
        directions[next] = (Vec3::new(x as f32, y as f32, z as f32).normalize(), weight);
        next += 1;
    }
    directions
}

/// Light at a place from all sides, as its mean radiance and how it leans: the first two bands of spherical harmonics.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Ambient {
    /// Mean radiance of each channel.
    pub mean: [f32; 3],
    /// Three times the mean of radiance times direction, for each channel.
    pub lean: [Vec3; 3],
}

impl Ambient {
    /// Adds light from a direction: `share` is the part of the sphere that it fills.
    pub(super) fn add(&mut self, direction: Vec3, radiance: [f32; 3], share: f32) {
        for k in 0..3 {
            self.mean[k] += radiance[k] * share;
            self.lean[k] += direction * (3.0 * radiance[k] * share);
        }
    }

    /// Adds `weight` times another.
    pub(super) fn add_weighted(&mut self, other: &Self, weight: f32) {
        for k in 0..3 {
            self.mean[k] += other.mean[k] * weight;
            self.lean[k] += other.lean[k] * weight;
        }
    }

    /// Irradiance on a surface with this unit normal: pi (mean + 2/3 lean . normal), kept above a tenth of the mean's,
    /// since two bands may go negative (Ramamoorthi and Hanrahan 2001).
    pub(super) fn irradiance(&self, normal: Vec3) -> [f32; 3] {
        std::array::from_fn(|k| {
            let value = self.mean[k] + self.lean[k].dot(&normal) * (2.0 / 3.0);
            PI * value.max(self.mean[k] * 0.1)
        })
    }
}

/// The surroundings of a frame without its tree.
pub(super) struct Atmosphere {
    zenith: [f32; 3],
    horizon: [f32; 3],
    sun: Vec3,
    glow: [f32; 3],
    ground: [f32; 3],
    haze: f32,
    /// Light from all sides in the open.
    pub open: Ambient,
}

impl Atmosphere {
    /// Gathers sky, sun and ground of a frame.
    pub(super) fn new(frame: &Frame, textures: &[Arc<MipMap>]) -> Self {
        let sun_height = frame.sun.direction.y.max(0.0);
        let sky_mean: [f32; 3] = std::array::from_fn(|k| frame.sky.zenith[k] * 0.5 + frame.sky.horizon[k] * 0.5);
        // Without a ground the horizon goes on below: a backdrop.
        let ground = frame.ground.as_ref().map_or(frame.sky.horizon, |ground| {
            let albedo = textures[ground.texture as usize].mean();
            std::array::from_fn(|k| albedo[k] * (frame.sun.irradiance[k] * sun_height / PI + sky_mean[k]))
        });
        let mut atmosphere = Self {
            zenith: frame.sky.zenith,
            horizon: frame.sky.horizon,
            sun: frame.sun.direction,
            // Air scatters a little of the sun forward; a backdrop is not air.
            glow: frame.sun.irradiance.map(|e| if frame.ground.is_some() { e * 0.04 } else { 0.0 }),
            ground,
            haze: frame.ground.as_ref().map_or(1.0, |ground| ground.haze),
            open: Ambient::default(),
        };
        for (direction, share) in directions() {
            atmosphere.open.add(direction, atmosphere.radiance(direction), share);
        }
        atmosphere
    }

    /// Radiance from a direction: sky above the horizon; below it the mean of the sunlit ground, or the backdrop.
    pub(super) fn radiance(&self, direction: Vec3) -> [f32; 3] {
        if direction.y < 0.0 {
            return self.ground;
        }
        let height = direction.y * (2.0 - direction.y);
        let cosine = direction.dot(&self.sun).max(0.0);
        let eighth = cosine * cosine * cosine * cosine * cosine * cosine * cosine * cosine;
        let around = eighth * eighth * eighth;
        std::array::from_fn(|k| self.horizon[k] + (self.zenith[k] - self.horizon[k]) * height + self.glow[k] * around)
    }

    /// A colour seen through `distance` metres of haze.
    pub(super) fn hazed(&self, colour: [f32; 3], distance: f32) -> [f32; 3] {
        let clear = expf(-distance / self.haze);
        std::array::from_fn(|k| self.horizon[k] + (colour[k] - self.horizon[k]) * clear)
    }

    /// How much of the sun's disc stands above the horizon.
    pub(super) fn sun_share(&self) -> f32 {
        smooth_step(-0.005, 0.005, self.sun.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_directions_integrate_low_polynomials() {
        let sum = |f: &dyn Fn(Vec3) -> f32| directions().iter().map(|(d, w)| f(*d) * w).sum::<f32>();
        assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-6);
        assert!((sum(&|d| d.y * d.y) - 1.0 / 3.0).abs() < 1e-6);
        assert!((sum(&|d| d.x * d.x * d.z * d.z) - 1.0 / 15.0).abs() < 1e-6);
        assert!((sum(&|d| d.y * d.y * d.y * d.y) - 1.0 / 5.0).abs() < 1e-6);
    }

    #[test]
    fn uniform_light_gives_pi_times_its_radiance() {
        let mut ambient = Ambient::default();
        for (direction, share) in directions() {
            ambient.add(direction, [0.5, 1.0, 2.0], share);
        }
        let irradiance = ambient.irradiance(Vec3::new(0.0, 0.6, 0.8));
        for (got, radiance) in irradiance.iter().zip([0.5, 1.0, 2.0]) {
            assert!((got - PI * radiance).abs() < 1e-5);
        }
    }

    #[test]
    fn light_from_one_half_favours_that_side() {
        let mut ambient = Ambient::default();
        for (direction, share) in directions() {
            let radiance = if direction.y > 0.1 {
                1.0
            } else if direction.y < -0.1 {
                0.0
            } else {
                0.5
            };
            ambient.add(direction, [radiance; 3], share);
        }
        let up = ambient.irradiance(Vec3::y())[0];
        assert!((up - PI).abs() < 0.2, "a full hemisphere gives pi: {up}");
        assert!(ambient.irradiance(-Vec3::y())[0] < 0.25 * up);
    }
}
