//! The age at which a tree has a given height.

use super::derivation::derive;
use super::grammar::Grammar;
use super::modules::Modules;
use super::{Settings, TreeError, turtle};
use crate::base::limits::Limits;

/// Nothing is grown for longer, years.
const LONGEST: u32 = 200;
/// Least age that a tree is asked for, years.
const YOUNGEST: f64 = 0.01;
/// How far a tree may be above the height asked for, metres.
const TOLERANCE: f64 = 0.005;
/// Halvings of the last year: to a millimetre for any shoot of less than four metres.
const HALVINGS: u32 = 12;

/// The age, fractions of a year included, at which the tree is `height` metres high.
pub(super) fn age(
    grammar: &Grammar,
    settings: &Settings,
    height: f64,
    seed: u64,
    limits: &Limits,
) -> Result<f64, TreeError> {
    let aged = |years: f64| Settings { age: Some(years), ..settings.clone() };
    let grown = |years: u32| -> Result<(f64, Modules), TreeError> {
        let settings = aged(f64::from(years));
        let modules = derive(grammar, &settings, seed, limits)?;
        super::allow(&modules, limits)?;
        Ok((highest(&modules, &settings)?, modules))
    };
    // Doubling first: growth costs more the longer it goes on.
    let (mut young, mut old) = (0, 8);
    let (mut reached, mut last_rate) = (0.0f64, f64::INFINITY);
    let mut last = loop {
        let (top, modules) = grown(old)?;
        if top >= height {
            break modules;
        }
        // Metres a year. Growth that slows down, as that of trees does, will not be faster again.
        let rate = (top - reached) / f64::from(old - young);
        let hopeless = rate <= last_rate && young > 0 && top + rate * f64::from(LONGEST - old) < height;
        if old == LONGEST || hopeless {
            return Err(TreeError::Height { metres: height, reached: top, years: old });
        }
        (reached, last_rate) = (top, rate);
        (young, old) = (old, (old * 2).min(LONGEST));
    };
    while old - young > 1 {
        let middle = young.midpoint(old);
        let (top, modules) = grown(middle)?;
        if top >= height {
            (old, last) = (middle, modules);
        } else {
            young = middle;
        }
    }
    let (mut low, mut high) = (f64::from(young), f64::from(old));
    for _ in 0..HALVINGS {
        let middle = low.midpoint(high);
        if highest(&last, &aged(middle))? >= height { high = middle } else { low = middle }
    }
    let met = highest(&last, &aged(high))?;
    if met > height + TOLERANCE {
        return Err(TreeError::Height { metres: height, reached: met, years: old });
    }
    Ok(high.max(YOUNGEST))
}

/// The highest point of the wood, metres.
fn highest(modules: &Modules, settings: &Settings) -> Result<f64, TreeError> {
    let drawing = turtle::draw(modules, settings)?;
    Ok(drawing.skeleton.segments.iter().map(|segment| segment.end.y).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::super::grow;
    use super::*;

    fn shoots() -> Settings {
        let rules = vec!["A(l) -> F(l)[+(40)A(l*0.5)]A(l*0.9)".to_owned()];
        Settings { axiom: "A(1)".to_owned(), rules, ..Settings::default() }
    }

    #[test]
    fn the_age_gives_the_height_asked_for() {
        // The leader is 1 + 0.9 + 0.81 + ... = 10 (1 - 0.9^n) m high; 2.5 m lie 0.6 m into the 0.81 m of the third year.
        for (height, age) in [(2.5, 2.0 + 0.6 / 0.81), (0.25, 0.25), (6.0, 8.0 + (6.0 - 5.6953279) / 0.43046721)] {
            let settings = Settings { height: Some(height), ..shoots() };
            let (tree, figures) = grow(&settings, 1, &Limits::default()).unwrap();
            assert!((tree.height - height).abs() < 1e-3, "{}", tree.height);
            assert!((figures.values["age_years"].as_f64().unwrap() - age).abs() < 1e-3);
        }
    }

    #[test]
    fn a_height_that_is_never_reached_is_an_error() {
        let rules = vec!["A(l) -> F(l)A(l*0.5)".to_owned()];
        let settings = Settings { rules, height: Some(2.5), ..shoots() };
        let error = grow(&settings, 1, &Limits::default()).unwrap_err();
        // 1.99 m after 8 years and hardly more after 16: what slows down so never gets there.
        assert!(matches!(error, TreeError::Height { years: 16, .. }));
    }

    #[test]
    fn a_tree_that_begins_too_high_is_an_error() {
        let rules = vec!["A -> F(0.3)A".to_owned()];
        let settings = Settings { axiom: "F(2)A".to_owned(), rules, height: Some(1.0), ..Settings::default() };
        assert!(matches!(grow(&settings, 1, &Limits::default()), Err(TreeError::Height { .. })));
    }

    #[test]
    fn wood_that_rules_only_lengthen_is_not_of_this_year() {
        let rules = vec!["F(l) -> F(l*1.5)".to_owned(), "A -> F(1)A".to_owned()];
        let top = |age| {
            let settings =
                Settings { axiom: "A".to_owned(), rules: rules.clone(), age: Some(age), ..Settings::default() };
            grow(&settings, 1, &Limits::default()).unwrap().0.height
        };
        // 1 + 1.5 + 2.25 m, of which the newest metre has grown by half.
        assert!((top(3.0) - 4.75).abs() < 1e-12 && (top(2.5) - 4.25).abs() < 1e-12);
    }

    #[test]
    fn a_part_of_a_year_is_a_part_of_its_growth() {
        let ends = |age| {
            let settings = Settings { age: Some(age), ..shoots() };
            grow(&settings, 1, &Limits::default()).unwrap().0.skeleton.segments
        };
        let (whole, half, before) = (ends(4.0), ends(3.5), ends(3.0));
        assert_eq!((whole.len(), before.len()), (half.len(), half.len().div_ceil(2) - 1));
        for (whole, half) in whole.iter().zip(&half) {
            let share = if whole.birth == 4 { 0.5 } else { 1.0 };
            assert_eq!(whole.id, half.id);
            assert!((half.length() - share * whole.length()).abs() < 1e-12);
            assert!(half.radius <= whole.radius);
        }
        // The year begins where the last one ended.
        let begun = ends(3.0 + 1e-9);
        for segment in &before {
            let same = begun.iter().find(|other| other.id == segment.id).unwrap();
            assert!((same.radius - segment.radius).abs() < 1e-6 && (same.end - segment.end).norm() < 1e-6);
        }
    }
}
