//! Cases of the seasons' chain.

use super::bench::SMALL;
use super::{Bench, Case, Seen, case, slow};
use crate::base::calendar::Date;
use crate::base::maths::log1p;
use crate::season::{self, Day, Settings, State, Transition, Weather};
use crate::study::chains::{KNOWN, STEPPED_HAZARDS, leaves, steady, with_hazards};
use crate::study::numbers::{shown, total_variation};
use crate::study::timing::pool;

pub const CASES: &[Case] = &[
    case("C01", "no time", "every leaf as it began, exactly", |_| {
        let law = leaves(&KNOWN[4].settings(), &steady(), 1, 1).laws(&[0.0])[0].expected.clone();
        (law == [1.0, 0.0, 0.0, 0.0], format!("{law:?}"))
    }),
    case("C02a", "1e12 days, a chain that ends", "all in the last state to 1e-12", |_| {
        at_end(&KNOWN[4].settings(), &[0.0, 0.0, 0.0, 1.0])
    }),
    case("C02b", "1e12 days, a chain that returns", "its stationary law to 1e-12", |_| {
        at_end(&KNOWN[1].settings(), &[0.25, 0.75])
    }),
    case("C04", "a half-life of 0", "error that names the key", |bench| refused(bench, "c04", "half_life", "0.0")),
    case("C05a", "a half-life below 0", "error that names the key", |bench| {
        refused(bench, "c05a", "half_life", "-3.0")
    }),
    case("C05b", "a half-life that is no number", "error that names the key", |bench| {
        refused(bench, "c05b", "half_life", "nan")
    }),
    case("C06a", "chances that sum to 0", "error that prints the sum", |_| row(&[0.0, 0.0], "sum to 0")),
    case("C06b", "chances that sum to 0.8", "error that prints the sum", |_| row(&[0.4, 0.4], "sum to 0.8")),
    case("C06c", "chances that sum to 1.25", "error that prints the sum", |_| row(&[0.75, 0.5], "sum to 1.25")),
    case("C06d", "a chance of -0.1", "error that names it", |_| row(&[-0.1, 1.1], "-0.1 is not a chance")),
    case("C06e", "no chances and no half-life", "the state lasts", |_| {
        let settings = Settings::of_states(&[("a", State::default())]);
        let share = leaves(&settings, &steady(), 1, 1).laws(&[1e6])[0].expected[0];
        (season::check(&settings, &steady()).is_empty() && share == 1.0, format!("share {share} after 1e6 days"))
    }),
    case("C07a", "one state", "all leaves in it", |_| {
        let found = leaves(&Settings::of_states(&[("a", State::default())]), &steady(), 1, 3).at(5.0).states;
        (found == [0, 0, 0], format!("{found:?}"))
    }),
    case("C07b", "64 states in line", "mean of the Poisson law to 1e-7", |_| long_line()),
    case("C07c", "no state", "error", |_| {
        let complaints = season::check(&Settings::default(), &steady());
        let first = complaints.first().map(|complaint| complaint.message.clone()).unwrap_or_default();
        (first.contains("0 states"), first)
    }),
    case("C08a", "a climate outside the corners by 1e-9", "moved to the corner, counted", |_| outside(1e-9)),
    case("C08b", "a climate outside the corners by 1e3", "moved to the corner, counted", |_| outside(1e3)),
    case("C10a", "a climate that changes within the time", "the reference M7 to 1e-12", |_| stepped_climate()),
    case("C10b", "a climate of 100,000 days", "the law of equal days to 1e-9; no leaf lost", |_| long_climate()),
    case("C11", "frames backwards, one at a time, on one thread and two", "the same states, bit by bit", |_| {
        any_order()
    }),
    case("C12a", "no leaves", "empty but valid", |_| {
        let mut none = leaves(&KNOWN[4].settings(), &steady(), 1, 0);
        let (sample, law) = (none.at(30.0), none.laws(&[30.0]));
        (sample.states.is_empty() && law.len() == 1, format!("{} states, {} law", sample.states.len(), law.len()))
    }),
    slow("C12b", "ten million leaves", "their law; memory in proportion", |_| many_leaves()),
    case("C13", "the uniform numbers 0 and 1 - 2^-53", "finite waiting times, no endless loop", |_| ends_of_uniform()),
    case(
        "C15",
        "the paper's step of a hundred half-lives",
        "equation (6): all at the direct targets; noticed as long",
        |_| long_step(),
    ),
];

fn at_end(settings: &Settings, expected: &[f64]) -> Seen {
    let law = leaves(settings, &steady(), 1, 1).laws(&[1e12])[0].expected.clone();
    let error = total_variation(&law, expected);
    (error <= 1e-12, format!("total variation {}", shown(error)))
}

fn refused(bench: &Bench, name: &str, key: &str, value: &str) -> Seen {
    let scene = format!("{SMALL}[season.states.green]\n{key} = {value}\n");
    bench.render(name, &scene, &[]).is_refusal(&[&format!("{name}.toml"), key])
}

fn row(chances: &[f64], says: &str) -> Seen {
    let mut a = State::in_any_climate(10.0, &[("b", 0.5), ("c", 0.5)]);
    a.dry_warm = chances.to_vec();
    let settings = Settings::of_states(&[("a", a), ("b", State::default()), ("c", State::default())]);
    let complaints = season::check(&settings, &steady());
    let told: Vec<String> =
        complaints.iter().map(|complaint| format!("{}: {}", complaint.key, complaint.message)).collect();
    (told.len() == 1 && told[0].contains(says) && told[0].contains("dry_warm"), told.join("; "))
}

fn long_line() -> Seen {
    let names: Vec<String> = (0..64).map(|number| format!("s{number:02}")).collect();
    let of = |(number, name): (usize, &String)| {
        let next = names.get(number + 1).map(|next| (next.as_str(), 1.0));
        (name.clone(), State::in_any_climate(0.5, next.as_slice()))
    };
    let list: Vec<(String, State)> = names.iter().enumerate().map(of).collect();
    let borrowed: Vec<(&str, State)> = list.iter().map(|(name, state)| (name.as_str(), state.clone())).collect();
    let law = leaves(&Settings::of_states(&borrowed), &steady(), 1, 1).laws(&[20.0])[0].expected.clone();
    let mean: f64 = law.iter().enumerate().map(|(number, share)| number as f64 * share).sum();
    let exact = 20.0 * std::f64::consts::LN_2 / 0.5;
    ((mean - exact).abs() < 1e-7, format!("mean {mean:.9}, {exact:.9} exactly"))
}

fn outside(by: f64) -> Seen {
    let mut settings = KNOWN[4].settings();
    for state in settings.states.values_mut().filter(|state| state.half_life.is_some()) {
        state.half_life = Some(crate::base::settings::Corners::Each([40.0, 5.0, 80.0, 15.0]));
    }
    let law = |temperature: f64| {
        let leaves = leaves(&settings, &Weather::constant(temperature, settings.wet), 1, 1);
        (leaves.laws(&[9.0])[0].expected.clone(), leaves.clamped().0)
    };
    let (inside, outside) = (law(settings.cold), law(settings.cold - by));
    (inside.0 == outside.0 && [inside.1, outside.1] == [0, 1], format!("{} day outside, same law", outside.1))
}

fn stepped_climate() -> Seen {
    let factors: Vec<f64> = (0..20).map(|day| if day < 10 { 1.0 } else { 3.0 }).collect();
    let Some((settings, weather)) = with_hazards(&factors, [1.0, 3.0]) else { return (false, "no weather".to_owned()) };
    let law = leaves(&settings, &weather, 1, 1).laws(&[20.0])[0].expected.clone();
    let worst = law.iter().zip(STEPPED_HAZARDS).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (worst <= 1e-12, format!("{} off at most", shown(worst)))
}

fn long_climate() -> Seen {
    let settings = Settings { gate: season::Gate::None, ..KNOWN[4].settings() };
    let day = Day { temperature: 12.0, humidity: 0.7, day_length: Some(12.0) };
    let origin = Date::new(1900, 1, 1);
    let Some(weather) = origin.and_then(|origin| Weather::series(origin, vec![day; 100_000], None)) else {
        return (false, "no weather".to_owned());
    };
    let mut daily = leaves(&settings, &weather, 1, 2000);
    let law = daily.laws(&[60.5])[0].expected.clone();
    let steady = leaves(&settings, &steady(), 1, 1).laws(&[60.5])[0].expected.clone();
    let error = total_variation(&law, &steady);
    let last = daily.at(99_999.0);
    let ended = last.states.iter().filter(|&&state| state == 3).count();
    (error <= 1e-9 && ended == 2000, format!("total variation {}, {ended} of 2000 leaves at the end", shown(error)))
}

fn any_order() -> Seen {
    let days: Vec<f64> = (0..30).map(|step| f64::from(step) * 3.25).collect();
    let settings = KNOWN[4].settings();
    let forward = || {
        let mut leaves = leaves(&settings, &steady(), 8, 3000);
        leaves.keep();
        days.iter().map(|day| leaves.at(*day).states).collect::<Vec<_>>()
    };
    let alone = || {
        let mut found: Vec<_> =
            days.iter().rev().map(|day| leaves(&settings, &steady(), 8, 3000).at(*day).states).collect();
        found.reverse();
        found
    };
    let on = |threads: usize, work: &(dyn Fn() -> Vec<Vec<u16>> + Sync)| pool(threads).map(|pool| pool.install(work));
    let all = [on(1, &forward), on(2, &forward), on(1, &alone), on(2, &alone)];
    let same = all.iter().all(|found| found.is_some() && *found == all[0]);
    (same, format!("30 frames of 3000 leaves, {}", if same { "the same four times" } else { "not the same" }))
}

fn many_leaves() -> Seen {
    let count = 10_000_000;
    let sample = leaves(&KNOWN[4].settings(), &steady(), 1, count).at(30.0);
    let share = |state: usize| sample.states.iter().filter(|&&s| usize::from(s) == state).count() as f64 / count as f64;
    let found: Vec<f64> = (0..4).map(share).collect();
    let error = total_variation(&found, KNOWN[4].values[1].1);
    (error < 1e-3, format!("total variation {}", shown(error)))
}

fn ends_of_uniform() -> Seen {
    let wait = |u: f64| -log1p(-u);
    let [least, most] = [0.0, 1.0 - f64::EPSILON / 2.0].map(wait);
    // A chain whose leaves leave at once, and one that they never leave.
    let at = |half_life: f64| {
        leaves(
            &Settings::of_states(&[("a", State::in_any_climate(half_life, &[("b", 1.0)])), ("b", State::default())]),
            &steady(),
            1,
            1000,
        )
        .at(1.0)
    };
    let (fast, slow) = (at(1e-12), at(1e300));
    let finite = fast.since.iter().chain(&slow.since).all(|day| day.is_finite());
    let passes = least == 0.0 && (36.0..37.5).contains(&most) && finite && fast.states.iter().all(|&s| s == 1);
    (passes, format!("waiting times of {least} and {most:.2} mean lives"))
}

fn long_step() -> Seen {
    let known = &KNOWN[4];
    let step = 3000.0;
    let law = Transition::stepped(&known.rates(), &known.moves(), step, 1.0).row(4, 0, 1.0);
    let error = total_variation(&law, &[0.0, 0.6, 0.3, 0.1]);
    let settings = Settings { mode: season::Mode::Paper, step, ..known.settings() };
    let longest = leaves(&settings, &steady(), 1, 1).largest_step();
    (
        error < 1e-12 && longest > 0.14,
        format!("total variation {}, chance of a jump {longest:.1} (0.14 warns)", shown(error)),
    )
}
