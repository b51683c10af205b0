//! The study of the species as trees: each is grown at 10, 25 and 60 years and measured.

use super::Line;
use super::expectation::{self, AGES, Expected, widened};
use super::stature::stature;
use crate::base::limits::Limits;
use crate::leaf::{self, LeafError, Pictures};
use crate::species;
use crate::tree::{self, TreeError};
use rayon::prelude::*;
use serde::Deserialize;
use std::collections::BTreeMap;
use thiserror::Error;

/// A species as far as this study looks at it.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The species' name, by which its expectations are found.
    pub name: String,
    /// Seed of the tree that is measured.
    pub seed: u64,
    /// How it grows.
    pub tree: tree::Settings,
    /// Its blade.
    pub leaf: leaf::Settings,
}

/// Why a species could not be measured.
#[derive(Clone, Debug, Error)]
pub enum Failure {
    /// The tree did not grow.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// The blade could not be made.
    #[error(transparent)]
    Leaf(#[from] LeafError),
}

/// All built-in species.
#[must_use]
pub fn built_in() -> Vec<Subject> {
    #[derive(Deserialize)]
    struct Tables {
        tree: tree::Settings,
        leaf: leaf::Settings,
    }
    let subject = |name: &str| {
        let Tables { tree, leaf } = toml::from_str(species::text(name)?).ok()?;
        Some(Subject { name: name.to_owned(), seed: 1, tree, leaf })
    };
    species::names().filter_map(subject).collect()
}

/// Measures each species at each age of the table, two ages when `quick`, and holds the figures against the table. A species
/// that the table does not know is measured against its own identities alone.
///
/// # Errors
/// The number of the subject that the tree's rules, the leaf's outline or the limits refuse, and why.
pub fn lines(subjects: &[Subject], limits: &Limits, quick: bool) -> Result<Vec<Line>, (usize, Failure)> {
    let table = expectation::table();
    let ages = if quick { &AGES[..2] } else { &AGES };
    let cases: Vec<(usize, usize)> =
        (0..subjects.len()).flat_map(|subject| (0..ages.len()).map(move |age| (subject, age))).collect();
    let measured = |(number, age): (usize, usize)| {
        let subject = &subjects[number];
        let settings = tree::Settings { age: Some(ages[age]), height: None, ..subject.tree.clone() };
        let model = leaf::model(&subject.leaf, Pictures::default(), limits);
        let (blade, _) = model.map_err(|error| (number, Failure::from(error)))?;
        let grown = tree::grow(&settings, subject.seed, limits);
        let (tree, _) = grown.map_err(|error| (number, Failure::from(error)))?;
        let name = format!("{} at {} years", subject.name, ages[age]);
        Ok(held(&name, &stature(&tree, &blade.mesh, &settings), table.get(&subject.name), age))
    };
    let lines: Result<Vec<Vec<Line>>, (usize, Failure)> = cases.into_par_iter().map(measured).collect();
    Ok(lines?.concat())
}

/// Figures beside what is expected of them.
fn held(subject: &str, figures: &BTreeMap<&'static str, f64>, expected: Option<&Expected>, age: usize) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut line = |figure: &str, asked: [f64; 2], passes: [f64; 2], standing| {
        let (subject, value) = (subject.to_owned(), figures.get(figure).copied());
        lines.push(Line { subject, figure: figure.to_owned(), value, asked, passes, standing });
    };
    line("leaves_on_old_wood", [0.0, 0.0], [0.0, 0.0], '=');
    if let Some(expected) = expected {
        for (figure, range) in expected.read.iter().filter_map(|(figure, range)| Some((figure, range.at(age)?))) {
            line(figure, range, range, 'S');
        }
        for (figure, range) in expected.judged.iter().filter_map(|(figure, range)| Some((figure, range.at(age)?))) {
            line(figure, range, widened(range), 'E');
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stand_for_ranges_and_pass_where_they_should() {
        let expected: BTreeMap<String, Expected> =
            toml::from_str("[x.S]\na = [1, 2]\n[x.E]\nb = [[], [10, 20], []]\nc = [1, 1]\n").unwrap();
        let figures = BTreeMap::from([("a", 2.1), ("b", 23.9), ("leaves_on_old_wood", 0.0)]);
        let lines = held("x", &figures, expected.get("x"), 1);
        let met: Vec<(&str, bool)> = lines.iter().map(|line| (line.figure.as_str(), line.is_met())).collect();
        assert_eq!(met, [("leaves_on_old_wood", true), ("a", false), ("b", true), ("c", false)]);
        assert_eq!(held("x", &figures, expected.get("x"), 0).len(), 3);
        assert_eq!(lines[2].asked, [10.0, 20.0]);
    }
}
