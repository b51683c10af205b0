//! Even-sized triangles between closed curves, by rounds of the paper's two steps: relocate the vertices, modify the
//! connections (Tang, Wu and Fan 2013, section 3, after the skin of Markosian et al. 1999: split, collapse, flip, relax).
//!
//! | step | how | where |
//! |---|---|---|
//! | rim | of all ways to stand vertices on the curve, the one whose chords are even, near the curve, and meet in multiples of 60 degrees: dynamic programming | `ring` |
//! | area | each rim vertex stands off the curve by half of what its chords cut off | `offset` |
//! | round 0 | constrained Delaunay triangulation (spade, exact predicates) of the rim and a hexagonal lattice whose rows follow the rim | `seeds`, `triangulation` |
//! | relocate | each vertex takes a Newton step, or slides on the curve, to where its triangles cost less | `relocate`, `energy` |
//! | reconnect | edges flip where that costs less; at irregular vertices edges are tried flipped, split, collapsed | `flip`, `reconnect`, `trial` |
//!
//! Edges are even, or shorter by a given share about the origin ([`Sizing`]): all rows of the table then go by the wanted length
//! of the place, and so do the figures of evenness.
//!
//! One cost rules both steps ([`energy`]: inverse mean ratio and area, in the spirit of Freitag and Knupp 2002), so that
//! neither undoes the other's work and the rounds settle. A vertex that rests is left out until one beside it moves.
//!
//! What holds for every result:
//! - the triangles are counter-clockwise, fill the loops, and each edge has two of them, or one on a loop;
//! - the loops neither touch nor cross; a round that made them is taken back, and the chords concerned stay as they were;
//! - a result of more rounds has neither a lower score nor a lower mean q than one of fewer ([`Quality::is_no_worse_than`]),
//!   and `history` tells what fewer rounds would have given;
//! - the first vertex of each loop is that planned nearest its first key, and on it where that costs little; along the
//!   curve it moves away by a seventh of the spacing at most;
//! - the vertices' number is within 5 % of the wanted one, where the rim leaves room for as many within; an outline that
//!   is too narrow or too lobed for so few vertices gets as many as its rim needs;
//! - everything is computed in one fixed order by one thread.
//!
//! What does not: there is no bound on the smallest angle (a tip sharper than 60 degrees cannot have a larger one; such
//! triangles are counted apart), nor on the rim's distance from the curve: teeth and bays less deep than about a quarter
//! of an edge are smoothed over where they would cost thin triangles ([`straying`]).

mod curve;
mod edit;
mod energy;
mod flip;
mod offset;
mod quality;
mod reconnect;
mod relocate;
mod rim;
mod ring;
mod seeds;
mod sizing;
mod straying;
mod trial;
mod triangulation;
mod web;

use crate::base::vector::DVec2;
use crate::leaf::LeafError;
use crate::leaf::spline::Spline;
use curve::Curve;
pub use quality::Quality;
use quality::graded;
use reconnect::Count;
use relocate::Mesher;
use rim::Rim;
pub use sizing::Sizing;
use std::ops::Range;
use straying::PLANNED;
pub use triangulation::{Topology, triangulated};

use web::Web;

/// Share of the wanted vertices by which splits and collapses may change their number.
const SLACK: f64 = 0.03;
/// Most vertices that the rim may need, as a multiple of the wanted ones and on top of it: a leaf's rim takes a third of them,
/// and a comb's rounds would never end.
const MOST_RIM: usize = 4;
const SPARE_RIM: usize = 400;
/// Edges are tried with a change when no vertex moves by more than this share of the spacing.
const QUIET: f64 = 0.02;
/// Rounds end when no vertex moves by more than this, and no change was kept.
const SETTLED: f64 = 2e-3;
/// Rounds also end when so many in a row brought nothing better.
const IDLE: u32 = 14;
/// A mesh that settles with an angle below this, radians, goes on so often with thin triangles costing more.
const SHARP: f64 = 35.0 * std::f64::consts::PI / 180.0;
const STIFFENINGS: u32 = 2;

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
    sized(loops, wanted, iterations, Sizing::EVEN)
}

/// As [`evened`], with edges of the lengths of a sizing.
///
/// # Errors
/// As [`evened`].
pub fn sized(loops: &[Spline], wanted: usize, iterations: u32, sizing: Sizing) -> Result<Remesh, LeafError> {
    let curves = curves(loops, wanted)?;
    let (rim, spacing) = fitted(&curves, wanted, sizing)?;
    let rings = rim.points();
    let inner = wanted.saturating_sub(rings.iter().map(Vec::len).sum());
    let seeds = seeds::lattice(&rings, (spacing, sizing), inner, seeds::heading(&rings));
    Rounds::new(Remesh::of(&rings, seeds, sizing)?, rim, (spacing, sizing), wanted)?.run(iterations)
}

/// The constrained Delaunay triangulation of the rim of such a mesh alone: the long and narrow triangles of the paper's
/// Figure 1(b), which the rounds are there to mend.
///
/// # Errors
/// As [`evened`].
#[allow(dead_code)] // Asked for by studies of the rounds, not by the leaf stage.
pub fn bare(loops: &[Spline], wanted: usize) -> Result<Remesh, LeafError> {
    let curves = curves(loops, wanted)?;
    let (rim, _) = fitted(&curves, wanted, Sizing::EVEN)?;
    Remesh::of(&rim.points(), Vec::new(), Sizing::EVEN)
}

/// The numbers of the points of each loop if all stand in one row.
fn ranges<T>(loops: &[Vec<T>]) -> Vec<Range<usize>> {
    let mut end = 0;
    let range = |points: &Vec<T>| {
        end += points.len();
        end - points.len()..end
    };
    loops.iter().map(range).collect()
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
fn fitted<'a>(curves: &'a [Curve<'a>], wanted: usize, sizing: Sizing) -> Result<(Rim<'a>, f64), LeafError> {
    let mut area: f64 = curves.iter().map(Curve::area).sum();
    let mut spacing = (area / 0.75f64.sqrt() / wanted as f64).sqrt();
    let needed = curves.iter().map(Curve::length).sum::<f64>() / spacing;
    if needed > (MOST_RIM * wanted + SPARE_RIM) as f64 {
        let what =
            format!("the outline is too long and narrow for {wanted} vertices: its rim alone needs about {needed:.0}");
        return Err(LeafError::Mesh { what });
    }
    let mut rim = Rim::fitted(curves, (spacing, sizing), PLANNED.among(wanted))?;
    area += sizing.surplus(&rim.points());
    let triangles = (2 * (wanted + curves.len())).saturating_sub(4 + rim.loops().concat().len()).max(wanted / 2);
    spacing = (2.0 * area / 0.75f64.sqrt() / triangles as f64).sqrt();
    rim = Rim::fitted(curves, (spacing, sizing), PLANNED.among(wanted))?;
    Ok((rim, spacing))
}

/// The rounds under way, and the best mesh so far.
struct Rounds<'a> {
    mesher: Mesher<'a>,
    best: Remesh,
    sizing: Sizing,
}

impl<'a> Rounds<'a> {
    fn new(start: Remesh, rim: Rim<'a>, (spacing, sizing): (f64, Sizing), wanted: usize) -> Result<Self, LeafError> {
        let narrow = || LeafError::Mesh { what: "the outline is too narrow to be triangulated".to_owned() };
        let edges = start.loops.iter().map(ExactSizeIterator::len).sum();
        let web = Web::new(start.points.clone(), start.topology.triangles.clone(), edges).ok_or_else(narrow)?;
        let slack = (SLACK * wanted as f64) as usize;
        let count = Count { now: start.points.len(), least: wanted.saturating_sub(slack), most: wanted + slack };
        Ok(Self { mesher: Mesher::new(web, rim, (spacing, sizing), count), best: start, sizing })
    }

    fn run(mut self, iterations: u32) -> Result<Remesh, LeafError> {
        let (mut idle, mut stiffenings) = (0, 0);
        for round in 1..=iterations {
            let before = self.mesher.clone();
            let mut settled = self.round();
            let crossing = self.mesher.rim.crossing();
            if !crossing.is_empty() {
                self.mesher = before;
                self.mesher.rim.freeze(&crossing);
                settled = false;
            }
            idle = if self.keep_better() { 0 } else { idle + 1 };
            self.best.rounds = round;
            if settled || idle == IDLE {
                if stiffenings == STIFFENINGS || self.best.quality.min_angle > SHARP {
                    break;
                }
                self.mesher.stiffen();
                (idle, stiffenings) = (0, stiffenings + 1);
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
            kept = self.mesher.reconnect();
        }
        self.mesher.set_off();
        moved < SETTLED && flipped + kept == 0
    }

    /// Takes the mesh as it stands if it is no worse than the best; whether it was taken.
    fn keep_better(&mut self) -> bool {
        let web = &self.mesher.web;
        let rings = self.mesher.rim.loops();
        let inner = (0..web.places() as u32).filter(|&v| web.is_vertex(v) && !self.mesher.rim.holds(v));
        let order: Vec<u32> = rings.iter().flatten().copied().chain(inner).collect();
        let mut numbers = vec![web::NONE; web.places()];
        order.iter().enumerate().for_each(|(number, &v)| numbers[v as usize] = number as u32);
        let points: Vec<DVec2> = order.iter().map(|&v| web.point(v)).collect();
        let triangles: Vec<[u32; 3]> = web.triangles().map(|(_, t)| t.map(|v| numbers[v as usize])).collect();
        let loops = ranges(&rings);
        let quality = graded(&points, &loops, &triangles, self.sizing);
        let better = quality.is_no_worse_than(&self.best.quality);
        if better {
            (self.best.points, self.best.loops, self.best.quality) = (points, loops, quality);
            self.best.topology = Topology { triangles, edges: Vec::new() };
        }
        self.best.history.push(self.best.quality);
        better
    }
}

impl Remesh {
    /// The triangulation of loops and the points within.
    fn of(rings: &[Vec<DVec2>], inner: Vec<DVec2>, sizing: Sizing) -> Result<Self, LeafError> {
        let loops = ranges(rings);
        let mut points = rings.concat();
        points.extend(inner);
        let topology = triangulated(&points, &loops)?;
        let quality = graded(&points, &loops, &topology.triangles, sizing);
        Ok(Self { points, loops, topology, quality, rounds: 0, history: vec![quality] })
    }
}

#[cfg(test)]
mod tests;
