//! The table of what each species is expected to be.

use serde::Deserialize;
use std::collections::BTreeMap;

/// The ages that the table is for, years.
pub(super) const AGES: [f64; 3] = [10.0, 25.0, 60.0];
/// How far a judged range is widened before a figure fails it.
const LEEWAY: f64 = 0.2;

/// Ranges of one species, by figure.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Expected {
    /// Read in a flora or paper.
    #[serde(rename = "S")]
    pub read: BTreeMap<String, Range>,
    /// Judged.
    #[serde(rename = "E")]
    pub judged: BTreeMap<String, Range>,
}

/// A range for all ages, or one for each (empty where nothing is expected).
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum Range {
    Always([f64; 2]),
    ByAge([Vec<f64>; 3]),
}

impl Range {
    /// The range at an age of the table, by its number.
    pub fn at(&self, age: usize) -> Option<[f64; 2]> {
        match self {
            Range::Always(range) => Some(*range),
            Range::ByAge(ranges) => ranges[age].as_slice().try_into().ok(),
        }
    }
}

/// The range that passes for a judged one.
pub(super) fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    [low * (1.0 - LEEWAY), high * (1.0 + LEEWAY)]
}

/// The whole table, by species.
pub(super) fn table() -> BTreeMap<String, Expected> {
    toml::from_str(include_str!("trees.toml")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_read_whole_and_its_ranges_are_in_order() {
        let table: BTreeMap<String, Expected> = toml::from_str(include_str!("trees.toml")).unwrap();
        assert!(table.keys().map(String::as_str).eq(crate::species::names()));
        for range in table.values().flat_map(|expected| expected.read.values().chain(expected.judged.values())) {
            for [low, high] in (0..3).filter_map(|age| range.at(age)) {
                assert!(low <= high);
            }
            if let Range::ByAge(ranges) = range {
                assert!(ranges.iter().all(|range| range.is_empty() || range.len() == 2));
            }
        }
    }
}
