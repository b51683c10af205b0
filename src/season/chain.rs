//! The chain itself: what each state's half-life and chances are at one climate.

use super::settings::{Settings, State};
use super::stages;
use super::weather::Day;

/// The chain of a species. States are numbered in the order of their names.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Names of the states, sorted.
    pub names: Vec<String>,
    /// The state of every leaf at day 0.
    pub start: u16,
    /// The states.
    pub(super) nodes: Vec<Node>,
    corners: Corners,
}

/// One state.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    /// Half-life at the corners, days; none for a state that lasts.
    half_life: Option<[f64; 4]>,
    /// Hidden stages.
    pub stages: u32,
    /// Whether it waits for short days and follows the leaf's speed.
    pub is_gated: bool,
    /// The states that may follow, with their chances at the corners.
    pub targets: Vec<(u16, [f64; 4])>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Corners {
    cold: f64,
    warm: f64,
    dry: f64,
    wet: f64,
}

/// Where a climate stands between the corners: 0 to 1 from cold to warm and from dry to wet. Outside it is moved to the nearest
/// point: half-lives extrapolated beyond could become negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    warmth: f64,
    wetness: f64,
    /// Whether the climate lay outside.
    pub is_clamped: bool,
}

impl Place {
    /// Bilinear interpolation of values given as wet and cold, wet and warm, dry and cold, dry and warm.
    fn between(&self, corners: [f64; 4]) -> f64 {
        let [wet_cold, wet_warm, dry_cold, dry_warm] = corners;
        let along = |cold: f64, warm: f64| {
            if cold == warm { cold } else { cold * (1.0 - self.warmth) + warm * self.warmth }
        };
        let (wet, dry) = (along(wet_cold, wet_warm), along(dry_cold, dry_warm));
        if wet == dry { wet } else { wet * self.wetness + dry * (1.0 - self.wetness) }
    }
}

impl Chain {
    /// Compiles settings that have passed [`check`](super::check). `is_staged` false makes one stage of every state, as the paper's
    /// rule has it.
    #[must_use]
    pub fn new(settings: &Settings, is_staged: bool) -> Self {
        let names: Vec<String> = settings.states.keys().cloned().collect();
        let number = |name: &String| names.binary_search(name).ok().map(|index| index as u16);
        let node = |state: &State| Node {
            half_life: state.half_life.map(crate::base::settings::Corners::values),
            stages: if is_staged { state.stages.max(1) } else { 1 },
            is_gated: state.gate,
            targets: targets(state).filter_map(|(name, chances)| Some((number(name)?, chances))).collect(),
        };
        Self {
            nodes: settings.states.values().map(node).collect(),
            start: number(&settings.start).unwrap_or(0),
            corners: Corners { cold: settings.cold, warm: settings.warm, dry: settings.dry, wet: settings.wet },
            names,
        }
    }

    /// Number of the state of a name.
    #[must_use]
    pub(super) fn number(&self, name: &str) -> Option<u16> {
        self.names.iter().position(|known| known == name).map(|index| index as u16)
    }

    pub(super) fn place(&self, day: &Day) -> Place {
        let Corners { cold, warm, dry, wet } = self.corners;
        let warmth = (day.temperature - cold) / (warm - cold);
        let wetness = (day.humidity - dry) / (wet - dry);
        let inside = 0.0..=1.0;
        Place {
            warmth: warmth.clamp(0.0, 1.0),
            wetness: wetness.clamp(0.0, 1.0),
            is_clamped: !inside.contains(&warmth) || !inside.contains(&wetness),
        }
    }

    /// Rate of each stage of a state, 1/day, by equation (5): the half-life is interpolated, as in the paper, not the rate.
    pub(super) fn rate(&self, state: usize, place: &Place) -> f64 {
        let node = &self.nodes[state];
        node.half_life.map_or(0.0, |half_life| stages::median(node.stages) / place.between(half_life))
    }

    /// Chances of the states that may follow, rescaled by the rounding error of their sum.
    pub(super) fn chances(&self, state: usize, place: &Place) -> Vec<f64> {
        let chances: Vec<f64> = self.nodes[state].targets.iter().map(|(_, at)| place.between(*at)).collect();
        let sum: f64 = chances.iter().sum();
        chances.iter().map(|chance| chance / sum).collect()
    }

    /// Whether a leaf can come back to a state it has left, by any way that has a chance at some corner.
    #[must_use]
    pub fn returns(&self) -> bool {
        // A state is done when all that may follow it are; what never gets done lies on a way that returns.
        let mut done = vec![false; self.nodes.len()];
        loop {
            let follows = |&(target, chances): &(u16, [f64; 4])| {
                chances.iter().all(|chance| *chance <= 0.0) || done[usize::from(target)]
            };
            let ready = |state: &usize| !done[*state] && self.nodes[*state].targets.iter().all(follows);
            let Some(next) = (0..self.nodes.len()).find(ready) else { break };
            done[next] = true;
        }
        done.contains(&false)
    }
}

/// The states that may follow, each with its chances at the corners; none for a state that lasts.
fn targets(state: &State) -> impl Iterator<Item = (&String, [f64; 4])> {
    let rows = [&state.wet_cold, &state.wet_warm, &state.dry_cold, &state.dry_warm];
    let lasts = state.half_life.is_none();
    let at = move |target: usize| rows.map(|row| row.get(target).copied().unwrap_or(0.0));
    state.next.iter().enumerate().filter(move |_| !lasts).map(move |(target, name)| (name, at(target)))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::base::settings::Corners as Given;
    use proptest::prelude::*;

    /// [`State::in_any_climate`].
    pub fn state(half_life: f64, next: &[(&str, f64)]) -> State {
        State::in_any_climate(half_life, next)
    }

    /// [`Settings::of_states`].
    pub fn settings(states: &[(&str, State)]) -> Settings {
        Settings::of_states(states)
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

    /// States in line with these half-lives, and one that lasts.
    pub fn line(half_lives: &[f64]) -> Settings {
        let names = ["a", "b", "c", "d", "e", "f"];
        let mut states: Vec<_> =
            half_lives.iter().enumerate().map(|(i, &h)| (names[i], state(h, &[(names[i + 1], 1.0)]))).collect();
        states.push((names[half_lives.len()], state(0.0, &[])));
        settings(&states)
    }

    /// Two states that follow each other for ever.
    pub fn returning(first: f64, second: f64) -> Settings {
        settings(&[("a", state(first, &[("b", 1.0)])), ("b", state(second, &[("a", 1.0)]))])
    }

    fn cornered() -> Settings {
        let mut settings = settings(&[("a", state(1.0, &[("b", 0.5), ("c", 0.5)])), ("b", State::default())]);
        settings.states.insert("c".to_owned(), State::default());
        let a = settings.states.get_mut("a").unwrap();
        a.half_life = Some(Given::Each([40.0, 5.0, 80.0, 15.0]));
        a.wet_cold = vec![0.9, 0.1];
        a.dry_warm = vec![0.1, 0.9];
        settings
    }

    fn day(temperature: f64, humidity: f64) -> Day {
        Day { temperature, humidity, day_length: None }
    }

    #[test]
    fn corners_are_met_and_the_middle_is_their_mean() {
        let chain = Chain::new(&cornered(), true);
        let half_life = |t, h| std::f64::consts::LN_2 / chain.rate(0, &chain.place(&day(t, h)));
        for (temperature, humidity, expected) in
            [(0.0, 0.9, 40.0), (25.0, 0.9, 5.0), (0.0, 0.3, 80.0), (25.0, 0.3, 15.0), (12.5, 0.6, 35.0)]
        {
            assert!((half_life(temperature, humidity) - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_climate_outside_the_corners_is_moved_to_them() {
        let chain = Chain::new(&cornered(), true);
        let (outside, corner) = (chain.place(&day(-1e3, 1.0)), chain.place(&day(0.0, 0.9)));
        assert!(outside.is_clamped && !corner.is_clamped);
        assert!(chain.place(&day(-1e-9, 0.5)).is_clamped);
        assert_eq!(chain.rate(0, &outside), chain.rate(0, &corner));
        assert_eq!(chain.chances(0, &outside), chain.chances(0, &corner));
    }

    #[test]
    fn ways_that_return_are_seen() {
        assert!(!Chain::new(&branching(), true).returns());
        assert!(Chain::new(&returning(1.0, 2.0), true).returns());
        let mut hidden = branching();
        hidden.states.get_mut("c").unwrap().next = vec!["d".to_owned(), "a".to_owned()];
        for row in 0..4 {
            let c = hidden.states.get_mut("c").unwrap();
            let rows = [&mut c.wet_cold, &mut c.wet_warm, &mut c.dry_cold, &mut c.dry_warm];
            rows.into_iter()
                .enumerate()
                .for_each(|(at, r)| *r = if at == row { vec![0.9, 0.1] } else { vec![1.0, 0.0] });
            assert!(Chain::new(&hidden, true).returns());
        }
    }

    proptest! {
        #[test]
        fn targets_have_chances_that_sum_to_one(temperature in -60.0..60.0, humidity in 0.0..1.0) {
            let chain = Chain::new(&cornered(), true);
            let sum: f64 = chain.chances(0, &chain.place(&day(temperature, humidity))).iter().sum();
            prop_assert!((sum - 1.0).abs() < 1e-14);
        }
    }
}
