//! The chain of one climate: a rate and weighed targets for each state.

use super::{Climate, Settings, State};

/// The chain compiled for a climate. States are numbered in the order of their names.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Names of the states, sorted.
    pub names: Vec<String>,
    /// Rate at which each state is left, 1/day; 0 for a state that lasts.
    pub rates: Vec<f64>,
    /// For each state the states that may follow, with their chances; empty for a state that lasts.
    pub targets: Vec<Vec<(u16, f64)>>,
    /// The state of every leaf at day 0.
    pub start: u16,
    /// Whether the climate lay outside the corners and was moved to the nearest point between them.
    pub clamped: bool,
}

/// Where a climate stands between the corners: 0 to 1 from cold to warm and from dry to wet.
struct Place {
    warmth: f64,
    wetness: f64,
    clamped: bool,
}

impl Place {
    fn new(settings: &Settings, climate: &Climate) -> Self {
        let warmth = (climate.temperature - settings.cold) / (settings.warm - settings.cold);
        let wetness = (climate.humidity - settings.dry) / (settings.wet - settings.dry);
        let inside = 0.0..=1.0;
        Self {
            warmth: warmth.clamp(0.0, 1.0),
            wetness: wetness.clamp(0.0, 1.0),
            clamped: !inside.contains(&warmth) || !inside.contains(&wetness),
        }
    }

    /// Bilinear interpolation of values given as wet and cold, wet and warm, dry and cold, dry and warm.
    fn between(&self, corners: [f64; 4]) -> f64 {
        let [wet_cold, wet_warm, dry_cold, dry_warm] = corners;
        let along = |cold: f64, warm: f64| {
            if cold == warm { cold } else { cold * (1.0 - self.warmth) + warm * self.warmth }
        };
        let (wet, dry) = (along(wet_cold, wet_warm), along(dry_cold, dry_warm));
        if wet == dry { wet } else { wet * self.wetness + dry * (1.0 - self.wetness) }
    }

    /// Rate of equation (5), 1/day: the half-life is interpolated, as in the paper, not the rate.
    fn rate(&self, state: &State) -> f64 {
        state.half_life.map_or(0.0, |half_life| std::f64::consts::LN_2 / self.between(half_life.values()))
    }

    /// Chances of `state.next`, rescaled by the rounding error of their sum.
    fn chances(&self, state: &State) -> Vec<f64> {
        let rows = [&state.wet_cold, &state.wet_warm, &state.dry_cold, &state.dry_warm];
        let at = |target: usize| rows.map(|row| row.get(target).copied().unwrap_or(0.0));
        let chances: Vec<f64> = (0..state.next.len()).map(|target| self.between(at(target))).collect();
        let sum: f64 = chances.iter().sum();
        chances.iter().map(|chance| chance / sum).collect()
    }
}

impl Chain {
    /// Compiles settings that have passed [`check`](super::check). A climate outside the corners is clamped to them: half-lives
    /// extrapolated beyond could become negative.
    #[must_use]
    pub fn new(settings: &Settings, climate: &Climate) -> Self {
        let place = Place::new(settings, climate);
        let names: Vec<String> = settings.states.keys().cloned().collect();
        let number = |name: &String| names.binary_search(name).ok().map(|index| index as u16);
        let targets = |state: &State| {
            let weighed = state.next.iter().zip(place.chances(state));
            weighed.filter_map(|(name, chance)| number(name).map(|target| (target, chance))).collect()
        };
        Self {
            rates: settings.states.values().map(|state| place.rate(state)).collect(),
            targets: settings.states.values().map(targets).collect(),
            start: number(&settings.start).unwrap_or(0),
            clamped: place.clamped,
            names,
        }
    }

    /// The target of a jump out of `state` for a uniform number in [0, 1): the inverse of the cumulative chances.
    #[must_use]
    pub fn target(&self, state: u16, uniform: f64) -> u16 {
        let targets = &self.targets[usize::from(state)];
        let mut left = uniform;
        for &(target, chance) in targets {
            left -= chance;
            if left < 0.0 {
                return target;
            }
        }
        // Rounding may leave a sliver above the last cumulative chance: it belongs to the last possible target.
        targets.iter().rev().find(|(_, chance)| *chance > 0.0).map_or(state, |&(target, _)| target)
    }

    /// Which states a leaf can ever be in, by number.
    #[must_use]
    pub fn reachable(&self) -> Vec<bool> {
        let mut reached = vec![false; self.names.len()];
        let mut open = vec![self.start];
        while let Some(state) = open.pop() {
            let Some(seen) = reached.get_mut(usize::from(state)) else { continue };
            if std::mem::replace(seen, true) || self.rates[usize::from(state)] == 0.0 {
                continue;
            }
            open.extend(self.targets[usize::from(state)].iter().filter(|(_, chance)| *chance > 0.0).map(|&(to, _)| to));
        }
        reached
    }
}

/// Which states any leaf can ever be in under this climate, in the order of the states' names.
#[must_use]
pub fn reachable(settings: &Settings, climate: &Climate) -> Vec<bool> {
    Chain::new(settings, climate).reachable()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::base::settings::Corners;
    use proptest::prelude::*;

    /// A state with the same half-life and chances in every climate.
    pub fn state(half_life: f64, next: &[(&str, f64)]) -> State {
        let row: Vec<f64> = next.iter().map(|(_, chance)| *chance).collect();
        State {
            half_life: (!next.is_empty()).then_some(Corners::Same(half_life)),
            next: next.iter().map(|(name, _)| (*name).to_owned()).collect(),
            wet_cold: row.clone(),
            wet_warm: row.clone(),
            dry_cold: row.clone(),
            dry_warm: row,
        }
    }

    /// Settings with the given states, starting in the first.
    pub fn settings(states: &[(&str, State)]) -> Settings {
        Settings {
            start: states[0].0.to_owned(),
            states: states.iter().map(|(name, state)| ((*name).to_owned(), state.clone())).collect(),
            ..Settings::default()
        }
    }

    /// Four states with branches: chain M5 of the reference values, half-lives 30, 15, 10 days and for ever.
    pub fn branching() -> Settings {
        settings(&[
            ("a", state(30.0, &[("b", 0.6), ("c", 0.3), ("d", 0.1)])),
            ("b", state(15.0, &[("c", 0.7), ("d", 0.3)])),
            ("c", state(10.0, &[("d", 1.0)])),
            ("d", state(0.0, &[])),
        ])
    }

    fn cornered() -> Settings {
        let mut settings = settings(&[("a", state(1.0, &[("b", 0.5), ("c", 0.5)])), ("b", state(1.0, &[]))]);
        settings.states.insert("c".to_owned(), State::default());
        let a = settings.states.get_mut("a").unwrap();
        a.half_life = Some(Corners::Each([40.0, 5.0, 80.0, 15.0]));
        a.wet_cold = vec![0.9, 0.1];
        a.dry_warm = vec![0.1, 0.9];
        settings
    }

    #[test]
    fn corners_are_met_and_the_middle_is_their_mean() {
        let settings = cornered();
        let half_life = |temperature, humidity| {
            std::f64::consts::LN_2 / Chain::new(&settings, &Climate { temperature, humidity }).rates[0]
        };
        for (temperature, humidity, expected) in
            [(0.0, 0.9, 40.0), (25.0, 0.9, 5.0), (0.0, 0.3, 80.0), (25.0, 0.3, 15.0), (12.5, 0.6, 35.0)]
        {
            assert!((half_life(temperature, humidity) - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_climate_outside_the_corners_is_clamped() {
        let at = |temperature, humidity| Chain::new(&cornered(), &Climate { temperature, humidity });
        let (outside, corner) = (at(-30.0, 1.0), at(0.0, 0.9));
        assert!(outside.clamped && !corner.clamped);
        assert_eq!((outside.rates, outside.targets), (corner.rates, corner.targets));
    }

    #[test]
    fn states_without_a_way_to_them_are_not_reachable() {
        let mut settings = branching();
        settings.start = "b".to_owned();
        assert_eq!(reachable(&settings, &Climate::default()), [false, true, true, true]);
    }

    proptest! {
        #[test]
        fn targets_have_chances_that_sum_to_one(temperature in -60.0..60.0, humidity in 0.0..1.0) {
            let chain = Chain::new(&cornered(), &Climate { temperature, humidity });
            let sum: f64 = chain.targets[0].iter().map(|(_, chance)| chance).sum();
            prop_assert!((sum - 1.0).abs() < 1e-14);
        }

        #[test]
        fn a_target_is_always_a_possible_one(uniform in 0.0..1.0f64) {
            let mut settings = branching();
            settings.states.get_mut("a").unwrap().wet_warm = vec![1.0, 0.0, 0.0];
            let chain = Chain::new(&settings, &Climate { temperature: 25.0, humidity: 0.9 });
            prop_assert_eq!(chain.target(0, uniform), 1);
            prop_assert_eq!(chain.target(0, 1.0 - f64::EPSILON / 2.0), 1);
        }
    }
}
