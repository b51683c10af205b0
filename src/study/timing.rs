//! Honest timing: processor time on one thread, cases in turn round after round, medians of the ratios within a round.
//!
//! A slow spell of the machine falls on all cases of a round alike, so ratios keep their meaning where seconds do not. No
//! best time is ever shown alone, and nothing passes or fails by seconds.

use super::numbers::quartiles;
use crate::run::stopwatch;
use rayon::ThreadPool;
use std::time::Instant;

/// Processor time below which a measurement is repeated within a round, seconds: the kernel counts in ticks of some
/// milliseconds.
const LEAST: f64 = 0.02;

/// What a case leaves behind, as a number that differs when a result differs.
pub type Digest = u64;

/// Something whose time is taken.
pub struct Case<'a> {
    /// Does the work once and tells its result.
    pub work: Box<dyn Fn() -> Digest + Sync + 'a>,
    /// Whether it is done once only, on one thread: what takes many seconds.
    pub is_heavy: bool,
}

impl<'a> Case<'a> {
    /// A case.
    pub fn new(work: impl Fn() -> Digest + Sync + 'a) -> Self {
        Self { work: Box::new(work), is_heavy: false }
    }

    /// The same, done once only when `is_heavy`.
    #[must_use]
    pub fn heavy(self, is_heavy: bool) -> Self {
        Self { is_heavy, ..self }
    }
}

/// The times of a case.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// Lower quartile, median, upper quartile of processor time, seconds.
    pub seconds: [f64; 3],
    /// The same of the ratio to the first case of the same round.
    pub ratio: [f64; 3],
    /// Rounds that were counted.
    pub rounds: u64,
    /// Whether every round, and a run on two threads, left the same result.
    pub is_same: bool,
}

/// How much time is spent on timing.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Most rounds.
    pub rounds: u64,
    /// Processor time for all rounds of one case, seconds.
    pub budget: f64,
}

impl Effort {
    /// At most three rounds for a quick study, fifteen for a full one, fewer for what is slow.
    #[must_use]
    pub fn of(quick: bool) -> Self {
        if quick { Self { rounds: 3, budget: 0.2 } } else { Self { rounds: 15, budget: 4.0 } }
    }
}

/// Processor time of this thread, seconds: from the scheduler's own count of nanoseconds, else the process's ticks, else the
/// wall clock. The scheduler brings its count up to date at its ticks.
fn clock() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    match text.split_whitespace().next().and_then(|field| field.parse::<f64>().ok()) {
        Some(nanoseconds) => nanoseconds * 1e-9,
        None => stopwatch::processor_seconds(),
    }
}

/// How processor time is taken here.
#[must_use]
pub fn clock_name() -> &'static str {
    if std::fs::metadata("/proc/thread-self/schedstat").is_ok() {
        "processor time of one thread, /proc/thread-self/schedstat"
    } else {
        "processor time of the process, /proc/self/stat (hundredths of a second; 0 where there is no such file)"
    }
}

/// Threads of a pool; `None` when the system gives none.
#[must_use]
pub fn pool(threads: usize) -> Option<ThreadPool> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()
}

/// How often the work has to be done for the clock to see it, and the seconds that this takes.
fn repeats(case: &Case<'_>) -> (u32, f64) {
    let mut repeats = 1;
    loop {
        let start = Instant::now();
        for _ in 0..repeats {
            std::hint::black_box((case.work)());
        }
        let seconds = start.elapsed().as_secs_f64();
        if seconds >= LEAST || repeats >= 1 << 20 {
            return (repeats, seconds);
        }
        repeats = (f64::from(repeats) * (1.3 * LEAST / seconds.max(1e-9)).clamp(2.0, 64.0)) as u32;
    }
}

/// Does the work so often; processor seconds of one time, its result, and whether that was always the same and as expected.
fn round(case: &Case<'_>, repeats: u32, expected: Option<Digest>) -> (f64, Digest, bool) {
    let start = clock();
    let digest = (case.work)();
    let mut is_same = expected.is_none_or(|expected| expected == digest);
    for _ in 1..repeats {
        is_same &= (case.work)() == digest;
    }
    ((clock() - start).max(0.0) / f64::from(repeats), digest, is_same)
}

/// Times all cases in turn. The first is what the others are held against. `tell` is told of each round.
pub fn measured(cases: &[Case<'_>], effort: Effort) -> Vec<Times> {
    let (Some(one), Some(two)) = (pool(1), pool(2)) else { return vec![Times::default(); cases.len()] };
    // The first run warms caches and is made on two threads; what follows tells how often a case is worth repeating.
    let first = |case: &Case<'_>| {
        if case.is_heavy {
            return (None, 1, 1);
        }
        let start = Instant::now();
        let digest = two.install(|| (case.work)());
        let seconds = start.elapsed().as_secs_f64();
        let (repeats, seconds) = if seconds >= 2.0 * LEAST { (1, seconds) } else { one.install(|| repeats(case)) };
        (Some(digest), repeats, ((effort.budget / seconds) as u64).clamp(1, effort.rounds))
    };
    let mut known: Vec<(Option<Digest>, u32, u64)> = cases.iter().map(first).collect();
    let most = known.iter().map(|known| known.2).max().unwrap_or(0);
    let mut seconds: Vec<Vec<f64>> = vec![Vec::new(); cases.len()];
    let mut ratios: Vec<Vec<f64>> = vec![Vec::new(); cases.len()];
    let mut same = vec![true; cases.len()];
    for number in 0..most {
        let mut unit = 0.0;
        for (at, case) in cases.iter().enumerate() {
            let (digest, repeats, rounds) = known[at];
            if at > 0 && number >= rounds {
                continue;
            }
            let (taken, digest, is_same) = one.install(|| round(case, repeats, digest));
            known[at].0 = Some(digest);
            same[at] &= is_same;
            unit = if at == 0 { taken } else { unit };
            seconds[at].push(taken);
            if unit > 0.0 {
                ratios[at].push(taken / unit);
            }
        }
    }
    let times = |at: usize| Times {
        seconds: quartiles(&seconds[at]),
        ratio: quartiles(&ratios[at]),
        rounds: seconds[at].len() as u64,
        is_same: same[at],
    };
    (0..cases.len()).map(times).collect()
}

/// A digest of numbers, bit by bit.
pub fn digest<'a>(values: impl IntoIterator<Item = &'a f64>) -> Digest {
    values.into_iter().fold(0, |sum, value| crate::base::random::hash(sum, value.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn a_result_that_changes_from_run_to_run_is_seen() {
        let count = AtomicU64::new(0);
        let cases = [Case::new(|| 7), Case::new(|| count.fetch_add(1, Ordering::Relaxed))];
        let times = measured(&cases, Effort { rounds: 2, budget: 1e-3 });
        assert_eq!([times[0].is_same, times[1].is_same], [true, false]);
        assert!(times.iter().all(|times| times.rounds >= 1));
    }

    #[test]
    fn digests_see_the_last_bit_and_the_order() {
        assert_ne!(digest(&[1.0, 2.0]), digest(&[2.0, 1.0]));
        assert_ne!(digest(&[1.0]), digest(&[1.0 + f64::EPSILON]));
        assert_eq!(digest(&[0.5]), digest(&[0.5]));
    }
}
