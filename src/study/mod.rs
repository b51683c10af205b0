//! Studies: what the program makes, measured and held against what is known, and what it costs.
//!
//! Error against work, family by family: `deform` (ways to a leaf's shape), `stability` (how long a step may be) with `matrix`
//! (stiff and extreme cases), `chain` (the seasons' law), `mesh` (blades), `raster` (pictures), `left_out` (what a scene does
//! not need) and `quality` (the error that a scene asks for). A family writes a table, a chart and its part of `report.md`, and
//! judges lines that pass or fail by errors, orders and counts, never by seconds. Columns whose names begin as in
//! [`table::VOLATILE`] depend on the machine; all others are the same in every run.
//!
//! [`trees`] holds the species as trees against what is known of them.

mod chain;
mod chains;
mod chart;
mod count;
mod deform;
pub mod desk;
mod environment;
mod expectation;
mod fan;
mod grade;
mod left_out;
mod linear;
mod matrix;
mod mesh;
pub mod numbers;
mod oscillator;
mod outlines;
mod own;
mod problems;
mod quality;
mod raster;
mod silhouette;
mod stability;
mod stage;
mod stature;
mod statures;
pub mod table;
mod timing;
pub mod trees;

use crate::base::diagnostic::Diagnostics;
use crate::base::family::Family;
pub use count::do_row;
use desk::{Desk, Request};
use own::Own;

/// Runs the families that are asked for; whether every line passes. `tell` is told of each row.
///
/// # Errors
/// Scenes that cannot be made, files that cannot be written.
pub fn run(request: &Request, tell: &mut dyn FnMut(&str)) -> Result<bool, Diagnostics> {
    let mut desk = Desk::new(request, tell);
    let scene = request.subject.as_ref().map(|subject| &subject.scene);
    let looks_inside = [Family::Chain, Family::Mesh, Family::Deform].iter().any(|family| desk.has(*family));
    let own = match scene.filter(|_| looks_inside) {
        Some(scene) => Own::of(&mut desk, scene)?,
        None => Own::default(),
    };
    // Built-in problems stand in for no part of a scene.
    let is_free = |has_part: bool| scene.is_none() || has_part;
    if desk.has(Family::Chain) && is_free(own.chain.is_some()) {
        chain::study(&mut desk, own.chain)?;
    }
    if desk.has(Family::Mesh) && is_free(own.blade.is_some()) {
        mesh::study(&mut desk, own.blade)?;
    }
    if desk.has(Family::Deform) && is_free(own.bending.is_some()) {
        deform::study(&mut desk, own.bending)?;
    }
    // What is stable does not depend on a scene.
    if desk.has(Family::Stability) && is_free(request.family != Family::All) {
        stability::study(&mut desk)?;
        matrix::study(&mut desk)?;
    }
    if desk.has(Family::Raster) {
        raster::study(&mut desk, scene)?;
    }
    if desk.has(Family::LeftOut) {
        left_out::study(&mut desk)?;
    }
    if desk.has(Family::Quality) {
        quality::study(&mut desk)?;
    }
    if desk.has(Family::Trees) {
        statures::study(&mut desk)?;
    }
    desk.close()
}

/// One figure of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What was measured: `red-maple at 25 years`.
    pub subject: String,
    /// The figure's name, with its unit: `height_m`.
    pub figure: String,
    /// What came out; `None` when there was nothing to measure.
    pub value: Option<f64>,
    /// The range asked for.
    pub asked: [f64; 2],
    /// The range that passes: as asked where a flora or paper says so, wider where it is a judgement.
    pub passes: [f64; 2],
    /// `S` for what is read in a flora or paper, `E` for a judgement, `=` for an identity.
    pub standing: char,
}

impl Line {
    /// Whether the figure is in the range that passes.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.value.is_some_and(|value| (self.passes[0]..=self.passes[1]).contains(&value))
    }
}

/// The lines as a table for people.
#[must_use]
pub fn table(lines: &[Line]) -> String {
    let mut text = String::new();
    let mut subject = "";
    for line in lines {
        if line.subject != subject {
            subject = &line.subject;
            text.push_str(&format!("{subject}\n"));
        }
        let value = line.value.map_or_else(|| "none".to_owned(), figure);
        let asked = format!("{} to {}", figure(line.asked[0]), figure(line.asked[1]));
        let met = match (line.is_met(), line.value) {
            (true, Some(value)) if (line.asked[0]..=line.asked[1]).contains(&value) => "met",
            (true, _) => "met within a fifth",
            (false, _) => "NOT MET",
        };
        text.push_str(&format!("  {:<22} {value:>10}   {}  {asked:<18} {met}\n", line.figure, line.standing));
    }
    let missed = lines.iter().filter(|line| !line.is_met()).count();
    text.push_str(&format!("{} of {} lines met\n", lines.len() - missed, lines.len()));
    text
}

/// The lines as comma-separated values with a header.
#[must_use]
pub fn csv(lines: &[Line]) -> String {
    let mut text = "subject,figure,value,standing,asked_low,asked_high,passes_low,passes_high,met\n".to_owned();
    for line in lines {
        let value = line.value.map_or_else(String::new, |value| value.to_string());
        let ([low, high], [least, most]) = (line.asked, line.passes);
        let subject = format!("\"{}\"", line.subject.replace('"', "\"\""));
        let (name, standing, met) = (&line.figure, line.standing, line.is_met());
        text.push_str(&format!("{subject},{name},{value},{standing},{low},{high},{least},{most},{met}\n"));
    }
    text
}

/// Three significant digits, or a whole number.
fn figure(value: f64) -> String {
    match value.abs() {
        size if value == value.round() && size < 1e6 => format!("{value}"),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        size if size >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}
