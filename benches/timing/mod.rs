//! Times cases in turn and tells how they compare.
//!
//! Cases run round after round, so that a slow spell of the machine falls on all of them; ratios are taken within a round.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::hint::black_box;
use std::time::Instant;

const ROUNDS: usize = 7;

/// The rounds that the command line asks for: `cargo bench -- 21`.
pub fn rounds() -> usize {
    std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(ROUNDS).max(1)
}

/// One thing that is timed.
pub struct Case<'a> {
    pub name: &'static str,
    pub threads: usize,
    pub work: Box<dyn Fn() + Sync + 'a>,
}

/// Keeps a result from being left out.
pub fn consume<T>(made: T) {
    black_box(made);
}

/// A case on one thread.
pub fn case<'a>(name: &'static str, work: impl Fn() + Sync + 'a) -> Case<'a> {
    Case { name, threads: 1, work: Box::new(work) }
}

/// The name of a case and its times, seconds, a round each.
pub struct Times {
    name: String,
    seconds: Vec<f64>,
}

/// Times all cases in turn, round after round, after one round that is not counted.
pub fn timed(cases: &[Case<'_>], rounds: usize) -> Vec<Times> {
    let pool = |case: &Case| ThreadPoolBuilder::new().num_threads(case.threads).build().expect("threads");
    let pools: Vec<ThreadPool> = cases.iter().map(pool).collect();
    let name = |case: &Case| match case.threads {
        1 => case.name.to_owned(),
        threads => format!("{}, {threads} threads", case.name),
    };
    let mut times: Vec<Times> = cases.iter().map(|case| Times { name: name(case), seconds: Vec::new() }).collect();
    for round in 0..=rounds {
        for ((case, pool), times) in cases.iter().zip(&pools).zip(&mut times) {
            let start = Instant::now();
            pool.install(&case.work);
            if round > 0 {
                times.seconds.push(start.elapsed().as_secs_f64());
            }
        }
    }
    times
}

/// Lower quartile, median and upper quartile, interpolated between neighbours.
fn quartiles(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    [0.25, 0.5, 0.75].map(|share| {
        let place = share * (sorted.len() - 1) as f64;
        let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
        low + (high - low) * place.fract()
    })
}

/// Prints the times, and their ratios to those of the case named `unit`.
pub fn report(what: &str, unit: &str, times: &[Times]) {
    let unit = times.iter().find(|times| times.name == unit).expect("the unit is a case");
    println!("\n{what}: {} rounds; median (quartiles) of seconds, and of ratios to {}", unit.seconds.len(), unit.name);
    for Times { name, seconds } in times {
        let ratios: Vec<f64> = seconds.iter().zip(&unit.seconds).map(|(own, unit)| own / unit).collect();
        let ([low, middle, high], [ratio_low, ratio, ratio_high]) = (quartiles(seconds), quartiles(&ratios));
        println!("{name:<18} {middle:>9.4} s ({low:.4} to {high:.4}) {ratio:>9.4} ({ratio_low:.4} to {ratio_high:.4})");
    }
}
