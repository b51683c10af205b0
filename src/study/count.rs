//! Instruction counts of rows, by valgrind in a process of this program's own: exact where times are not.

use super::desk::Desk;
use super::{deform, environment};
use rayon::prelude::*;
use std::process::Command;
use std::sync::OnceLock;

/// Rows longer than this are not counted: valgrind is some twenty times slower, seconds.
const LONGEST: f64 = 0.25;

/// Instructions of a process that does no row; none when they cannot be counted.
static NOTHING: OnceLock<Option<u64>> = OnceLock::new();

/// Instructions of the work of rows, given with the seconds they take, each on one thread, several at a time: nothing that
/// runs beside changes a count. `None` in a quick study, without valgrind, and for rows that take long.
pub fn instructions(desk: &mut Desk<'_>, rows: &[(String, f64)]) -> Vec<Option<u64>> {
    let none = || vec![None; rows.len()];
    let request = desk.request;
    let Some(program) = request.program.as_ref().filter(|_| !request.quick && request.subject.is_none()) else {
        return none();
    };
    let nothing = NOTHING.get_or_init(|| environment::valgrind().and_then(|_| counted(program, "nothing")));
    let Some(nothing) = *nothing else { return none() };
    let is_short = |(_, seconds): &&(String, f64)| *seconds <= LONGEST;
    for (row, _) in rows.iter().filter(is_short) {
        desk.tell(&format!("counting the instructions of {row}"));
    }
    let count = |row: &(String, f64)| {
        Some(row).filter(is_short).and_then(|(row, _)| Some(counted(program, row)?.saturating_sub(nothing)))
    };
    rows.par_iter().map(count).collect()
}

fn counted(program: &std::path::Path, row: &str) -> Option<u64> {
    let output = Command::new("valgrind")
        .args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"])
        .arg(program)
        .args(["study", "--row", row, "--out", "."])
        .output()
        .ok()?;
    read(&String::from_utf8_lossy(&output.stderr)).filter(|_| output.status.success())
}

/// The count in what the tool prints: `==12== I refs: 1,234`.
fn read(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.split_once("I refs:").or_else(|| line.split_once("I   refs:")))?;
    let digits: String = line.1.chars().filter(char::is_ascii_digit).collect();
    digits.parse().ok()
}

/// Does the work of a row once, for its instructions to be counted; whether there is such a row.
#[must_use]
pub fn do_row(name: &str) -> bool {
    name == "nothing" || deform::do_row(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_count_is_read_from_what_the_tool_prints() {
        assert_eq!(read("==7== Command: x\n==7== \n==7== I refs:        12,345,678\n"), Some(12_345_678));
        assert_eq!(read("==7== I   refs: 9\n"), Some(9));
        assert_eq!(read("nothing of it"), None);
    }

    #[test]
    fn rows_that_are_not_known_are_told() {
        assert!(do_row("nothing") && !do_row("deform/none"));
    }
}
