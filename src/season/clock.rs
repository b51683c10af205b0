//! One leaf's history: the event clock of the exact chain, and the step-by-step rule of the paper.
//!
//! A leaf's draws are keyed by (seed, leaf, year, jump or step), so its state at a day is a pure function of (seed, leaf,
//! day): days may be asked for in any order and agree with each other. A [`Stay`] may be carried on from day to day, which is only
//! faster.

use super::course::Course;
use super::exposure::{Class, Odds};
use super::law::DayLaws;
use super::transition::Transition;
use crate::base::maths::exp;
use crate::base::random::{Purpose, Stream};

/// Jumps of one leaf in a year that are followed one by one. A season has fewer than ten; only chains that return can have more.
const MOST_JUMPS: u32 = 256;
/// Steps of one leaf in a constant climate that are followed one by one.
pub(super) const MOST_STEPS: u64 = 1000;
/// The event of what a bud opens into, and of a draw from a law: beyond any jump.
const OPENING: u64 = 0xFFFF;

/// A leaf in a state, from the day it entered it to the day it leaves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stay {
    /// Its state.
    pub state: u16,
    /// The state that it left for this one; its own for a leaf that has not changed yet.
    pub before: u16,
    /// The day on which it entered the state.
    pub since: f64,
    /// The day on which it leaves it; infinite for a state that lasts.
    pub until: f64,
    /// The day on which the bud of the next leaf opens at this site; infinite without one.
    pub closes: f64,
    /// When the leaf before it left this site, and in which state; none without one, or where it is not asked for.
    pub shed: Option<(f64, u16)>,
    /// Number of the spring whose leaf it is, from 1; 0 for the leaf of the beginning.
    spring: u32,
    /// Jumps that the leaf has made.
    jumps: u32,
    /// Whether it had more jumps than are followed, so that its state was drawn from the law of the rest.
    pub is_from_law: bool,
}

/// A leaf and its chain.
pub(super) struct Clock<'a> {
    pub course: &'a Course,
    pub odds: &'a Odds,
    pub seed: u64,
    pub leaf: u64,
    pub class: Class,
    pub speed: f64,
    /// Whether it is asked when the leaf of the year before left.
    pub sheds: bool,
}

impl Clock<'_> {
    /// The stay of a day. `known` is a stay of the same leaf on any day.
    pub fn at(&self, known: Option<Stay>, day: f64) -> Stay {
        let known = known.filter(|stay| stay.since <= day && !stay.is_from_law);
        let mut stay = known.unwrap_or_else(|| self.entered(day));
        while stay.until <= day && stay.jumps < MOST_JUMPS {
            stay = self.next(stay);
        }
        stay
    }

    /// The first stay of the leaf that its site bears on a day.
    fn entered(&self, day: f64) -> Stay {
        let springs = &self.course.springs;
        let piece = self.course.piece(day);
        let begun = springs.partition_point(|spring| spring.begin <= piece);
        for number in (1..=begun).rev() {
            let opened = self.opening(number);
            if opened <= day {
                return self.flushed(number, opened, self.left(number));
            }
        }
        self.settled(Stay { closes: self.opening(1), ..self.begun() })
    }

    /// The day on which the site's bud opens in a spring, from 1; infinite after the last.
    fn opening(&self, number: usize) -> f64 {
        match self.course.springs.get(number - 1) {
            Some(spring) if self.course.bud.is_some() => {
                let need = Stream::new(self.seed, Purpose::BudBreak, self.leaf, spring.year as u64).exponential();
                self.course.opened(spring, need)
            }
            _ => f64::INFINITY,
        }
    }

    /// When the leaf left that hung at the site before a spring, and in which state.
    fn left(&self, spring: usize) -> Option<(f64, u16)> {
        if !self.sheds {
            return None;
        }
        let mut stay = match spring - 1 {
            0 => self.settled(Stay { closes: self.opening(1), ..self.begun() }),
            before => self.flushed(before, self.opening(before), None),
        };
        while stay.until < stay.closes && stay.jumps < MOST_JUMPS {
            stay = self.next(stay);
        }
        self.pushed_off(&stay)
    }

    /// When the leaf of a stay leaves if none has fallen before its site's next bud opens, and in which state.
    fn pushed_off(&self, stay: &Stay) -> Option<(f64, u16)> {
        match stay.state {
            state if self.course.fallen == Some(state) => Some((stay.since, stay.before)),
            state if self.course.bud == Some(state) => None,
            state => Some((stay.closes, state)),
        }
        .filter(|_| self.sheds)
    }

    /// The leaf of a spring, out of its bud.
    fn flushed(&self, number: usize, day: f64, shed: Option<(f64, u16)>) -> Stay {
        let bud = self.course.bud.unwrap_or(self.course.start);
        let stay = Stay {
            state: bud,
            before: bud,
            since: day,
            until: f64::INFINITY,
            closes: self.opening(number + 1),
            shed,
            spring: number as u32,
            jumps: 0,
            is_from_law: false,
        };
        let targets = self.course.targets(self.course.piece(day), usize::from(bud));
        let state = self.drawn(&stay, OPENING, targets).unwrap_or(bud);
        self.settled(Stay { state, ..stay })
    }

    /// The stay with the day on which it ends.
    fn settled(&self, stay: Stay) -> Stay {
        let node = &self.course.chain.nodes[usize::from(stay.state)];
        if node.targets.is_empty() {
            return Stay { until: stay.closes, ..stay };
        }
        let event = self.event(&stay, u64::from(stay.jumps));
        let mut stream = Stream::new(self.seed, Purpose::WaitingTime, self.leaf, event);
        let need: f64 = (0..node.stages).map(|_| stream.exponential()).sum();
        let need = if node.is_gated { need / self.speed } else { need };
        let left = self.course.spent(usize::from(stay.state), stay.since, need);
        Stay { until: left.min(stay.closes), ..stay }
    }

    /// The stay after one that ends.
    fn next(&self, stay: Stay) -> Stay {
        if stay.until >= stay.closes {
            return self.flushed(stay.spring as usize + 1, stay.closes, self.pushed_off(&stay));
        }
        let state = self.target(&stay, stay.until, u64::from(stay.jumps));
        self.settled(Stay { state, before: stay.state, since: stay.until, jumps: stay.jumps + 1, ..stay })
    }

    /// The target of a jump on a day: the inverse of the cumulative chances at one number of the leaf's own.
    fn target(&self, stay: &Stay, day: f64, event: u64) -> u16 {
        let mut targets = Vec::with_capacity(8);
        let of_day = self.course.targets(self.course.piece(day), usize::from(stay.state));
        self.odds.weighed(self.class, of_day, &mut targets);
        self.drawn(stay, event, targets.into_iter()).unwrap_or(stay.state)
    }

    /// One of the targets of an event of a stay, at the number that belongs to it.
    fn drawn(&self, stay: &Stay, event: u64, targets: impl Iterator<Item = (u16, f64)>) -> Option<u16> {
        let uniform = Stream::new(self.seed, Purpose::Target, self.leaf, self.event(stay, event)).uniform();
        chosen(targets, uniform)
    }

    /// Number of an event of the year of a stay.
    fn event(&self, stay: &Stay, event: u64) -> u64 {
        let spring = (stay.spring as usize).checked_sub(1).and_then(|number| self.course.springs.get(number));
        let year = spring.map_or(self.course.year, |spring| spring.year);
        (year as u64) << 16 | event.min(OPENING)
    }

    /// A leaf that jumps too often to be followed, in a constant climate: it makes one jump more, and its state is drawn once
    /// from the exact law of the time that is left after that. The law of each day stays exact; only the
    /// path between two such days is no longer that of single jumps.
    pub fn resumed(&self, stay: Stay, law: &Transition, day: f64) -> Stay {
        let from = self.target(&stay, stay.until, u64::from(stay.jumps));
        let shares = law.row(self.course.states(), from, day - stay.until);
        Stay { until: day, ..self.lawful(Stay { since: stay.until, ..stay }, &shares, (from, day)) }
    }

    /// A stay in a state drawn from shares, on a day; `from` is for shares of nothing.
    fn lawful(&self, stay: Stay, shares: &[f64], (from, day): (u16, f64)) -> Stay {
        let uniform = Stream::new(self.seed, Purpose::Target, self.leaf, u64::MAX).uniform();
        let state = chosen(numbered(shares), uniform).unwrap_or(from);
        let since = self.aged(self.course.rate(0, usize::from(state)), day).max(stay.since);
        Stay { state, before: stay.state, since, is_from_law: true, ..stay }
    }

    /// Whether a stay stands after more jumps than are followed.
    pub fn is_lost(stay: &Stay, day: f64) -> bool {
        stay.jumps >= MOST_JUMPS && stay.until <= day
    }

    /// A leaf of a chain that returns too often for single jumps, in a year's weather: its state at the beginning of each day
    /// is drawn from the law of the day before, and that of `day` from the law of the part of its day.
    pub fn by_days(&self, laws: &DayLaws, day: f64) -> Stay {
        let piece = self.course.piece(day);
        let draw = |piece: usize, shares: &[f64], from: u16| {
            let uniform = Stream::new(self.seed, Purpose::Target, self.leaf, piece as u64).uniform();
            chosen(numbered(shares), uniform).unwrap_or(from)
        };
        let start = (0..piece).fold(self.course.start, |state, at| draw(at, laws.row(at, state), state));
        let state = draw(piece, laws.part(start), start);
        let since = self.aged(self.course.rate(piece, usize::from(state)), day);
        Stay {
            state,
            before: start,
            since: since.max(self.course.first),
            until: day,
            closes: f64::INFINITY,
            shed: None,
            spring: 0,
            jumps: 0,
            is_from_law: true,
        }
    }

    /// When a state was entered that was drawn from a law: its age is exponential when the chain has run for long.
    fn aged(&self, rate: f64, day: f64) -> f64 {
        let age = Stream::new(self.seed, Purpose::WaitingTime, self.leaf, u64::MAX).exponential() / rate;
        day - age
    }

    /// A leaf under equations (4) to (6): once a step it stays with chance exp(-rate step) or makes one jump. In a constant
    /// climate the state is drawn once from the law of the remaining steps after [`MOST_STEPS`].
    pub fn stepped(&self, law: Option<&Transition>, step: f64, count: f64) -> Stay {
        let course = self.course;
        let mut stay = Stay { closes: self.opening(1), ..self.begun() };
        let followed = if law.is_some() { count.min(MOST_STEPS as f64) } else { count } as u64;
        for number in 0..followed {
            let (from, to) = (course.first + number as f64 * step, course.first + (number + 1) as f64 * step);
            if stay.closes <= to {
                stay =
                    Stay { since: to, ..self.flushed(stay.spring as usize + 1, stay.closes, self.pushed_off(&stay)) };
                continue;
            }
            let state = usize::from(stay.state);
            let hazard = course.hazard(state, to) - course.hazard(state, from);
            if hazard > 0.0 && Stream::new(self.seed, Purpose::WaitingTime, self.leaf, number).uniform() >= exp(-hazard)
            {
                let mut targets = Vec::with_capacity(8);
                self.odds.weighed(self.class, course.targets(course.piece(from), state), &mut targets);
                let uniform = Stream::new(self.seed, Purpose::Target, self.leaf, number).uniform();
                let target = chosen(targets.iter().copied(), uniform).unwrap_or(stay.state);
                stay = Stay { state: target, before: stay.state, since: to, ..stay };
            }
        }
        let left = count - followed as f64;
        match law {
            Some(law) if left > 0.0 && course.rate(0, usize::from(stay.state)) > 0.0 => {
                self.lawful(stay, &law.row(course.states(), stay.state, left), (stay.state, count * step))
            }
            _ => stay,
        }
    }

    /// A leaf at the beginning of the first piece.
    fn begun(&self) -> Stay {
        let start = self.course.start;
        let closes = f64::INFINITY;
        let since = self.course.first;
        Stay {
            state: start,
            before: start,
            since,
            until: closes,
            closes,
            shed: None,
            spring: 0,
            jumps: 0,
            is_from_law: false,
        }
    }
}

/// The states with their shares.
fn numbered(shares: &[f64]) -> impl Iterator<Item = (u16, f64)> {
    shares.iter().enumerate().map(|(state, &share)| (state as u16, share))
}

/// The state whose share of the unit interval holds a uniform number. Rounding may leave a sliver above the last: it belongs to
/// the last possible one.
fn chosen(chances: impl Iterator<Item = (u16, f64)>, uniform: f64) -> Option<u16> {
    let (mut left, mut last) = (uniform, None);
    for (state, chance) in chances.filter(|(_, chance)| *chance > 0.0) {
        left -= chance;
        last = Some(state);
        if left < 0.0 {
            break;
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_chosen_has_a_chance(uniform in 0.0..1.0f64) {
            let state = chosen([(3, 0.0), (1, 1.0), (2, 0.0)].into_iter(), uniform);
            prop_assert_eq!(state, Some(1));
            prop_assert_eq!(chosen([(1, 0.3), (2, 0.7 - 1e-16)].into_iter(), 1.0 - f64::EPSILON / 2.0), Some(2));
            prop_assert_eq!(chosen(std::iter::empty(), uniform), None);
        }
    }
}
