//! What the season promises as a whole: the exact law, histories that agree with each other, and extremes.

use super::chain::tests::{branching, line, returning, settings, state};
use super::*;
use crate::base::calendar::Date;
use crate::base::maths::exp;
use crate::base::random::hash;

fn constant() -> Weather {
    Weather::constant(12.0, 0.7)
}

fn position(id: u64) -> Position {
    let part = |salt: u64| hash(id, salt) as f64 / u64::MAX as f64;
    Position { height: 3.0 + 15.0 * part(1), distance: 6.0 * part(2), limb: id % 13, shoot: id / 8 }
}

fn ids(count: u64) -> Vec<u64> {
    (0..count).map(|index| hash(index, 99)).collect()
}

fn population(settings: &Settings, weather: &Weather, seed: u64, ids: &[u64]) -> Population {
    let mut population = Population::new(settings, weather, seed);
    let crown = Crown::new(&settings.crown, Some(30.0), None);
    population.add(None, crown.as_ref(), ids.iter().map(|&id| (id, position(id))));
    population
}

fn chi_square(states: &[u16], expected: &[f64]) -> f64 {
    let count = |state| states.iter().filter(|&&s| usize::from(s) == state).count() as f64;
    let leaves = states.len() as f64;
    let cells = (0..expected.len()).filter(|&state| expected[state] * leaves > 5.0);
    cells.map(|s| (count(s) - leaves * expected[s]) * (count(s) / (leaves * expected[s]) - 1.0)).sum()
}

/// Exceeded by chance once in a million with 1, 3 and 9 degrees of freedom.
const CRITICAL_ONE: f64 = 23.928_127;
const CRITICAL: f64 = 30.664_849;
const CRITICAL_NINE: f64 = 46.68;

/// Three years of the mean weather of a latitude.
fn years() -> Weather {
    Weather::mean_years(44.0, None, Date::new(2017, 1, 1).unwrap(), 1095)
}

/// A chain of a species with buds, stages, gates and a crown.
fn species() -> Settings {
    let spring = |half_life: f64, next: &str| State { gate: false, ..state(half_life, &[(next, 1.0)]) };
    let staged = |state: State| State { stages: 4, ..state };
    let mut settings = settings(&[
        ("green", staged(state(4.0, &[("red", 0.5), ("yellow", 0.5)]))),
        ("bud", spring(3.0, "flush")),
        ("flush", spring(8.0, "green")),
        ("red", state(3.0, &[("brown", 0.3), ("fallen", 0.7)])),
        ("yellow", state(3.0, &[("fallen", 1.0)])),
        ("brown", state(60.0, &[("fallen", 1.0)])),
        ("fallen", State::default()),
    ]);
    settings.coherence = 1.0;
    settings.crown = NominalCrown {
        height: 18.0,
        radius: 6.0,
        base: 2.0,
        years: 20.0,
        rate: 1.2,
        limb: 0.2,
        shoot: 0.3,
        odds: [("red".to_owned(), 1.5)].into(),
    };
    settings
}

#[test]
fn a_hundred_thousand_leaves_follow_the_exact_law() {
    let (settings, weather) = (branching(), constant());
    for seed in [1, 2, 3] {
        let mut leaves = population(&settings, &weather, seed, &ids(100_000));
        assert!(chi_square(&leaves.at(30.0).states, &[0.5, 0.15, 0.108_75, 0.241_25]) < CRITICAL);
    }
}

#[test]
fn a_species_in_real_seasons_follows_the_mean_of_its_leaves_laws() {
    let (settings, weather) = (species(), years());
    let days = [140.0, 262.5, 275.0, 290.25, 365.0, 500.0, 640.0];
    let all = ids(60_000);
    for seed in [1, 2] {
        let mut leaves = population(&settings, &weather, seed, &all);
        for (day, law) in days.iter().zip(leaves.laws(&days)) {
            assert!((law.expected.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let drawn = chi_square(&leaves.at(*day).states, &law.expected);
            assert!(drawn < CRITICAL_NINE, "day {day}: chi-square {drawn}, {:?}", law.expected);
        }
    }
}

#[test]
fn hidden_stages_keep_the_half_life_and_sharpen_it() {
    let at = |stages: u32, day: f64| {
        let mut settings = line(&[10.0]);
        settings.states.get_mut("a").unwrap().stages = stages;
        population(&settings, &constant(), 1, &[1]).laws(&[day])[0].expected[0]
    };
    assert!([1, 4, 32].iter().all(|&stages| (at(stages, 10.0) - 0.5).abs() < 1e-12));
    assert!(at(4, 5.0) > at(1, 5.0) + 0.1 && at(4, 20.0) < at(1, 20.0) - 0.1);
}

#[test]
fn equal_days_give_the_jumps_of_a_constant_climate() {
    let mut settings = branching();
    settings.gate = Gate::None;
    let day = Day { temperature: 12.0, humidity: 0.7, day_length: Some(10.0) };
    let series = Weather::series(Date::new(2017, 9, 1).unwrap(), vec![day; 90], None).unwrap();
    let (weather, all) = (constant(), ids(500));
    let mut steady = population(&settings, &weather, 5, &all);
    for day in [0.0, 7.25, 30.0, 89.5] {
        // The year is part of an event's key: the same draws belong to another year here.
        let mut daily = population(&settings, &series, 5, &all);
        let laws = [steady.laws(&[day]), daily.laws(&[day])];
        let close = laws[0][0].expected.iter().zip(&laws[1][0].expected).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close, "{laws:?}");
        let share = |sample: Sample| sample.states.iter().filter(|state| **state == 3).count() as f64 / 500.0;
        assert!((share(steady.at(day)) - share(daily.at(day))).abs() < 0.1);
    }
}

#[test]
fn the_reference_of_hazards_that_change_is_met() {
    // Chain M7: hazards of the branching chain times 1, 3 and 0 for ten days each, by half-lives that the weather divides.
    let mut settings = branching();
    settings.gate = Gate::None;
    for state in settings.states.values_mut().filter(|state| state.half_life.is_some()) {
        let base = state.half_life.unwrap().values()[0];
        state.half_life = Some(crate::base::settings::Corners::Each([base, base / 3.0, base, base / 3.0]));
    }
    let day = |temperature: f64| Day { temperature, humidity: 0.6, day_length: Some(10.0) };
    let days: Vec<Day> = (0..20).map(|at| day(if at < 10 { 0.0 } else { 25.0 })).collect();
    let weather = Weather::series(Date::new(2017, 9, 1).unwrap(), days, None).unwrap();
    let law = population(&settings, &weather, 1, &[1]).laws(&[20.0]);
    let expected = [0.396_850_262_992, 0.143_616_079_053_1, 0.110_787_939_666_5, 0.348_745_718_288_3];
    let close = law[0].expected.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(close, "{:?}", law[0].expected);
}

#[test]
fn frames_agree_at_any_step_in_any_order_with_and_without_memory() {
    let (settings, weather, all) = (species(), years(), ids(300));
    let fresh = |day: f64| {
        let mut leaves = population(&settings, &weather, 8, &all);
        leaves.remember();
        leaves.at(day)
    };
    let days: Vec<f64> = (0..200).map(|step| 100.0 + f64::from(step) * 5.25).collect();
    let alone: Vec<Sample> = days.iter().map(|day| fresh(*day)).collect();
    let mut kept = population(&settings, &weather, 8, &all);
    kept.remember();
    kept.keep();
    let forward: Vec<Sample> = days.iter().map(|day| kept.at(*day)).collect();
    let mut backward: Vec<Sample> = days.iter().rev().map(|day| kept.at(*day)).collect();
    backward.reverse();
    assert!(alone == forward && alone == backward);
    // A leaf that has not changed between two frames was entered on the same day in both.
    for ((today, tomorrow), day) in alone.iter().zip(&alone[1..]).zip(&days) {
        for leaf in 0..all.len() {
            let same = today.states[leaf] == tomorrow.states[leaf] && tomorrow.since[leaf] <= *day;
            assert!(!same || today.since[leaf] == tomorrow.since[leaf]);
        }
    }
    assert!(alone.iter().any(|sample| !sample.shed.is_empty()));
}

#[test]
fn a_leaf_does_not_depend_on_others() {
    let (settings, weather, all) = (species(), years(), ids(60));
    let together = population(&settings, &weather, 5, &all).at(280.0);
    for (index, &leaf) in all.iter().enumerate() {
        let alone = population(&settings, &weather, 5, &[leaf]).at(280.0);
        assert_eq!((alone.states[0], alone.since[0]), (together.states[index], together.since[index]));
    }
}

#[test]
fn weather_to_come_changes_nothing() {
    let mut settings = Settings { summer_advance: 0.2, ..species() };
    let yellow = settings.states.get_mut("yellow").unwrap();
    yellow.half_life = Some(crate::base::settings::Corners::Each([3.0, 9.0, 3.0, 9.0]));
    let cut = 280;
    let days = |warmer: f64| {
        let of = |day: i64| {
            let mean = super::sine_year::day(44.0, day as f64, None);
            Day { temperature: mean.temperature + if day > cut { warmer } else { 0.0 }, ..mean }
        };
        Weather::series(Date::new(2017, 1, 1).unwrap(), (1..=365).map(of).collect(), None).unwrap()
    };
    let (usual, other, all) = (days(0.0), days(15.0), ids(400));
    let at = |weather: &Weather, day: f64| population(&settings, weather, 3, &all).at(day);
    assert!(at(&usual, cut as f64) == at(&other, cut as f64));
    assert!(at(&usual, cut as f64 + 20.0) != at(&other, cut as f64 + 20.0));
}

#[test]
fn every_spring_brings_new_leaves_and_pushes_off_the_old() {
    let (settings, weather, all) = (species(), years(), ids(2_000));
    let mut leaves = population(&settings, &weather, 2, &all);
    let names = leaves.names().to_vec();
    let mut share = |day: f64, state: &str| {
        let number = names.iter().position(|name| name == state).unwrap() as u16;
        leaves.at(day).states.iter().filter(|s| **s == number).count() as f64 / 2_000.0
    };
    // Years begin with day 0, 365 and 730.
    for year in [0.0, 365.0, 730.0] {
        assert!(share(year + 172.0, "green") + share(year + 172.0, "flush") == 1.0);
        assert!(share(year + 60.0, "fallen") + share(year + 60.0, "brown") == 1.0);
        assert!(share(year + 60.0, "brown") > 0.01 && share(year + 171.0, "brown") == 0.0);
    }
}

#[test]
fn outside_leaves_turn_first_and_the_leaves_of_a_shoot_together() {
    let (mut settings, weather) = (species(), years());
    settings.states.get_mut("green").unwrap().stages = 12;
    settings.crown.shoot = 0.5;
    let all: Vec<u64> = (0..40_000).collect();
    let mut leaves = population(&settings, &weather, 2, &all);
    let names = leaves.names().to_vec();
    let green = names.iter().position(|name| name == "green").unwrap();
    let days: Vec<f64> = (230..330).map(f64::from).collect();
    let laws = leaves.laws(&days);
    let day = days[laws.iter().position(|law| law.expected[green] < 0.5).unwrap()];
    let turned: Vec<f64> =
        leaves.at(day).states.iter().map(|state| f64::from(u8::from(usize::from(*state) != green))).collect();
    let crown = Crown::new(&settings.crown, Some(30.0), None).unwrap();
    let exposures: Vec<f64> = all.iter().map(|&id| crown.exposure(&position(id))).collect();
    let mean = |wanted: &dyn Fn(f64) -> bool| {
        let of: Vec<f64> = turned.iter().zip(&exposures).filter(|(_, e)| wanted(**e)).map(|(t, _)| *t).collect();
        of.iter().sum::<f64>() / of.len() as f64
    };
    assert!(mean(&|exposure| exposure > 0.75) > 2.0 * mean(&|exposure| exposure < 0.35));
    // Beyond exposure: what is left when each class of exposure has its mean taken away.
    let class = |exposure: f64| (exposure * 20.0) as usize;
    let means: Vec<f64> = (0..=20).map(|number| mean(&|exposure| class(exposure) == number)).collect();
    let rest: Vec<f64> = turned.iter().zip(&exposures).map(|(t, e)| t - means[class(*e)]).collect();
    let variance = rest.iter().map(|r| r * r).sum::<f64>() / rest.len() as f64;
    let pairs: Vec<f64> = rest.chunks(8).flat_map(|shoot| (1..8).map(|i| shoot[0] * shoot[i])).collect();
    let correlation = pairs.iter().sum::<f64>() / pairs.len() as f64 / variance;
    assert!(correlation > 0.3, "{correlation}");
}

#[test]
fn day_zero_and_before_all_leaves_are_as_they_started() {
    let (settings, weather) = (branching(), constant());
    for day in [0.0, -3.0, f64::NAN] {
        let mut leaves = population(&settings, &weather, 1, &ids(20));
        let sample = leaves.at(day);
        assert!(sample.states.iter().all(|&state| state == 0) && sample.since.iter().all(|&since| since == 0.0));
        assert_eq!(leaves.laws(&[0.0])[0].expected, [1.0, 0.0, 0.0, 0.0]);
    }
}

#[test]
fn extreme_times_and_half_lives_end_in_the_law() {
    let all = ids(4_000);
    let weather = constant();
    // A leaf that must have fallen, at any time that can be written.
    let mut last = population(&line(&[1e-9, 1e9]), &weather, 1, &ids(50));
    assert!(last.laws(&[1e12])[0].expected.iter().zip([0.0, 0.0, 1.0]).all(|(share, end)| (share - end).abs() < 1e-12));
    // Returns without end.
    let fast = returning(1e-9, 3e-9);
    for day in [1000.0, 1e12] {
        let sample = population(&fast, &weather, 4, &all).at(day);
        assert_eq!(sample.from_law, 4_000);
        assert!(chi_square(&sample.states, &[0.25, 0.75]) < CRITICAL_ONE);
        assert!(sample.since.iter().all(|&since| since > day * 0.999 && since <= day));
    }
    last.keep();
    assert!(last.at(1e12).states.iter().all(|state| *state > 0));
}

#[test]
fn a_chain_that_returns_within_days_keeps_its_law_in_a_years_weather() {
    let mut settings = returning(1e-3, 3e-3);
    settings.gate = Gate::None;
    let weather = years();
    let all = ids(20_000);
    let mut leaves = population(&settings, &weather, 4, &all);
    let sample = leaves.at(10.5);
    assert_eq!(sample.from_law, 20_000);
    let law = leaves.laws(&[10.5]);
    assert!((law[0].expected[0] - 0.25).abs() < 1e-12);
    assert!(chi_square(&sample.states, &law[0].expected) < CRITICAL_ONE);
}

#[test]
fn one_state_and_sixty_four_are_chains_too() {
    let one = settings(&[("a", State::default())]);
    assert_eq!(population(&one, &constant(), 1, &ids(3)).at(5.0).states, [0, 0, 0]);
    let names: Vec<String> = (0..64).map(|number| format!("s{number:02}")).collect();
    let states = names.iter().enumerate().map(|(number, name)| {
        let next = names.get(number + 1).map(|next| (next.as_str(), 1.0));
        (name.as_str(), state(0.5, next.as_slice()))
    });
    let long = settings(&states.collect::<Vec<_>>());
    let mut leaves = population(&long, &constant(), 1, &ids(20_000));
    let law = leaves.laws(&[20.0]);
    let moments = leaves.at(20.0);
    // Poisson with mean 20 ln 2 / 0.5: its mean is that of the numbers of the states, but for 1e-9 beyond the last.
    let mean = moments.states.iter().map(|state| f64::from(*state)).sum::<f64>() / 20_000.0;
    let poisson = 20.0 * std::f64::consts::LN_2 / 0.5;
    assert!((mean - poisson).abs() < 0.2);
    let exact: f64 = law[0].expected.iter().enumerate().map(|(number, share)| number as f64 * share).sum();
    assert!((exact - poisson).abs() < 1e-7, "{}", exact - poisson);
}

#[test]
fn one_thread_and_many_agree() {
    let (settings, weather, all) = (species(), years(), ids(2_000));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut leaves = population(&settings, &weather, 3, &all);
            (leaves.at(281.0), leaves.laws(&[281.0]))
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn waiting_times_are_exponential() {
    let settings = line(&[10.0]);
    let weather = constant();
    // Kolmogorov's distance; 1.95 / sqrt(n) is exceeded once in a thousand samples.
    let mut since = population(&settings, &weather, 1, &ids(50_000)).at(1e6).since;
    since.sort_unstable_by(f64::total_cmp);
    let rate = std::f64::consts::LN_2 / 10.0;
    let distance = |(rank, day): (usize, &f64)| (rank as f64 / 50_000.0 - (1.0 - exp(-rate * day))).abs();
    assert!(since.iter().enumerate().map(distance).fold(0.0, f64::max) < 1.95 / 50_000f64.sqrt());
}

mod paper {
    use super::*;

    fn stepped(settings: Settings, step: f64) -> Settings {
        Settings { mode: Mode::Paper, step, ..settings }
    }

    /// Five states in a row with half-lives of 10, 8, 6 and 5 days.
    fn row() -> Settings {
        line(&[10.0, 8.0, 6.0, 5.0])
    }

    #[test]
    fn a_days_step_is_off_by_its_known_error_after_thirty_days_and_the_order_is_one() {
        let weather = constant();
        let error = |step: f64| {
            let settings = stepped(row(), step);
            population(&settings, &weather, 1, &[1]).step_error(30.0).unwrap()
        };
        assert!((error(1.0) - 0.033).abs() < 0.001, "{}", error(1.0));
        for step in [0.5, 0.25, 0.125] {
            assert!((error(step) / error(step / 2.0) - 2.0).abs() < 0.1);
        }
    }

    #[test]
    fn leaves_follow_the_papers_own_law() {
        let (settings, weather) = (stepped(branching(), 10.0), constant());
        let course = course::Course::new(&settings, &weather, 0.0);
        let law = law::constant_steps(&course, 10.0, 3.0).row(4, 0, 3.0);
        for seed in [1, 2, 3] {
            let sample = population(&settings, &weather, seed, &ids(100_000)).at(30.0);
            assert!(chi_square(&sample.states, &law) < CRITICAL);
        }
    }

    #[test]
    fn in_a_years_weather_too() {
        let mut settings = stepped(species(), 2.5);
        settings.coherence = 0.0;
        let weather = years();
        let course = course::Course::new(&settings, &weather, 0.0);
        let odds = exposure::Odds::new(&settings, &course.chain.names);
        for day in [120.0, 280.0, 480.0, 655.0] {
            let sample = population(&settings, &weather, 6, &ids(20_000)).at(day);
            let steps = ((day - course.first) / 2.5).floor();
            let law = law::stepped(&course, &odds, 2.5, steps);
            assert!((law.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(chi_square(&sample.states, &law) < CRITICAL_NINE, "day {day}");
        }
    }

    #[test]
    fn steps_beyond_those_followed_keep_their_law() {
        let (settings, weather) = (stepped(line(&[1e3]), 1.0), constant());
        let sample = population(&settings, &weather, 4, &ids(2_000)).at(3000.0);
        assert!(sample.from_law > 500);
        assert!(chi_square(&sample.states, &[0.125, 0.875]) < CRITICAL_ONE);
    }
}

mod moments {
    use super::*;

    #[test]
    fn the_south_has_its_autumn_in_april_and_a_series_from_july_the_autumn_that_follows() {
        let settings = species();
        let south = Weather::mean_years(-42.0, None, Date::new(2017, 1, 1).unwrap(), 380);
        let leaves = population(&settings, &south, 1, &ids(300));
        let day = |moment| leaves.day_of(moment).unwrap();
        assert!((85.0..160.0).contains(&day(Moment::HalfBare)), "{}", day(Moment::HalfBare));
        assert!(day(Moment::Summer) < 40.0 && (250.0..353.0).contains(&day(Moment::Flush)));
        let of = |day: i64| super::sine_year::day(44.0, day as f64, None);
        let july = Weather::series(Date::new(2017, 7, 1).unwrap(), (182..700).map(of).collect(), None).unwrap();
        let half = population(&settings, &july, 1, &ids(300)).day_of(Moment::HalfBare).unwrap();
        assert!((60.0..150.0).contains(&half), "{half}");
    }

    #[test]
    fn a_series_that_begins_in_may_begins_in_leaf_and_stays_so() {
        let settings = species();
        let of = |day: i64| super::sine_year::day(44.0, day as f64, None);
        let may = Weather::series(Date::new(2017, 5, 1).unwrap(), (121..500).map(of).collect(), None).unwrap();
        let mut leaves = population(&settings, &may, 1, &ids(300));
        leaves.remember();
        let sample = leaves.at(80.0);
        assert!(sample.since.iter().all(|since| *since == 0.0) && sample.shed.is_empty());
    }

    #[test]
    fn they_come_in_the_order_of_the_year() {
        let (settings, weather) = (species(), years());
        let order =
            [Moment::Flush, Moment::Summer, Moment::FirstColour, Moment::Peak, Moment::HalfBare, Moment::Winter];
        let leaves = population(&settings, &weather, 1, &ids(300));
        let days: Vec<f64> = order.iter().map(|moment| leaves.day_of(*moment).unwrap()).collect();
        assert!(days.is_sorted_by(|a, b| a < b), "{days:?}");
        let fallen = leaves.names().iter().position(|name| name == FALLEN).unwrap();
        let bare = |day: f64| leaves.laws(&[day])[0].expected[fallen];
        assert!(bare(days[4]) >= 0.5 && bare(days[4] - 1.0) < 0.5);
        assert_eq!(population(&settings, &constant(), 1, &ids(3)).day_of(Moment::Peak), None);
    }
}
