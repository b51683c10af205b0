//! All leaves of a species: which course each follows and in which class, and their states on a day.

use super::clock::{Clock, Stay};
use super::course::Course;
use super::exposure::{Class, Crown, Odds, Position};
use super::law::{self, DayLaws, Law, Weight};
use super::moment::{self, Moment};
use super::sample::Sample;
use super::settings::{Mode, Settings};
use super::transition::Transition;
use super::weather::Weather;
use crate::base::random::{Purpose, Stream};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Days short of a whole step by less than this share of the step count as reached: 0.3 / 0.1 is below 3.
const STEP_ROUNDING: f64 = 1e-9;
/// Classes of a tree's timing in one standard deviation, and deviations at most.
const TIMINGS: f64 = 4.0;
const LATEST_TREE: f64 = 3.0;
/// Jumps of a leaf through all of a year's weather above which it is followed by days instead.
const MOST_FOLLOWED: f64 = 100.0;

/// A leaf: its stable id, and by what it differs from others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    id: u64,
    course: u16,
    class: Class,
}

/// The leaves of a species in a weather.
pub struct Population {
    settings: Settings,
    weather: Weather,
    seed: u64,
    courses: Vec<Course>,
    /// Number of the course of each timing, in quarters of a standard deviation.
    timings: BTreeMap<i8, u16>,
    odds: Odds,
    leaves: Vec<Leaf>,
    /// Whether samples tell of the leaves of the year before.
    sheds: bool,
    /// The last stay of each leaf, carried on to the next day that is asked for; empty when none is kept.
    stays: Vec<Option<Stay>>,
}

impl Population {
    /// No leaves yet. The settings have passed [`check`](super::check).
    #[must_use]
    pub fn new(settings: &Settings, weather: &Weather, seed: u64) -> Self {
        let course = Course::new(settings, weather, 0.0);
        let odds = Odds::new(settings, &course.chain.names);
        let (settings, weather) = (settings.clone(), weather.clone());
        let timings = BTreeMap::from([(0, 0)]);
        Self {
            settings,
            weather,
            seed,
            courses: vec![course],
            timings,
            odds,
            leaves: Vec::new(),
            sheds: false,
            stays: Vec::new(),
        }
    }

    /// Adds the leaves of a tree, each with its id and position. `timing` is the key of a tree among others, which has a timing of
    /// its own; none for a tree that is alone. `crown` is the tree's nominal crown.
    pub fn add(&mut self, timing: Option<u64>, crown: Option<&Crown>, leaves: impl Iterator<Item = (u64, Position)>) {
        let course = self.course(timing);
        let class = |position: &Position| match self.settings.mode {
            Mode::Exact => Class::of(&self.settings, self.seed, crown, position),
            Mode::Paper => Class::MEAN,
        };
        let leaf = |(id, position): (u64, Position)| Leaf { id, course, class: class(&position) };
        let added: Vec<Leaf> = leaves.map(leaf).collect();
        self.leaves.extend(added);
    }

    fn course(&mut self, timing: Option<u64>) -> u16 {
        let spread = self.settings.tree_spread;
        let Some(key) = timing.filter(|_| spread > 0.0 && !self.weather.is_constant()) else { return 0 };
        let deviation = Stream::new(self.seed, Purpose::TreeTiming, key, 0).normal();
        let level = (TIMINGS * deviation.clamp(-LATEST_TREE, LATEST_TREE)).round() as i8;
        *self.timings.entry(level).or_insert_with(|| {
            let shift = spread * f64::from(level) / TIMINGS;
            self.courses.push(Course::new(&self.settings, &self.weather, shift));
            self.courses.len() as u16 - 1
        })
    }

    /// Names of the states, sorted.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.courses[0].chain.names
    }

    /// Which states any leaf can come to, in the order of the names.
    #[must_use]
    pub fn reachable(&self) -> Vec<bool> {
        self.courses[0].reachable()
    }

    /// Days of the weather that lie outside the corners of the chain, and how many there are.
    #[must_use]
    pub fn clamped(&self) -> (usize, usize) {
        (self.courses[0].clamped, self.courses[0].pieces())
    }

    /// The largest chance of a jump in one of the paper's steps at rates as high as any; 0 in the exact mode.
    #[must_use]
    pub fn largest_step(&self) -> f64 {
        let course = &self.courses[0];
        let rates =
            (0..course.pieces()).flat_map(|piece| (0..course.states()).map(move |state| course.rate(piece, state)));
        if self.settings.mode == Mode::Paper { self.settings.step * rates.fold(0.0, f64::max) } else { 0.0 }
    }

    /// Keeps each leaf's last stay from now on, about 64 bytes, so that the next day is found without its past.
    pub fn keep(&mut self) {
        self.stays = vec![None; self.leaves.len()];
    }

    /// Lets samples tell when and in which state the leaf of the year before left each site.
    pub fn remember(&mut self) {
        self.sheds = true;
    }

    /// How many leaves there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.leaves.len()
    }

    /// The state of every leaf on a day, in the order in which they were added; before the weather begins all are as they begin.
    #[must_use]
    pub fn at(&mut self, day: f64) -> Sample {
        let day = if day.is_nan() { 0.0 } else { day.clamp(f64::MIN, f64::MAX) };
        let day = day.max(self.courses[0].first);
        match self.settings.mode {
            Mode::Paper => self.stepped(day),
            Mode::Exact => self.exact(day),
        }
    }

    fn exact(&mut self, day: f64) -> Sample {
        let course = &self.courses[0];
        let is_restless = course.chain.returns();
        if is_restless && !course.is_constant() && course.most_jumps() > MOST_FOLLOWED {
            let laws: Vec<DayLaws> = self.courses.iter().map(|course| DayLaws::new(course, &self.odds, day)).collect();
            return self.each(|leaf, clock| clock.by_days(&laws[usize::from(leaf.course)], day));
        }
        // Only a chain that returns can be lost, and coherence does not go with it: one law serves all.
        let law = (is_restless && course.is_constant()).then(|| law::constant_law(course, &self.odds, day));
        let mut stays = std::mem::take(&mut self.stays);
        let shown = |clock: &Clock<'_>, stay: Stay| match &law {
            Some(law) if Clock::is_lost(&stay, day) => clock.resumed(stay, law, day),
            _ => stay,
        };
        let sample = if stays.len() == self.leaves.len() {
            let both = self.leaves.par_iter().zip(&mut stays).map(|(leaf, kept)| {
                let clock = self.clock(leaf);
                shown(&clock, *kept.insert(clock.at(*kept, day)))
            });
            Sample::of(&both.collect::<Vec<Stay>>())
        } else {
            self.each(|_, clock| shown(clock, clock.at(None, day)))
        };
        self.stays = stays;
        sample
    }

    fn stepped(&self, day: f64) -> Sample {
        let course = &self.courses[0];
        let count = self.steps(day);
        let law: Option<Transition> =
            course.is_constant().then(|| law::constant_steps(course, self.settings.step, count));
        self.each(|_, clock| clock.stepped(law.as_ref(), self.settings.step, count))
    }

    /// Whole steps of the paper's rule up to a day.
    fn steps(&self, day: f64) -> f64 {
        ((day - self.courses[0].first) / self.settings.step + STEP_ROUNDING).floor().clamp(0.0, f64::MAX)
    }

    fn each(&self, stay: impl Fn(&Leaf, &Clock<'_>) -> Stay + Sync) -> Sample {
        Sample::of(&self.leaves.par_iter().map(|leaf| stay(leaf, &self.clock(leaf))).collect::<Vec<Stay>>())
    }

    fn clock(&self, leaf: &Leaf) -> Clock<'_> {
        let course = &self.courses[usize::from(leaf.course)];
        let Leaf { id, class, .. } = *leaf;
        Clock { course, odds: &self.odds, seed: self.seed, leaf: id, class, speed: class.speed(), sheds: self.sheds }
    }

    /// The exact shares of the states over all leaves, without sampling, on days that ascend: the mean of the leaves' own laws in
    /// continuous time, also under the paper's rule: what that misses is [`step_error`](Self::step_error).
    #[must_use]
    pub fn laws(&self, days: &[f64]) -> Vec<Law> {
        let mut counts: BTreeMap<(u16, Class), u64> = BTreeMap::new();
        self.leaves.iter().for_each(|leaf| *counts.entry((leaf.course, leaf.class)).or_default() += 1);
        let weight = |(&(course, class), &count): (&(u16, Class), &u64)| Weight {
            course: &self.courses[usize::from(course)],
            class,
            leaves: count as f64,
        };
        let weights: Vec<Weight<'_>> = counts.iter().map(weight).collect();
        law::laws(&weights, &self.odds, days)
    }

    /// The first day from the beginning of the weather on, but not before day 0, on which a moment has come to these leaves; none
    /// when it does not come, as in a constant climate.
    #[must_use]
    pub fn day_of(&self, moment: Moment) -> Option<f64> {
        let from = self.courses[0].first.max(0.0);
        moment::day_of(self.names(), &self.weather, moment, from, |days| self.laws(days))
    }

    /// How far the law of the paper's rule lies from the exact one on a day, in total variation; none in the exact mode.
    #[must_use]
    pub fn step_error(&self, day: f64) -> Option<f64> {
        let course = &self.courses[0];
        (self.settings.mode == Mode::Paper && !self.leaves.is_empty()).then(|| {
            let stepped = law::stepped(course, &self.odds, self.settings.step, self.steps(day));
            let exact = law::class_law(course, &self.odds, Class::MEAN, &[day]);
            super::sample::total_variation(&stepped, &exact[0])
        })
    }
}
