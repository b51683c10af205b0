//! The machine and the program of a study, for those who read its figures later.

use super::desk::Request;
use super::timing;
use crate::run::manifest;
use std::fmt::Write;
use std::process::Command;

/// The text of `environment.txt`.
#[must_use]
pub fn text(request: &Request) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: &str| {
        let _ = writeln!(text, "{name}: {}", crate::base::message::shown(value.trim(), 200));
    };
    line("version", env!("CARGO_PKG_VERSION"));
    line("build", manifest::BUILD);
    line("commit", &commit().unwrap_or_else(|| "unknown (not run within a checkout)".to_owned()));
    line("processor", &processor());
    line("system", &format!("{} {}", std::env::consts::OS, std::env::consts::ARCH));
    line("cores", &std::thread::available_parallelism().map_or(0, usize::from).to_string());
    line("threads", &rayon::current_num_threads().to_string());
    line("load", &std::fs::read_to_string("/proc/loadavg").unwrap_or_else(|_| "unknown".to_owned()));
    line("clock", timing::clock_name());
    line("instructions", &valgrind().unwrap_or_else(|| "not counted: valgrind is not installed".to_owned()));
    line("quick", if request.quick { "yes" } else { "no" });
    text
}

/// The commit of the checkout that the command was called in.
fn commit() -> Option<String> {
    let output = Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name"));
    name.map_or_else(|| "unknown".to_owned(), |rest| rest.trim_start_matches([' ', '\t', ':']).to_owned())
}

/// The version of valgrind, where it is installed.
#[must_use]
pub fn valgrind() -> Option<String> {
    let output = Command::new("valgrind").arg("--version").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
