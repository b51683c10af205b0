//! One leaf's history: the event clock of the exact chain, and the step-by-step rule of the paper.
//!
//! A leaf's draws are keyed by (seed, leaf, jump or step), so its state at a day is a pure function of (seed, leaf, day):
//! days may be asked for in any order and agree with each other.

use super::chain::Chain;
use super::transition::Transition;
use crate::base::maths::exp;
use crate::base::random::{Purpose, Stream};

/// Jumps of one leaf that are followed one by one. A season has fewer than ten; only chains that return can have more.
const MOST_JUMPS: u64 = 256;
/// Steps of one leaf that are followed one by one.
pub(super) const MOST_STEPS: u64 = 1000;

/// What a leaf is at the day asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moment {
    /// Its state.
    pub state: u16,
    /// The state that it left for this one; its own for a leaf that has not changed yet.
    pub before: u16,
    /// The day on which it entered the state.
    pub since: f64,
    /// Whether it had more jumps than are followed, so that its state was drawn from the law of the rest.
    pub from_law: bool,
}

/// A leaf under the exact chain. Each jump spends a unit-exponential threshold against the cumulative hazard, which
/// in a constant climate is rate x time, and draws its target.
///
/// After [`MOST_JUMPS`] jumps the state is drawn once from the exact law of the time that is left, by the inverse of
/// its cumulative shares at one number of the leaf's own. The law of each day stays exact; only the path between
/// two such days is no longer that of single jumps.
pub(super) fn exact(chain: &Chain, law: &Transition, seed: u64, leaf: u64, day: f64) -> Moment {
    let (mut state, mut before, mut since) = (chain.start, chain.start, 0.0);
    for jump in 0..MOST_JUMPS {
        let rate = chain.rates[usize::from(state)];
        if rate == 0.0 {
            return Moment { state, before, since, from_law: false };
        }
        let wait = Stream::new(seed, Purpose::WaitingTime, leaf, jump).exponential() / rate;
        if since + wait > day {
            return Moment { state, before, since, from_law: false };
        }
        since += wait;
        before = state;
        state = chain.target(state, Stream::new(seed, Purpose::Target, leaf, jump).uniform());
    }
    let (before, (state, age)) = (state, drawn(chain, law, seed, leaf, (state, day - since)));
    Moment { state, before, since: (day - age).max(since), from_law: true }
}

/// A leaf under equations (4) to (6): once a step it stays with chance exp(-rate step) or makes one jump. After
/// [`MOST_STEPS`] steps the state is drawn once from the law of the remaining steps.
pub(super) fn stepped(chain: &Chain, law: &Transition, seed: u64, leaf: u64, (step, count): (f64, f64)) -> Moment {
    let (mut state, mut before, mut since) = (chain.start, chain.start, 0.0);
    let followed = count.min(MOST_STEPS as f64) as u64;
    for number in 0..followed {
        let rate = chain.rates[usize::from(state)];
        if rate == 0.0 {
            return Moment { state, before, since, from_law: false };
        }
        if Stream::new(seed, Purpose::WaitingTime, leaf, number).uniform() >= exp(-rate * step) {
            before = state;
            state = chain.target(state, Stream::new(seed, Purpose::Target, leaf, number).uniform());
            since = (number + 1) as f64 * step;
        }
    }
    let left = count - followed as f64;
    if left == 0.0 || chain.rates[usize::from(state)] == 0.0 {
        return Moment { state, before, since, from_law: false };
    }
    let (before, (state, age)) = (state, drawn(chain, law, seed, leaf, (state, left)));
    Moment { state, before, since: (count * step - age).max(since), from_law: true }
}

/// A state drawn from the law of `time` after `from`, and the days since it was entered: exponential, as the age of a
/// state is when the chain has run for long (infinite for a state that lasts; the caller cuts it).
fn drawn(chain: &Chain, law: &Transition, seed: u64, leaf: u64, (from, time): (u16, f64)) -> (u16, f64) {
    let shares = law.row(chain.names.len(), from, time);
    let mut left = Stream::new(seed, Purpose::Target, leaf, u64::MAX).uniform();
    let mut state = from;
    for (number, &share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
        state = number as u16;
        left -= share;
        if left < 0.0 {
            break;
        }
    }
    let age = Stream::new(seed, Purpose::WaitingTime, leaf, u64::MAX).exponential();
    (state, age / chain.rates[usize::from(state)])
}
