//! A chain through the days of the weather: rates and chances of every day, and their running sums, from which each leaf
//! reads when its thresholds are spent.
//!
//! A piece is a day, over which rates are constant; in a constant climate one piece lasts for ever. Rates here are those of a leaf
//! of mean speed.

use super::chain::{Chain, Place};
use super::settings::{Gate, Mode, Settings};
use super::weather::{Day, Weather};
use super::{BUD, FALLEN};
use serde::Serialize;

/// Days of the growing year: the equinox from which spring warmth is summed, and the longest day, on which the last bud opens.
pub(super) const EQUINOX: i64 = 82;
pub(super) const LONGEST_DAY: i64 = 172;
/// A series that begins after this day of the growing year and before `LATE` begins in leaf.
const LATEST_BUD: i64 = 101;
const LATE: i64 = 335;
/// The days of the growing year from which summer's warmth is judged: 1 May to 31 August.
const SUMMER: std::ops::RangeInclusive<i64> = 121..=243;
/// Kelvin of summer's warmth that count at most.
const MOST_WARMTH: f64 = 3.0;

/// A spring within the weather: when buds may open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Spring {
    /// The growing year.
    pub year: i64,
    /// The first piece at or after the equinox.
    pub begin: usize,
    /// The piece of the longest day, at whose beginning the last buds open; none when the weather ends before.
    pub end: Option<usize>,
}

/// A species' chain through the weather, for one tree's timing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Course {
    pub chain: Chain,
    /// The state in which all leaves begin, at the beginning of the first piece.
    pub start: u16,
    /// The growing year in which they begin; 0 in a constant climate.
    pub year: i64,
    /// The state `bud`, whose targets open in spring; none where there are no buds or no years.
    pub bud: Option<u16>,
    /// The state `fallen`.
    pub fallen: Option<u16>,
    pub springs: Vec<Spring>,
    /// The day on which the first piece begins.
    pub first: f64,
    /// Pieces outside the corners of the climate.
    pub clamped: usize,
    /// Rate of each stage: of state s in piece p at `p * states + s`, 1/day.
    rates: Vec<f64>,
    /// Number of each state's first edge; edges are (state, target) pairs in the chain's order.
    edges: Vec<usize>,
    /// Chances of the edges, piece after piece.
    chances: Vec<f64>,
    /// Sums of rates: of state s up to the beginning of piece p at `s * (pieces + 1) + p`.
    hazards: Vec<f64>,
    /// Sums of the rate at which buds open, up to the beginning of each piece.
    opening: Vec<f64>,
}

impl Course {
    /// A chain through the weather, on a tree whose autumn begins at days longer by `shift` hours.
    #[must_use]
    pub fn new(settings: &Settings, weather: &Weather, shift: f64) -> Self {
        let chain = Chain::new(settings, settings.mode == Mode::Exact);
        let bud = chain
            .number(BUD)
            .filter(|&bud| !weather.is_constant() && !chain.nodes[usize::from(bud)].targets.is_empty());
        let places: Vec<Place> = weather.days().iter().map(|day| chain.place(day)).collect();
        let gates = gates(settings, weather, shift);
        let mut edges = vec![0];
        chain.nodes.iter().for_each(|node| edges.push(edges[edges.len() - 1] + node.targets.len()));
        let (mut rates, mut chances, mut opens) = (Vec::new(), Vec::new(), Vec::new());
        let warmth = warmth(settings, weather);
        for ((place, gate), sum) in places.iter().zip(&gates).zip(&warmth) {
            for (state, node) in chain.nodes.iter().enumerate() {
                let rate = chain.rate(state, place) * if node.is_gated { *gate } else { 1.0 };
                rates.push(if bud == Some(state as u16) { 0.0 } else { rate });
                chances.extend(chain.chances(state, place));
            }
            let is_warm = sum.is_some_and(|sum| sum >= settings.flush_degree_days);
            let state = bud.filter(|_| is_warm).map(usize::from);
            opens.push(state.map_or(0.0, |bud| chain.rate(bud, place)));
        }
        let first_day = weather.growing_day(0);
        let is_bare = first_day.is_some_and(|(_, day)| day <= LATEST_BUD || day >= LATE);
        let start = bud.filter(|_| is_bare).unwrap_or(chain.start);
        let mut springs = bud.map_or_else(Vec::new, |_| springs(weather));
        if bud != Some(start) && springs.first().is_some_and(|spring| spring.begin == 0) {
            // The leaves that are there have opened in that spring.
            springs.remove(0);
        }
        let states = chain.nodes.len();
        let column = |state: usize| rates.iter().skip(state).step_by(states).copied();
        Self {
            start,
            year: first_day.map_or(0, |(year, _)| year),
            fallen: chain.number(FALLEN),
            springs,
            first: weather.first() as f64,
            clamped: places.iter().filter(|place| place.is_clamped).count(),
            hazards: (0..states).flat_map(|state| sums(column(state))).collect(),
            opening: sums(opens.iter().copied()),
            bud,
            chain,
            rates,
            edges,
            chances,
        }
    }

    /// How many states there are.
    pub fn states(&self) -> usize {
        self.chain.nodes.len()
    }

    /// How many pieces there are.
    pub fn pieces(&self) -> usize {
        self.opening.len() - 1
    }

    /// Whether one piece lasts for ever and no spring comes.
    pub fn is_constant(&self) -> bool {
        self.pieces() == 1 && self.springs.is_empty()
    }

    /// The sum of all states' rates over all days: a bound of the jumps of one leaf.
    pub fn most_jumps(&self) -> f64 {
        let fastest = |piece: usize| (0..self.states()).map(|state| self.rate(piece, state)).fold(0.0, f64::max);
        (0..self.pieces()).map(fastest).sum()
    }

    /// The piece of a day; days before the first and after the last are in those.
    pub fn piece(&self, day: f64) -> usize {
        // A cast of a float saturates.
        ((day - self.first) as usize).min(self.pieces() - 1)
    }

    /// The day on which a piece begins.
    pub fn begin(&self, piece: usize) -> f64 {
        self.first + piece as f64
    }

    /// Rate of each stage of a state in a piece, 1/day.
    pub fn rate(&self, piece: usize, state: usize) -> f64 {
        self.rates[piece * self.states() + state]
    }

    /// Targets of a state and their chances in a piece.
    pub fn targets(&self, piece: usize, state: usize) -> impl Iterator<Item = (u16, f64)> {
        let all = piece * self.edges[self.states()];
        let chances = &self.chances[all + self.edges[state]..all + self.edges[state + 1]];
        self.chain.nodes[state].targets.iter().map(|(target, _)| *target).zip(chances.iter().copied())
    }

    /// The first day on which the rate of a state has summed up to `need` since `from`.
    pub fn spent(&self, state: usize, from: f64, need: f64) -> f64 {
        let sums = &self.hazards[state * (self.pieces() + 1)..][..=self.pieces()];
        let rate = |piece: usize| self.rate(piece, state);
        self.reached(sums, rate, from, need)
    }

    /// The sum of a state's rate up to a day.
    pub fn hazard(&self, state: usize, day: f64) -> f64 {
        let piece = self.piece(day);
        self.hazards[state * (self.pieces() + 1) + piece] + self.rate(piece, state) * (day - self.begin(piece))
    }

    /// Rate at which buds open in a piece.
    pub fn opening_rate(&self, piece: usize) -> f64 {
        self.opening[piece + 1] - self.opening[piece]
    }

    /// The sum of the rate at which buds open, up to a day.
    pub fn opening_sum(&self, day: f64) -> f64 {
        let piece = self.piece(day);
        self.opening[piece] + self.opening_rate(piece) * (day - self.begin(piece))
    }

    /// The day on which a bud opens whose threshold is `need`.
    pub fn opened(&self, spring: &Spring, need: f64) -> f64 {
        let from = self.begin(spring.begin);
        let last = spring.end.map_or(f64::INFINITY, |end| self.begin(end));
        self.reached(&self.opening, |piece| self.opening_rate(piece), from, need).min(last)
    }

    fn reached(&self, sums: &[f64], rate: impl Fn(usize) -> f64, from: f64, need: f64) -> f64 {
        let piece = self.piece(from);
        let target = sums[piece] + rate(piece) * (from - self.begin(piece)) + need;
        let last = self.pieces() - 1;
        // The last piece whose beginning lies at or below the target, and goes on if it is the last of all.
        let piece = sums[..=last].partition_point(|sum| *sum <= target).saturating_sub(1);
        match rate(piece) {
            rate if rate > 0.0 => (self.begin(piece) + (target - sums[piece]) / rate).max(from),
            _ => f64::INFINITY,
        }
    }

    /// Which states a leaf can come to, by number.
    #[must_use]
    pub fn reachable(&self) -> Vec<bool> {
        let edges = self.edges[self.states()];
        let has_chance = |edge: usize| self.chances.iter().skip(edge).step_by(edges.max(1)).any(|chance| *chance > 0.0);
        let opens = self.opening[self.pieces()] > 0.0 || self.springs.iter().any(|spring| spring.end.is_some());
        let mut reached = vec![false; self.states()];
        let mut open: Vec<usize> = vec![usize::from(self.start)];
        open.extend(self.bud.filter(|_| opens).map(usize::from));
        while let Some(state) = open.pop() {
            if std::mem::replace(&mut reached[state], true) {
                continue;
            }
            let moves =
                self.hazards[state * (self.pieces() + 1) + self.pieces()] > 0.0 || self.bud == Some(state as u16);
            let targets = self.chain.nodes[state].targets.iter().enumerate().filter(|_| moves);
            let next = targets.filter(|(at, _)| has_chance(self.edges[state] + at));
            open.extend(next.map(|(_, (target, _))| usize::from(*target)));
        }
        if self.bud.is_some_and(|bud| self.start != bud) {
            // Buds of later years are not shown: a site stays as it was until its leaf comes.
            self.bud.into_iter().for_each(|bud| reached[usize::from(bud)] = false);
        }
        reached
    }
}

/// Running sums, compensated (Kahan 1965): a sum over many years keeps the digits of a day.
fn sums(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let (mut sum, mut lost) = (0.0, 0.0);
    let mut sums = vec![0.0];
    for value in values {
        let value: f64 = value - lost;
        let next = sum + value;
        lost = (next - sum) - value;
        sum = next;
        sums.push(sum);
    }
    sums
}

/// How far open the gate is on each day: 0 while leaves wait, 1 where the half-lives hold.
fn gates(settings: &Settings, weather: &Weather, shift: f64) -> Vec<f64> {
    if weather.is_constant() || settings.gate == Gate::None {
        return vec![1.0; weather.days().len()];
    }
    let (mut warmth, mut days, mut year) = (0.0, 0.0, None);
    let mut gate = |(at, day): (usize, &Day)| {
        let (this_year, date) = weather.growing_day(at)?;
        if year.replace(this_year) != Some(this_year) {
            (warmth, days) = (0.0, 0.0);
        }
        if SUMMER.contains(&date) {
            warmth += day.temperature - settings.summer_normal;
            days += 1.0;
        }
        // Leaves that are there when the weather begins are that spring's.
        let first_year = weather.growing_day(0).map(|(year, _)| year);
        let begin = if first_year == Some(this_year) { 0 } else { EQUINOX };
        if (begin..LONGEST_DAY).contains(&date) {
            return Some(0.0);
        }
        // The mean so far: what a leaf does never depends on days to come.
        let advance = if days > 0.0 { (warmth / days).clamp(-MOST_WARMTH, MOST_WARMTH) } else { 0.0 };
        let needed = settings.day_length + shift + settings.summer_advance * advance;
        Some(((needed - day.day_length?) / settings.day_length_span).max(0.0))
    };
    weather.days().iter().enumerate().map(|day| gate(day).unwrap_or(1.0)).collect()
}

/// The degree-days of each day since the equinox of its year; none outside spring.
fn warmth(settings: &Settings, weather: &Weather) -> Vec<Option<f64>> {
    let mut sum = 0.0;
    let of_day = |(at, day): (usize, &Day)| {
        let (_, date) = weather.growing_day(at)?;
        if !(EQUINOX..LONGEST_DAY).contains(&date) {
            sum = 0.0;
            return None;
        }
        sum += (day.temperature - settings.flush_base).max(0.0);
        Some(sum)
    };
    weather.days().iter().enumerate().map(of_day).collect()
}

/// The springs in the weather, in order.
fn springs(weather: &Weather) -> Vec<Spring> {
    let mut springs: Vec<Spring> = Vec::new();
    let mut before = None;
    for (at, (year, date)) in (0..weather.days().len()).filter_map(|at| Some((at, weather.growing_day(at)?))) {
        let is_spring = (EQUINOX..LONGEST_DAY).contains(&date);
        match (before, is_spring) {
            (None | Some(false), true) => springs.push(Spring { year, begin: at, end: None }),
            (Some(true), false) => springs.iter_mut().next_back().into_iter().for_each(|s| s.end = Some(at)),
            _ => {}
        }
        before = Some(is_spring);
    }
    springs
}

#[cfg(test)]
mod tests {
    use super::super::chain::tests::{branching, line};
    use super::*;
    use crate::base::calendar::Date;

    fn years() -> Weather {
        Weather::mean_years(45.0, None, Date::parse("2017-01-01").unwrap(), 900)
    }

    #[test]
    fn thresholds_are_spent_across_days_of_different_rates() {
        let mut settings = line(&[10.0]);
        settings.gate = Gate::None;
        let a = settings.states.get_mut("a").unwrap();
        a.half_life = Some(crate::base::settings::Corners::Each([1.0, 3.0, 1.0, 3.0]));
        let day = |temperature| Day { temperature, humidity: 0.6, day_length: Some(10.0) };
        let days = vec![day(0.0), day(25.0), day(25.0), day(0.0)];
        let weather = Weather::series(Date::parse("2017-10-01").unwrap(), days, None).unwrap();
        let course = Course::new(&settings, &weather, 0.0);
        let half = std::f64::consts::LN_2;
        // One half-life on the first day, a third on each of the next two.
        for (from, need, expected) in [
            (0.0, half, 1.0),
            (0.0, half * 4.0 / 3.0, 2.0),
            (0.5, half, 2.5),
            (0.0, half * 8.0 / 3.0, 4.0),
            (9.0, half, 10.0),
        ] {
            let found = course.spent(0, from, need);
            assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
        }
        assert!((course.hazard(0, 2.5) - half * 1.5).abs() < 1e-12);
    }

    #[test]
    fn the_gate_is_shut_from_the_equinox_to_the_longest_day_and_opens_with_short_days() {
        let weather = years();
        let gates = gates(&branching(), &weather, 0.0);
        let at = |date: &str| gates[(weather.day_of(Date::parse(date).unwrap()).unwrap() + 366.0) as usize];
        assert_eq!((at("2017-04-01"), at("2017-06-01"), at("2017-07-15")), (0.0, 0.0, 0.0));
        assert!(at("2017-10-01") > 0.3 && at("2017-12-01") > at("2017-11-01") && at("2018-01-15") > 1.0);
    }

    #[test]
    fn every_spring_has_its_year_and_its_end() {
        let weather = years();
        let springs = springs(&weather);
        let of = |spring: &Spring| {
            (spring.year, weather.date(weather.first() as f64 + spring.begin as f64).unwrap().to_string())
        };
        assert_eq!(
            springs.iter().map(of).collect::<Vec<_>>()[1..],
            [(2017, "2017-03-23".to_owned()), (2018, "2018-03-23".to_owned()), (2019, "2019-03-23".to_owned())]
        );
        assert!(
            springs.iter().all(|spring| spring.end.is_some_and(|end| end - spring.begin <= 91) || spring.year == 2019)
        );
    }

    #[test]
    fn a_warm_summer_opens_the_gate_earlier_and_only_so_far() {
        let settings = super::super::Settings { summer_advance: 0.1, ..branching() };
        let gate = |normal: f64| {
            let settings = super::super::Settings { summer_normal: normal, ..settings.clone() };
            gates(&settings, &years(), 0.0)[366 + 280]
        };
        let (cool, usual, hot, hotter) = (gate(40.0), gate(17.5), gate(-10.0), gate(-20.0));
        assert!(cool < usual && usual < hot && hot == hotter);
    }

    #[test]
    fn states_without_a_way_to_them_are_not_reachable() {
        let settings = super::super::Settings { start: "b".to_owned(), ..branching() };
        let course = Course::new(&settings, &Weather::constant(10.0, 0.5), 0.0);
        assert_eq!(course.reachable(), [false, true, true, true]);
    }
}
