//! What a leaf costs in a frame of a film through a year: `cargo bench --bench season`, or with a number for as many leaves.
//!
//! The bound is a microsecond a leaf and frame on one core. A run of 365 days, one frame a day, of a red maple in the mean year of 42.5 °N;
//! frames alone, each found without the others; and the exact shares of all frames.

use leafseason::base::calendar::Date;
use leafseason::base::random::hash;
use leafseason::season::{Crown, Population, Position, Settings, Weather};
use std::time::Instant;

#[derive(serde::Deserialize)]
struct Species {
    season: Settings,
}

fn population(settings: &Settings, weather: &Weather, leaves: u64) -> Population {
    let mut population = Population::new(settings, weather, 1);
    let crown = Crown::new(&settings.crown, Some(30.0), None);
    let part = |id: u64, salt: u64| hash(id, salt) as f64 / u64::MAX as f64;
    let leaf = |id: u64| {
        let (height, distance) = (3.0 + 9.0 * part(id, 1), 4.0 * part(id, 2));
        (hash(id, 3), Position { height, distance, limb: id % 40, shoot: id / 6 })
    };
    population.add(None, crown.as_ref(), (0..leaves).map(leaf));
    population
}

fn main() {
    let leaves = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(1_000_000);
    let text = leafseason::species::text("red-maple").expect("a built-in species");
    let species: toml::Table = text.parse().expect("a table");
    let species: Species = species.try_into().expect("a season");
    let origin = Date::new(2017, 1, 1).expect("a date");
    let weather = Weather::mean_years(42.5, None, origin, 366);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let start = Instant::now();
        let mut film = population(&species.season, &weather, leaves);
        film.keep();
        let added = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let fallen: usize = (0..365).map(|day| film.at(f64::from(day)).states.len()).sum();
        let run = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let days: Vec<f64> = (0..365).map(f64::from).collect();
        let laws = film.laws(&days).len();
        let law = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let mut alone = population(&species.season, &weather, leaves);
        let one = alone.at(290.0).states.len();
        let single = start.elapsed().as_secs_f64();
        println!("{leaves} leaves, 365 frames, one core ({fallen} states, {laws} laws, {one} leaves alone)");
        println!("leaves added once               {added:8.3} s");
        println!(
            "film                            {run:8.3} s  {:8.4} us a leaf and frame",
            run * 1e6 / (365.0 * leaves as f64)
        );
        println!("exact shares of 365 frames      {law:8.3} s");
        println!("day 290 alone, with its leaves  {single:8.3} s  {:8.4} us a leaf", single * 1e6 / leaves as f64);
    });
}
