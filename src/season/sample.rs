//! The states of leaves as they were drawn, and how far they lie from the exact shares.

use super::clock::Stay;
use super::law::Law;
use crate::base::figures::{ErrorFigure, Figures};
use serde_json::{Map, Value};

/// Leaves counted and expected in each state.
type Cells = Vec<(f64, f64)>;
/// Expected leaves of a state below which it is lumped with others for the chi-square: the statistic's law needs some.
const FEWEST: f64 = 5.0;

/// The states of leaves on a day, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// State of each leaf, counted in the chain's names.
    pub states: Vec<u16>,
    /// The state that each leaf left for its present one; its own for a leaf that has not changed yet.
    pub before: Vec<u16>,
    /// Day on which each leaf entered its state.
    pub since: Vec<f64>,
    /// The leaves of the year before, where they are asked for: number of the leaf's site, when it left, and in which state.
    pub shed: Vec<(usize, f64, u16)>,
    /// Leaves whose state was drawn from the law of what was not followed jump by jump.
    pub from_law: u64,
}

impl Sample {
    pub(super) fn of(stays: &[Stay]) -> Self {
        Self {
            states: stays.iter().map(|stay| stay.state).collect(),
            before: stays.iter().map(|stay| stay.before).collect(),
            since: stays.iter().map(|stay| stay.since).collect(),
            shed: stays
                .iter()
                .enumerate()
                .filter_map(|(leaf, stay)| stay.shed.map(|(day, state)| (leaf, day, state)))
                .collect(),
            from_law: stays.iter().filter(|stay| stay.is_from_law).count() as u64,
        }
    }
}

/// The states of all leaves of a scene, in the order of the leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeafStates {
    /// Names of the states, sorted; the numbers in `states` count them.
    pub names: Vec<String>,
    /// State of each leaf.
    pub states: Vec<u16>,
    /// The state that each leaf left for its present one; its own for a leaf that has not changed yet.
    pub before: Vec<u16>,
    /// Day on which each leaf entered its state.
    pub since: Vec<f64>,
    /// Exact share of each state on that day.
    pub expected: Vec<f64>,
    /// The leaves of the year before that have left their sites to new ones: site, day, and state in which each left. Only where
    /// leaves that fall are asked for.
    pub shed: Vec<(usize, f64, u16)>,
}

/// Half the sum of the differences: the largest difference in the chance of any set of states.
pub(super) fn total_variation(a: &[f64], b: &[f64]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

/// What the stage tells of states: their counts, and how far their shares lie from the law by which they were drawn.
#[must_use]
pub fn figures(names: &[String], states: &[u16], law: &Law) -> Figures {
    let mut counts = vec![0u64; names.len()];
    for count in states.iter().map(|&state| usize::from(state)).filter(|state| *state < names.len()) {
        counts[count] += 1;
    }
    let drawn: u64 = counts.iter().sum();
    let leaves = drawn.max(1) as f64;
    let shares: Vec<f64> = counts.iter().map(|&count| count as f64 / leaves).collect();
    let named: Map<String, Value> = names.iter().cloned().zip(counts.iter().map(|&count| Value::from(count))).collect();
    let (chi_square, freedom) = chi_square(&counts, &law.expected, leaves);
    let mut figures = Figures::of(drawn)
        .with("states", named)
        .with("expected_sampling_error", sampling_error(&law.variance, leaves))
        .with("chi_square", chi_square)
        .with("degrees_of_freedom", freedom);
    if drawn > 0 {
        figures.error = Some(ErrorFigure {
            metric: "total variation".to_owned(),
            value: total_variation(&shares, &law.expected),
            unit: String::new(),
            bound: None,
            how: "shares of the leaves against the exact shares, exp(Q t)".to_owned(),
        });
    }
    figures
}

/// Mean total variation of a sample of `leaves` from its own law, by the normal approximation of each share.
fn sampling_error(variance: &[f64], leaves: f64) -> f64 {
    let spread: f64 = variance.iter().map(|variance| variance.max(0.0).sqrt()).sum();
    0.5 * spread * (2.0 / (std::f64::consts::PI * leaves)).sqrt()
}

/// Pearson's statistic and its degrees of freedom. States that few leaves are expected in are lumped. Leaves of different classes
/// have different laws, which makes the statistic smaller than chance alone would, never larger.
fn chi_square(counts: &[u64], expected: &[f64], leaves: f64) -> (f64, u64) {
    let all = counts.iter().zip(expected).map(|(&count, share)| (count as f64, share * leaves));
    let (mut cells, rare): (Cells, Cells) = all.partition(|(_, expected)| *expected >= FEWEST);
    let lump = rare.iter().fold((0.0, 0.0), |sum, cell| (sum.0 + cell.0, sum.1 + cell.1));
    if lump.1 >= FEWEST {
        cells.push(lump);
    } else if let Some(smallest) = cells.iter_mut().min_by(|a, b| a.1.total_cmp(&b.1)) {
        // Too few for a cell of their own, they go to the smallest.
        *smallest = (smallest.0 + lump.0, smallest.1 + lump.1);
    }
    let sum = cells.iter().map(|(count, expected)| (count - expected) * (count - expected) / expected).sum();
    (sum, (cells.len() as u64).saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(expected: &[f64]) -> Law {
        Law { expected: expected.to_vec(), variance: expected.iter().map(|p| p * (1.0 - p)).collect() }
    }

    #[test]
    fn the_figures_are_those_of_the_closed_forms() {
        let names = ["a", "b"].map(str::to_owned);
        let figures = figures(&names, &[0, 0, 0, 1], &law(&[0.5, 0.5]));
        assert_eq!((figures.items, figures.error.unwrap().value), (4, 0.25));
        // Two leaves of each are too few: both cells are lumped and nothing is left to be tested.
        assert_eq!(figures.values["degrees_of_freedom"], 0);
        let mean = figures.values["expected_sampling_error"].as_f64().unwrap();
        assert!((mean - 0.5 * (2.0 / (std::f64::consts::PI * 4.0)).sqrt()).abs() < 1e-15);
        assert_eq!(chi_square(&[60, 40], &[0.5, 0.5], 100.0), (4.0, 1));
    }

    #[test]
    fn leaves_without_a_state_are_not_counted() {
        let names = ["a"].map(str::to_owned);
        assert_eq!(figures(&names, &[0, u16::MAX], &law(&[1.0])).items, 1);
    }
}
