//! The level ground, and what of it is seen on uneven ground and behind blades of grass.

use super::Prepared;
use super::phase::phase;
use crate::base::maths::{asinf, log2f, mix, smooth_step};
use crate::base::noise::{Lattice, Nodes};
use crate::base::random::hash;
use crate::base::vector::{Vec2, Vec3};
use crate::frame::Ground;
use std::f32::consts::PI;

/// Share of that which is left by the shade that blades of unlike height throw on each other (judged).
const SWARD: f32 = 0.66;
/// Transmittance of a blade of grass over its reflectance (judged; measured leaves of grasses have 0.6 to 0.9).
const BLADE: f32 = 0.75;

/// A spot of the ground as the eye sees it.
struct Spot {
    position: Vec3,
    /// From the eye, metres.
    distance: f32,
    /// Unit vector from the eye.
    ray: Vec3,
    /// Unit normal.
    normal: Vec3,
}

impl Spot {
    /// Cosine of the angle at which the look meets the ground.
    fn slope(&self) -> f32 {
        -self.ray.dot(&self.normal)
    }

    /// Width of a pixel across the look, metres.
    fn pixel(&self, prepared: &Prepared) -> f32 {
        self.distance / prepared.projection.pixels_per_metre
    }

    /// Length of a pixel on the ground along the look, metres.
    fn long(&self, prepared: &Prepared) -> f32 {
        self.pixel(prepared) / self.slope().max(1e-3)
    }
}

/// What wide patches make of a place of the ground.
struct Patches {
    /// How light it is, 1 in the mean.
    light: f32,
    /// How dry, 0 in the mean.
    dry: f32,
    /// How far grass is worn away, 0..1.
    worn: f32,
    /// The octave of tufts that pixels show.
    octave: f32,
}

impl Patches {
    /// Those that `Prepared::ground_patches` tells.
    fn of([light, dry, worn, octave]: [f32; 4]) -> Self {
        Self { light, dry: dry - 1.0, worn: (worn - 1.0).max(0.0), octave }
    }
}

/// The light on a place of the ground, and the air between it and the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct GroundLight {
    /// Radiance of a white ground in the sun's unshaded beam.
    sun: [f32; 3],
    /// Radiance of a white ground in all other light.
    ambient: [f32; 3],
    /// Share of its radiance that comes through the air.
    kept: [f32; 3],
    /// Radiance that the air adds.
    air: [f32; 3],
}

impl GroundLight {
    /// How many numbers it is made of.
    pub(super) const VALUES: usize = 12;

    /// Its numbers.
    pub(super) fn values(&self) -> [f32; Self::VALUES] {
        let parts = [self.sun, self.ambient, self.kept, self.air];
        std::array::from_fn(|number| parts[number / 3][number % 3])
    }

    /// Radiance of a reflectance in a share of the sun, through the air.
    fn seen(&self, albedo: [f32; 3], lit: f32) -> [f32; 3] {
        std::array::from_fn(|k| albedo[k] * (self.sun[k] * lit + self.ambient[k]) * self.kept[k] + self.air[k])
    }

    /// Made of its numbers.
    pub(super) fn of(values: [f32; Self::VALUES]) -> Self {
        let part = |number: usize| std::array::from_fn(|k| values[3 * number + k]);
        Self { sun: part(0), ambient: part(1), kept: part(2), air: part(3) }
    }
}

/// Grass about a place, as the eye sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sward {
    light: GroundLight,
    /// Its mean reflectance.
    albedo: [f32; 3],
    /// The ground's unit normal.
    pub normal: Vec3,
}

impl Sward {
    /// Radiance of what is by these factors lighter than the mean, where it is lit by this share of the sun.
    pub(super) fn radiance(&self, share: [f32; 3], lit: f32) -> [f32; 3] {
        self.light.seen(std::array::from_fn(|k| self.albedo[k] * share[k]), lit)
    }
}

impl Prepared<'_> {
    /// Where a point of the picture below the horizon meets the level ground.
    fn on_ground(&self, at: [f32; 2]) -> Spot {
        let ray = self.projection.ray(at[0], at[1]);
        let distance = self.projection.eye.y / (-ray.y).max(1e-6);
        Spot { position: self.projection.eye + ray * distance, distance, ray, normal: Vec3::y() }
    }

    /// Radiance of uneven ground at a point of it, its unit normal on the side of the eye.
    pub(super) fn uneven_ground(&self, position: Vec3, normal: Vec3, salt: u64) -> [f32; 3] {
        let Some(ground) = &self.frame.ground else { return [0.0; 3] };
        let spot = self.spot(position, normal);
        self.seen(&spot, &self.spot_light(&spot, ground), self.spot_patches(&spot), salt)
    }

    /// Radiance of a spot of the ground in its light and its patches.
    fn seen(&self, spot: &Spot, light: &GroundLight, patches: [f32; 4], salt: u64) -> [f32; 3] {
        self.reads.borrow_mut().rest = true;
        let albedo = self.ground_albedo(spot, patches);
        light.seen(albedo, self.shade(spot.position, spot.normal, salt))
    }

    /// The sward about a place of the ground with this unit normal.
    pub(super) fn sward_about(&self, position: Vec3, normal: Vec3) -> Sward {
        let Some(ground) = &self.frame.ground else {
            return Sward { light: GroundLight::default(), albedo: [0.0; 3], normal };
        };
        self.reads.borrow_mut().rest = true;
        let spot = self.spot(position, normal);
        let patches = Patches { worn: 0.0, ..Patches::of(self.spot_patches(&spot)) };
        let mean = self.textures[ground.texture as usize].mean();
        let albedo = self.covered(ground, mean, Vec2::new(position.x, position.z), &patches, (0.0, spot.long(self)));
        Sward { light: self.spot_light(&spot, ground), albedo, normal }
    }

    /// A place of the ground with its unit normal on the side of the eye.
    fn spot(&self, position: Vec3, normal: Vec3) -> Spot {
        let way = position - self.projection.eye;
        let distance = way.norm();
        Spot { position, distance, ray: way / distance.max(1e-6), normal }
    }

    /// Radiance of the ground at a point of the picture below the horizon, of what changes little from pixel to pixel.
    pub(super) fn ground(&self, at: [f32; 2], light: &GroundLight, patches: [f32; 4]) -> [f32; 3] {
        let Some(ground) = &self.frame.ground else { return self.sky(at) };
        let spot = self.on_ground(at);
        let seen = self.seen(&spot, light, patches, hash(at[0] as u64, at[1] as u64));
        match ground.wood {
            // What lies beyond the wood's edge is hidden by it.
            Some(wood) if spot.distance > wood.distance => self.before_wood(&wood, spot.ray, seen),
            _ => seen,
        }
    }

    /// Radiance of tall grass at the far end of the meadow, along a unit direction and a distance, of a patch that is fresh (0) to
    /// dry (1).
    pub(super) fn far_meadow(&self, ray: Vec3, distance: f32, patch: f32) -> [f32; 3] {
        let Some(ground) = &self.frame.ground else { return [0.0; 3] };
        self.reads.borrow_mut().rest = true;
        let mean = self.textures[ground.texture as usize].mean();
        let meeting = mix(self.frame.sun.direction.y.max(0.0), self.sward(ray, Vec3::y()), ground.blades);
        let sun = self.frame.sun.irradiance.map(|e| e * meeting * self.atmosphere.sun_share());
        let sky = self.atmosphere.open.irradiance(Vec3::y());
        let straw = (STRAWY + 0.24 * (patch - 0.5) + 0.58 * ground.dormant) * ground.blades;
        let light = 0.66 + 0.34 * patch;
        let lit = std::array::from_fn(|k| light * mean[k] * mix(1.0, STRAW[k], straw) * (sun[k] + sky[k]) / PI);
        self.atmosphere.hazed(lit, ray * distance)
    }

    /// The light on the ground at a point of the picture, and the air before it.
    pub(super) fn ground_light(&self, at: [f32; 2]) -> GroundLight {
        let Some(ground) = &self.frame.ground else { return GroundLight::default() };
        self.spot_light(&self.on_ground(at), ground)
    }

    fn spot_light(&self, spot: &Spot, ground: &Ground) -> GroundLight {
        let Spot { position, distance, ray, normal } = *spot;
        let share = self.atmosphere.sun_share();
        let facing = self.frame.sun.direction.dot(&normal).max(0.0);
        let meeting = mix(facing, self.sward(ray, normal), ground.blades) * share / PI;
        // No meadow is farther away than the wood that closes it off.
        let farthest = ground.wood.map_or(f32::MAX, |wood| wood.distance);
        let way = ray * distance.min(farthest);
        let open = open_at_feet(&ground.feet, Vec2::new(position.x, position.z));
        let air = self.atmosphere.air(way);
        GroundLight {
            sun: self.frame.sun.irradiance.map(|e| e * meeting),
            ambient: self.ambient(position).irradiance(normal).map(|e| e * open / PI),
            kept: air.map(|channel| channel[0]),
            air: air.map(|channel| channel[1]),
        }
    }

    /// Wide patches in the ground, which do not repeat: how light it is, how dry and how worn (both with 1 added, so that what
    /// counts as even is told from 1), and the octave of tufts that pixels show.
    pub(super) fn ground_patches(&self, at: [f32; 2]) -> [f32; 4] {
        self.spot_patches(&self.on_ground(at))
    }

    fn spot_patches(&self, spot: &Spot) -> [f32; 4] {
        let place = Vec2::new(spot.position.x, spot.position.z);
        let (pixel, long) = (spot.pixel(self), spot.long(self));
        let [field, wide] = [(71.0, 1), (19.0, 2)].map(|(size, salt)| patches(place / size, salt, long / size));
        let octave = log2f((pixel / FINEST).max(1.0));
        let worn = self.frame.ground.as_ref().map_or(0.0, |ground| worn(&ground.feet, place));
        [1.0 + 0.18 * field + 0.32 * wide, 1.0 + 0.24 * field - 0.26 * wide, 1.0 + worn, octave]
    }

    /// Reflectance of the ground: its texture, tufts and patches of herbs.
    fn ground_albedo(&self, spot: &Spot, patches: [f32; 4]) -> [f32; 3] {
        let Some(ground) = &self.frame.ground else { return [0.0; 3] };
        let (slope, patches) = (spot.slope(), Patches::of(patches));
        let place = Vec2::new(spot.position.x, spot.position.z);
        // A pixel on the ground is long and narrow; the mean of its sides keeps detail without crawling.
        let (pixel, long) = (spot.pixel(self), spot.long(self));
        let footprint = (pixel * long).sqrt() / ground.tile;
        let texture = &self.textures[ground.texture as usize];
        let mean = texture.mean();
        // Where a repeat is a few pixels there is no detail left but the repeats.
        let near = 1.0 - smooth_step(0.04, 0.10, footprint);
        let detail = if near > 0.0 { texture.sample(place / ground.tile, footprint) } else { mean };
        let detail = std::array::from_fn(|k| mix(mean[k], detail[k], near));
        // Where even a tuft that is drawn out is shorter than a pixel it would be a weave of the lattice and the pixels.
        let drawn = 1.0 - smooth_step(0.6 * LONGEST, 1.6 * LONGEST, 0.5 / slope.max(1e-4));
        let upright = if ground.blades > 0.0 && drawn > 0.0 {
            self.tufts(place, patches.octave, spot.distance * slope) * ground.blades * drawn
        } else {
            0.0
        };
        // A tuft hides what lies behind it, so patches end in tufts: what is seen lies nearer by its height over the slope.
        let seen = place - self.atmosphere.ahead * (upright * TALL * ground.blades / slope.max(1e-3));
        self.covered(ground, detail, seen, &patches, (upright, long))
    }

    /// Reflectance of what covers the ground, of a texture's reflectance, at a place in patches: how far upright tufts make it
    /// lighter, and how long a pixel is there, metres.
    fn covered(
        &self,
        ground: &Ground,
        detail: [f32; 3],
        place: Vec2,
        patches: &Patches,
        (upright, long): (f32, f32),
    ) -> [f32; 3] {
        let mean = self.textures[ground.texture as usize].mean();
        let nodes = &mut *self.nodes.borrow_mut();
        let [middle, small, clumps, tufts] = [(4.3, 4, 0), (1.15, 3, 1), (0.38, 6, 4), (0.13, 7, 5)]
            .map(|(size, salt, kept)| patches_by(&mut nodes[kept], place / size, salt, long / size));
        let light = patches.light + 0.40 * middle + 0.34 * small + 0.34 * clumps + 0.30 * tufts + TUFTS * upright;
        let grass = ground.blades * (1.0 - patches.worn);
        let patchy = 0.58 * small - 0.40 * middle + 0.50 * clumps + 0.36 * tufts;
        let straw = STRAWY + patches.dry + patchy + 0.25 * upright + ground.dormant * 0.58;
        let straw = straw.clamp(0.0, 1.0) * grass;
        std::array::from_fn(|k| {
            let textured = detail[k] * light;
            let rested = textured * mix(1.0, DULL[k], ground.dormant * grass);
            let earth = SOIL[k] * (0.6 + 0.4 * textured / mean[k].max(1e-3));
            let cover = mix(rested, mix(mean[k], textured, 0.7) * STRAW[k], straw);
            mix(cover, earth, patches.worn * ground.blades).max(0.15 * mean[k])
        })
    }

    /// Noise of tufts that stand upright: each hides what lies behind it for as far as it is high over the slope of the look, so
    /// on the ground it is drawn out away from the eye, by as much as at the distance where its size is that of a pixel. Two sizes
    /// are mixed as the distance grows, so that it is never lost and each stays where it is. The eye is `over` metres over the ground.
    fn tufts(&self, place: Vec2, octave: f32, over: f32) -> f32 {
        let ahead = self.atmosphere.ahead;
        let (along, across) = (place.dot(&ahead), place.x * ahead.y - place.y * ahead.x);
        let level = (octave.max(0.0) as i32).min(20);
        let of = |level: i32| {
            let times = (1i32 << level) as f32;
            let drawn_out =
                (0.5 * times * FINEST * self.projection.pixels_per_metre / over.max(0.1)).clamp(1.0, LONGEST);
            let size = 2.5 * FINEST * times;
            // A slant of its own keeps the lattice's rows from lying along the picture's.
            let (u, v) = (across / size, along / (size * drawn_out));
            let nodes = &mut self.nodes.borrow_mut()[2 + (level & 1) as usize];
            Lattice::new(40 + level as u64).gradient_by(nodes, u + 0.24 * v, v - 0.15 * u)
        };
        let part = octave - level as f32;
        if part <= 0.0 { of(level) } else { mix(of(level), of(level + 1), part) }
    }

    /// How a meadow meets the sun where an eye sees it, as a share of the irradiance across the beam, 0 to about 2: blades that
    /// stand all ways, lit and seen through one another. Single scattering in a deep layer is mu0 / (mu0 + mu) times the
    /// leaves' phase function (Ross 1981, spherical leaf angles), 1 where sun and eye are both overhead.
    fn sward(&self, ray: Vec3, normal: Vec3) -> f32 {
        let sun = self.frame.sun.direction;
        let (in_cosine, out_cosine) = (sun.dot(&normal).max(0.0), (-ray.dot(&normal)).max(0.0));
        if in_cosine <= 0.0 {
            return 0.0;
        }
        let [sent_back, let_through] = phase(sun, ray);
        SWARD * 2.0 * in_cosine / (in_cosine + out_cosine) * (sent_back + BLADE * let_through) / PI
    }
}

/// Width of a tuft that is told from others near by, metres.
const FINEST: f32 = 0.007;
/// How much longer than wide a tuft is on the ground at most.
const LONGEST: f32 = 160.0;
/// How much lighter and darker tufts are than the mean (judged).
const TUFTS: f32 = 0.34;

/// Height of a tuft over the sward, metres, for a noise of 1.
const TALL: f32 = 0.16;
/// Metres from a trunk to where grass is whole again, for a thin one.
const WORN: f32 = 0.45;
/// Share of dry stalks and seed heads in a summer's meadow.
const STRAWY: f32 = 0.16;
/// Reflectance of dry grass over that of the meadow's mean, and of resting green grass over fresh.
const STRAW: [f32; 3] = [2.10, 1.42, 2.60];
const DULL: [f32; 3] = [1.00, 0.78, 1.25];
/// Reflectance of trodden soil with crumbs of litter and moss (linear, judged).
const SOIL: [f32; 3] = [0.085, 0.070, 0.042];

/// Noise of mean 0 with features one unit across, that fades out where pixels are wider.
fn patches(place: Vec2, salt: u64, pixel: f32) -> f32 {
    patches_by(&mut Nodes::default(), place, salt, pixel)
}

/// `patches` by nodes that are kept.
fn patches_by(nodes: &mut Nodes, place: Vec2, salt: u64, pixel: f32) -> f32 {
    let seen = 1.0 - smooth_step(0.4, 1.5, pixel);
    if seen <= 0.0 { 0.0 } else { Lattice::new(salt).gradient_by(nodes, place.x, place.y) * seen }
}

/// Share of the sky's light that trunks (x, z, radius) leave on the ground at a place: an endless wall that spans the angle
/// 2 asin(r / d) takes asin(r / d) / pi of the irradiance of an even sky.
fn open_at_feet(feet: &[[f32; 3]], place: Vec2) -> f32 {
    feet.iter().fold(1.0, |open, [x, z, radius]| {
        let (away, reach) = ((place.x - x) * (place.x - x) + (place.y - z) * (place.y - z), REACH * radius);
        if away > reach * reach {
            return open;
        }
        let distance = away.sqrt();
        // Less what is left at the reach, so that it ends there.
        let taken = (asinf((radius / distance.max(*radius)).min(1.0)) - asinf(1.0 / REACH)) / PI;
        // Between blades and litter at its very foot it is darker still (judged).
        let crevice = 1.0 - 0.4 * (1.0 - smooth_step(0.0, 0.9 * radius + 0.06, distance - radius));
        open * (1.0 - taken.max(0.0)) * crevice
    })
}

/// Radii of a trunk within which it keeps light off the ground.
const REACH: f32 = 16.0;

/// How much of the ground's cover is worn away about trunks (x, z, radius), 0..1.
fn worn(feet: &[[f32; 3]], place: Vec2) -> f32 {
    feet.iter().fold(0.0f32, |worn, [x, z, radius]| {
        let away = (place.x - x) * (place.x - x) + (place.y - z) * (place.y - z);
        let reach = 2.0 * radius + WORN;
        if away > reach * reach {
            return worn;
        }
        let frayed = 0.35 * Lattice::new(9).gradient(place.x / 0.23, place.y / 0.23);
        worn.max(0.85 * (1.0 - smooth_step(0.25, 1.0, (away.sqrt() - radius) / (reach - radius) + frayed)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trunk_darkens_the_ground_at_its_foot_and_nothing_far_away() {
        let feet = [[1.0, 2.0, 0.2]];
        let open = |distance: f32| open_at_feet(&feet, Vec2::new(1.0, 2.0 + distance));
        let opens: Vec<f32> = (4..70).map(|step| open(0.05 * step as f32)).collect();
        assert!(opens.windows(2).all(|pair| pair[0] <= pair[1] + 1e-6), "{opens:?}");
        // At the wall itself, and within, half of the sky is hidden; away from the crevice the closed form holds.
        assert!((open(0.1) - 0.6 * (0.5 + asinf(1.0 / REACH) / PI)).abs() < 1e-5);
        assert!((open(1.0) - (1.0 - (asinf(0.2) - asinf(1.0 / REACH)) / PI)).abs() < 1e-5);
        assert_eq!((open(4.0), open_at_feet(&[], Vec2::zeros())), (1.0, 1.0));
    }

    #[test]
    fn grass_is_worn_at_a_trunk_s_foot_only() {
        let feet = [[0.0, 0.0, 0.15]];
        let worn = |distance: f32| worn(&feet, Vec2::new(distance, 0.0));
        assert!(worn(0.15) > 0.3 && worn(0.9) == 0.0, "{} {}", worn(0.15), worn(0.9));
    }
}
