//! What can be wrong with colour settings: all of it at once.

use super::contents::parsed;
use super::{Painting, Pigments, Settings, State};
use crate::base::settings::Complaint;

/// Everything wrong with the settings; empty when they can be used.
#[must_use]
pub fn check(settings: &Settings) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    let size = settings.side();
    if !size.is_power_of_two() || !(16..=4096).contains(&size) {
        let message = format!("a texture of {size} pixels a side has no even mip levels");
        complaints.push(Complaint::new("size", message, "give a power of two from 16 to 4096, for example 256"));
    }
    if !(1..=16).contains(&settings.variants) {
        let message = format!("{} textures a state cannot be painted", settings.variants);
        complaints.push(Complaint::new("variants", message, "give 1 to 16"));
    }
    for (state, given) in &settings.pigments {
        match given {
            State::Contents(pigments) => complaints.extend(contents(state, pigments)),
            State::Colour(text) if parsed(text).is_none() => {
                let message = format!("\"{}\" is not a colour", text.escape_debug());
                let help = "write a number sign and six hexadecimal digits, for example \"#b5301c\"";
                complaints.push(Complaint::new(format!("pigments.{state}"), message, help));
            }
            State::Colour(_) => {}
        }
    }
    for (state, sliders) in &settings.sliders {
        let values = [("red", sliders.red), ("yellow", sliders.yellow), ("brown", sliders.brown)];
        for (name, value) in values.into_iter().filter(|(_, value)| !(0.0..=1.0).contains(value)) {
            let message = format!("{name} at {value} is beyond the slider's ends");
            complaints.push(Complaint::new(format!("sliders.{state}.{name}"), message, "give 0 to 1"));
        }
    }
    complaints.extend(painting(&settings.painting));
    complaints
}

fn painting(painting: &Painting) -> Vec<Complaint> {
    let values = [
        ("softness", painting.softness, 0.1, 10.0),
        ("hold", painting.hold, 0.0, 4.0),
        ("margin", painting.margin, -4.0, 4.0),
        ("patchiness", painting.patchiness, 0.0, 4.0),
        ("scorch", painting.scorch, 0.0, 50.0),
        ("spots", painting.spots, 0.0, 5000.0),
        ("pallor", painting.pallor, 0.0, 0.6),
        ("relief", painting.relief, 0.0, 5.0),
    ];
    let outside = values.into_iter().filter(|(_, value, low, high)| !(low..=high).contains(&value));
    let complaint = |(name, value, low, high): (&str, f64, f64, f64)| {
        let message = format!("{name} of {value} is out of range");
        Complaint::new(format!("painting.{name}"), message, format!("give {low} to {high}"))
    };
    outside.map(complaint).collect()
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
    use super::super::Sliders;
    use super::*;

    #[test]
    fn the_defaults_are_sound() {
        assert_eq!(check(&Settings::default()), []);
    }

    #[test]
    fn all_faults_are_named_at_once() {
        let red = Pigments { structure: 0.5, chlorophyll: f64::NAN, brown: -1.0, ..Pigments::default() };
        let states = [("red", State::Contents(red)), ("yellow", State::Colour("ochre".to_owned()))];
        let pigments = states.map(|(name, state)| (name.to_owned(), state)).into_iter().collect();
        let sliders = [("brown".to_owned(), Sliders { red: 1.5, ..Sliders::default() })].into_iter().collect();
        let painting = Painting { hold: -1.0, ..Painting::default() };
        let faulty = Settings { size: Some(200), variants: 0, pigments, sliders, painting, ..Settings::default() };
        let keys: Vec<String> = check(&faulty).into_iter().map(|complaint| complaint.key).collect();
        let expected = [
            "size",
            "variants",
            "pigments.red.structure",
            "pigments.red.chlorophyll",
            "pigments.red.brown",
            "pigments.yellow",
            "sliders.brown.red",
            "painting.hold",
        ];
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
