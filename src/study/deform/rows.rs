//! The family's table and chart.

use super::cases::{Problem, STATES, counted_name};
use super::{Row, Solved};
use crate::base::diagnostic::Diagnostics;
use crate::deform::integrators::{Method, Run};
use crate::study::chart::{self, Curve};
use crate::study::count;
use crate::study::desk::Desk;
use crate::study::numbers::beaten_by;
use crate::study::table::{Field, Table};

/// Why other methods have no rows.
const LEFT_OUT: [&str; 2] = [
    "Runge-Kutta 4: four evaluations a step for a step 1.4 times as long, and the way to rest does not matter",
    "vertex block descent: 97 % from the shape after ten times the time of Newton's method (prototype)",
];
pub const COLUMNS: [&str; 20] = [
    "family",
    "problem",
    "n_vertices",
    "method",
    "setting",
    "error_pos_rel",
    "error_energy_rel",
    "max_strain",
    "iterations",
    "factorizations",
    "force_evals",
    "instructions",
    "cpu_ms_median",
    "cpu_ms_q1",
    "cpu_ms_q3",
    "cpu_rounds",
    "ratio_to_baseline",
    "status",
    "on_front",
    "note",
];

/// A problem's rows.
pub fn rows_of(desk: &mut Desk<'_>, problem: &Problem, solved: &Solved, table: &mut Table) {
    let work = work_points(solved);
    let named = |row: &Row| (counted_name(problem, row.way), row.seconds());
    let instructions = count::instructions(desk, &solved.rows.iter().map(named).collect::<Vec<_>>());
    for (number, row) in solved.rows.iter().enumerate() {
        let (steps, factorisations) = row.run.as_ref().map_or((0, 0), |run| (run.steps, run.factorisations));
        let strain = row.run.as_ref().map(|run| run.strains.iter().copied().fold(0.0, f64::max));
        let is_newton = row.way.method == Method::Newton;
        let status = if row.run.is_none() { "diverged" } else { "ok" };
        let number_or_none = |value: f64| Field::Number(value.is_finite().then_some(value));
        table.push(vec![
            "deform".into(),
            problem.name.as_str().into(),
            problem.mesh.positions.len().into(),
            row.way.name().into(),
            row.way.setting().into(),
            number_or_none(row.error),
            number_or_none(row.energy_error),
            strain.into(),
            steps.into(),
            factorisations.into(),
            (if is_newton { 0 } else { steps }).into(),
            instructions[number].map_or(Field::Number(None), Field::Count),
            (row.seconds() * 1e3).into(),
            (row.times.seconds[0] * 1e3).into(),
            (row.times.seconds[2] * 1e3).into(),
            row.times.rounds.into(),
            row.times.ratio[1].into(),
            status.into(),
            (row.run.is_some() && beaten_by(&work, number, 0.0).is_empty()).into(),
            row.fault.as_str().into(),
        ]);
    }
}

/// Work that does not depend on the machine, in factorisations of the sheet's matrix: a step of equation (1) or of position-based
/// dynamics touches each triangle once, as a hundredth of a factorisation does at these sizes.
pub fn work_points(solved: &Solved) -> Vec<[f64; 2]> {
    let work =
        |row: &Row| row.run.as_ref().map_or(f64::INFINITY, |run| run.factorisations as f64 + evaluations(row, run));
    solved.rows.iter().map(|row| [work(row), row.error]).collect()
}

fn evaluations(row: &Row, run: &Run) -> f64 {
    if matches!(row.way.method, Method::Newton | Method::Implicit { .. }) { 0.0 } else { run.steps as f64 * 0.01 }
}

/// Error against work of a problem's ways.
///
/// # Errors
/// When the files cannot be made.
pub fn write_chart(desk: &Desk<'_>, problem: &Problem, solved: &Solved) -> Result<(), Diagnostics> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in &solved.rows {
        if curves.last().is_none_or(|curve| curve.name != row.way.name()) {
            curves.push(Curve::new(row.way.name(), Vec::new()));
        }
        let Some(curve) = curves.last_mut() else { continue };
        match row.run {
            Some(_) => curve.points.push([row.seconds() * 1e3 / STATES.len() as f64, row.error]),
            None => curve.diverged.push(row.seconds() * 1e3 / STATES.len() as f64),
        }
    }
    let title = format!("A leaf's shape: error against work, {} vertices", problem.mesh.positions.len());
    let frame = chart::Frame {
        title: &title,
        x: ["processor time for one state", "ms"],
        y: ["error, as a share of the deformation", ""],
        orders: &[-1.0, -2.0],
        floor: Some(solved.floor),
        left_out: &LEFT_OUT,
    };
    desk.write_chart("deform", &chart::chart(&frame, &curves))
}
