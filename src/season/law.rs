//! The shares of the states over all leaves of a species, without sampling: the mean of the laws of their classes.

use super::course::Course;
use super::exposure::{Class, Odds};
use super::propagation::{Generator, Spread};
use super::transition::Transition;
use crate::base::maths::{exp, expm1};
use rayon::prelude::*;

/// Classes whose laws are found at once; fixed, so that sums are taken in the same order on any machine.
const AT_ONCE: usize = 16;

/// The law of one day.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Law {
    /// Share of each state, in the order of the chain's names.
    pub expected: Vec<f64>,
    /// Mean over the leaves of the variance of each state's indicator, p (1 - p) of the leaf's own law.
    pub variance: Vec<f64>,
}

/// How many leaves follow a course in a class.
pub(super) struct Weight<'a> {
    pub course: &'a Course,
    pub class: Class,
    pub leaves: f64,
}

/// The laws of days, which ascend, of all leaves together.
pub(super) fn laws(weights: &[Weight<'_>], odds: &Odds, days: &[f64]) -> Vec<Law> {
    let states = weights.first().map_or(0, |weight| weight.course.states());
    let empty = Law { expected: vec![0.0; states], variance: vec![0.0; states] };
    let mut laws = vec![empty; days.len()];
    let all: f64 = weights.iter().map(|weight| weight.leaves).sum();
    for chunk in weights.chunks(AT_ONCE) {
        let of = |weight: &Weight<'_>| class_law(weight.course, odds, weight.class, days);
        let rows: Vec<Vec<Vec<f64>>> = chunk.par_iter().map(of).collect();
        for (weight, rows) in chunk.iter().zip(rows) {
            let part = weight.leaves / all.max(1.0);
            for (law, row) in laws.iter_mut().zip(rows) {
                for ((expected, variance), share) in law.expected.iter_mut().zip(&mut law.variance).zip(row) {
                    *expected += part * share;
                    *variance += part * (share * (1.0 - share)).max(0.0);
                }
            }
        }
    }
    laws
}

/// The shares of one class of leaves on days, which ascend. Each day is reached from the beginning of its piece, so that what
/// is asked of other days changes no bit of it.
pub(super) fn class_law(course: &Course, odds: &Odds, class: Class, days: &[f64]) -> Vec<Vec<f64>> {
    let spread = Spread::new(&course.chain);
    let mut days = days.iter().copied().peekable();
    let mut rows = Vec::new();
    let unit = spread.unit(course.start);
    while days.next_if(|day| *day <= course.first).is_some() {
        rows.push(spread.shares(&unit));
    }
    if course.is_constant() {
        let generator = Generator::new(course, &spread, odds, class, 0);
        let longest = days.clone().fold(0.0, f64::max) - course.first;
        let law = generator.transition(longest);
        let start = spread.first(course.start) as u16;
        rows.extend(days.map(|day| spread.shares(&law.row(spread.places(), start, day - course.first))));
        return rows;
    }
    let mut sites = Sites { unopened: unit, opened: vec![0.0; spread.places()] };
    if course.bud.is_none() {
        std::mem::swap(&mut sites.unopened, &mut sites.opened);
    }
    for piece in 0..course.pieces() {
        let is_last = piece + 1 == course.pieces();
        sites.spring(course, &spread, piece);
        let moves = Moves::new(course, &spread, odds, class, piece);
        while let Some(day) = days.next_if(|day| is_last || *day < course.begin(piece + 1)) {
            let at_day = sites.advanced(&moves, day - course.begin(piece));
            rows.push(spread.shares(&at_day.sum()));
        }
        if days.peek().is_none() {
            break;
        }
        sites = sites.advanced(&moves, 1.0);
    }
    rows
}

/// The distribution of the sites whose bud has not opened in the growing year, and of those whose bud has.
struct Sites {
    unopened: Vec<f64>,
    opened: Vec<f64>,
}

impl Sites {
    /// At the equinox all buds are shut; on the longest day the last ones open.
    fn spring(&mut self, course: &Course, spread: &Spread, piece: usize) {
        let Some(bud) = course.bud else { return };
        if course.springs.iter().any(|spring| spring.begin == piece) {
            let opened = std::mem::replace(&mut self.opened, vec![0.0; spread.places()]);
            self.unopened.iter_mut().zip(opened).for_each(|(all, share)| *all += share);
        }
        if course.springs.iter().any(|spring| spring.end == Some(piece)) {
            let late: f64 = self.unopened.iter().sum();
            self.unopened.fill(0.0);
            for (target, chance) in course.targets(piece, usize::from(bud)) {
                self.opened[spread.first(target)] += late * chance;
            }
        }
    }

    fn advanced(&self, moves: &Moves, days: f64) -> Self {
        let is_empty = |row: &[f64]| row.iter().all(|share| *share == 0.0);
        if let Some(both) = moves.with_buds.as_ref().filter(|_| !is_empty(&self.unopened)) {
            let rows = [self.unopened.as_slice(), &self.opened].concat();
            let mut unopened = both.advanced(&rows, days);
            let opened = unopened.split_off(self.unopened.len());
            return Self { unopened, opened };
        }
        let own = |row: &Vec<f64>| {
            if moves.own.is_still() || is_empty(row) { row.clone() } else { moves.own.advanced(row, days) }
        };
        Self { unopened: own(&self.unopened), opened: own(&self.opened) }
    }

    fn sum(&self) -> Vec<f64> {
        self.unopened.iter().zip(&self.opened).map(|(a, b)| a + b).collect()
    }
}

/// What moves in a piece, without and with buds that open.
struct Moves {
    own: Generator,
    with_buds: Option<Generator>,
}

impl Moves {
    fn new(course: &Course, spread: &Spread, odds: &Odds, class: Class, piece: usize) -> Self {
        let own = Generator::new(course, spread, odds, class, piece);
        let opening = course.opening_rate(piece);
        let with_buds = course.bud.filter(|_| opening > 0.0).map(|bud| {
            let targets: Vec<(u16, f64)> = course.targets(piece, usize::from(bud)).collect();
            own.with_buds(spread, opening, &targets)
        });
        Self { own, with_buds }
    }
}

/// The laws of whole days for a chain that returns too often for single jumps, and of the part of one day.
pub(super) struct DayLaws {
    /// Each day's law, row after row.
    days: Vec<Vec<f64>>,
    part: Vec<f64>,
    states: usize,
}

impl DayLaws {
    /// The laws of a course up to a day.
    pub fn new(course: &Course, odds: &Odds, day: f64) -> Self {
        let spread = Spread::new(&course.chain);
        let piece = course.piece(day);
        let law = |piece: usize, days: f64| -> Vec<f64> {
            let law = Generator::new(course, &spread, odds, Class::MEAN, piece).transition(days);
            (0..spread.places()).flat_map(|state| law.row(spread.places(), state as u16, days)).collect()
        };
        let days = (0..piece).into_par_iter().map(|piece| law(piece, 1.0)).collect();
        Self { days, part: law(piece, day - course.begin(piece)), states: spread.places() }
    }

    /// The shares after a piece of a leaf that was in a state at its beginning.
    pub fn row(&self, piece: usize, state: u16) -> &[f64] {
        &self.days[piece][usize::from(state) * self.states..][..self.states]
    }

    /// The shares on the day that was asked for.
    pub fn part(&self, state: u16) -> &[f64] {
        &self.part[usize::from(state) * self.states..][..self.states]
    }
}

/// The law of equations (4) to (6), one jump a step at most, after `count` steps of `step` days from the beginning of the weather.
pub(super) fn stepped(course: &Course, odds: &Odds, step: f64, count: f64) -> Vec<f64> {
    let states = course.states();
    let unit = |state: u16| {
        let mut row = vec![0.0; states];
        row[usize::from(state)] = 1.0;
        row
    };
    if course.is_constant() {
        return constant_steps(course, step, count).row(states, course.start, count);
    }
    let (mut unopened, mut opened) = (unit(course.start), vec![0.0; states]);
    if course.bud.is_none() {
        std::mem::swap(&mut unopened, &mut opened);
    }
    let mut springs = course.springs.iter().peekable();
    for number in 0..count as u64 {
        let (from, to) = (course.first + number as f64 * step, course.first + (number + 1) as f64 * step);
        if let Some(spring) = springs.peek().filter(|spring| course.begin(spring.begin) < to) {
            let is_new = course.begin(spring.begin) >= from || number == 0;
            if is_new {
                unopened.iter_mut().zip(&mut opened).for_each(|(all, share)| *all += std::mem::take(share));
            }
            let flush = opened_share(course, spring, (from, to));
            let ends = spring.end.is_some_and(|end| course.begin(end) <= to);
            let leaving: f64 = unopened.iter().map(|share| share * flush).sum();
            let mut moved = one_step(course, odds, &opened, (from, to));
            let piece = course.piece(from);
            if let Some(bud) = course.bud {
                course
                    .targets(piece, usize::from(bud))
                    .for_each(|(to, chance)| moved[usize::from(to)] += leaving * chance);
            }
            let left: Vec<f64> = unopened.iter().map(|share| share * (1.0 - flush)).collect();
            (unopened, opened) = (one_step(course, odds, &left, (from, to)), moved);
            if ends {
                springs.next();
            }
        } else {
            (unopened, opened) =
                (one_step(course, odds, &unopened, (from, to)), one_step(course, odds, &opened, (from, to)));
        }
    }
    unopened.iter().zip(&opened).map(|(a, b)| a + b).collect()
}

/// Share of the shut buds that opens within a step.
fn opened_share(course: &Course, spring: &super::course::Spring, (from, to): (f64, f64)) -> f64 {
    if spring.end.is_some_and(|end| course.begin(end) <= to) {
        return 1.0;
    }
    let sum = |day: f64| course.opening_sum(day.max(course.begin(spring.begin)));
    -expm1(sum(from) - sum(to))
}

fn one_step(course: &Course, odds: &Odds, row: &[f64], (from, to): (f64, f64)) -> Vec<f64> {
    let mut next = vec![0.0; row.len()];
    let mut targets = Vec::new();
    for (state, share) in row.iter().enumerate().filter(|(_, share)| **share > 0.0) {
        let hazard = course.hazard(state, to) - course.hazard(state, from);
        next[state] += share * exp(-hazard);
        odds.weighed(Class::MEAN, course.targets(course.piece(from), state), &mut targets);
        targets.iter().for_each(|&(to, chance)| next[usize::from(to)] += share * -expm1(-hazard) * chance);
    }
    next
}

/// The law of a constant climate up to a day, for a chain without hidden stages.
pub(super) fn constant_law(course: &Course, odds: &Odds, day: f64) -> Transition {
    let spread = Spread::new(&course.chain);
    Generator::new(course, &spread, odds, Class::MEAN, 0).transition(day - course.first)
}

/// The law of steps in a constant climate.
pub(super) fn constant_steps(course: &Course, step: f64, most: f64) -> Transition {
    let states = 0..course.states();
    let rates: Vec<f64> = states.clone().map(|state| course.rate(0, state)).collect();
    let targets: Vec<Vec<(u16, f64)>> = states.map(|state| course.targets(0, state).collect()).collect();
    Transition::stepped(&rates, &targets, step, most)
}
