//! The distribution over states of one class of leaves, advanced exactly over a time of constant rates.
//!
//! States with hidden stages are spread out, one place for each stage. Rates are uniformised (Jensen 1953): all terms are
//! non-negative, so nothing cancels; where so many events come that the sum would be long, a squared matrix is used.

use super::chain::Chain;
use super::course::Course;
use super::exposure::{Class, Odds};
use super::transition::Transition;
use crate::base::maths::exp;

/// Mean number of events up to which the Poisson sum is taken: its first term, e^-32, is far from underflow.
const MOST_EVENTS: f64 = 32.0;
/// Parts into which a longer time is cut before a matrix is squared instead.
const MOST_PARTS: f64 = 64.0;
/// The Poisson sum ends where the rest is below this.
const TAIL: f64 = 1e-18;

/// Where the stages of each state stand in a spread-out distribution.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    /// Place of the first stage of each state; ends with the number of places.
    firsts: Vec<usize>,
}

impl Spread {
    pub fn new(chain: &Chain) -> Self {
        let mut firsts = vec![0];
        for node in &chain.nodes {
            let stages = if node.targets.is_empty() { 1 } else { node.stages as usize };
            firsts.push(firsts[firsts.len() - 1] + stages);
        }
        Self { firsts }
    }

    pub fn places(&self) -> usize {
        self.firsts[self.firsts.len() - 1]
    }

    /// The place of a state's first stage.
    pub fn first(&self, state: u16) -> usize {
        self.firsts[usize::from(state)]
    }

    /// All leaves in the first stage of one state.
    pub fn unit(&self, state: u16) -> Vec<f64> {
        let mut row = vec![0.0; self.places()];
        row[self.first(state)] = 1.0;
        row
    }

    /// The shares of the states themselves.
    pub fn shares(&self, row: &[f64]) -> Vec<f64> {
        self.firsts.windows(2).map(|ends| row[ends[0]..ends[1]].iter().sum()).collect()
    }
}

/// The moves of a spread-out distribution within one piece.
#[derive(Clone, Debug, Default)]
pub(super) struct Generator {
    /// Rate at which each place is left, 1/day.
    rates: Vec<f64>,
    /// From where, to where, and with which chance.
    moves: Vec<(usize, usize, f64)>,
}

impl Generator {
    /// The moves of a class of leaves in a piece.
    pub fn new(course: &Course, spread: &Spread, odds: &Odds, class: Class, piece: usize) -> Self {
        let mut generator = Self { rates: vec![0.0; spread.places()], moves: Vec::new() };
        let (speed, mut targets) = (class.speed(), Vec::new());
        for (state, node) in course.chain.nodes.iter().enumerate() {
            let rate = course.rate(piece, state) * if node.is_gated { speed } else { 1.0 };
            if rate == 0.0 {
                continue;
            }
            let (first, end) = (spread.firsts[state], spread.firsts[state + 1]);
            generator.rates[first..end].fill(rate);
            generator.moves.extend((first + 1..end).map(|stage| (stage - 1, stage, 1.0)));
            odds.weighed(class, course.targets(piece, state), &mut targets);
            let jumps = targets.iter().map(|&(target, chance)| (end - 1, spread.first(target), chance));
            generator.moves.extend(jumps);
        }
        generator
    }

    /// Two copies of the places, the first for sites whose bud has not opened: those open at `rate` into `targets` of the second.
    pub fn with_buds(&self, spread: &Spread, rate: f64, targets: &[(u16, f64)]) -> Self {
        let places = self.rates.len();
        let mut both = Self::default();
        both.rates.extend(self.rates.iter().map(|own| own + rate));
        both.rates.extend(&self.rates);
        for &(from, to, chance) in &self.moves {
            both.moves.push((from, to, chance * self.rates[from] / (self.rates[from] + rate)));
            both.moves.push((places + from, places + to, chance));
        }
        for from in 0..places {
            let opening = rate / both.rates[from];
            both.moves.extend(targets.iter().map(|&(to, chance)| (from, places + spread.first(to), opening * chance)));
        }
        both
    }

    /// Whether nothing moves.
    pub fn is_still(&self) -> bool {
        self.moves.is_empty()
    }

    /// The distribution after `days`.
    pub fn advanced(&self, row: &[f64], days: f64) -> Vec<f64> {
        let fastest = self.rates.iter().copied().fold(0.0, f64::max);
        let mean = fastest * days;
        let is_at_rest = row.iter().zip(&self.rates).all(|(share, rate)| *share == 0.0 || *rate == 0.0);
        if mean <= 0.0 || is_at_rest {
            return row.to_vec();
        }
        if mean > MOST_EVENTS * MOST_PARTS {
            return self.squared(row, days);
        }
        let parts = (mean / MOST_EVENTS).ceil().max(1.0);
        let mut row = row.to_vec();
        for _ in 0..parts as u64 {
            row = self.poisson(&row, fastest, mean / parts);
        }
        row
    }

    /// The distribution after a time in which the fastest place has `mean` events.
    fn poisson(&self, row: &[f64], fastest: f64, mean: f64) -> Vec<f64> {
        let mut power = row.to_vec();
        let mut weight = exp(-mean);
        let mut sum: Vec<f64> = power.iter().map(|share| share * weight).collect();
        let mut next = vec![0.0; row.len()];
        let mut event = 0.0;
        while event < mean || weight > TAIL {
            event += 1.0;
            self.event(&power, fastest, &mut next);
            std::mem::swap(&mut power, &mut next);
            weight *= mean / event;
            sum.iter_mut().zip(&power).for_each(|(total, share)| *total += weight * share);
        }
        sum
    }

    /// One event of the uniformised chain.
    fn event(&self, row: &[f64], fastest: f64, into: &mut [f64]) {
        for ((into, share), rate) in into.iter_mut().zip(row).zip(&self.rates) {
            *into = share * (1.0 - rate / fastest);
        }
        for &(from, to, chance) in &self.moves {
            into[to] += row[from] * (self.rates[from] / fastest) * chance;
        }
    }

    fn squared(&self, row: &[f64], days: f64) -> Vec<f64> {
        let law = self.transition(days);
        let mut sum = vec![0.0; row.len()];
        for (from, share) in row.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            let part = law.row(row.len(), from as u16, days);
            sum.iter_mut().zip(&part).for_each(|(total, chance)| *total += share * chance);
        }
        sum
    }

    /// The law of times up to `longest` days.
    pub fn transition(&self, longest: f64) -> Transition {
        let mut targets = vec![Vec::new(); self.rates.len()];
        self.moves.iter().for_each(|&(from, to, chance)| targets[from].push((to as u16, chance)));
        Transition::exact(&self.rates, &targets, longest)
    }
}
