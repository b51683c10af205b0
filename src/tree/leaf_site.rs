//! Where leaves sit and how they hold themselves: petioles leave the twig at an angle and bend up, blades face the sky and
//! lean outward. Each leaf's numbers are keyed by its own id.

use super::Settings;
use super::skeleton::{Shoot, Skeleton};
use crate::base::maths::{cos, sin};
use crate::base::random::{Purpose, Stream, hash};
use crate::base::vector::{DVec3, rotated};
use std::collections::BTreeMap;

/// Spread of the blades' inclination, degrees: leaf angle distributions of broad-leaved trees (Pisek et al. 2013) have
/// standard deviations of 12 to 18.
const INCLINATION_SPREAD: f64 = 15.0;
/// Spread of the blades' azimuth about that of the petiole, degrees.
const AZIMUTH_SPREAD: f64 = 28.0;
/// Spread of the roll of a blade about its midrib, degrees.
const ROLL_SPREAD: f64 = 14.0;
/// Spread of the angle between twig and petiole, degrees.
const PETIOLE_SPREAD: f64 = 9.0;
/// Spread of the petioles' lengths at one place, relative.
const PETIOLE_LENGTH_SPREAD: f64 = 0.1;
/// How far a petiole bends up: the vertical added to its unit direction before that is made unit again.
const PETIOLE_RISE: f64 = 0.25;

/// A leaf on the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafSite {
    /// Stable id.
    pub id: u64,
    /// Where the petiole leaves the twig's surface, metres.
    pub base: DVec3,
    /// Unit vector of the petiole, away from the twig.
    pub petiole: DVec3,
    /// Unit vector from the blade's joint to its tip.
    pub blade: DVec3,
    /// Unit vector of the blade's upper side, at right angles to `blade`.
    pub normal: DVec3,
    /// Size relative to the species' mean blade.
    pub scale: f64,
    /// Order of the axis it sits on.
    pub order: u32,
    /// Length of the petiole over that of the species' mean leaf of this size.
    pub petiole_length: f64,
    /// Number of the segment at whose end it sits.
    pub segment: Option<u32>,
    /// Identity of the limb, the axis out of the trunk that bears it; the trunk's where no limb does.
    pub limb: u64,
    /// Identity of the year's shoot that it sits on.
    pub shoot: u64,
}

/// Length of a blade in full light and in deep shade over the mean (sun and shade leaves; Pisek et al. 2013 for the angle).
const SUN_SIZE: f64 = 0.92;
const SHADE_SIZE: f64 = 1.14;
/// Inclination of blades in full light and in deep shade over the mean.
const SUN_INCLINATION: f64 = 1.15;
const SHADE_INCLINATION: f64 = 0.7;

/// The site of a leaf that the turtle passed and that sees the share `light` of the sky; its `petiole` is relative to the mean.
pub(super) fn site(
    shoot: &Shoot,
    skeleton: &Skeleton,
    bearer: &Bearer,
    (light, petiole_length): (f64, f64),
    settings: &Settings,
    seed: u64,
) -> LeafSite {
    let mut stream = Stream::new(seed, Purpose::LeafSite, shoot.id, 0);
    let angle = (settings.petiole_angle + PETIOLE_SPREAD * stream.normal()).clamp(0.0, 180.0).to_radians();
    let leaving = shoot.heading * cos(angle) - shoot.up * sin(angle);
    let petiole = (leaving + DVec3::y() * PETIOLE_RISE).try_normalize(1e-9).unwrap_or(leaving);
    let lit = |shade: f64, sun: f64| shade + (sun - shade) * light;
    let mean = settings.blade_inclination * lit(SHADE_INCLINATION, SUN_INCLINATION);
    let (blade, normal) = attitude(petiole, shoot, mean, &mut stream);
    let size = 1.0 + settings.leaf_size_spread * stream.normal();
    let scale = shoot.scale * size.clamp(0.35, 1.65) * lit(SHADE_SIZE, SUN_SIZE);
    let base = surface(shoot, skeleton, petiole);
    let petiole_length = petiole_length * (1.0 + PETIOLE_LENGTH_SPREAD * stream.normal()).clamp(0.7, 1.3);
    let (segment, order) = (shoot.segment, shoot.order);
    let Bearer { limb, shoot: of_year } = *bearer;
    LeafSite { id: shoot.id, base, petiole, blade, normal, scale, order, petiole_length, segment, limb, shoot: of_year }
}

/// The wood that bears a leaf, by identities that stay the same when other branches come or go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bearer {
    /// The first segment of the axis of order 1 on the way to the trunk; of the trunk without one.
    limb: u64,
    /// The axis and the year in which the segment grew.
    shoot: u64,
}

impl Bearer {
    /// Of a leaf on no wood.
    pub const NONE: Self = Self { limb: 0, shoot: 0 };

    /// Of the leaves at the end of each segment.
    pub fn of_segments(skeleton: &Skeleton) -> Vec<Self> {
        let (mut bearers, mut axes): (Vec<Self>, BTreeMap<u32, u64>) = (Vec::new(), BTreeMap::new());
        for segment in &skeleton.segments {
            let axis = *axes.entry(segment.axis).or_insert(segment.id);
            let below = segment.parent.and_then(|parent| bearers.get(parent as usize));
            let limb = if segment.order <= 1 { axis } else { below.map_or(axis, |below: &Self| below.limb) };
            bearers.push(Self { limb, shoot: hash(axis, u64::from(segment.birth)) });
        }
        bearers
    }
}

/// The point of the twig's surface that the petiole leaves from.
fn surface(shoot: &Shoot, skeleton: &Skeleton, petiole: DVec3) -> DVec3 {
    let Some(segment) = shoot.segment.map(|number| &skeleton.segments[number as usize]) else { return shoot.position };
    let along = segment.direction();
    let aside = petiole - along * along.dot(&petiole);
    segment.end + aside.try_normalize(1e-9).unwrap_or_else(DVec3::zeros) * segment.radius
}

/// Directions of the blade's midrib and upper side.
fn attitude(petiole: DVec3, shoot: &Shoot, inclination: f64, stream: &mut Stream) -> (DVec3, DVec3) {
    // Level part of the petiole, with a little of "away from the trunk" so that upright shoots fan out.
    let outward = DVec3::new(shoot.position.x, 0.0, shoot.position.z).try_normalize(1e-6).unwrap_or_else(DVec3::x);
    let level = DVec3::new(petiole.x, 0.0, petiole.z) + outward * 0.25;
    let level = level.try_normalize(1e-6).unwrap_or(outward);
    let level = rotated(level, DVec3::y(), (AZIMUTH_SPREAD * stream.normal()).to_radians());
    let spread = INCLINATION_SPREAD * stream.normal();
    let inclination = (inclination + spread).clamp(-90.0, 90.0).to_radians();
    let blade = level * cos(inclination) - DVec3::y() * sin(inclination);
    let normal = level * sin(inclination) + DVec3::y() * cos(inclination);
    (blade, rotated(normal, blade, (ROLL_SPREAD * stream.normal()).to_radians()))
}
