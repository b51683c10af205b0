//! Error against work of the ways to a leaf's shape: the shell's own solver, implicit Euler, equation (1) and extended
//! position-based dynamics, on meshes, thicknesses and curls of several sizes.

use super::chart::{self, Curve};
use super::count;
use super::desk::{Desk, bug};
use super::numbers::{beaten_by, shown};
use super::problems::{OVATE_EXTENT, flat, ovate, relative_distance};
use super::table::{Field, Table};
use super::timing::{Case, Effort, Times, digest, measured};
use crate::base::diagnostic::Diagnostics;
use crate::base::flat_mesh::FlatMesh;
use crate::base::vector::DVec3;
use crate::deform::DeformError;
use crate::deform::integrators::{Method, Run, run};
use crate::deform::shell::Settings;
use std::sync::OnceLock;

/// The drynesses of the eight states.
const STATES: [f64; 8] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];
/// The solver's tolerances, extents.
const TOLERANCES: [f64; 7] = [1e-1, 1e-2, 3e-3, 1e-3, 3e-4, 1e-5, 1e-7];
/// Tolerance of the reference and of the one that it is held against.
const REFERENCE: [f64; 2] = [1e-9, 1e-8];
/// Why other methods have no rows.
const LEFT_OUT: [&str; 2] = [
    "Runge-Kutta 4: four evaluations a step for a step 1.4 times as long, and the way to rest does not matter",
    "vertex block descent: 97 % from the shape after ten times the time of Newton's method (prototype)",
];
const COLUMNS: [&str; 20] = [
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

/// A blade and how it dries.
#[derive(Clone, Debug)]
pub struct Problem {
    /// For the table.
    pub name: String,
    /// The blade.
    pub mesh: FlatMesh,
    /// Metres that the integrators' unit of length stands for.
    pub extent: f64,
    /// How it dries.
    pub settings: Settings,
    /// The ways that are tried.
    pub ways: Vec<Way>,
}

/// A way to the shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// The method.
    pub method: Method,
    /// Newton's tolerance, extents.
    pub tolerance: f64,
}

impl Way {
    fn newton(tolerance: f64) -> Self {
        Self { method: Method::Newton, tolerance }
    }

    fn name(&self) -> &'static str {
        match self.method {
            Method::Newton => "Newton",
            Method::Implicit { .. } => "implicit Euler",
            Method::Explicit { .. } => "equation (1)",
            Method::PositionBased { .. } => "XPBD",
        }
    }

    fn setting(&self) -> String {
        match self.method {
            Method::Newton => format!("tolerance {}", shown(self.tolerance)),
            Method::Implicit { steps } | Method::Explicit { steps } | Method::PositionBased { steps } => {
                format!("{steps} steps")
            }
        }
    }

    /// Whether it takes many seconds; a quick study has fewer of them.
    fn is_heavy(&self, quick: bool) -> bool {
        let share = if quick { 8 } else { 1 };
        match self.method {
            Method::Explicit { steps } => steps >= 8000 / share,
            Method::PositionBased { steps } => steps >= 800 / share,
            Method::Implicit { steps } => steps >= 128 / share,
            Method::Newton => false,
        }
    }

    /// Runs it.
    ///
    /// # Errors
    /// As [`run`].
    pub fn run(&self, problem: &Problem) -> Result<Run, DeformError> {
        let settings = Settings { tolerance: self.tolerance, ..problem.settings.clone() };
        run(&settings, &problem.mesh, &STATES, 1, self.method)
    }
}

/// The blade on which solvers are measured: a hundred times as long as thick, curled to a tenth of its length.
fn base(rings: u32) -> Problem {
    let settings = Settings { curl: 10.0, thickness: 0.01, ..Settings::default() };
    let mesh = ovate(rings);
    let name = "h/L 0.01, curl 10".to_owned();
    Problem { name, mesh, extent: OVATE_EXTENT, settings, ways: Vec::new() }
}

fn all_ways(quick: bool) -> Vec<Way> {
    let tolerance = Settings::default().tolerance;
    let way = |method| Way { method, tolerance };
    let mut ways: Vec<Way> = TOLERANCES.map(Way::newton).to_vec();
    let implicit: &[u32] = if quick { &[8, 32] } else { &[4, 8, 16, 32, 64] };
    ways.extend(implicit.iter().map(|&steps| way(Method::Implicit { steps })));
    let explicit: &[u32] = if quick { &[500, 4000] } else { &[500, 2000, 8000, 32_000] };
    ways.extend(explicit.iter().map(|&steps| way(Method::Explicit { steps })));
    let position_based: &[u32] = if quick { &[200] } else { &[200, 800, 3200] };
    ways.extend(position_based.iter().map(|&steps| way(Method::PositionBased { steps })));
    ways
}

/// The ways that are tried on a blade of the user's, the scene's own tolerance among them.
pub fn ways_around(tolerance: f64) -> Vec<Way> {
    let mut ways = all_ways(true);
    if !ways.iter().any(|way| way.method == Method::Newton && way.tolerance.total_cmp(&tolerance).is_eq()) {
        ways.insert(0, Way::newton(tolerance));
    }
    ways
}

/// The problems, the measured one first.
fn problems(quick: bool) -> Vec<Problem> {
    let few = || if quick { vec![Way::newton(3e-4)] } else { [1e-2, 3e-4, 1e-7].map(Way::newton).to_vec() };
    let mut problems = vec![Problem { ways: all_ways(quick), ..base(14) }];
    let sizes: &[u32] = if quick { &[26] } else { &[10, 20, 26] };
    for &rings in sizes {
        let mut ways = few();
        ways.extend((!quick).then_some(Way { method: Method::Implicit { steps: 16 }, tolerance: 3e-4 }));
        problems.push(Problem { ways, ..base(rings) });
    }
    for thickness in if quick { &[0.05][..] } else { &[0.05, 0.02, 0.005] } {
        let mut problem = Problem { ways: few(), ..base(14) };
        problem.settings.thickness = *thickness;
        problem.name = format!("h/L {thickness}, curl 10");
        problems.push(problem);
    }
    for curl in if quick { &[25.0][..] } else { &[1.0, 4.0, 25.0] } {
        let mut problem = Problem { ways: few(), ..base(14) };
        problem.settings.curl = *curl;
        problem.name = format!("h/L 0.01, curl {curl}");
        problems.push(problem);
    }
    problems
}

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
    write_charts(desk, &problems[0], &solved[0])?;
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

fn rows_of(desk: &mut Desk<'_>, problem: &Problem, solved: &Solved, table: &mut Table) {
    let work = work_points(solved);
    for (number, row) in solved.rows.iter().enumerate() {
        let (steps, factorisations) = row.run.as_ref().map_or((0, 0), |run| (run.steps, run.factorisations));
        let strain = row.run.as_ref().map(|run| run.strains.iter().copied().fold(0.0, f64::max));
        let is_newton = row.way.method == Method::Newton;
        let status = if row.run.is_none() { "diverged" } else { "ok" };
        let number_or_none = |value: f64| Field::Number(value.is_finite().then_some(value));
        let instructions = count::instructions(desk, &counted_name(problem, row.way), row.seconds());
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
            instructions.map_or(Field::Number(None), Field::Count),
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
fn work_points(solved: &Solved) -> Vec<[f64; 2]> {
    let work =
        |row: &Row| row.run.as_ref().map_or(f64::INFINITY, |run| run.factorisations as f64 + evaluations(row, run));
    solved.rows.iter().map(|row| [work(row), row.error]).collect()
}

fn evaluations(row: &Row, run: &Run) -> f64 {
    if matches!(row.way.method, Method::Newton | Method::Implicit { .. }) { 0.0 } else { run.steps as f64 * 0.01 }
}

fn counted_name(problem: &Problem, way: Way) -> String {
    format!("deform/{}/{}/{}/{}", problem.mesh.positions.len(), problem.name, way.name(), way.setting())
}

/// Does the work of a row by its name, once; whether there is such a row.
pub fn do_row(name: &str) -> bool {
    let all = problems(false);
    let named = |problem: &Problem| problem.ways.iter().copied().find(|&way| counted_name(problem, way) == name);
    let found = all.iter().find_map(|problem| named(problem).map(|way| (problem, way)));
    found.is_some_and(|(problem, way)| {
        let _ = std::hint::black_box(way.run(problem));
        true
    })
}

fn write_charts(desk: &Desk<'_>, problem: &Problem, solved: &Solved) -> Result<(), Diagnostics> {
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

/// The default lies on the front: no row has both less error and less work, in factorisations.
fn judge_front(desk: &mut Desk<'_>, problem: &Problem, solved: &Solved) {
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

fn judge(desk: &mut Desk<'_>, problems: &[Problem], solved: &[Solved]) {
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
