//! How leaves differ within a crown: by exposure, and by what the leaves of a limb and of a shoot share.
//!
//! Exposure is a number of a leaf's own site in the species' nominal crown, half an ellipsoid; no leaf's depends on another's, so
//! that a branch more changes no leaf. Speeds and exposures are taken in classes, so that the exact shares of all leaves are a sum
//! over few laws.

use super::settings::{Mode, NominalCrown, Settings};
use crate::base::maths::exp;
use crate::base::random::{Purpose, Stream};

/// Classes of exposure: 0, 1/8, ... 1; the middle one is that of a leaf whose exposure is not known.
pub(super) const EXPOSURES: usize = 9;
/// Classes of speed in one e-fold.
const SPEEDS: f64 = 8.0;
/// The fastest class: e^3 of the mean.
const FASTEST: i8 = 24;

/// Where a leaf sits in its tree, and with which leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// Height above the ground, metres.
    pub height: f64,
    /// Distance from the trunk's axis, metres.
    pub distance: f64,
    /// Identity of the limb.
    pub limb: u64,
    /// Identity of the shoot.
    pub shoot: u64,
}

/// The nominal crown of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crown {
    height: f64,
    radius: f64,
    base: f64,
}

impl Crown {
    /// The crown of a tree of an age in years, or as high as was asked for, metres; an old one without either. None where the
    /// species' crown is not known.
    #[must_use]
    pub fn new(nominal: &NominalCrown, age: Option<f64>, height: Option<f64>) -> Option<Self> {
        if nominal.height <= 0.0 {
            return None;
        }
        let grown = age.map_or(1.0, |age| 1.0 - exp(-age / nominal.years));
        let scale = height.map_or(grown, |height| height / nominal.height);
        Some(Self { height: nominal.height * scale, radius: nominal.radius * scale, base: nominal.base * scale })
    }

    /// 0 low and inside to 1 at the top: the mean of the height in the crown and of the distance from the middle of its foot, both
    /// relative to the crown, half an ellipsoid.
    #[must_use]
    pub fn exposure(&self, position: &Position) -> f64 {
        let up = ((position.height - self.base) / (self.height - self.base).max(1e-9)).clamp(0.0, 1.0);
        let aside = position.distance / self.radius.max(1e-9);
        0.5 * up + 0.5 * (up * up + aside * aside).sqrt().min(1.0)
    }
}

/// Leaves of equal speed and exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Class {
    /// Logarithm of the speed, in `SPEEDS` steps of one e-fold.
    speed: i8,
    /// Number of the exposure's class.
    pub exposure: u8,
}

impl Class {
    /// The class of every leaf of the plain chain.
    pub const MEAN: Self = Self { speed: 0, exposure: (EXPOSURES / 2) as u8 };

    /// The class of a leaf.
    pub fn of(settings: &Settings, seed: u64, crown: Option<&Crown>, position: &Position) -> Self {
        if settings.coherence == 0.0 {
            return Self::MEAN;
        }
        let exposure = crown.map_or(0.5, |crown| crown.exposure(position));
        let shared = |id: u64, event: u64| Stream::new(seed, Purpose::Tempo, id, event).normal();
        let NominalCrown { rate, limb, shoot, .. } = settings.crown;
        let mut logarithm = rate * (exposure - 0.5);
        if limb > 0.0 {
            logarithm += limb * shared(position.limb, 0);
        }
        if shoot > 0.0 {
            logarithm += shoot * shared(position.shoot, 1);
        }
        Self::rounded(settings, logarithm, exposure)
    }

    fn rounded(settings: &Settings, logarithm: f64, exposure: f64) -> Self {
        let steps = (SPEEDS * settings.coherence * logarithm).round();
        let has_odds = settings.coherence > 0.0 && settings.crown.odds.values().any(|odds| *odds != 0.0);
        let exposure = (exposure * (EXPOSURES - 1) as f64).round();
        Self {
            speed: steps.clamp(-f64::from(FASTEST), f64::from(FASTEST)) as i8,
            exposure: if has_odds { exposure as u8 } else { Self::MEAN.exposure },
        }
    }

    /// How many times faster than the mean the leaf passes its gated states.
    pub fn speed(self) -> f64 {
        if self.speed == 0 { 1.0 } else { exp(f64::from(self.speed) / SPEEDS) }
    }
}

/// Weights of the targets by class of exposure.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Odds {
    /// Weight of each target state, exposure after exposure; empty when all are 1.
    weights: Vec<f64>,
    states: usize,
}

impl Odds {
    /// `names` are those of the chain.
    pub fn new(settings: &Settings, names: &[String]) -> Self {
        // The paper's leaves are all alike.
        let coherence = if settings.mode == Mode::Exact { settings.coherence } else { 0.0 };
        let odds = |name: &String| coherence * settings.crown.odds.get(name).copied().unwrap_or(0.0);
        let is_plain = names.iter().all(|name| odds(name) == 0.0);
        let weight = |class: usize, name: &String| exp(odds(name) * (class as f64 / (EXPOSURES - 1) as f64 - 0.5));
        let of_class = |class: usize| names.iter().map(move |name| weight(class, name));
        let weights = if is_plain { Vec::new() } else { (0..EXPOSURES).flat_map(of_class).collect() };
        Self { weights, states: names.len() }
    }

    /// The chances as a leaf of a class has them; their sum is 1 again.
    pub fn weighed(&self, class: Class, targets: impl Iterator<Item = (u16, f64)>, into: &mut Vec<(u16, f64)>) {
        into.clear();
        into.extend(targets);
        if self.weights.is_empty() {
            return;
        }
        let own = &self.weights[usize::from(class.exposure) * self.states..][..self.states];
        into.iter_mut().for_each(|(target, chance)| *chance *= own[usize::from(*target)]);
        let sum: f64 = into.iter().map(|(_, chance)| chance).sum();
        into.iter_mut().for_each(|(_, chance)| *chance /= sum);
    }
}

#[cfg(test)]
mod tests {
    use super::super::chain::tests::branching;
    use super::*;

    fn crowned() -> Settings {
        let crown = NominalCrown {
            height: 20.0,
            radius: 6.0,
            base: 2.0,
            years: 30.0,
            rate: 1.0,
            limb: 0.0,
            shoot: 0.0,
            odds: [("c".to_owned(), 2.0)].into(),
        };
        Settings { coherence: 1.0, crown, ..branching() }
    }

    fn at(height: f64, distance: f64) -> Position {
        Position { height, distance, limb: 1, shoot: 2 }
    }

    #[test]
    fn the_top_is_exposed_and_the_inside_is_not() {
        let crown = Crown::new(&crowned().crown, None, None).unwrap();
        assert_eq!((crown.exposure(&at(20.0, 0.0)), crown.exposure(&at(90.0, 50.0))), (1.0, 1.0));
        assert!((crown.exposure(&at(11.0, 0.0)) - 0.5).abs() < 1e-12);
        assert!((crown.exposure(&at(2.0, 6.0)) - 0.5).abs() < 1e-12);
        assert_eq!(crown.exposure(&at(1.0, 0.0)), 0.0);
    }

    #[test]
    fn a_young_trees_crown_is_the_old_ones_made_small() {
        let crown = Crown::new(&crowned().crown, Some(30.0 * std::f64::consts::LN_2), None).unwrap();
        assert!((crown.height - 10.0).abs() < 1e-9 && (crown.radius - 3.0).abs() < 1e-9);
        assert_eq!(Crown::new(&crowned().crown, Some(5.0), Some(5.0)).unwrap().height, 5.0);
        assert_eq!(Crown::new(&NominalCrown::default(), None, None), None);
    }

    #[test]
    fn without_coherence_all_leaves_are_of_the_mean_class() {
        let settings = Settings { coherence: 0.0, ..crowned() };
        assert_eq!(Class::of(&settings, 1, None, &at(1.0, 1.0)), Class::MEAN);
        assert_eq!(Class::MEAN.speed(), 1.0);
    }

    #[test]
    fn the_exposed_are_faster_and_their_targets_weigh_more() {
        let settings = crowned();
        let crown = Crown::new(&settings.crown, None, None);
        let class = |height, distance| Class::of(&settings, 1, crown.as_ref(), &at(height, distance));
        let (top, inside) = (class(19.5, 2.0), class(5.0, 0.5));
        assert!(top.speed() / inside.speed() > 1.5);
        let odds = Odds::new(&settings, &["a".to_owned(), "b".to_owned(), "c".to_owned()]);
        let mut weighed = Vec::new();
        let mut chance = |class| {
            odds.weighed(class, [(1, 0.5), (2, 0.5)].into_iter(), &mut weighed);
            assert!((weighed.iter().map(|(_, chance)| chance).sum::<f64>() - 1.0).abs() < 1e-14);
            weighed[1].1 / weighed[0].1
        };
        // From exposure 0 to 1 the odds grow by e^2.
        let ends = [0, EXPOSURES as u8 - 1].map(|exposure| chance(Class { speed: 0, exposure }));
        assert!((ends[1] / ends[0] - exp(2.0)).abs() < 1e-9);
        assert!(chance(top) > chance(inside));
    }
}
