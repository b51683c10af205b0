//! The state of every leaf of a tree, and how far the sample lies from the exact shares.

use super::chain::Chain;
use super::clock::{self, Moment};
use super::transition::Transition;
use super::{Climate, Mode, Settings};
use crate::base::figures::{ErrorFigure, Figures};
use rayon::prelude::*;
use serde_json::{Map, Value};

/// Days short of a whole step by less than this share of the step count as reached: 0.3 / 0.1 is below 3.
const STEP_ROUNDING: f64 = 1e-9;

/// The states of leaves, in the order in which the leaves were given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeafStates {
    /// Names of the states, sorted; the numbers in `states` count them.
    pub names: Vec<String>,
    /// State of each leaf.
    pub states: Vec<u16>,
    /// The state that each leaf left for its present one; its own for a leaf that has not changed yet.
    pub before: Vec<u16>,
    /// Day on which each leaf entered its state; 0 for the first one.
    pub since: Vec<f64>,
    /// Exact share of each state on that day.
    pub expected: Vec<f64>,
}

/// The state of each leaf (by its stable id) on `day`, days since all were in `settings.start`; day 0 and before, all
/// still are. The settings have passed [`check`](super::check). A leaf's state depends on nothing but its id, the
/// seed, the day, settings and climate.
///
/// `expected` is the law of the continuous-time chain in both modes; the figure `step_error` holds how far the law of
/// `mode = "paper"` is from it.
#[must_use]
pub fn assign(settings: &Settings, climate: &Climate, seed: u64, leaves: &[u64], day: f64) -> (LeafStates, Figures) {
    let chain = Chain::new(settings, climate);
    let day = if day > 0.0 { day.min(f64::MAX) } else { 0.0 };
    let law = Transition::exact(&chain, day);
    let expected = law.row(chain.names.len(), chain.start, day);
    let (moments, stepped) = match settings.mode {
        Mode::Exact => (each(leaves, |leaf| clock::exact(&chain, &law, seed, leaf, day)), None),
        Mode::Paper => {
            let count = (day / settings.step + STEP_ROUNDING).floor().min(f64::MAX);
            let law = Transition::stepped(&chain, settings.step, count);
            let moments = each(leaves, |leaf| clock::stepped(&chain, &law, seed, leaf, (settings.step, count)));
            (moments, Some(law.row(chain.names.len(), chain.start, count)))
        }
    };
    let figures = figures(&chain, &moments, &expected, stepped.as_deref());
    let states = moments.iter().map(|moment| moment.state).collect();
    let before = moments.iter().map(|moment| moment.before).collect();
    let since = moments.iter().map(|moment| moment.since).collect();
    (LeafStates { names: chain.names, states, before, since, expected }, figures)
}

fn each(leaves: &[u64], moment: impl Fn(u64) -> Moment + Sync) -> Vec<Moment> {
    leaves.par_iter().map(|&leaf| moment(leaf)).collect()
}

/// Half the sum of the differences: the largest difference in the chance of any set of states.
pub(super) fn total_variation(a: &[f64], b: &[f64]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

fn figures(chain: &Chain, moments: &[Moment], expected: &[f64], stepped: Option<&[f64]>) -> Figures {
    let mut counts = vec![0u64; chain.names.len()];
    for moment in moments {
        counts[usize::from(moment.state)] += 1;
    }
    let leaves = moments.len().max(1) as f64;
    let shares: Vec<f64> = counts.iter().map(|&count| count as f64 / leaves).collect();
    let named: Map<String, Value> =
        chain.names.iter().cloned().zip(counts.iter().map(|&count| Value::from(count))).collect();
    let from_law = moments.iter().filter(|moment| moment.from_law).count();
    let mut figures = Figures::of(moments.len() as u64)
        .with("states", named)
        .with("expected_sampling_error", sampling_error(expected, leaves))
        .with("drawn_from_law", from_law as u64)
        .with("climate_clamped", chain.clamped);
    if let Some(stepped) = stepped {
        figures = figures.with("step_error", total_variation(stepped, expected));
    }
    if !moments.is_empty() {
        figures.error = Some(ErrorFigure {
            metric: "total variation".to_owned(),
            value: total_variation(&shares, expected),
            unit: String::new(),
            bound: None,
            how: "shares of the leaves against the exact shares, exp(Q t)".to_owned(),
        });
    }
    figures
}

/// Mean total variation of a sample of `leaves` from its own law, by the normal approximation of each share.
fn sampling_error(expected: &[f64], leaves: f64) -> f64 {
    let spread: f64 = expected.iter().map(|p| (p * (1.0 - p)).max(0.0).sqrt()).sum();
    0.5 * spread * (2.0 / (std::f64::consts::PI * leaves)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::chain::tests::{branching, settings, state};
    use super::*;
    use crate::base::maths::exp;
    use crate::base::random::hash;

    fn ids(count: u64) -> Vec<u64> {
        (0..count).map(|index| hash(index, 99)).collect()
    }

    fn chi_square(states: &LeafStates, expected: &[f64]) -> f64 {
        let count = |state| states.states.iter().filter(|&&s| usize::from(s) == state).count() as f64;
        let leaves = states.states.len() as f64;
        (0..expected.len()).map(|s| (count(s) - leaves * expected[s]) * (count(s) / (leaves * expected[s]) - 1.0)).sum()
    }

    /// Exceeded by chance once in a million with 3 degrees of freedom, and with 1.
    const CRITICAL: f64 = 30.664_849;
    const CRITICAL_ONE: f64 = 23.928_127;

    #[test]
    fn a_hundred_thousand_leaves_follow_the_exact_law() {
        for seed in [1, 2, 3] {
            let (states, figures) = assign(&branching(), &Climate::default(), seed, &ids(100_000), 30.0);
            assert!(chi_square(&states, &[0.5, 0.15, 0.108_75, 0.241_25]) < CRITICAL);
            let expected = figures.values["expected_sampling_error"].as_f64().unwrap();
            assert!(figures.error.unwrap().value < 4.0 * expected);
        }
    }

    #[test]
    fn the_papers_rule_follows_its_own_law() {
        let paper = Settings { mode: Mode::Paper, step: 10.0, ..branching() };
        let chain = Chain::new(&paper, &Climate::default());
        let law = Transition::stepped(&chain, 10.0, 3.0).row(4, 0, 3.0);
        for seed in [1, 2, 3] {
            let (states, _) = assign(&paper, &Climate::default(), seed, &ids(100_000), 30.0);
            assert!(chi_square(&states, &law) < CRITICAL);
        }
    }

    #[test]
    fn the_papers_step_error_is_reported() {
        // Three equal states in line, one step of four half-lives: the reference total variation is 0.764.
        let line =
            settings(&[("a", state(5.0, &[("b", 1.0)])), ("b", state(5.0, &[("c", 1.0)])), ("c", state(0.0, &[]))]);
        let paper = Settings { mode: Mode::Paper, step: 20.0, ..line };
        let (_, figures) = assign(&paper, &Climate::default(), 1, &[7], 20.0);
        assert!((figures.values["step_error"].as_f64().unwrap() - 0.764).abs() < 5e-4);
    }

    #[test]
    fn a_leaf_does_not_depend_on_its_neighbours() {
        let leaves = ids(50);
        let (together, _) = assign(&branching(), &Climate::default(), 5, &leaves, 25.0);
        for (index, &leaf) in leaves.iter().enumerate() {
            let (alone, _) = assign(&branching(), &Climate::default(), 5, &[leaf], 25.0);
            assert_eq!((alone.states[0], alone.since[0]), (together.states[index], together.since[index]));
        }
    }

    #[test]
    fn days_agree_with_each_other() {
        let leaves = ids(300);
        let at = |day: f64| assign(&branching(), &Climate::default(), 8, &leaves, day).0;
        let days: Vec<LeafStates> = (0..40).map(|day| at(f64::from(day) * 3.0)).collect();
        for (index, _) in leaves.iter().enumerate() {
            for (today, tomorrow) in days.iter().zip(&days[1..]) {
                let (before, after) = (today.states[index], tomorrow.states[index]);
                // States of this chain only grow, and one that has not changed was entered on the same day.
                assert!(after >= before);
                assert!(after != before || today.since[index] == tomorrow.since[index]);
            }
        }
    }

    #[test]
    fn day_zero_and_before_all_leaves_are_as_they_started() {
        for day in [0.0, -3.0, f64::NAN] {
            let (states, _) = assign(&branching(), &Climate::default(), 1, &ids(20), day);
            assert!(states.states.iter().all(|&state| state == 0) && states.since.iter().all(|&since| since == 0.0));
            assert_eq!(states.expected, [1.0, 0.0, 0.0, 0.0]);
        }
    }

    #[test]
    fn a_chain_that_returns_a_trillion_times_ends_in_its_stationary_law() {
        let fast = settings(&[("a", state(1e-9, &[("b", 1.0)])), ("b", state(3e-9, &[("a", 1.0)]))]);
        let (states, figures) = assign(&fast, &Climate::default(), 4, &ids(20_000), 1000.0);
        assert_eq!(figures.values["drawn_from_law"], 20_000);
        assert!(chi_square(&states, &[0.25, 0.75]) < CRITICAL_ONE);
        assert!(states.since.iter().all(|&since| since > 999.9 && since <= 1000.0));
    }

    #[test]
    fn steps_beyond_those_followed_keep_their_law() {
        let slow = settings(&[("a", state(1e3, &[("b", 1.0)])), ("b", state(0.0, &[]))]);
        let paper = Settings { mode: Mode::Paper, ..slow };
        let (states, figures) = assign(&paper, &Climate::default(), 4, &ids(2_000), 3000.0);
        assert!(figures.values["drawn_from_law"].as_u64().unwrap() > 500);
        assert!(chi_square(&states, &[0.125, 0.875]) < CRITICAL_ONE);
    }

    #[test]
    fn one_thread_and_many_agree() {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| assign(&branching(), &Climate::default(), 3, &ids(2_000), 12.0))
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn waiting_times_are_exponential() {
        let line = settings(&[("a", state(10.0, &[("b", 1.0)])), ("b", state(0.0, &[]))]);
        let (states, _) = assign(&line, &Climate::default(), 1, &ids(50_000), 1e6);
        // Kolmogorov's distance; 1.95 / sqrt(n) is exceeded once in a thousand samples.
        let mut since = states.since;
        since.sort_unstable_by(f64::total_cmp);
        let rate = std::f64::consts::LN_2 / 10.0;
        let distance = |(rank, day): (usize, &f64)| (rank as f64 / 50_000.0 - (1.0 - exp(-rate * day))).abs();
        assert!(since.iter().enumerate().map(distance).fold(0.0, f64::max) < 1.95 / 50_000f64.sqrt());
    }
}
