//! Error against work of the ways to a leaf's shape: the shell's own solver, implicit Euler, equation (1) and extended
//! position-based dynamics, on meshes, thicknesses and curls of several sizes.

mod cases;
mod rows;
mod verdicts;

use super::desk::{Desk, bug};
use super::numbers::shown;
use super::problems::{flat, relative_distance};
use super::table::Table;
use super::timing::{Case, Effort, Times, digest, measured};
use crate::base::diagnostic::Diagnostics;
use crate::base::vector::DVec3;
use crate::deform::DeformError;
use crate::deform::integrators::Run;
pub use cases::{Problem, do_row, ways_around};
use cases::{Way, problems};
use rows::{COLUMNS, rows_of, write_chart};
use std::sync::OnceLock;
use verdicts::{judge, judge_front};

/// Tolerance of the reference and of the one that it is held against.
const REFERENCE: [f64; 2] = [1e-9, 1e-8];

/// A way's row.
struct Row {
    way: Way,
    run: Option<Run>,
    error: f64,
    energy_error: f64,
    times: Times,
    fault: String,
}

impl Row {
    fn seconds(&self) -> f64 {
        self.times.seconds[1]
    }
}

/// A problem's rows, and the reference's own error.
struct Solved {
    rows: Vec<Row>,
    floor: f64,
}

/// Runs the family.
///
/// # Errors
/// Files that cannot be written.
pub fn study(desk: &mut Desk<'_>, own: Option<Problem>) -> Result<(), Diagnostics> {
    let is_own = own.is_some();
    let problems = own.map_or_else(|| problems(desk.request.quick), |own| vec![own]);
    let mut table = Table::new(&COLUMNS);
    let mut solved = Vec::new();
    for problem in &problems {
        let one = solve(desk, problem)?;
        rows_of(desk, problem, &one, &mut table);
        solved.push(one);
    }
    desk.write_table("work_precision.csv", &table)?;
    write_chart(desk, &problems[0], &solved[0])?;
    judge_front(desk, &problems[0], &solved[0]);
    if !is_own {
        judge(desk, &problems, &solved);
    }
    let columns = ["problem", "n_vertices", "method", "setting", "error_pos_rel", "error_energy_rel", "iterations"];
    let columns = [&columns[..], &["cpu_ms_median", "ratio_to_baseline", "status"]].concat();
    let text = format!(
        "Eight states of one blade, each from the one before. The error is the worst of the states: root mean square \
         distance from the reference over that of the reference from the flat blade. Times are of all eight states, and \
         ratios are to the first row of the problem, within a round. `factorizations` and `force_evals` do not depend on \
         the machine.\n\n![error against work](deform.png)\n\n{}",
        table.markdown(&columns)
    );
    desk.section("Deformation: error against work", &text);
    Ok(())
}

fn solve(desk: &mut Desk<'_>, problem: &Problem) -> Result<Solved, Diagnostics> {
    let reference = |tolerance| Way::newton(tolerance).run(problem).map_err(|error| bug(&error.to_string()));
    let [exact, other] = [reference(REFERENCE[0])?, reference(REFERENCE[1])?];
    let flat = flat(&problem.mesh, problem.extent);
    let floor = worst_error(&other, &exact, &flat);
    let quick = desk.request.quick;
    let made: Vec<OnceLock<Result<Run, DeformError>>> = problem.ways.iter().map(|_| OnceLock::new()).collect();
    let cases: Vec<Case<'_>> = problem
        .ways
        .iter()
        .zip(&made)
        .map(|(way, made)| {
            Case::new(move || {
                let run = way.run(problem);
                let digest = digested(&run);
                let _ = made.set(run);
                digest
            })
            .heavy(way.is_heavy(quick))
        })
        .collect();
    let times = measured(&cases, Effort::of(desk.request.quick));
    drop(cases);
    let mut rows = Vec::new();
    for ((way, made), times) in problem.ways.iter().zip(made).zip(times) {
        let made = made.into_inner().unwrap_or(Err(DeformError::Empty));
        let name = format!("deform {} {} {} {}", problem.name, flat.len(), way.name(), way.setting());
        desk.steady(&name, times.is_same);
        let row = row(*way, made, times, (&exact, &flat));
        desk.tell(&format!("{name}: error {}, {} ms", shown(row.error), shown(row.seconds() * 1e3)));
        rows.push(row);
    }
    Ok(Solved { rows, floor })
}

fn row(way: Way, made: Result<Run, DeformError>, times: Times, (exact, flat): (&Run, &[DVec3])) -> Row {
    match made {
        Ok(run) => {
            let energy = |(found, exact): (&f64, &f64)| (found - exact).abs() / exact.abs().max(f64::MIN_POSITIVE);
            let energy_error = run.energies.iter().zip(&exact.energies).map(energy).fold(0.0, f64::max);
            let error = worst_error(&run, exact, flat);
            Row { way, error, energy_error, run: Some(run), times, fault: String::new() }
        }
        Err(error) => {
            Row { way, run: None, error: f64::INFINITY, energy_error: f64::INFINITY, times, fault: error.to_string() }
        }
    }
}

fn worst_error(found: &Run, exact: &Run, flat: &[DVec3]) -> f64 {
    let error = |(found, exact): (&Vec<DVec3>, &Vec<DVec3>)| relative_distance(found, exact, flat);
    found.shapes.iter().zip(&exact.shapes).map(error).fold(0.0, f64::max)
}

fn digested(run: &Result<Run, DeformError>) -> u64 {
    run.as_ref().map_or(1, |run| digest(run.shapes.iter().flatten().flat_map(|p| p.iter())))
}
