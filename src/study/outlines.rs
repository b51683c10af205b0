//! Outlines on which meshes are measured: closed forms and the blades of the built-in species.

use crate::base::maths::{sin, sincos};
use crate::leaf::Settings;
use crate::species;
use serde::Deserialize;
use std::f64::consts::TAU;

/// The outlines without teeth or bristles, on which the rim is judged too.
pub const SMOOTH: [&str; 2] = ["ellipse", "lobed"];

/// The blades by name, their meshes even: an ellipse, five lobes with teeth, then the species; fewer of them when `quick`.
#[must_use]
pub fn all(quick: bool) -> Vec<(String, Settings)> {
    let mut all: Vec<(String, Settings)> =
        SMOOTH.iter().map(|&name| (name.to_owned(), closed(if name == "lobed" { lobes } else { |_| 1.0 }))).collect();
    all.push(("toothed".to_owned(), closed(teeth)));
    let few = ["red-maple", "english-oak"];
    let names = species::names().filter(|name| !quick || few.contains(name));
    all.extend(names.filter_map(|name| Some((name.to_owned(), blade_of(name)?))));
    // How even edges are is what is measured.
    all.iter_mut().for_each(|(_, settings)| settings.joint_edges = 1.0);
    all
}

/// The blade of a built-in species.
#[must_use]
pub fn blade_of(name: &str) -> Option<Settings> {
    #[derive(Deserialize)]
    struct Tables {
        leaf: Settings,
    }
    toml::from_str::<Tables>(species::text(name)?).ok().map(|tables| tables.leaf)
}

fn lobes(number: u32) -> f64 {
    1.0 + 0.35 * sin(5.0 * TAU * f64::from(number) / 60.0)
}

fn teeth(number: u32) -> f64 {
    lobes(number) + if number.is_multiple_of(3) { 0.08 } else { 0.0 }
}

/// Sixty key points about the middle of an ellipse of 30 mm and 50 mm, times a factor, from the joint at its lower end.
fn closed(factor: impl Fn(u32) -> f64) -> Settings {
    let lowest = factor(45);
    let point = |number: u32| {
        let (sine, cosine) = sincos(TAU * f64::from(number) / 60.0);
        let radius = factor(number % 60);
        [30.0 * radius * cosine, 50.0 * (radius * sine + lowest)]
    };
    Settings { outline: Some((45..105).map(point).collect()), ..Settings::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_outline_begins_at_its_joint_and_can_be_used() {
        for (name, settings) in all(false) {
            assert!(crate::leaf::check(&settings).is_empty(), "{name}");
        }
        let ellipse = closed(|_| 1.0).outline.unwrap();
        assert!(ellipse[0][0].abs() < 1e-12 && ellipse[0][1].abs() < 1e-12);
        assert!((ellipse[30][1] - 100.0).abs() < 1e-9);
    }
}
