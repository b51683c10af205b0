//! The exact law of the chain: the distribution over states after a time or a number of steps, without sampling.
//!
//! A one-step matrix is squared again and again; a row is then advanced by the squares that make up the time. Everything
//! added is non-negative, so nothing cancels, and as long as a state is mostly kept its diagonal is taken as
//! 1 - (sum of the rest): the small chances of leaving keep their relative precision (the idea of Grassmann, Taksar and
//! Heyman 1985), where 2^k-fold squaring of a rounded diagonal would lose k digits. Eigenvectors are not used: equal
//! half-lives in line make the matrix defective.

use crate::base::maths::{exp, expm1};

/// Terms of the Poisson sum for a mean of at most 1: the rest is below 1e-17.
const POISSON_TERMS: usize = 19;
/// Half-lives of at least 1e-12 days and any finite day keep the number of squares below this.
const MOST_SQUARES: usize = 2100;

type Matrix = Vec<Vec<f64>>;

/// The transition law of a chain, prepared for times up to a given one.
#[derive(Clone, Debug)]
pub struct Transition {
    /// The time of the first square: days, or 1 step.
    unit: f64,
    /// `squares[k]` is the law of `unit` times 2^k.
    squares: Vec<Matrix>,
    /// Off-diagonal chances of one event of the uniformised chain, for times shorter than `unit`; empty for steps.
    uniformised: Matrix,
    /// Events per day of the uniformised chain.
    rate: f64,
}

impl Transition {
    /// The law of the continuous-time chain, P(t) = exp(Q t), for times up to `longest` days. `rates` are those at which states
    /// are left, 1/day; `targets` the states that may follow each, with their chances.
    #[must_use]
    pub fn exact(rates: &[f64], targets: &[Vec<(u16, f64)>], longest: f64) -> Self {
        let rate = rates.iter().copied().fold(0.0, f64::max);
        if rate == 0.0 {
            return Self { unit: f64::INFINITY, squares: Vec::new(), uniformised: Vec::new(), rate };
        }
        let uniformised = jumps(targets, |state| rates[state] / rate);
        // Half an event in one unit: the Poisson sum is short and every state is mostly kept.
        let unit = 0.5 / rate;
        let identity = (0..rates.len()).map(|state| unit_row(rates.len(), state));
        let first = identity.map(|row| poisson_row(&row, &uniformised, 0.5)).collect();
        Self { unit, squares: squares(first, longest / unit), uniformised, rate }
    }

    /// The law of equations (4) to (6) applied once a step of `step` days: at most one jump in each, for up to
    /// `most` steps. Times are counted in steps.
    #[must_use]
    pub fn stepped(rates: &[f64], targets: &[Vec<(u16, f64)>], step: f64, most: f64) -> Self {
        let mut first = jumps(targets, |state| -expm1(-rates[state] * step));
        for (state, row) in first.iter_mut().enumerate() {
            row[state] = exp(-rates[state] * step);
        }
        Self { unit: 1.0, squares: squares(first, most), uniformised: Vec::new(), rate: 0.0 }
    }

    /// The distribution over states after `time` (days, or whole steps), starting in `start`. Non-negative; sums to 1
    /// within a few roundings. Times beyond the one prepared for are cut to it.
    #[must_use]
    pub fn row(&self, states: usize, start: u16, time: f64) -> Vec<f64> {
        let mut row = unit_row(states, usize::from(start));
        let mut left = time;
        for (power, square) in self.squares.iter().enumerate().rev() {
            let span = self.unit * two_to(power);
            if left >= span {
                left -= span;
                row = advanced(&row, square);
            }
        }
        if left > 0.0 && !self.uniformised.is_empty() {
            row = poisson_row(&row, &self.uniformised, (self.rate * left).min(1.0));
        }
        row
    }
}

/// Two to a whole power, exact, up to infinity.
fn two_to(power: usize) -> f64 {
    libm::scalbn(1.0, power as i32)
}

fn unit_row(states: usize, state: usize) -> Vec<f64> {
    (0..states).map(|other| if other == state { 1.0 } else { 0.0 }).collect()
}

/// Chances of going from each state to each other one, given the chance of leaving; diagonals are 1 - that chance.
fn jumps(targets: &[Vec<(u16, f64)>], leaving: impl Fn(usize) -> f64) -> Matrix {
    let row = |state: usize| {
        let mut row = vec![0.0; targets.len()];
        for &(target, chance) in &targets[state] {
            row[usize::from(target)] += leaving(state) * chance;
        }
        row[state] = 1.0 - leaving(state);
        row
    };
    (0..targets.len()).map(row).collect()
}

/// The first matrix and its repeated squares, enough for `ratio` times the first one's time.
fn squares(first: Matrix, ratio: f64) -> Vec<Matrix> {
    let mut squares = vec![tidied(first)];
    while squares.len() < MOST_SQUARES && two_to(squares.len()) <= ratio {
        let last = &squares[squares.len() - 1];
        let square = last.iter().map(|row| advanced(row, last)).collect();
        squares.push(tidied(square));
    }
    squares
}

/// Makes the rows sum to 1 where that costs no precision: in the diagonal while it is the larger part, else by scaling.
fn tidied(mut matrix: Matrix) -> Matrix {
    for (state, row) in matrix.iter_mut().enumerate() {
        let left: f64 = row.iter().enumerate().filter(|(other, _)| *other != state).map(|(_, chance)| chance).sum();
        if left < 0.5 {
            row[state] = 1.0 - left;
        } else {
            let sum = left + row[state];
            row.iter_mut().for_each(|chance| *chance /= sum);
        }
    }
    matrix
}

fn advanced(row: &[f64], matrix: &Matrix) -> Vec<f64> {
    let mut next = vec![0.0; row.len()];
    advance(row, matrix, &mut next);
    next
}

/// The row after a step of a matrix, in place of what `next` held.
fn advance(row: &[f64], matrix: &Matrix, next: &mut [f64]) {
    next.fill(0.0);
    for (share, chances) in row.iter().zip(matrix).filter(|(share, _)| **share > 0.0) {
        for (sum, chance) in next.iter_mut().zip(chances) {
            *sum += share * chance;
        }
    }
}

/// The row after a Poisson number of events with mean `mean` (at most 1): uniformisation (Jensen 1953).
fn poisson_row(row: &[f64], uniformised: &Matrix, mean: f64) -> Vec<f64> {
    let (mut power, mut next) = (row.to_vec(), vec![0.0; row.len()]);
    let mut weight = exp(-mean);
    let mut sum: Vec<f64> = power.iter().map(|share| share * weight).collect();
    for term in 1..=POISSON_TERMS {
        advance(&power, uniformised, &mut next);
        std::mem::swap(&mut power, &mut next);
        weight *= mean / term as f64;
        for (total, share) in sum.iter_mut().zip(&power) {
            *total += weight * share;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::chain::tests::{branching, line, returning};
    use super::super::course::Course;
    use super::super::{Settings, Weather};
    use super::*;

    type Rates = (Vec<f64>, Vec<Vec<(u16, f64)>>, u16);

    /// Rates, targets and the start of a chain in a constant climate.
    fn chain(settings: &Settings) -> Rates {
        let course = Course::new(settings, &Weather::constant(12.0, 0.7), 0.0);
        let states = 0..course.states();
        let rates = states.clone().map(|state| course.rate(0, state)).collect();
        (rates, states.map(|state| course.targets(0, state).collect()).collect(), course.start)
    }

    fn row(settings: &Settings, time: f64) -> Vec<f64> {
        let (rates, targets, start) = chain(settings);
        Transition::exact(&rates, &targets, time).row(rates.len(), start, time)
    }

    fn close(settings: &Settings, time: f64, expected: &[f64]) {
        let found = row(settings, time);
        for (share, reference) in found.iter().zip(expected) {
            assert!((share - reference).abs() < 1e-12, "at {time} d: {found:?}, not {expected:?}");
        }
        assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn one_and_two_states_have_their_closed_forms() {
        close(&line(&[10.0]), 1.0, &[0.933_032_991_536_8, 0.066_967_008_463_19]);
        close(&line(&[10.0]), 10.0, &[0.5, 0.5]);
        close(&line(&[10.0]), 100.0, &[0.000_976_562_5, 0.999_023_437_5]);
        close(&returning(4.0, 12.0), 1.0, &[0.845_275_394_488_1, 0.154_724_605_511_9]);
        close(&returning(4.0, 12.0), 10.0, &[0.324_409_424_311, 0.675_590_575_689]);
        close(&returning(4.0, 12.0), 1000.0, &[0.25, 0.75]);
    }

    #[test]
    fn lines_have_their_reference_values() {
        close(&line(&[5.0, 5.0]), 1.0, &[0.870_550_563_296_1, 0.120_683_933_696_7, 0.008_765_503_007_16]);
        close(&line(&[5.0, 5.0]), 5.0, &[0.5, 0.346_573_590_28, 0.153_426_409_72]);
        close(&line(&[5.0, 5.0]), 20.0, &[0.0625, 0.173_286_795_14, 0.764_213_204_86]);
        close(&line(&[5.0, 20.0]), 1.0, &[0.870_550_563_296_1, 0.127_181_020_838_3, 0.002_268_415_865_581]);
        close(&line(&[5.0, 20.0]), 5.0, &[0.5, 0.454_528_553_671_6, 0.045_471_446_328_38]);
        close(&line(&[5.0, 20.0]), 20.0, &[0.0625, 0.583_333_333_333_3, 0.354_166_666_666_7]);
    }

    #[test]
    fn branches_have_their_reference_values() {
        let seven = [0.850_667_160_950_9, 0.076_219_525_338_4, 0.043_231_697_818_59, 0.029_881_615_892_15];
        close(&branching(), 7.0, &seven);
        close(&branching(), 30.0, &[0.5, 0.15, 0.108_75, 0.241_25]);
        close(&branching(), 90.0, &[0.125, 0.065_625, 0.058_652_343_75, 0.750_722_656_25]);
    }

    #[test]
    fn half_lives_six_orders_apart_keep_their_digits() {
        let stiff = line(&[1e-3, 1.0, 1e3]);
        close(&stiff, 1e-3, &[0.5, 0.499_806_899_890_3, 0.000_193_100_062_586_2, 4.707_089_438_651e-11]);
        close(&stiff, 1.0, &[0.0, 0.500_500_500_500_5, 0.499_306_898_696_7, 0.000_192_600_802_758_4]);
        close(&stiff, 100.0, &[0.0, 7.896_505_557_768e-31, 0.933_967_892_463_2, 0.066_032_107_536_8]);
    }

    #[test]
    fn no_time_is_the_identity() {
        assert_eq!(row(&branching(), 0.0), [1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn endless_time_is_finite() {
        close(&returning(4.0, 12.0), 1e300, &[0.25, 0.75]);
        close(&returning(1e-12, 3e-12), 1e300, &[0.25, 0.75]);
    }

    #[test]
    fn steps_converge_to_the_exact_law_with_order_one() {
        let (rates, targets, _) = chain(&line(&[5.0, 5.0]));
        let exact = Transition::exact(&rates, &targets, 20.0).row(3, 0, 20.0);
        let error = |count: f64| {
            let stepped = Transition::stepped(&rates, &targets, 20.0 / count, count).row(3, 0, count);
            stepped.iter().zip(&exact).map(|(a, b)| (a - b).abs()).sum::<f64>() * 0.5
        };
        // The reference total variations of n chained steps.
        for (count, expected) in [(1.0, 0.764), (2.0, 0.202), (4.0, 0.077), (32.0, 7.7e-3), (256.0, 9.4e-4)] {
            assert!((error(count) / expected - 1.0).abs() < 0.01, "{count} steps: {}", error(count));
        }
        assert!((error(64.0) / error(128.0) - 2.0).abs() < 0.05);
    }
}
