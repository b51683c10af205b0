//! What can be wrong with a season: all of it at once.

use super::chain::Chain;
use super::weather::Weather;
use super::{BUD, Mode, Settings, State};
use crate::base::settings::Complaint;

/// How far a row of chances may miss 1 by rounding in the file.
const ROW_TOLERANCE: f64 = 1e-6;
/// Half-lives below this (0.1 microseconds) are a slip, and their rates could overflow.
const SHORTEST_HALF_LIFE: f64 = 1e-12;
/// More states than this are a slip: the exact shares cost the cube of their number.
const MOST_STATES: usize = 64;
/// Hidden stages of all states together.
const MOST_STAGES: u32 = 512;
/// Shortest step of the paper's rule in a year's weather, days: it is followed step by step.
const SHORTEST_STEP: f64 = 0.02;

/// Everything wrong with the settings for this weather; empty when they can be used.
#[must_use]
pub fn check(settings: &Settings, weather: &Weather) -> Vec<Complaint> {
    let mut complaints = corners(settings);
    complaints.extend(start(settings));
    for (name, state) in &settings.states {
        complaints.extend(half_life(name, state));
        complaints.extend(targets(settings, name, state));
        complaints.extend(rows(name, state));
    }
    complaints.extend(stages(settings));
    complaints.extend(odds(settings));
    if complaints.is_empty() {
        complaints.extend(returns(settings, weather));
    }
    let is_short = settings.mode == Mode::Paper && settings.step < SHORTEST_STEP && !weather.is_constant();
    complaints.extend(is_short.then(|| {
        let message = format!("a step of {} days is too short for a year's weather", settings.step);
        Complaint::new(
            "step",
            message,
            format!("give at least {SHORTEST_STEP}, or mode = \"exact\", which has no step"),
        )
    }));
    complaints
}

fn stages(settings: &Settings) -> Option<Complaint> {
    let sum: u32 = settings.states.values().map(|state| state.stages.min(MOST_STAGES)).sum();
    (sum > MOST_STAGES).then(|| {
        let message = format!("the states have {sum} hidden stages together");
        Complaint::new("states", message, format!("have at most {MOST_STAGES}"))
    })
}

fn odds(settings: &Settings) -> Vec<Complaint> {
    let unknown = settings.crown.odds.keys().filter(|name| !settings.states.contains_key(*name));
    let complaint = |name: &String| {
        let message = format!("`{name}` is not one of the states");
        Complaint::new(format!("crown.odds.{name}"), message, format!("name one of {}", known(settings)))
    };
    unknown.map(complaint).collect()
}

/// A chain that returns has no course through the year to be early or late in.
fn returns(settings: &Settings, weather: &Weather) -> Option<Complaint> {
    let has_buds = !weather.is_constant() && settings.states.get(BUD).is_some_and(|bud| !bud.next.is_empty());
    let has_stages = settings.states.values().any(|state| state.stages > 1);
    if settings.coherence == 0.0 && !has_buds && !has_stages || !Chain::new(settings, true).returns() {
        return None;
    }
    let message = "leaves can come back to a state they have left";
    if let Some((name, _)) = settings.states.iter().find(|(_, state)| state.stages > 1) {
        let message = format!("`{name}` has hidden stages, and {message}");
        return Some(Complaint::new(format!("states.{name}.stages"), message, "have one stage in each state"));
    }
    Some(if settings.coherence > 0.0 {
        Complaint::new("coherence", format!("{message}: none is early or late"), "set coherence = 0")
    } else {
        let help = "let states follow each other one way, or take `bud` out: spring brings the leaves back";
        Complaint::new("states", format!("{message}, and buds open in spring as well"), help)
    })
}

fn corners(settings: &Settings) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    for (low_name, low, high_name, high) in
        [("cold", settings.cold, "warm", settings.warm), ("dry", settings.dry, "wet", settings.wet)]
    {
        // The negation also catches numbers that are not comparable.
        if low.partial_cmp(&high) != Some(std::cmp::Ordering::Less) {
            complaints.push(Complaint::new(
                low_name,
                format!("`{low_name}` = {low} is not below `{high_name}` = {high}: no climate lies between them"),
                format!("make `{low_name}` the lower of the two"),
            ));
        }
    }
    if !(settings.step > 0.0 && settings.step.is_finite()) {
        complaints.push(Complaint::new(
            "step",
            format!("a step of {} days does not advance", settings.step),
            "give a step above 0, for example 1.0",
        ));
    }
    complaints
}

fn start(settings: &Settings) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    let count = settings.states.len();
    if count == 0 || count > MOST_STATES {
        complaints.push(Complaint::new(
            "states",
            format!("there are {count} states"),
            format!("give 1 to {MOST_STATES} states as [season.states.NAME], or a species that has them"),
        ));
    }
    if count > 0 && !settings.states.contains_key(&settings.start) {
        complaints.push(Complaint::new(
            "start",
            format!("leaves start as `{}`, which is not one of the states", settings.start),
            format!("name one of {}", known(settings)),
        ));
    }
    complaints
}

fn known(settings: &Settings) -> String {
    settings.states.keys().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

fn half_life(name: &str, state: &State) -> Option<Complaint> {
    let key = format!("states.{name}.half_life");
    let Some(half_life) = state.half_life else {
        return (!state.next.is_empty()).then(|| {
            let message = format!("`{name}` has states that follow but no half-life");
            Complaint::new(key, message, "give half_life in days, or leave `next` out for a state that lasts")
        });
    };
    let values = half_life.values();
    if let Some(value) = values.iter().find(|value| value.is_nan() || **value < SHORTEST_HALF_LIFE) {
        let message = match *value > 0.0 {
            true => format!("a half-life of {value:e} days is shorter than {SHORTEST_HALF_LIFE:e}"),
            false => format!("a half-life of {value} days is not a positive time"),
        };
        return Some(Complaint::new(key, message, "give days above 0, or leave the state out of the chain"));
    }
    let endless = values.iter().filter(|value| value.is_infinite()).count();
    (endless > 0 && endless < values.len()).then(|| {
        let message =
            "some corners are left after a time and others never: interpolating between them gives never everywhere";
        Complaint::new(key, message, "give a long half-life instead of infinity, for example 1e6")
    })
}

fn targets(settings: &Settings, name: &str, state: &State) -> Vec<Complaint> {
    let key = format!("states.{name}.next");
    let mut complaints = Vec::new();
    if state.next.is_empty() && state.half_life.is_some() {
        let message = format!("`{name}` has a half-life but nothing follows it");
        complaints.push(Complaint::new(&key, message, "give `next`, or leave half_life out for a state that lasts"));
    }
    for (index, target) in state.next.iter().enumerate() {
        let (message, help) = if target == name {
            (format!("`{name}` follows itself"), "take it out and lengthen half_life instead".to_owned())
        } else if !settings.states.contains_key(target) {
            (format!("`{target}` is not one of the states"), format!("name one of {}", known(settings)))
        } else if state.next[..index].contains(target) {
            (format!("`{target}` is named twice"), "add its chances together".to_owned())
        } else {
            continue;
        };
        complaints.push(Complaint::new(&key, message, help));
    }
    complaints
}

fn rows(name: &str, state: &State) -> Vec<Complaint> {
    let rows = [
        ("wet_cold", &state.wet_cold),
        ("wet_warm", &state.wet_warm),
        ("dry_cold", &state.dry_cold),
        ("dry_warm", &state.dry_warm),
    ];
    let complaint = |(corner, row): (&str, &Vec<f64>)| {
        row_fault(row, state.next.len())
            .map(|(message, help)| Complaint::new(format!("states.{name}.{corner}"), message, help))
    };
    rows.into_iter().filter_map(complaint).collect()
}

fn row_fault(row: &[f64], targets: usize) -> Option<(String, String)> {
    if row.len() != targets {
        let message = format!("{} chances for {targets} states in `next`", row.len());
        return Some((message, "give one chance for each state of `next`, in the same order".to_owned()));
    }
    if let Some(value) = row.iter().find(|value| value.is_nan() || **value < 0.0) {
        return Some((format!("{value} is not a chance"), "give numbers from 0 to 1".to_owned()));
    }
    let sum: f64 = row.iter().sum();
    // As a text with 9 decimals: the rounding of the sum itself is of no use to the reader.
    ((sum - 1.0).abs() > ROW_TOLERANCE && targets > 0).then(|| {
        let shown = format!("{sum:.9}");
        let shown = shown.trim_end_matches('0').trim_end_matches('.').to_owned();
        (format!("the chances sum to {shown}, not to 1"), format!("divide each by {shown}"))
    })
}

#[cfg(test)]
mod tests {
    use super::super::chain::tests::{branching, settings, state};
    use super::*;
    use crate::base::settings::Corners;

    fn keys(settings: &Settings) -> Vec<String> {
        check(settings, &Weather::constant(12.0, 0.7)).into_iter().map(|complaint| complaint.key).collect()
    }

    #[test]
    fn a_sound_chain_has_no_complaints() {
        assert_eq!(check(&branching(), &Weather::constant(12.0, 0.7)), []);
    }

    #[test]
    fn all_faults_are_named_at_once() {
        let mut faulty = branching();
        let a = faulty.states.get_mut("a").unwrap();
        a.wet_cold = vec![0.6, 0.3, 0.2];
        a.wet_warm = vec![0.5, 0.5];
        a.dry_cold = vec![-0.1, 0.6, 0.5];
        a.dry_warm[0] = f64::NAN;
        faulty.states.get_mut("b").unwrap().next = vec!["b".to_owned(), "q".to_owned()];
        faulty.states.get_mut("c").unwrap().half_life = Some(Corners::Same(0.0));
        faulty.start = "z".to_owned();
        faulty.cold = 25.0;
        faulty.dry = 0.95;
        let expected = [
            "cold",
            "dry",
            "start",
            "states.a.wet_cold",
            "states.a.wet_warm",
            "states.a.dry_cold",
            "states.a.dry_warm",
            "states.b.next",
            "states.b.next",
            "states.c.half_life",
        ];
        assert_eq!(keys(&faulty), expected);
    }

    #[test]
    fn the_sum_of_a_row_is_printed() {
        let faulty =
            settings(&[("a", state(1.0, &[("b", 0.5), ("c", 0.6)])), ("b", State::default()), ("c", State::default())]);
        let complaints = check(&faulty, &Weather::constant(12.0, 0.7));
        assert_eq!(complaints.len(), 4);
        assert_eq!(complaints[0].message, "the chances sum to 1.1, not to 1");
    }

    #[test]
    fn rows_may_miss_one_by_rounding() {
        let third = 0.333_333_3;
        let rounded = [("b", third), ("c", third), ("d", third)];
        let sound = settings(&[
            ("a", state(1.0, &rounded)),
            ("b", State::default()),
            ("c", State::default()),
            ("d", State::default()),
        ]);
        assert_eq!(keys(&sound), [] as [String; 0]);
    }

    #[test]
    fn half_life_and_next_come_together() {
        let mut faulty = branching();
        faulty.states.get_mut("a").unwrap().half_life = None;
        faulty.states.get_mut("d").unwrap().half_life = Some(Corners::Same(3.0));
        assert_eq!(keys(&faulty), ["states.a.half_life", "states.d.next"]);
    }

    #[test]
    fn corners_that_mix_some_time_and_never_are_refused() {
        let mut mixed = branching();
        mixed.states.get_mut("c").unwrap().half_life = Some(Corners::Each([1.0, f64::INFINITY, 1.0, 1.0]));
        assert_eq!(keys(&mixed), ["states.c.half_life"]);
        mixed.states.get_mut("c").unwrap().half_life = Some(Corners::Same(f64::INFINITY));
        assert_eq!(keys(&mixed), [] as [String; 0]);
    }

    #[test]
    fn the_red_maple_is_sound_and_its_green_half_life_lies_between_its_corners() {
        #[derive(serde::Deserialize)]
        struct Species {
            season: Settings,
        }
        let species: Species = toml::from_str(include_str!("../species/red-maple.season.toml")).unwrap();
        assert_eq!(check(&species.season, &Weather::constant(12.0, 0.7)), []);
        let chain = Chain::new(&species.season, false);
        let green = chain.names.iter().position(|name| name == "green").unwrap();
        let early_october = super::super::Day { temperature: 12.0, humidity: 0.7, day_length: None };
        let half_life = std::f64::consts::LN_2 / chain.rate(green, &chain.place(&early_october));
        let corners = species.season.states["green"].half_life.unwrap().values();
        // Bilinear by hand: two thirds of the way to the wet corners.
        let warmth = (12.0 - species.season.cold) / (species.season.warm - species.season.cold);
        let along = |cold: f64, warm: f64| (1.0 - warmth) * cold + warmth * warm;
        let expected = along(corners[0], corners[1]) * 2.0 / 3.0 + along(corners[2], corners[3]) / 3.0;
        assert!((half_life - expected).abs() < 1e-12);
    }

    #[test]
    fn chains_that_return_have_neither_coherence_nor_buds() {
        let returning = super::super::chain::tests::returning(1.0, 2.0);
        assert_eq!(keys(&returning), [] as [String; 0]);
        assert_eq!(keys(&Settings { coherence: 0.5, ..returning.clone() }), ["coherence"]);
        let mut with_buds = returning;
        with_buds.states.insert(BUD.to_owned(), state(3.0, &[("a", 1.0)]));
        let year = Weather::mean_years(45.0, None, crate::base::calendar::Date::new(2017, 1, 1).unwrap(), 10);
        assert_eq!(check(&with_buds, &year)[0].key, "states");
        assert_eq!(keys(&with_buds), [] as [String; 0]);
    }

    #[test]
    fn odds_are_those_of_states_that_are() {
        let mut faulty = branching();
        faulty.crown.odds.insert("purple".to_owned(), 1.0);
        assert_eq!(keys(&faulty), ["crown.odds.purple"]);
    }

    #[test]
    fn a_season_without_states_is_refused() {
        assert_eq!(keys(&Settings::default()), ["states"]);
    }
}
