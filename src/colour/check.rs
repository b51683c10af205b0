//! What can be wrong with colour settings: all of it at once.

use super::{Pigments, Settings};
use crate::base::settings::Complaint;

/// Everything wrong with the settings; empty when they can be used.
#[must_use]
pub fn check(settings: &Settings) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    if !settings.size.is_power_of_two() || !(16..=4096).contains(&settings.size) {
        let message = format!("a texture of {} pixels a side has no even mip levels", settings.size);
        complaints.push(Complaint::new("size", message, "give a power of two from 16 to 4096, for example 256"));
    }
    if !(1..=16).contains(&settings.variants) {
        let message = format!("{} textures a state cannot be painted", settings.variants);
        complaints.push(Complaint::new("variants", message, "give 1 to 16"));
    }
    for (state, pigments) in &settings.pigments {
        complaints.extend(contents(state, pigments));
    }
    complaints
}

fn contents(state: &str, pigments: &Pigments) -> Vec<Complaint> {
    let values = [
        ("structure", pigments.structure, 1.0, 4.0),
        ("chlorophyll", pigments.chlorophyll, 0.0, 200.0),
        ("carotenoids", pigments.carotenoids, 0.0, 60.0),
        ("anthocyanins", pigments.anthocyanins, 0.0, 100.0),
        ("brown", pigments.brown, 0.0, 10.0),
        ("water", pigments.water, 0.0, 0.2),
        ("dry_matter", pigments.dry_matter, 0.0, 0.1),
    ];
    let outside = values.into_iter().filter(|(_, value, low, high)| !(low..=high).contains(&value));
    let complaint = |(name, value, low, high): (&str, f64, f64, f64)| {
        let message = format!("{name} of {value} is outside what leaves hold");
        Complaint::new(format!("pigments.{state}.{name}"), message, format!("give {low} to {high}"))
    };
    outside.map(complaint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_sound() {
        assert_eq!(check(&Settings::default()), []);
    }

    #[test]
    fn all_faults_are_named_at_once() {
        let red = Pigments { structure: 0.5, chlorophyll: f64::NAN, brown: -1.0, ..Pigments::default() };
        let pigments = [("red".to_owned(), red)].into_iter().collect();
        let faulty = Settings { size: 200, variants: 0, pigments, ..Settings::default() };
        let keys: Vec<String> = check(&faulty).into_iter().map(|complaint| complaint.key).collect();
        let expected = ["size", "variants", "pigments.red.structure", "pigments.red.chlorophyll", "pigments.red.brown"];
        assert_eq!(keys, expected);
    }

    #[test]
    fn the_red_maple_is_sound() {
        #[derive(serde::Deserialize)]
        struct Species {
            colour: Settings,
        }
        let species: Species = toml::from_str(include_str!("../species/red-maple.colour.toml")).unwrap();
        assert_eq!(check(&species.colour), []);
        assert_eq!(species.colour.pigments.len(), 7);
    }
}
