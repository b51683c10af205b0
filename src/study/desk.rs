//! What a study is asked for, and where it puts what it finds: rows told as they come, files, verdicts and the report.

use super::environment;
use super::table::Table;
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::family::Family;
use crate::base::limits::Limits;
use crate::base::message;
use crate::export;
use crate::plot::{self, Plot};
use crate::run::files;
use crate::scene::Scene;
use std::path::{Path, PathBuf};

/// A scene that is studied.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The scene as read.
    pub scene: Scene,
    /// Its file.
    pub path: PathBuf,
    /// The keys that the call changes, `KEY=VALUE`.
    pub sets: Vec<String>,
}

/// What a study is asked for.
#[derive(Clone, Debug)]
pub struct Request {
    /// The folder for the files.
    pub out: PathBuf,
    /// What is studied.
    pub family: Family,
    /// Whether costly rows are left out.
    pub quick: bool,
    /// The scene whose leaf, chain and camera are studied; built-in problems without one.
    pub subject: Option<Subject>,
    /// This program, for rows that need a process of their own: time, memory, instruction counts.
    pub program: Option<PathBuf>,
    /// The limits in force.
    pub limits: Limits,
}

/// A line that passes or fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Its name: `P1`.
    pub id: &'static str,
    /// What is asked.
    pub asked: String,
    /// What was found.
    pub found: String,
    /// Whether it passes.
    pub passes: bool,
}

/// A study under way.
pub struct Desk<'a> {
    /// What was asked for.
    pub request: &'a Request,
    tell: &'a mut dyn FnMut(&str),
    /// The lines judged so far.
    pub verdicts: Vec<Verdict>,
    /// Rows whose result was not the same in every round and on two threads.
    pub unsteady: Vec<String>,
    /// Rows that were made more than once.
    pub repeated: u64,
    sections: Vec<String>,
}

impl<'a> Desk<'a> {
    /// An empty desk; `tell` is told of each row.
    pub fn new(request: &'a Request, tell: &'a mut dyn FnMut(&str)) -> Self {
        Self { request, tell, verdicts: Vec::new(), unsteady: Vec::new(), repeated: 0, sections: Vec::new() }
    }

    /// Whether a family is asked for.
    #[must_use]
    pub fn has(&self, family: Family) -> bool {
        self.request.family.includes(family)
    }

    /// Tells of a row.
    pub fn tell(&mut self, row: &str) {
        (self.tell)(&message::shown(row, 300));
    }

    /// Notes whether a row that was made several times gave the same result each time.
    pub fn steady(&mut self, row: &str, is_same: bool) {
        self.repeated += 1;
        if !is_same {
            self.unsteady.push(row.to_owned());
        }
    }

    /// Judges a line.
    pub fn judge(&mut self, id: &'static str, passes: bool, asked: impl Into<String>, found: impl Into<String>) {
        let verdict = Verdict { id, asked: asked.into(), found: found.into(), passes };
        self.tell(&format!("{id} {}: {}", if passes { "passes" } else { "FAILS" }, verdict.found));
        self.verdicts.push(verdict);
    }

    /// Adds a section to the report.
    pub fn section(&mut self, heading: &str, text: &str) {
        self.sections.push(format!("## {heading}\n\n{}\n", text.trim_end()));
    }

    /// Writes a file under a temporary name and renames it.
    ///
    /// # Errors
    /// When the folder or the file cannot be made.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Diagnostics> {
        write(&self.request.out.join(name), bytes)
    }

    /// Writes a table.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_table(&self, name: &str, table: &Table) -> Result<(), Diagnostics> {
        self.write(name, table.csv().as_bytes())
    }

    /// Writes a chart as SVG and PNG.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_chart(&self, name: &str, plot: &Plot) -> Result<(), Diagnostics> {
        self.write(&format!("{name}.svg"), plot::svg(plot).as_bytes())?;
        let png = export::png(&plot::picture(plot)).map_err(|error| bug(&error.to_string()))?;
        self.write(&format!("{name}.png"), &png)
    }

    /// Writes `environment.txt` and `report.md`; whether every line passes.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn close(mut self) -> Result<bool, Diagnostics> {
        if self.repeated > 0 {
            let asked = "every row that is timed gives the same result in each round, on one thread and on two";
            let found = match self.unsteady.as_slice() {
                [] => format!("{} rows, all the same", self.repeated),
                rows => format!("of {} rows these differ: {}", self.repeated, rows.join("; ")),
            };
            self.judge("P12", self.unsteady.is_empty(), asked, found);
        }
        self.verdicts.sort_by_key(|verdict| number(verdict.id));
        let failed = self.verdicts.iter().filter(|verdict| !verdict.passes).count();
        self.write("environment.txt", environment::text(self.request).as_bytes())?;
        let mut table = Table::new(&["line", "asked", "found", "result"]);
        for Verdict { id, asked, found, passes } in &self.verdicts {
            let result = if *passes { "pass" } else { "FAIL" };
            table.push(vec![(*id).into(), asked.as_str().into(), found.as_str().into(), result.into()]);
        }
        let mut text =
            format!("# Study\n\n{} of {} lines pass.\n\n", self.verdicts.len() - failed, self.verdicts.len());
        text.push_str(&table.markdown(&table.columns));
        text.push('\n');
        text.push_str(&self.sections.join("\n"));
        self.write("report.md", text.as_bytes())?;
        Ok(failed == 0)
    }
}

/// The order of lines: by their letter's first mention and their number.
fn number(id: &str) -> (u8, u32) {
    let letter = id.bytes().next().unwrap_or(0);
    (if letter == b'P' { 0 } else { letter }, id[1.min(id.len())..].parse().unwrap_or(0))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Diagnostics> {
    let failed = |error: &dyn std::fmt::Display| {
        let what = format!("cannot write {}: {error}", message::shown(&path.to_string_lossy(), 200));
        Diagnostics::from(Diagnostic::error(Fault::Output, what, "name another folder with --out"))
    };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| failed(&error))?;
    }
    files::write(path, bytes).map_err(|error| failed(&error))
}

/// What cannot happen with sound problems of our own.
pub(super) fn bug(what: &str) -> Diagnostics {
    Diagnostic::error(Fault::Bug, what, "please report it").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_in_the_order_of_their_numbers() {
        let mut ids = vec!["P12", "Q1", "P2", "L1", "P1"];
        ids.sort_by_key(|id| number(id));
        assert_eq!(ids, ["P1", "P2", "P12", "L1", "Q1"]);
    }
}
