//! The tables of the built-in species, read from their files: sound, of one set of states, of the size of their kind, and
//! with the habits that tell one species from another.

use leafseason::base::limits::Limits;
use leafseason::colour::{self, Table, appearance, colour_difference, lab};
use leafseason::season::{self, Population, Position, Weather};
use leafseason::{deform, leaf};
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

/// What each stage reads of a species; the tree has tests of its own.
#[derive(serde::Deserialize)]
struct Tables {
    leaf: leaf::Settings,
    deform: deform::Settings,
    season: season::Settings,
    colour: colour::Settings,
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/species")
}

fn tables(name: &str) -> Tables {
    let part = |stage: &str| fs::read_to_string(folder().join(format!("{name}.{stage}.toml"))).expect(name);
    let text: String = ["leaf", "deform", "season", "colour"].map(part).join("\n");
    toml::from_str(&text).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The smallest and the largest value.
type Range = [f64; 2];

/// Lengths from the joint, widths (mm) and areas (cm2) between which an average leaf lies: the species' range in floras and
/// leaf keys as named in each leaf file, areas estimated from them.
const SIZES: [(&str, Range, Range, Range); 11] = [
    ("beech", [50.0, 100.0], [30.0, 65.0], [15.0, 40.0]),
    ("english-oak", [70.0, 140.0], [40.0, 85.0], [20.0, 45.0]),
    ("ginkgo", [40.0, 70.0], [50.0, 80.0], [15.0, 35.0]),
    ("japanese-maple", [40.0, 80.0], [50.0, 100.0], [12.0, 30.0]),
    ("norway-maple", [80.0, 140.0], [100.0, 180.0], [60.0, 130.0]),
    ("quaking-aspen", [30.0, 70.0], [30.0, 70.0], [10.0, 30.0]),
    ("red-maple", [50.0, 100.0], [50.0, 110.0], [30.0, 60.0]),
    ("red-oak", [120.0, 200.0], [100.0, 150.0], [70.0, 150.0]),
    ("silver-birch", [30.0, 70.0], [25.0, 55.0], [7.0, 15.0]),
    ("sugar-maple", [75.0, 130.0], [75.0, 150.0], [40.0, 90.0]),
    ("sweetgum", [70.0, 150.0], [80.0, 180.0], [50.0, 110.0]),
];

#[test]
fn every_table_is_sound_and_all_tables_of_a_species_know_the_same_states() {
    for (name, ..) in SIZES {
        let Tables { leaf, deform, season, colour } = tables(name);
        assert_eq!(leaf::check(&leaf), [], "{name}");
        assert_eq!(deform::check(&deform), [], "{name}");
        assert_eq!(season::check(&season, &Weather::constant(12.0, 0.7)), [], "{name}");
        assert_eq!(colour::check(&colour), [], "{name}");
        let shown: BTreeSet<&String> =
            season.states.keys().filter(|state| !["bud", "fallen"].contains(&state.as_str())).collect();
        assert_eq!(colour.pigments.keys().collect::<BTreeSet<_>>(), shown, "{name}");
        assert_eq!(deform.states.keys().collect::<BTreeSet<_>>(), shown, "{name}");
    }
}

#[test]
fn blades_are_as_large_as_those_of_their_species() {
    for (name, length, width, area) in SIZES {
        let settings = tables(name).leaf;
        let (blade, _) = leaf::model(&settings, leaf::Pictures::default(), &Limits::default()).expect(name);
        let across = blade.outline.iter().map(|p| p.x);
        let found = across.clone().fold(f64::MIN, f64::max) - across.fold(f64::MAX, f64::min);
        let within = |[low, high]: Range, value: f64| (low..=high).contains(&value);
        assert!(within(length, settings.length), "{name}: {} mm long", settings.length);
        assert!(within(width, found * 1e3), "{name}: {} mm wide", found * 1e3);
        assert!(within(area, blade.mesh.area() * 1e4), "{name}: {} cm2", blade.mesh.area() * 1e4);
    }
}

#[test]
fn every_blade_can_be_meshed_by_the_default_number_of_vertices() {
    for (name, ..) in SIZES {
        let settings = leaf::Settings { vertices: leaf::Settings::default().vertices, ..tables(name).leaf };
        let made = leaf::model(&settings, leaf::Pictures::default(), &Limits::default());
        assert!(made.is_ok(), "{name}: {made:?}");
    }
}

/// Share of the leaves in a state after a time in a cool, moist climate, all having started in another state.
fn share(name: &str, from: &str, days: f64, state: &str) -> f64 {
    let settings = season::Settings { start: from.to_owned(), coherence: 0.0, ..tables(name).season };
    // A ginkgo lets go in frost.
    let temperature = if name == "ginkgo" { 1.0 } else { 4.0 };
    let mut leaves = Population::new(&settings, &Weather::constant(temperature, 0.8), 1);
    let position = Position { height: 0.0, distance: 0.0, limb: 0, shoot: 0 };
    leaves.add(None, None, [(1, position)].into_iter());
    let place = leaves.names().iter().position(|known| known == state).expect(state);
    leaves.laws(&[days])[0].expected[place]
}

#[test]
fn beech_and_english_oak_hold_brown_leaves_into_winter_and_birch_and_ginkgo_none() {
    for (name, days) in [("beech", 90.0), ("english-oak", 60.0)] {
        assert!(share(name, "green", days, "brown") > 0.10, "{name}");
    }
    for name in ["silver-birch", "ginkgo", "quaking-aspen"] {
        assert!(share(name, "green", 90.0, "fallen") > 0.999, "{name}");
    }
}

#[test]
fn a_yellow_ginkgo_is_bare_within_days_and_a_coppery_beech_is_not() {
    assert!(share("ginkgo", "yellow", 3.0, "fallen") > 0.8);
    assert!(share("beech", "copper", 3.0, "fallen") < 0.1);
}

#[test]
fn the_oaks_turn_later_than_the_maples() {
    let green = |name: &str| share(name, "green", 10.0, "green") + share(name, "green", 10.0, "late-green");
    for oak in ["english-oak", "red-oak"] {
        assert!(green(oak) > green("red-maple") + 0.2 && green(oak) > green("sugar-maple") + 0.2);
    }
}

/// The state by whose colour a species is known.
const KNOWN_BY: [(&str, &str); 11] = [
    ("beech", "copper"),
    ("english-oak", "yellow"),
    ("ginkgo", "yellow"),
    ("japanese-maple", "red"),
    ("norway-maple", "yellow"),
    ("quaking-aspen", "yellow"),
    ("red-maple", "red"),
    ("red-oak", "red"),
    ("silver-birch", "yellow"),
    ("sugar-maple", "orange"),
    ("sweetgum", "purple"),
];

#[test]
fn species_are_told_apart_by_their_colours_and_the_ginkgo_is_the_lemon_among_them() {
    let colour = |(name, state): (&str, &str)| appearance(&tables(name).colour.contents(state), Table::Fine).reflected;
    let colours = KNOWN_BY.map(colour);
    for (i, &one) in colours.iter().enumerate() {
        for (j, &other) in colours.iter().enumerate().take(i) {
            // A difference of 1 can just be seen side by side; 4 shows at a glance.
            assert!(colour_difference(one, other) > 4.0, "{:?} and {:?}", KNOWN_BY[i], KNOWN_BY[j]);
        }
    }
    // The hue turns from red over yellow to green: the larger b over a, the less red is in it.
    let greenness = |colour: [f64; 3]| lab(colour)[2] / lab(colour)[1].max(1e-9);
    let ginkgo = greenness(colour(("ginkgo", "yellow")));
    assert!(KNOWN_BY.iter().zip(colours).all(|(known, c)| known.0 == "ginkgo" || greenness(c) < ginkgo));
}
