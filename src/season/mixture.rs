//! Trees of several species together: their law is the mixture of the species' laws, weighted by their leaves.

use super::assignment::{LeafStates, total_variation};
use crate::base::figures::Figures;
use serde_json::{Map, Value};

/// The shares that are expected of all leaves, in the order of `names` (which hold every name of the parts), and the figures
/// of the whole. One part keeps its own.
#[must_use]
pub fn mixed(names: &[String], parts: &[(LeafStates, Figures)]) -> (Vec<f64>, Figures) {
    let place = |name: &String| names.binary_search(name).ok();
    if let [(states, figures)] = parts {
        let mut expected = vec![0.0; names.len()];
        for (name, share) in states.names.iter().zip(&states.expected) {
            place(name).into_iter().for_each(|at| expected[at] = *share);
        }
        return (expected, figures.clone());
    }
    let leaves: usize = parts.iter().map(|(states, _)| states.states.len()).sum();
    let mut expected = vec![0.0; names.len()];
    let mut shares = vec![0.0; names.len()];
    let mut variance = vec![0.0; names.len()];
    let mut counts = vec![0u64; names.len()];
    for (states, _) in parts {
        let weight = states.states.len() as f64 / leaves.max(1) as f64;
        for (own, at) in states.names.iter().enumerate().filter_map(|(own, name)| Some((own, place(name)?))) {
            let share = states.expected[own];
            let count = states.states.iter().filter(|&&state| usize::from(state) == own).count();
            expected[at] += weight * share;
            variance[at] += weight * (share * (1.0 - share)).max(0.0);
            counts[at] += count as u64;
            shares[at] += count as f64 / leaves.max(1) as f64;
        }
    }
    let named: Map<String, Value> = names.iter().cloned().zip(counts.into_iter().map(Value::from)).collect();
    let spread: f64 = variance.iter().map(|v| v.sqrt()).sum();
    let sampling_error = 0.5 * spread * (2.0 / (std::f64::consts::PI * leaves.max(1) as f64)).sqrt();
    let numbers = |name: &'static str| parts.iter().filter_map(move |(_, figures)| figures.values.get(name)?.as_f64());
    let mut figures = Figures::of(leaves as u64)
        .with("states", named)
        .with("expected_sampling_error", sampling_error)
        .with("drawn_from_law", numbers("drawn_from_law").sum::<f64>() as u64)
        .with(
            "climate_clamped",
            parts.iter().any(|(_, figures)| figures.values.get("climate_clamped") == Some(&true.into())),
        );
    if let Some(largest) = numbers("step_error").reduce(f64::max) {
        figures = figures.with("step_error", largest);
    }
    figures.error = parts.iter().find_map(|(_, figures)| figures.error.clone());
    if let Some(error) = &mut figures.error {
        error.value = total_variation(&shares, &expected);
    }
    (expected, figures)
}

#[cfg(test)]
mod tests {
    use super::super::chain::tests::{branching, settings, state};
    use super::super::{Climate, assign};
    use super::*;
    use crate::base::random::hash;

    fn ids(count: u64, salt: u64) -> Vec<u64> {
        (0..count).map(|index| hash(index, salt)).collect()
    }

    fn names(parts: &[(LeafStates, Figures)]) -> Vec<String> {
        let mut names: Vec<String> = parts.iter().flat_map(|(states, _)| states.names.clone()).collect();
        names.sort();
        names.dedup();
        names
    }

    #[test]
    fn two_halves_of_one_species_have_the_law_and_the_error_of_the_whole() {
        let leaves = ids(3000, 1);
        let whole = assign(&branching(), &Climate::default(), 4, &leaves, 30.0);
        let halves = leaves.chunks(1000).map(|part| assign(&branching(), &Climate::default(), 4, part, 30.0));
        let parts: Vec<_> = halves.collect();
        let (expected, figures) = mixed(&names(&parts), &parts);
        assert!(expected.iter().zip(&whole.0.expected).all(|(a, b)| (a - b).abs() < 1e-12));
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(close(figures.error.unwrap().value, whole.1.error.unwrap().value));
        for name in ["expected_sampling_error", "drawn_from_law"] {
            assert!(close(figures.values[name].as_f64().unwrap(), whole.1.values[name].as_f64().unwrap()), "{name}");
        }
        assert_eq!(figures.values["states"], whole.1.values["states"]);
    }

    #[test]
    fn species_with_other_states_are_weighted_by_their_leaves() {
        let lasting = settings(&[("z", state(0.0, &[]))]);
        let lasting = super::super::Settings { start: "z".to_owned(), ..lasting };
        let parts = [
            assign(&branching(), &Climate::default(), 1, &ids(100, 1), 0.0),
            assign(&lasting, &Climate::default(), 1, &ids(300, 2), 0.0),
        ];
        let names = names(&parts);
        let (expected, figures) = mixed(&names, &parts);
        let at = |name: &str| expected[names.iter().position(|known| known == name).unwrap()];
        assert_eq!((at("z"), expected.iter().sum::<f64>()), (0.75, 1.0));
        assert_eq!(figures.items, 400);
        assert_eq!(figures.error.unwrap().value, 0.0);
    }
}
