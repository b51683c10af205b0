//! The chart of the shares of the leaf states against time, with the weather under it: the exact shares, in the states' own
//! colours.

use super::preparation::Prepared;
use crate::base::maths::linear_to_srgb8;
use crate::colour;
use crate::export::{self, ExportError};
use crate::plot::{Axis, Legend, Panel, Plot, Scale, Series, Style};
use crate::scene::Species;
use crate::scene::output::Chart;
use crate::season::{BUD, FALLEN, Weather};

/// Points of each curve at least.
const POINTS: u32 = 240;
/// Days that are shown around one day of a constant climate, at least.
const SPAN: f64 = 60.0;
/// States in the order in which leaves pass them, as far as they have usual names; others come between turning and brown.
const ORDER: [&str; 9] = [BUD, "flush", "green", "late-green", "turning", "yellow", "orange", "red", "purple"];
const LAST: [&str; 3] = ["copper", "brown", FALLEN];
/// Colours of what is no leaf, and of the weather.
const BARE: [u8; 3] = [205, 205, 200];
const BUDS: [u8; 3] = [120, 100, 90];
const WARMTH: [u8; 3] = [190, 70, 40];
const DAMP: [u8; 3] = [40, 100, 160];

/// The chart of a scene: what its name ends with, and its content.
///
/// # Errors
/// When it cannot be encoded.
pub fn chart(cell: &Prepared, form: Chart) -> Result<(&'static str, Vec<u8>), ExportError> {
    let plot = plot(cell);
    Ok(match form {
        Chart::Svg => ("svg", crate::plot::svg(&plot).into_bytes()),
        Chart::Png => ("png", export::png(&crate::plot::picture(&plot))?),
    })
}

fn plot(cell: &Prepared) -> Plot {
    let days = days(cell);
    let weather = cell.scene.weather.clone();
    let time = match weather.date(0.0) {
        Some(origin) => Axis { scale: Scale::Dates { origin }, ..Axis::default() },
        None => Axis { label: "time".to_owned(), unit: "d".to_owned(), ..Axis::default() },
    };
    let percent = Some([0.0, 100.0]);
    let y = |label: &str, unit: &str, range| Axis {
        label: label.to_owned(),
        unit: unit.to_owned(),
        range,
        ..Axis::default()
    };
    let of_weather = |label: &str, unit: &str, range, colour, value: fn(&crate::season::Day) -> f64| Panel {
        x: time.clone(),
        y: y(label, unit, range),
        share: 1.0,
        series: vec![Series::new(label, Style::Line, steps(&weather, &days, value)).coloured(colour)],
        legend: Legend::Absent,
        ..Panel::default()
    };
    let shares = Panel {
        x: time.clone(),
        y: y("share of leaves", "%", percent),
        share: 3.0,
        series: series(cell, &days),
        ..Panel::default()
    };
    let temperature = of_weather("temperature", "°C", None, WARMTH, |day| day.temperature);
    let humidity = of_weather("humidity", "%", percent, DAMP, |day| 100.0 * day.humidity);
    let title = cell.scene.species.iter().map(Species::label).collect::<Vec<_>>().join(", ");
    Plot { width: 1200, height: 900, title, panels: vec![shares, temperature, humidity], ..Plot::default() }
}

/// The days of the curves: over the frames, or around the day of a scene with one.
fn days(cell: &Prepared) -> Vec<f64> {
    let (time, weather) = (&cell.scene.time, &cell.scene.weather);
    let last = time.at(time.count().max(1.0) as i64 - 1);
    let (from, to) = match (time.is_single(), weather.is_constant()) {
        (false, _) => (time.at(0), last),
        (true, true) => (0.0, SPAN.max(2.0 * last)),
        (true, false) => (0.0, weather.end().min(last.max(365.0))),
    };
    let points = POINTS.max(((to - from).min(20_000.0) * 2.0) as u32);
    (0..=points).map(|point| from + (to - from) * f64::from(point) / f64::from(points)).collect()
}

/// The stacked shares of all states, what has fallen at the bottom.
fn series(cell: &Prepared, days: &[f64]) -> Vec<Series> {
    let laws = cell.seasons.laws_of(days);
    let rank = |name: &str| {
        let early = ORDER.iter().position(|known| *known == name);
        let late = LAST.iter().position(|known| *known == name).map(|place| 1000 + place);
        early.or(late).unwrap_or(ORDER.len())
    };
    let mut order: Vec<usize> = (0..cell.states.len()).collect();
    order.sort_by_key(|&state| std::cmp::Reverse(rank(&cell.states[state])));
    let has_leaves = |state: &usize| laws.iter().any(|law| law.expected[*state] > 1e-4);
    let one = |state: usize| {
        let points = days.iter().zip(&laws).map(|(day, law)| [*day, 100.0 * law.expected[state]]).collect();
        let name = cell.states[state].as_str();
        let series = Series::new(name, Style::Area, points);
        match ink(&cell.scene.species, name) {
            Some(ink) => series.coloured(ink),
            None => series,
        }
    };
    order.into_iter().filter(has_leaves).map(one).collect()
}

/// The colour of a state in the first species that has leaves of it; none for a state without a colour of its own.
fn ink(species: &[Species], state: &str) -> Option<[u8; 3]> {
    match state {
        FALLEN => return Some(BARE),
        BUD => return Some(BUDS),
        _ => {}
    }
    let colour = &species.iter().find(|one| one.colour.pigments.contains_key(state))?.colour;
    let seen = colour::appearance(&colour.contents(state), colour.table).reflected;
    Some(seen.map(|channel| linear_to_srgb8(channel as f32)))
}

/// A value of the weather over days, which changes from day to day.
fn steps(weather: &Weather, days: &[f64], value: fn(&crate::season::Day) -> f64) -> Vec<[f64; 2]> {
    days.iter().map(|&day| [day, value(&weather.days()[weather.number(day)])]).collect()
}
