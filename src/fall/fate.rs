//! What has become of a leaf at a time.

use super::{DAY, Decay, Fallen, Flight, Settings};
use crate::base::random::{Purpose, Stream};

/// Seconds of a leaf's own that it takes to come to rest after it has touched the ground.
pub(super) const SETTLING: f64 = 1.2;

/// What has become of a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// It still hangs.
    Hanging,
    /// It is in the air, so many seconds of its own flight after it let go.
    Air(f64),
    /// It lies as it fell; so far on the way to its rest, 0 to 1.
    Fresh(f64),
    /// It lies and is brown.
    Brown,
    /// It lies, brown and flat.
    Flat,
    /// Nothing is left of it.
    Decayed,
}

impl Fate {
    /// Whether it lies on the ground.
    #[must_use]
    pub fn lies(self) -> bool {
        matches!(self, Self::Fresh(_) | Self::Brown | Self::Flat)
    }
}

/// What has become of all leaves that ever grew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Leaves that grew.
    pub grown: u64,
    /// On their twigs.
    pub attached: u64,
    /// In the air.
    pub air: u64,
    /// On the ground.
    pub lying: u64,
    /// Gone: decayed or raked away.
    pub decayed: u64,
    /// Raked away, of those that are gone.
    pub raked: u64,
}

impl Counts {
    /// Those of two stands together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            grown: self.grown + other.grown,
            attached: self.attached + other.attached,
            air: self.air + other.air,
            lying: self.lying + other.lying,
            decayed: self.decayed + other.decayed,
            raked: self.raked + other.raked,
        }
    }
}

/// When a leaf's fates begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// When it lands, days.
    pub landed: f64,
    /// Days after its landing from which it is brown, flat and gone.
    ages: [f64; 3],
}

impl Course {
    /// The course of a leaf. Single leaves brown after 0.4 to 1.6 of the mean time, flatten after 0.3 to 0.55 of the time that
    /// litter stays, and are gone after 0.7 to 1.3 of it.
    #[must_use]
    pub fn new(settings: &Settings, decay: &Decay, seed: u64, leaf: &Fallen, flight: &Flight) -> Self {
        let mut stream = Stream::new(seed, Purpose::Litter, leaf.leaf, leaf.year);
        let mut after = |mean: f64, low: f64, high: f64| mean * stream.range(low, high);
        let brown = after(decay.browning, 0.4, 1.6);
        let flat = after(decay.days, 0.3, 0.55).max(brown);
        let gone = after(decay.days, 0.7, 1.3).max(brown);
        let landed = if settings.air { flight.lands(leaf, settings.slow_motion) } else { leaf.day };
        Self { landed, ages: [brown, flat, gone] }
    }

    /// What has become of the leaf on `day`.
    #[must_use]
    pub fn fate(&self, settings: &Settings, leaf: &Fallen, flight: &Flight, day: f64) -> Fate {
        if day < leaf.day {
            return Fate::Hanging;
        }
        if day < self.landed {
            return Fate::Air(((day - leaf.day) * DAY / settings.slow_motion).clamp(0.0, flight.seconds));
        }
        let (age, [brown, flat, gone]) = (day - self.landed, self.ages);
        match age {
            age if age >= gone => Fate::Decayed,
            age if age >= flat => Fate::Flat,
            age if age >= brown => Fate::Brown,
            _ if settings.air => Fate::Fresh((age * DAY / settings.slow_motion / SETTLING).min(1.0)),
            _ => Fate::Fresh(1.0),
        }
    }
}
