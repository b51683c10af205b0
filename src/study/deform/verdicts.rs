//! What is asked of the ways to a leaf's shape.

use super::cases::{Problem, STATES};
use super::rows::work_points;
use super::{Row, Solved};
use crate::deform::integrators::Method;
use crate::study::desk::Desk;
use crate::study::numbers::{beaten_by, shown};

/// The default lies on the front: no row has both less error and less work, in factorisations.
pub fn judge_front(desk: &mut Desk<'_>, problem: &Problem, solved: &Solved) {
    let default = problem
        .ways
        .iter()
        .position(|way| way.method == Method::Newton && way.tolerance.total_cmp(&problem.settings.tolerance).is_eq());
    let Some(default) = default else { return };
    let beaten = beaten_by(&work_points(solved), default, 0.0);
    let names: Vec<String> = beaten.iter().map(|&row| problem.ways[row].setting()).collect();
    let own = &solved.rows[default];
    let (steps, error) = (own.run.as_ref().map_or(0, |run| run.factorisations), shown(own.error));
    let found = format!("the default ({}): error {error} in {steps} factorisations", own.way.setting());
    let found = if names.is_empty() { found } else { format!("{found}; beaten by {}", names.join(", ")) };
    desk.judge("F1", beaten.is_empty(), "the default tolerance lies on the front of error and work", found);
}

/// Judges the built-in problems.
pub fn judge(desk: &mut Desk<'_>, problems: &[Problem], solved: &[Solved]) {
    let each = |row: &Row| row.run.as_ref().map_or(f64::INFINITY, |run| run.steps as f64 / STATES.len() as f64);
    let reached = |solved: &Solved| {
        solved
            .rows
            .iter()
            .filter(|row| row.way.method == Method::Newton && row.error <= 1e-3)
            .map(each)
            .fold(f64::INFINITY, f64::min)
    };
    let large = problems.iter().position(|problem| problem.mesh.positions.len() > 2000).unwrap_or(0);
    let [small, large] = [reached(&solved[0]), reached(&solved[large])];
    let found = format!("{small:.2} iterations a state at 631 vertices, {large:.2} at 2,107");
    let asked = "Newton reaches 1e-3 in at most 12 iterations a state at 600 and 2,000 vertices";
    desk.judge("P1", small.max(large) <= 12.0, asked, found.clone());
    desk.judge("P2", large <= 1.3 * small, "iterations at 2,000 vertices at most 1.3 times those at 600", found);
    let one_per_cent = |row: &&Row| row.error <= 0.01;
    let newton = solved[0].rows.iter().filter(|row| row.way.method == Method::Newton).filter(one_per_cent);
    let cheapest = newton.map(|row| row.times.ratio[1]).fold(f64::INFINITY, f64::min);
    let explicit: Vec<&Row> =
        solved[0].rows.iter().filter(|row| matches!(row.way.method, Method::Explicit { .. })).collect();
    let arrived = explicit.iter().find(|row| one_per_cent(row));
    let longest = explicit.last().map_or(0.0, |row| row.times.ratio[1]) / cheapest;
    let (passes, found) = match arrived {
        Some(row) => {
            let times = row.times.ratio[1] / cheapest;
            (times >= 20.0, format!("{times:.0} times Newton's processor time ({})", row.way.setting()))
        }
        None => {
            let error = explicit.last().map_or(f64::INFINITY, |row| row.error);
            (longest >= 20.0, format!("not reached in {longest:.0} times Newton's processor time (error {error:.2})"))
        }
    };
    desk.judge("P3", passes, "equation (1) takes at least 20 times Newton's work to 1 %, 600 vertices", found);
}
