//! Times the stages for the report.

use crate::base::figures::Figures;
use crate::report::Report;
use std::time::Instant;

/// Runs a stage and adds its time and figures to the report; a failed stage is not reported.
pub fn timed<T, E>(report: &mut Report, stage: &str, work: impl FnOnce() -> Result<(T, Figures), E>) -> Result<T, E> {
    let start = Instant::now();
    let (made, figures) = work()?;
    report.add(stage, start.elapsed().as_secs_f64(), figures);
    Ok(made)
}

/// Largest memory that this process has held, bytes; 0 where the system does not tell.
#[must_use]
pub fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)).and_then(|number| number.parse().ok());
    kilobytes.unwrap_or(0u64) * 1024
}

/// Processor time that this process has used, seconds; 0 where the system does not tell.
#[must_use]
pub fn processor_seconds() -> f64 {
    // The second field is the program's name in brackets and may hold blanks; user and system ticks are the 12th and
    // 13th after it, in hundredths of a second on every Linux that Rust supports.
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks: u64 = after.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
    ticks as f64 / 100.0
}
