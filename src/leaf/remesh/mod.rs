//! Even-sized triangles inside an outline, by rounds of the paper's two steps: relocate the vertices, modify the connections.

mod curve;
mod energy;
mod quality;
mod reconnect;
mod relocate;
mod rim;
mod ring;
mod seeds;
mod triangulation;
mod web;

use crate::base::vector::DVec2;
use crate::leaf::LeafError;
use crate::leaf::spline::Spline;
use curve::Curve;
use energy::Energy;
pub use quality::Quality;
use quality::graded;
use reconnect::{Count, Marks};
use relocate::Mesher;
use rim::Rim;
use std::ops::Range;
pub use triangulation::Topology;
use triangulation::triangulated;
use web::Web;

/// Share of the wanted vertices by which splits and collapses may change their number.
const SLACK: f64 = 0.03;
/// Edges are tried with a change when no vertex moves by more than this share of the spacing.
const QUIET: f64 = 0.02;
/// Rounds end when no vertex moves by more than this, and no change was kept.
const SETTLED: f64 = 2e-3;

/// A mesh whose first points are its loops.
#[derive(Clone, Debug, PartialEq)]
pub struct Remesh {
    /// Vertices: those of the loops in order, loop by loop, then the inner ones.
    pub points: Vec<DVec2>,
    /// Vertex numbers of each loop; the first is the rim, the others are holes.
    pub loops: Vec<Range<usize>>,
    /// Triangles and edges.
    pub topology: Topology,
    /// Figures of the result.
    pub quality: Quality,
    /// Rounds that were run.
    pub rounds: u32,
    /// Figures of the result if there had been only so many rounds: 0, 1, ... `rounds`.
    pub history: Vec<Quality>,
}

/// A mesh of about `wanted` vertices between closed curves, after at most `iterations` rounds.
///
/// # Errors
/// [`LeafError::Mesh`] when the curves touch or cross, or are too narrow to be triangulated.
pub fn evened(loops: &[Spline], wanted: usize, iterations: u32) -> Result<Remesh, LeafError> {
    let curves = curves(loops, wanted)?;
    let (rim, spacing) = fitted(&curves, wanted)?;
    let inner = wanted.saturating_sub(rim.len());
    let mut points = rim.points();
    let rings: Vec<&[DVec2]> = rim.loops.iter().map(|range| &points[range.clone()]).collect();
    let seeds = if inner > 0 { seeds::lattice(&rings, spacing, inner, 0.0) } else { Vec::new() };
    points.extend(seeds);
    let topology = triangulated(&points, &rim.loops)?;
    Rounds::new(points, topology, rim, spacing, wanted)?.run(iterations)
}

fn curves(loops: &[Spline], wanted: usize) -> Result<Vec<Curve<'_>>, LeafError> {
    let rough: Vec<Curve> = loops.iter().map(|spline| Curve::new(spline, f64::INFINITY)).collect();
    let area: f64 = rough.iter().map(Curve::area).sum();
    if !(area.is_finite() && area > 0.0) {
        return Err(LeafError::Mesh {
            what: "the outline encloses no area; give its points counter-clockwise".to_owned(),
        });
    }
    let spacing = (area / wanted.max(3) as f64).sqrt();
    Ok(loops.iter().map(|spline| Curve::new(spline, spacing / 16.0)).collect())
}

/// A rim, and the spacing at which even triangles between it and `wanted` vertices in all fill the area: a triangulation of
/// n vertices, b of them on 1 + holes loops, has 2 (n - 1 + holes) - b triangles.
fn fitted<'a>(curves: &'a [Curve<'a>], wanted: usize) -> Result<(Rim<'a>, f64), LeafError> {
    let area: f64 = curves.iter().map(Curve::area).sum();
    let mut spacing = (area / 0.75f64.sqrt() / wanted as f64).sqrt();
    let mut rim = Rim::fitted(curves, spacing)?;
    for _ in 0..2 {
        let triangles = (2 * (wanted + curves.len())).saturating_sub(4 + rim.len()).max(wanted / 2);
        spacing = (2.0 * area / 0.75f64.sqrt() / triangles as f64).sqrt();
        rim = Rim::fitted(curves, spacing)?;
    }
    Ok((rim, spacing))
}

/// The rounds under way, and the best mesh so far.
struct Rounds<'a> {
    mesher: Mesher<'a>,
    count: Count,
    best: Remesh,
    tried: Vec<bool>,
    marks: Marks,
}

impl<'a> Rounds<'a> {
    fn new(
        points: Vec<DVec2>,
        topology: Topology,
        rim: Rim<'a>,
        spacing: f64,
        wanted: usize,
    ) -> Result<Self, LeafError> {
        let narrow = || LeafError::Mesh { what: "the outline is too narrow to be triangulated".to_owned() };
        let web = Web::new(points.clone(), topology.triangles.clone(), rim.len()).ok_or_else(narrow)?;
        let quality = graded(&points, &rim.loops, &topology.triangles);
        let slack = (SLACK * wanted as f64) as usize;
        let count = Count { now: points.len(), least: wanted.saturating_sub(slack), most: wanted + slack };
        let loops = rim.loops.clone();
        let best = Remesh { points, loops, topology, quality, rounds: 0, history: vec![quality] };
        let energy = Energy { doubled_area: spacing * spacing * 0.75f64.sqrt() };
        let mesher = Mesher::new(web, rim, energy, spacing);
        Ok(Self { mesher, count, best, tried: Vec::new(), marks: Marks::default() })
    }

    fn run(mut self, iterations: u32) -> Result<Remesh, LeafError> {
        for round in 1..=iterations {
            let settled = self.round();
            self.keep_better();
            self.best.rounds = round;
            if settled {
                break;
            }
        }
        self.best.topology = Topology::of(self.best.topology.triangles.into_iter());
        Ok(self.best)
    }

    /// One round; whether nothing is left to gain.
    fn round(&mut self) -> bool {
        let moved = self.mesher.relocate() / self.mesher.spacing;
        let flipped = self.mesher.flip_all();
        let mut kept = 0;
        if moved < QUIET {
            self.mesher.set_off();
            kept = self.mesher.reconnect(&mut self.count, &mut self.tried, &mut self.marks);
        }
        moved < SETTLED && flipped + kept == 0
    }

    /// Takes the mesh as it stands if it is no worse than the best.
    fn keep_better(&mut self) {
        let web = &self.mesher.web;
        let triangles: Vec<[u32; 3]> = web.triangles().map(|(_, corners)| corners).collect();
        let quality = graded(web.points(), &self.best.loops, &triangles);
        if quality.is_no_worse_than(&self.best.quality) && self.mesher.rim.is_simple(web.points()) {
            let mut numbers = vec![web::NONE; web.places()];
            let live = (0..web.places() as u32).filter(|&v| web.is_vertex(v));
            self.best.points = live.clone().map(|v| web.point(v)).collect();
            live.enumerate().for_each(|(number, v)| numbers[v as usize] = number as u32);
            let renumbered = triangles.iter().map(|t| t.map(|v| numbers[v as usize]));
            self.best.topology = Topology { triangles: renumbered.collect(), edges: Vec::new() };
            self.best.quality = quality;
        }
        self.best.history.push(self.best.quality);
    }
}
