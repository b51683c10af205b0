//! What a state's leaf holds: the pigments of its species, a plain colour turned into pigments, or three sliders.

use super::appearance::{Colour, Optics, lab};
use super::{Pigments, Settings, Sliders, State};
use crate::base::maths::{exp, srgb_to_linear};

/// The state of young leaves, which hold little chlorophyll because they are not yet green.
const YOUNG: &str = "flush";
/// The state whose leaf sliders start from.
const GREEN: &str = "green";

/// The contents of a state.
#[derive(Clone, Debug)]
pub(super) struct Contents {
    pub pigments: Pigments,
    /// Chlorophyll of the leaf before it aged (ug/cm2).
    pub reference: f64,
    /// How far a plain colour is missed, dE76; `None` where no colour was given.
    pub miss: Option<f64>,
}

/// The contents of a state; the defaults for one that the settings do not name.
pub(super) fn contents(settings: &Settings, optics: &Optics, state: &str) -> Contents {
    let (pigments, miss) = resolved(settings, optics, state);
    let others = settings.pigments.values().filter_map(|state| match state {
        State::Contents(pigments) => Some(pigments.chlorophyll),
        State::Colour(_) => None,
    });
    let reference = others.fold(pigments.chlorophyll, f64::max);
    let reference = if state == YOUNG { pigments.chlorophyll } else { reference };
    Contents { pigments, reference, miss }
}

fn resolved(settings: &Settings, optics: &Optics, state: &str) -> (Pigments, Option<f64>) {
    if let Some(sliders) = settings.sliders.get(state) {
        let green = match settings.pigments.get(GREEN) {
            Some(State::Contents(pigments)) => pigments.clone(),
            _ => Pigments::default(),
        };
        return (slid(&green, sliders), None);
    }
    match settings.pigments.get(state) {
        None => (Pigments::default(), None),
        Some(State::Contents(pigments)) => (pigments.clone(), None),
        Some(State::Colour(text)) => {
            let (pigments, miss) = fitted(optics, parsed(text).unwrap_or([0.0; 3]));
            (pigments, Some(miss))
        }
    }
}

/// The linear colour of `#rrggbb`.
pub(super) fn parsed(text: &str) -> Option<Colour> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let mut colour = [0.0; 3];
    for (channel, place) in colour.iter_mut().zip([0, 2, 4]) {
        let code = u8::from_str_radix(digits.get(place..place + 2)?, 16).ok()?;
        *channel = f64::from(srgb_to_linear(f32::from(code) / 255.0));
    }
    // A sign would pass for a digit.
    digits.bytes().all(|byte| byte.is_ascii_hexdigit()).then_some(colour)
}

/// A green leaf turned by sliders. Contents follow the squares of red and brown, since the first micrograms change a
/// colour most; chlorophyll goes as any of the three comes.
fn slid(green: &Pigments, sliders: &Sliders) -> Pigments {
    let Sliders { red, yellow, brown } = *sliders;
    let left = (1.0 - red) * (1.0 - yellow) * (1.0 - brown);
    Pigments {
        structure: green.structure + 0.2 * (1.0 - left) + 0.4 * brown,
        chlorophyll: green.chlorophyll * left * left + 0.6 * (1.0 - left),
        carotenoids: (green.carotenoids * (1.0 - 0.3 * red) + 3.0 * yellow) * (1.0 - 0.75 * brown),
        anthocyanins: green.anthocyanins * left + 22.0 * red * red,
        brown: green.brown + 1.5 * brown * brown,
        water: green.water * (1.0 - 0.85 * brown),
        dry_matter: green.dry_matter + 0.001 * (1.0 - left),
    }
}

/// Leaves from which the search for a colour starts: chlorophyll, carotenoids, anthocyanins, brown, structure.
const STARTS: [[f64; 5]; 6] = [
    [38.0, 7.0, 3.0, 0.05, 1.45],
    [6.0, 7.0, 2.0, 0.05, 1.5],
    [1.2, 7.0, 0.5, 0.03, 1.65],
    [1.0, 5.0, 11.0, 0.03, 1.7],
    [3.0, 3.5, 24.0, 0.1, 1.7],
    [0.5, 2.0, 1.5, 1.0, 2.0],
];
/// The least and largest contents that the search may take.
const BOUNDS: [(f64, f64); 5] = [(0.05, 150.0), (0.05, 30.0), (0.02, 80.0), (0.002, 6.0), (1.0, 3.5)];

/// The contents whose reflected colour, gloss included, is nearest to a colour, and how far it is off (dE76). A pattern
/// search (Hooke and Jeeves 1961) on logarithms from several leaves: always the same steps.
pub(super) fn fitted(optics: &Optics, colour: Colour) -> (Pigments, f64) {
    let goal = lab(colour);
    let miss = |values: &[f64; 5]| {
        let found = lab(optics.appearance(&pigments(values)).reflected);
        let squares = found.iter().zip(&goal).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        squares.sqrt()
    };
    let best = STARTS.iter().map(|start| descended(*start, &miss)).min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or((Pigments::default(), f64::INFINITY), |(values, miss)| (pigments(&values), miss))
}

fn descended(mut values: [f64; 5], miss: &impl Fn(&[f64; 5]) -> f64) -> ([f64; 5], f64) {
    let (mut best, mut stride) = (miss(&values), 0.5);
    while stride > 0.004 && best > 0.05 {
        let before = best;
        for axis in 0..5 {
            for sign in [1.0, -1.0] {
                let mut next = values;
                next[axis] = (next[axis] * exp(sign * stride)).clamp(BOUNDS[axis].0, BOUNDS[axis].1);
                let found = miss(&next);
                if found < best {
                    (best, values) = (found, next);
                }
            }
        }
        if best > before - 1e-3 {
            stride *= 0.5;
        }
    }
    (values, best)
}

/// Contents of a leaf that dries as it browns.
fn pigments(values: &[f64; 5]) -> Pigments {
    let [chlorophyll, carotenoids, anthocyanins, brown, structure] = *values;
    let water = 0.009 * (1.0 - brown.min(0.8));
    Pigments { structure, chlorophyll, carotenoids, anthocyanins, brown, water, dry_matter: 0.004 }
}

#[cfg(test)]
mod tests {
    use super::super::Table;
    use super::*;

    fn settings(text: &str) -> Settings {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn colours_of_leaves_are_fitted_closely_and_others_say_how_far_they_are_off() {
        let optics = Optics::new(Table::Coarse);
        // The first has less blue than the bare surface of any leaf sends back.
        for (text, most) in [("#b5301c", 16.0), ("#985242", 0.3), ("#a6843e", 0.3), ("#495536", 0.3), ("#856c57", 0.3)]
        {
            let (pigments, miss) = fitted(&optics, parsed(text).unwrap());
            assert!(miss < most, "{text}: dE {miss} with {pigments:?}");
        }
        let blue = fitted(&optics, parsed("#2040ff").unwrap());
        assert!(blue.1 > 40.0, "{blue:?}");
    }

    #[test]
    fn only_six_hexadecimal_digits_are_a_colour() {
        assert_eq!(parsed("#ffffff"), Some([1.0; 3]));
        for text in ["b5301c", "#b5301", "#b5301cff", "#+53 1c", "#gg0000", "", "#é301c"] {
            assert_eq!(parsed(text), None, "{text}");
        }
    }

    #[test]
    fn sliders_turn_a_green_leaf() {
        let settings = settings(
            "sliders = { a = {}, r = { red = 1.0 }, y = { yellow = 1.0 }, b = { brown = 1.0 } }\n[pigments.green]\n",
        );
        let optics = Optics::new(Table::Coarse);
        let seen = |state: &str| lab(optics.appearance(&contents(&settings, &optics, state).pigments).reflected);
        assert_eq!(contents(&settings, &optics, "a").pigments, Pigments::default());
        let [green, red, yellow, brown] = ["a", "r", "y", "b"].map(seen);
        assert!(
            green[1] < -5.0 && red[1] > 20.0 && yellow[2] > 40.0 && yellow[0] > 55.0,
            "{green:?} {red:?} {yellow:?}"
        );
        assert!((0.0..15.0).contains(&brown[1]) && brown[2] < 25.0, "{brown:?}");
    }

    #[test]
    fn the_chlorophyll_of_the_green_leaf_is_what_others_lost() {
        let settings = settings(
            "[pigments.green]\nchlorophyll = 40.0\n[pigments.yellow]\nchlorophyll = 1.0\n[pigments.flush]\nchlorophyll = 15.0\n",
        );
        let optics = Optics::new(Table::Coarse);
        let reference = |state: &str| contents(&settings, &optics, state).reference;
        assert_eq!(["green", "yellow", "flush"].map(reference), [40.0, 40.0, 15.0]);
    }
}
