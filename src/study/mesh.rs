//! Meshes of blades: how near a mesh of some vertices is to its outline, how even it is, and what it costs.

use super::chart::{self, Curve};
use super::desk::{Desk, bug};
use super::grade::{Grade, grade};
use super::numbers::{shown, slope};
use super::outlines;
use super::table::{Field, Table};
use super::timing::{Case, Effort, Times, digest, measured};
use crate::base::blade::Blade;
use crate::base::diagnostic::Diagnostics;
use crate::base::limits::Limits;
use crate::leaf::{self, Meshing, Pictures, Settings};
use rayon::prelude::*;

const COLUMNS: [&str; 21] = [
    "outline",
    "n_keys",
    "param",
    "iterations",
    "n_vertices",
    "n_triangles",
    "min_angle",
    "excused",
    "p01_angle",
    "mean_min_angle",
    "edge_cv",
    "mean_rr",
    "worst_rr",
    "valence_6",
    "area_err",
    "hausdorff",
    "cpu_ms",
    "cpu_ms_q1",
    "cpu_ms_q3",
    "cpu_rounds",
    "ratio_to_coarsest",
];
/// Vertices that are asked for; meshes from `JUDGED` on are held to the targets.
const VERTICES: [u32; 6] = [100, 220, 600, 1200, 2000, 4000];
const JUDGED: u32 = 2000;
/// Rounds of relocation and reconnection.
const ROUNDS: [u32; 7] = [0, 1, 2, 5, 10, 40, 160];

/// One mesh that is made.
struct Trial<'a> {
    outline: &'a str,
    param: &'static str,
    settings: Settings,
}

impl Trial<'_> {
    fn blade(&self) -> Option<(Blade, f64)> {
        let (blade, figures) = leaf::model(&self.settings, Pictures::default(), &Limits::default()).ok()?;
        let excused = figures.values.get("excused_triangles").and_then(serde_json::Value::as_f64);
        Some((blade, excused.unwrap_or(0.0)))
    }

    /// Its grade, the outline's key points, the triangles that are excused.
    fn graded(&self) -> Option<(Grade, usize, f64)> {
        self.blade().map(|(blade, excused)| (grade(&blade), blade.keys.len(), excused))
    }

    fn digest(&self) -> u64 {
        self.blade().map_or(0, |(blade, _)| digest(blade.mesh.positions.iter().flat_map(|p| p.iter())))
    }
}

/// Runs the family, on the scene's own blade if there is one.
///
/// # Errors
/// Outlines that cannot be meshed, files that cannot be written.
pub fn study(desk: &mut Desk<'_>, own: Option<(String, Settings)>) -> Result<(), Diagnostics> {
    let is_own = own.is_some();
    let blades = own.map_or_else(|| outlines::all(desk.request.quick), |own| vec![own]);
    let mut table = Table::new(&COLUMNS);
    let (mut curves, mut grades) = (Vec::new(), Vec::new());
    for (name, settings) in &blades {
        let made = ladder(desk, (name, settings), &mut table)?;
        let points: Vec<[f64; 2]> = made.iter().map(|grade| [grade.vertices as f64, grade.hausdorff]).collect();
        curves.push(Curve::new(name.clone(), points));
        grades.extend(made.into_iter().map(|grade| (name.clone(), grade)));
    }
    if let Some((name, settings)) = blades.first() {
        rounds(desk, (name, settings), &mut table)?;
    }
    desk.write_table("mesh.csv", &table)?;
    let frame = chart::Frame {
        title: "Meshes of blades: distance of the rim from the outline",
        x: ["vertices", ""],
        y: ["Hausdorff distance over the blade's extent", ""],
        orders: &[-1.0],
        floor: None,
        left_out: &["the bare Delaunay triangulation of the rim: it has no inner vertices to even out (see the table)"],
    };
    desk.write_chart("mesh", &chart::chart(&frame, &curves))?;
    if !is_own {
        judge(desk, &grades);
    }
    let orders: Vec<f64> = curves.iter().filter_map(|curve| slope(&curve.points)).collect();
    let text = format!(
        "`hausdorff` is in extents of the blade (the longer side of its box), angles are in degrees, `rr` is twice the \
         incircle's radius over the circumcircle's, `valence_6` the share of inner vertices with six neighbours. The \
         distance falls with the vertices to the power {}.\n\n![distance against vertices](mesh.png)\n\n{}",
        orders.iter().map(|order| format!("{order:.2}")).collect::<Vec<_>>().join(", "),
        table.markdown(&[
            "outline",
            "param",
            "n_vertices",
            "min_angle",
            "p01_angle",
            "edge_cv",
            "mean_rr",
            "worst_rr",
            "valence_6",
            "area_err",
            "hausdorff",
            "cpu_ms",
        ])
    );
    desk.section("Meshes of blades", &text);
    Ok(())
}

/// Meshes of rising numbers of vertices.
fn ladder(
    desk: &mut Desk<'_>,
    (name, settings): (&str, &Settings),
    table: &mut Table,
) -> Result<Vec<Grade>, Diagnostics> {
    let most = if desk.request.quick { JUDGED } else { u32::MAX };
    let least = if desk.request.quick { 200 } else { 0 };
    let chosen =
        VERTICES.iter().filter(|&&vertices| vertices <= most && vertices >= least && (vertices != 1200 || least == 0));
    let trials: Vec<Trial<'_>> = chosen
        .map(|&vertices| Trial {
            outline: name,
            param: "vertices",
            settings: Settings { vertices, ..settings.clone() },
        })
        .collect();
    graded(desk, &trials, table)
}

/// One mesh after more and more rounds, and the bare triangulation.
fn rounds(desk: &mut Desk<'_>, (name, settings): (&str, &Settings), table: &mut Table) -> Result<(), Diagnostics> {
    let trial = |param, iterations, meshing| {
        let settings = Settings { vertices: 600, iterations, meshing, ..settings.clone() };
        Trial { outline: name, param, settings }
    };
    let mut trials: Vec<Trial<'_>> = ROUNDS.map(|rounds| trial("rounds", rounds, Meshing::Even)).into();
    trials.push(trial("bare", 0, Meshing::Delaunay));
    graded(desk, &trials, table).map(|_| ())
}

fn graded(desk: &mut Desk<'_>, trials: &[Trial<'_>], table: &mut Table) -> Result<Vec<Grade>, Diagnostics> {
    let cases: Vec<Case<'_>> = trials.iter().map(|trial| Case::new(move || trial.digest())).collect();
    let effort = Effort::of(desk.request.quick);
    let effort = Effort { budget: effort.budget.min(0.5), ..effort };
    let times = measured(&cases, effort);
    let graded: Vec<_> = trials.par_iter().map(|trial| trial.graded()).collect();
    let mut grades = Vec::new();
    for ((trial, times), graded) in trials.iter().zip(times).zip(graded) {
        let name = format!("mesh {} {} {}", trial.outline, trial.param, trial.settings.vertices);
        let (grade, keys, excused) = graded.ok_or_else(|| bug(&format!("{name} cannot be made")))?;
        desk.steady(&name, times.is_same);
        desk.tell(&format!("{name}: Hausdorff {}, smallest angle {:.1}", shown(grade.hausdorff), grade.min_angle));
        table.push(row(trial, &grade, excused, keys, &times));
        grades.push(grade);
    }
    Ok(grades)
}

fn row(trial: &Trial<'_>, grade: &Grade, excused: f64, keys: usize, times: &Times) -> Vec<Field> {
    vec![
        trial.outline.into(),
        keys.into(),
        trial.param.into(),
        trial.settings.iterations.into(),
        grade.vertices.into(),
        grade.triangles.into(),
        grade.min_angle.into(),
        excused.into(),
        grade.angle_p01.into(),
        grade.mean_min_angle.into(),
        grade.edge_cv.into(),
        grade.mean_rr.into(),
        grade.worst_rr.into(),
        grade.valence_six.into(),
        grade.area_error.into(),
        grade.hausdorff.into(),
        (times.seconds[1] * 1e3).into(),
        (times.seconds[0] * 1e3).into(),
        (times.seconds[2] * 1e3).into(),
        times.rounds.into(),
        times.ratio[1].into(),
    ]
}

/// The targets, on every outline's mesh of 2,000 vertices.
fn judge(desk: &mut Desk<'_>, grades: &[(String, Grade)]) {
    let mut missed = Vec::new();
    let judged: Vec<&(String, Grade)> =
        grades.iter().filter(|(_, grade)| (1900..2200).contains(&grade.vertices)).collect();
    for (name, grade) in &judged {
        let mut faults = grade.missed_targets();
        if !outlines::SMOOTH.contains(&name.as_str()) {
            faults.retain(|fault| !fault.starts_with("rim ") && !fault.starts_with("area "));
        }
        if !faults.is_empty() {
            missed.push(format!("{name}: {}", faults.join(", ")));
        }
    }
    let toothed =
        judged.iter().filter(|(name, grade)| !outlines::SMOOTH.contains(&name.as_str()) && grade.hausdorff > 1e-3);
    let rims: Vec<String> = toothed.map(|(name, grade)| format!("{name} {:.4}", grade.hausdorff)).collect();
    let found = match missed.as_slice() {
        [] => format!(
            "met on {} outlines at {JUDGED} vertices; rims with teeth farther than 1e-3: {}",
            judged.len(),
            rims.join(", ")
        ),
        missed => missed.join("; "),
    };
    let asked = "smallest angle 25, 1st percentile 33, mean smallest 54 degrees; edge variation 0.12; mean 2r/R 0.95, worst \
                 0.5; valence 6 on 70 %; where there are no teeth (margins with \
                 teeth are drawn apart from the mesh) area within 0.1 % and rim within 1e-3 (triangles at tips sharper than 60 degrees excused)";
    desk.judge("P10", missed.is_empty() && !judged.is_empty(), asked, found);
}
