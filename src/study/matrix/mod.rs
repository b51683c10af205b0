//! The matrix of stiff and extreme cases: every case runs, is held against what must hold, and has a row.

mod bench;
mod chain;
mod leaf;
mod masses;
mod pictures;
mod scenes;
mod sheets;

use super::desk::Desk;
use super::table::{Field, Table};
use crate::base::diagnostic::Diagnostics;
pub(super) use bench::Bench;
use rayon::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};

const COLUMNS: [&str; 5] = ["id", "case", "expectation", "observed", "pass"];
/// Cases that are done before any of them is told.
const AT_ONCE: usize = 8;

/// What was seen of a case, and whether that is what must hold.
pub(super) type Seen = (bool, String);

/// One case.
pub(super) struct Case {
    /// Its row in the matrix, with a letter where a row has several: `D01a`.
    pub id: &'static str,
    /// What is done.
    pub what: &'static str,
    /// What must hold.
    pub expects: &'static str,
    /// Whether a quick study leaves it out.
    pub is_slow: bool,
    /// Does it.
    pub run: fn(&Bench) -> Seen,
}

/// A case.
pub(super) const fn case(id: &'static str, what: &'static str, expects: &'static str, run: fn(&Bench) -> Seen) -> Case {
    Case { id, what, expects, is_slow: false, run }
}

/// A case that takes many seconds.
pub(super) const fn slow(id: &'static str, what: &'static str, expects: &'static str, run: fn(&Bench) -> Seen) -> Case {
    Case { id, what, expects, is_slow: true, run }
}

/// All cases.
fn cases() -> impl Iterator<Item = &'static Case> {
    [masses::CASES, sheets::CASES, chain::CASES, leaf::CASES, pictures::CASES, scenes::CASES].into_iter().flatten()
}

fn seen(case: &Case, bench: &Bench) -> Seen {
    catch_unwind(AssertUnwindSafe(|| (case.run)(bench))).unwrap_or_else(|_| (false, "a panic".to_owned()))
}

/// Runs every case, some at once: none of their rows tells of time.
///
/// # Errors
/// Files that cannot be written.
pub fn study(desk: &mut Desk<'_>) -> Result<(), Diagnostics> {
    let bench = Bench::new(&desk.request.out, desk.request.program.clone());
    let mut table = Table::new(&COLUMNS);
    let (mut failed, mut skipped, mut count) = (Vec::new(), 0, 0);
    for some in cases().collect::<Vec<_>>().chunks(AT_ONCE) {
        let is_left = |case: &Case| case.is_slow && desk.request.quick;
        let seen: Vec<Option<Seen>> =
            some.par_iter().map(|case| (!is_left(case)).then(|| seen(case, &bench))).collect();
        for (case, seen) in some.iter().zip(seen) {
            let head = [case.id, case.what, case.expects].map(Field::from);
            let Some((passes, observed)) = seen else {
                skipped += 1;
                table.push(head.into_iter().chain(["left to the full study".into(), "".into()]).collect());
                continue;
            };
            count += 1;
            desk.tell(&format!("matrix {} {}: {}", case.id, case.what, if passes { "pass" } else { &observed }));
            if !passes {
                failed.push(format!("{}: {observed}", case.id));
            }
            table.push(head.into_iter().chain([observed.into(), passes.into()]).collect());
        }
    }
    bench.clean();
    desk.write_table("matrix.csv", &table)?;
    let found = if failed.is_empty() { format!("all {count}") } else { failed.join("; ") };
    let found = if skipped > 0 { format!("{found}; {skipped} slow ones left to the full study") } else { found };
    desk.judge("P11", failed.is_empty(), "every case of the matrix passes", found);
    desk.section("Stiff and extreme cases", &table.markdown(&COLUMNS));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// The rows of the matrix.
    const ROWS: &str = "D01 D02 D03 D04 D05 D06 D07 D08 D09 D10 D11 D12 D14 D15 D16 D17 D18 D19 D21 D23 D24 D25 D27 D28 D29 \
                        D31 D32 D33 D34 C01 C02 C04 C05 C06 C07 C08 C10 C11 C12 C13 C15 M01 M02 M03 M04 M05 M06 M08 M10 R01 \
                        R03 R05 R06 R07 S01 S02";

    #[test]
    fn every_row_has_its_cases_and_no_case_is_named_twice() {
        let rows: BTreeSet<&str> = cases().map(|case| &case.id[..3]).collect();
        assert_eq!(rows, ROWS.split_whitespace().collect());
        let names: BTreeSet<&str> = cases().map(|case| case.id).collect();
        assert_eq!(names.len(), cases().count());
    }
}
