//! Light that comes from far away: the sky, the haze, and the mean light of an open place.

use super::distant_wood::Palette;
use super::sky::ClearTable;
use super::texture::MipMap;
use crate::base::maths::{expf, mix, sincosf, smooth_step};
use crate::base::vector::{Vec2, Vec3};
use crate::frame::Frame;
use std::f32::consts::PI;
use std::sync::Arc;

/// The steps to the 26 neighbours of a cell.
pub(super) fn steps() -> impl Iterator<Item = [i32; 3]> {
    let all = (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| [x, y, z])));
    all.filter(|step| *step != [0; 3])
}

/// The 26 directions of a cube's faces, edges and corners, in the order of `steps`, with the weights that integrate
/// polynomials up to degree 7 over the sphere (Lebedev 1976).
pub(super) fn directions() -> [(Vec3, f32); 26] {
    let mut directions = [(Vec3::zeros(), 0.0); 26];
    for (direction, [x, y, z]) in directions.iter_mut().zip(steps()) {
        let weight = match x.abs() + y.abs() + z.abs() {
            1 => 1.0 / 21.0,
            2 => 4.0 / 105.0,
            _ => 9.0 / 280.0,
        };
        *direction = (Vec3::new(x as f32, y as f32, z as f32).normalize(), weight);
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
    clear: Option<ClearTable>,
    sun: Vec3,
    ground: Option<[f32; 3]>,
    haze: f32,
    /// Light from all sides in the open.
    pub open: Ambient,
    /// What the distant wood wears.
    pub wood: Palette,
    /// The level direction of the look, along x and z: what stands upright hides what lies farther along it.
    pub ahead: Vec2,
}

impl Atmosphere {
    /// Gathers sky, sun and ground of a frame.
    pub(super) fn new(frame: &Frame, textures: &[Arc<MipMap>]) -> Self {
        let sun = frame.sun.direction;
        let mut atmosphere = Self {
            zenith: frame.sky.zenith,
            horizon: frame.sky.horizon,
            clear: frame.sky.clear.as_ref().map(|sky| ClearTable::new(sky, sun)),
            sun,
            ground: None,
            haze: frame.ground.as_ref().map_or(1.0, |ground| ground.haze),
            open: Ambient::default(),
            wood: Palette::of(frame, textures),
            ahead: ahead(frame),
        };
        // Without a ground the horizon goes on below: a backdrop.
        if let Some(ground) = &frame.ground {
            let albedo = textures[ground.texture as usize].mean();
            let level = atmosphere.level();
            let height = sun.y.max(0.0) * atmosphere.sun_share();
            let sent = |k: usize| albedo[k] * (frame.sun.irradiance[k] * height + level[k]) / PI;
            atmosphere.ground = Some(std::array::from_fn(sent));
        }
        for (direction, share) in directions() {
            atmosphere.open.add(direction, atmosphere.radiance(direction), share);
        }
        atmosphere
    }

    /// Surroundings of one radiance on all sides.
    #[cfg(test)]
    pub(super) fn even(radiance: [f32; 3]) -> Self {
        let open = Ambient { mean: radiance, lean: [Vec3::zeros(); 3] };
        let wood = Palette::default();
        Self {
            zenith: radiance,
            horizon: radiance,
            clear: None,
            sun: Vec3::y(),
            ground: None,
            haze: 1.0,
            open,
            wood,
            ahead: Vec2::y(),
        }
    }

    /// Irradiance of the sky on level ground.
    fn level(&self) -> [f32; 3] {
        const HEIGHTS: u32 = 6;
        const AZIMUTHS: u32 = 12;
        let mut sum = [0.0f32; 3];
        for (row, column) in (0..HEIGHTS).flat_map(|row| (0..AZIMUTHS).map(move |column| (row, column))) {
            // Even steps of the squared sine of the height have equal projected solid angles.
            let up = ((row as f32 + 0.5) / HEIGHTS as f32).sqrt();
            let (sine, cosine) = sincosf((column as f32 + 0.5) / AZIMUTHS as f32 * 2.0 * PI);
            let along = (1.0 - up * up).sqrt();
            let found = self.radiance(Vec3::new(along * cosine, up, along * sine));
            for k in 0..3 {
                sum[k] += found[k];
            }
        }
        sum.map(|s| s * PI / (HEIGHTS * AZIMUTHS) as f32)
    }

    /// Radiance from a direction: sky above the horizon; below it the mean of the sunlit ground, or the backdrop.
    pub(super) fn radiance(&self, direction: Vec3) -> [f32; 3] {
        match self.ground {
            Some(ground) if direction.y < 0.0 => ground,
            _ => self.sky(direction),
        }
    }

    /// Radiance of the sky without its clouds; below the horizon that of the horizon.
    pub(super) fn sky(&self, direction: Vec3) -> [f32; 3] {
        let height = direction.y.max(0.0);
        let even: [f32; 3] = std::array::from_fn(|k| mix(self.horizon[k], self.zenith[k], height));
        match &self.clear {
            Some(clear) => {
                let clear = clear.radiance(direction);
                std::array::from_fn(|k| even[k] + clear[k])
            }
            None => even,
        }
    }

    /// What the air does to each channel over this way from the eye, metres: the share of radiance that it keeps, and the
    /// radiance that it adds. What is lost is replaced by the light of the horizon behind it. Blue goes first (air and fine haze
    /// scatter with a power of about -1.3 of the wavelength).
    pub(super) fn air(&self, way: Vec3) -> [[f32; 2]; 3] {
        let distance = way.norm();
        let depth = distance / self.haze;
        if depth < 2e-3 {
            return [[1.0, 0.0]; 3];
        }
        let level = Vec3::new(way.x / distance, (way.y / distance).max(0.04), way.z / distance);
        let horizon = self.sky(level.normalize());
        std::array::from_fn(|k| {
            let met = depth * AIR[k];
            // The first terms of the series are enough for what is near.
            let lost = if met < 0.1 { met * (1.0 - 0.5 * met) } else { 1.0 - expf(-met) };
            [1.0 - lost, horizon[k] * lost]
        })
    }

    /// A colour seen over this way through the air, metres.
    pub(super) fn hazed(&self, colour: [f32; 3], way: Vec3) -> [f32; 3] {
        let air = self.air(way);
        std::array::from_fn(|k| colour[k] * air[k][0] + air[k][1])
    }

    /// How much of the sun's disc stands above the horizon.
    pub(super) fn sun_share(&self) -> f32 {
        smooth_step(-0.005, 0.005, self.sun.y)
    }
}

/// The level direction of a frame's look.
fn ahead(frame: &Frame) -> Vec2 {
    let way = frame.camera.target - frame.camera.position;
    Vec2::new(way.x, way.z).try_normalize(1e-6).unwrap_or_else(Vec2::x)
}

/// Extinction of the air in each channel over that of green.
const AIR: [f32; 3] = [0.87, 1.0, 1.24];

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
