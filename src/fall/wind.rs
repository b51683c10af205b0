//! The wind that a leaf falls through: a mean with a profile over the height, and gusts.
//!
//! Gusts are an Ornstein-Uhlenbeck process in both level directions: stationary, Gaussian, with correlation exp(-|dt|/T). Its
//! values at knots T/2 apart are drawn exactly by halving intervals (Levy's construction of Brownian motion, carried over):
//! the ends of blocks of 16 T are independent to within e^-16, and the middle of an interval of length 2 d given its ends
//! is normal with mean (a + b) / (2 cosh(d/T)) and variance tanh(d/T). Each value is keyed by its place in time, so any time is
//! reached in seven draws from nowhere. Between knots the process is taken at its mean given both knots, a sum of hyperbolic
//! sines, and integrated in closed form; what this leaves out is faster than a leaf follows.
//!
//! Hours differ: the gusts' variance in an hour is exponential with mean 1. A normal displacement with an exponential
//! variance follows Laplace's law, whose tails are exponential, as those of leaf litter about a tree are (Ferrari and Sugita
//! 1996; Molnar 2004).

use super::{DAY, Settings};
use crate::base::maths::{exp, log1p, pow, sincos};
use crate::base::random::{Purpose, Stream, hash};
use crate::base::vector::DVec2;
use std::f64::consts::TAU;

/// Exponent of the wind's profile over the height (open country; power law).
const PROFILE: f64 = 0.2;
/// Knots to a block: 16 T in halves, and how often that is halved.
const BLOCK: i64 = 1 << HALVINGS;
const HALVINGS: usize = 5;
/// Seconds that are calm or blustery together.
const SPELL: f64 = 3600.0;
/// Standard deviation of an hour's direction about that of its day, degrees: light winds meander (by 30 to 60 degrees below
/// 1 m/s, Hanna 1983).
const WANDERING: f64 = 50.0;
/// Knots that are integrated one by one; of a longer flight (slower than any leaf) the rest is left out.
const MOST_KNOTS: i64 = 4096;

/// The wind of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Wind {
    seed: u64,
    /// Mean speed, m/s.
    speed: f64,
    /// Where it blows to, a unit vector along x and z; by days and hours when absent.
    direction: Option<DVec2>,
    /// Standard deviation of gusts in each direction, m/s.
    deviation: f64,
    /// Correlation time, s.
    time: f64,
    /// Weight of both ends in the middle of an interval and the deviation about their mean, from blocks downwards.
    halves: [[f64; 2]; HALVINGS],
}

impl Wind {
    /// The wind of these settings.
    #[must_use]
    pub fn new(settings: &Settings, seed: u64) -> Self {
        let direction = settings.direction.map(|degrees| heading(degrees.to_radians()));
        let halves = std::array::from_fn(|level| {
            // half the interval in correlation times
            let e = exp(-((BLOCK >> level) as f64) * 0.25);
            [e / (1.0 + e * e), ((1.0 - e * e) / (1.0 + e * e)).sqrt()]
        });
        let (speed, deviation) = (settings.wind, settings.wind * settings.gustiness);
        Self { seed, speed, direction, deviation, time: settings.gust_time, halves }
    }

    /// Mean speed, m/s.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Where the wind blows to at a time (seconds): a unit vector along x and z. Without a direction of the scene each day has
    /// one by chance, about which that of the hours wanders.
    #[must_use]
    pub fn direction(&self, time: f64) -> DVec2 {
        self.direction.unwrap_or_else(|| {
            let number = |seconds: f64| (time / seconds).floor() as i64 as u64;
            let of_day = Stream::new(self.seed, Purpose::Gust, number(DAY), 1).range(0.0, TAU);
            let of_hour = Stream::new(self.seed, Purpose::Gust, number(SPELL), 2).normal();
            heading(of_day + of_hour * WANDERING.to_radians())
        })
    }

    /// How far the mean wind carries a leaf that lets go at `start` (seconds) and falls at `speed` m/s from `height`, when the
    /// share `done` of it is behind it.
    /// The leaf takes up the wind as it takes up its descent, dx/ds = U(y) / speed, so the integral over the profile U(y) ~
    /// y^0.2 is exact. The mean over the height is the scene's wind: all the way comes to U height / speed.
    #[must_use]
    pub fn carried(&self, start: f64, height: f64, speed: f64, done: f64) -> DVec2 {
        if self.speed <= 0.0 {
            return DVec2::zeros();
        }
        let share = 1.0 - pow((1.0 - done).clamp(0.0, 1.0), PROFILE + 1.0);
        self.direction(start) * (self.speed * height / speed * share)
    }

    /// How far gusts carry a leaf within `seconds` after the time `start` (seconds), from rest: a leaf takes up a gust
    /// within `response` seconds, the gust at the start thus by its integral less what it lags behind.
    #[must_use]
    pub fn gusted(&self, start: f64, seconds: f64, response: f64) -> DVec2 {
        if self.deviation <= 0.0 || seconds <= 0.0 {
            return DVec2::zeros();
        }
        let spell = (start / SPELL).floor() as i64 as u64;
        let strength = Stream::new(self.seed, Purpose::Gust, spell, 0).exponential().sqrt();
        let (first, way) = self.integral(start, start + seconds);
        let lag = first * (response * (1.0 - exp(-seconds / response)));
        (way - lag) * (self.deviation * strength)
    }

    /// The process of unit variance at the first of two times, and its integral from there to the second.
    fn integral(&self, from: f64, to: f64) -> (DVec2, DVec2) {
        let ((first, start), (last, end)) = (self.place(from), self.place(to));
        let last = last.min(first + MOST_KNOTS);
        let (mut value_at_start, mut sum) = (DVec2::zeros(), DVec2::zeros());
        let weights = self.weights(start);
        self.knots(first, last + 1, &mut |number, value| {
            if number - first < 2 {
                value_at_start += value * weights[(number - first) as usize];
            }
            // each knot weighs in the interval after it as the left one, in that before it as the right one
            let part = |knot: i64| if knot == last { end } else { 1.0 };
            let before = |knot: i64| if knot == first { self.areas(start) } else { [0.0; 2] };
            if number <= last {
                sum += value * (self.areas(part(number))[0] - before(number)[0]);
            }
            if number > first {
                sum += value * (self.areas(part(number - 1))[1] - before(number - 1)[1]);
            }
        });
        (value_at_start, sum)
    }

    /// The knot before a time, and the share of the interval that has passed.
    fn place(&self, time: f64) -> (i64, f64) {
        let place = time / (0.5 * self.time);
        (place.floor() as i64, place - place.floor())
    }

    /// Weights of both knots of an interval in the mean of the process within it.
    fn weights(&self, part: f64) -> [f64; 2] {
        let whole = sinh(0.5);
        [sinh(0.5 * (1.0 - part)) / whole, sinh(0.5 * part) / whole]
    }

    /// Integrals of the weights from the interval's beginning, seconds.
    fn areas(&self, part: f64) -> [f64; 2] {
        let whole = sinh(0.5);
        [self.time * (cosh(0.5) - cosh(0.5 * (1.0 - part))) / whole, self.time * (cosh(0.5 * part) - 1.0) / whole]
    }

    /// Tells the process at all knots from `first` to `last`.
    fn knots(&self, first: i64, last: i64, told: &mut impl FnMut(i64, DVec2)) {
        let mut block = first.div_euclid(BLOCK) * BLOCK;
        while block <= last {
            let ends = [self.draw(block, 0), self.draw(block + BLOCK, 0)];
            if block >= first {
                told(block, ends[0]);
            }
            self.between(0, [block, block + BLOCK], ends, [first, last], told);
            block += BLOCK;
        }
    }

    /// Tells the process at the knots of `wanted` between two whose values are known, by halves.
    fn between(
        &self,
        level: usize,
        [low, high]: [i64; 2],
        ends: [DVec2; 2],
        wanted: [i64; 2],
        told: &mut impl FnMut(i64, DVec2),
    ) {
        let Some([weight, deviation]) = self.halves.get(level).filter(|_| high > wanted[0] && low < wanted[1]) else {
            return;
        };
        let middle = low + (high - low) / 2;
        let value = (ends[0] + ends[1]) * *weight + self.draw(middle, 1) * *deviation;
        self.between(level + 1, [low, middle], [ends[0], value], wanted, told);
        if (wanted[0]..=wanted[1]).contains(&middle) {
            told(middle, value);
        }
        self.between(level + 1, [middle, high], [value, ends[1]], wanted, told);
    }

    /// Two standard normal numbers of a knot (Box and Muller 1958), of the ends of blocks (`kind` 0) or between them. By hashes,
    /// since a landing takes a dozen of them.
    fn draw(&self, knot: i64, kind: u64) -> DVec2 {
        let key = hash(hash(self.seed, Purpose::Gust as u64 * 2 + kind), knot as u64);
        let unit = |salt: u64| (hash(key, salt) >> 11) as f64 * (1.0 / (1u64 << 53) as f64);
        let radius = (-2.0 * log1p(-unit(1))).sqrt();
        let (sine, cosine) = sincos(TAU * unit(2));
        DVec2::new(radius * cosine, radius * sine)
    }
}

/// The unit vector along x and z of an angle from +x towards +z.
fn heading(angle: f64) -> DVec2 {
    let (sine, cosine) = sincos(angle);
    DVec2::new(cosine, sine)
}

fn sinh(x: f64) -> f64 {
    0.5 * (exp(x) - exp(-x))
}

fn cosh(x: f64) -> f64 {
    0.5 * (exp(x) + exp(-x))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wind() -> Wind {
        Wind::new(&Settings { wind: 2.0, ..Settings::default() }, 5)
    }

    #[test]
    fn knots_have_the_variance_and_the_correlation_of_the_process() {
        let wind = wind();
        let count = 60_000i64;
        let mut values = Vec::new();
        wind.knots(0, count - 1, &mut |_, value| values.push(value));
        assert_eq!(values.len(), count as usize);
        for lag in [0usize, 1, 2, 4, 8] {
            let pairs = values.iter().zip(&values[lag..]);
            let sum: f64 = pairs.map(|(a, b)| 0.5 * (a.x * b.x + a.y * b.y)).sum();
            let found = sum / (count as usize - lag) as f64;
            // the mean of 15,000 independent products
            assert!((found - exp(-0.5 * lag as f64)).abs() < 0.035, "{lag}: {found}");
        }
    }

    #[test]
    fn the_integral_is_that_of_the_values_from_any_start() {
        let wind = wind();
        for start in [0.0, 3.7, -911.3, 4.1e6 + 0.123] {
            let (steps, length) = (20_000, 23.4);
            let step = length / f64::from(steps);
            let middle = |number: i32| start + (f64::from(number) + 0.5) * step;
            let way = |from: f64, to: f64| wind.integral(from, to).1;
            let sum: DVec2 = (0..steps).map(|number| wind.integral(middle(number), middle(number)).0 * step).sum();
            assert!((sum - way(start, start + length)).norm() < 1e-5);
            let split = way(start, start + 9.1) + way(start + 9.1, start + length);
            assert!((split - way(start, start + length)).norm() < 1e-7);
        }
    }

    #[test]
    fn the_mean_wind_carries_by_height_over_speed() {
        let wind = wind();
        let all = wind.carried(0.0, 6.0, 1.2, 1.0);
        assert!((all.norm() - 2.0 * 6.0 / 1.2).abs() < 1e-12);
        // The lower half of the way lies in slower air.
        assert!(wind.carried(0.0, 6.0, 1.2, 0.5).norm() > 0.5 * all.norm());
    }

    #[test]
    fn without_a_direction_the_wind_blows_from_all_sides_in_turn_and_keeps_for_a_day() {
        let wind = Wind::new(&Settings { wind: 2.0, ..Settings::default() }, 5);
        let mean = |hours: std::ops::Range<u32>| {
            let count = f64::from(hours.end - hours.start);
            hours.map(|hour| wind.direction(3600.0 * (f64::from(hour) + 0.5))).sum::<DVec2>() / count
        };
        // 400 days of 24 hours: the mean of a day is exp(-wandering^2 / 2) = 0.68, that of all days small
        let days: f64 = (0..400).map(|day| mean(24 * day..24 * day + 24).norm()).sum::<f64>() / 400.0;
        assert!((days - 0.69).abs() < 0.04, "{days}");
        assert!(mean(0..9600).norm() < 0.1);
        let fixed = Wind::new(&Settings { direction: Some(90.0), ..Settings::default() }, 5);
        assert!((fixed.direction(1e6) - DVec2::y()).norm() < 1e-12);
    }

    #[test]
    fn still_air_has_no_gusts() {
        let still = Wind::new(&Settings { wind: 0.0, ..Settings::default() }, 5);
        assert_eq!((still.gusted(3.0, 9.0, 0.1), still.carried(0.0, 9.0, 1.0, 1.0)), (DVec2::zeros(), DVec2::zeros()));
    }
}
