//! Even-sized triangles inside a rim, by rounds of the paper's two steps: relocate the vertices, modify the connections.
//!
//! Seeds stand on a hexagonal lattice. A round moves every inner vertex to the area-weighted mean of its triangles'
//! circumcentres (Du, Faber and Gunzburger 1999: centroidal Voronoi tessellation by Lloyd's rounds, in the form of Alliez et
//! al. 2005) and reconnects by constrained Delaunay, which is flipping until no flip is left. When the rounds have settled,
//! single vertices are collapsed, or split off, at the worst triangles, and what raises the quality is kept.

use crate::base::vector::DVec2;
use crate::leaf::LeafError;
use crate::leaf::polygon;
use crate::leaf::quality::{Quality, angles, graded, sharp_rim};
use crate::leaf::ring;
use crate::leaf::triangulation::{Topology, triangulated};

/// Inner vertices keep this share of the spacing away from the rim.
const CLEARANCE: f64 = 0.45;
/// Seeds keep more, so that the first rounds start even.
const SEED_CLEARANCE: f64 = 0.62;
/// Rounds have settled when the score moves less than this.
const SETTLED: f64 = 1e-5;
/// Rounds of relaxation after a collapse or split, and how many of those are tried.
const REPAIR_ROUNDS: u32 = 6;
const REPAIRS: u32 = 14;
/// Share of the wanted vertices by which repairs may change their number.
const SLACK: f64 = 0.04;

/// A mesh whose first `rim` points are the rim.
#[derive(Clone, Debug, PartialEq)]
pub struct Remesh {
    /// Vertices.
    pub points: Vec<DVec2>,
    /// How many of them are the rim.
    pub rim: usize,
    /// Triangles and edges.
    pub topology: Topology,
    /// Figures of the result.
    pub quality: Quality,
    /// Rounds that were run.
    pub rounds: u32,
}

/// A mesh of about `wanted` vertices inside the dense `outline`, after at most `iterations` rounds.
///
/// # Errors
/// [`LeafError::Mesh`] when the outline is too narrow for that many vertices.
pub fn evened(outline: &[DVec2], wanted: usize, iterations: u32) -> Result<Remesh, LeafError> {
    let (rim_points, spacing) = fitted_ring(outline, wanted)?;
    let rim = rim_points.len();
    let inner = wanted.saturating_sub(rim);
    let mut points = rim_points;
    let seeds = seeds(&points, spacing, inner);
    points.extend(seeds);
    let mut best = Remesh::graded(points, rim, 0)?;
    best.settle(spacing, iterations)?;
    best.repair(spacing, iterations, wanted)?;
    Ok(best)
}

/// A simple rim and the spacing at which lattice and rim together have the wanted number of vertices: a triangulation of
/// area A with edges h and a rim of b vertices has A / (h^2 sqrt(3)/2) + b/2 + 1.
fn fitted_ring(outline: &[DVec2], wanted: usize) -> Result<(Vec<DVec2>, f64), LeafError> {
    let area = polygon::doubled_area(outline) * 0.5;
    let cell = area / 0.75f64.sqrt();
    let mut spacing = (cell / wanted as f64).sqrt();
    let mut ring = ring::sampled(outline, spacing);
    for _ in 0..6 {
        let room = (wanted as f64 - ring.len() as f64 * 0.5 - 1.0).max(wanted as f64 * 0.2);
        spacing = (cell / room).sqrt();
        ring = ring::sampled(outline, spacing);
    }
    for _ in 0..8 {
        if polygon::crossing(&ring).is_none() && polygon::doubled_area(&ring) > 0.0 {
            return Ok((ring, spacing));
        }
        spacing *= 0.75;
        ring = ring::sampled(outline, spacing);
    }
    Err(LeafError::Mesh { what: format!("the outline is too narrow for {wanted} vertices") })
}

/// About `wanted` lattice points inside the rim, mirrored about x = 0.
fn seeds(rim: &[DVec2], spacing: f64, wanted: usize) -> Vec<DVec2> {
    let mut pitch = spacing;
    let mut best: Vec<DVec2> = Vec::new();
    for _ in 0..8 {
        let points = lattice(rim, pitch);
        if points.len().abs_diff(wanted) < best.len().abs_diff(wanted) || best.is_empty() {
            best.clone_from(&points);
        }
        let ratio = (points.len() as f64 + 1.0) / (wanted as f64 + 1.0);
        pitch = (pitch * ratio.sqrt()).clamp(0.6 * spacing, 1.6 * spacing);
    }
    best
}

fn lattice(rim: &[DVec2], pitch: f64) -> Vec<DVec2> {
    let low = rim.iter().fold(rim[0], |low, p| low.inf(p));
    let high = rim.iter().fold(rim[0], |high, p| high.sup(p));
    let rise = pitch * 0.75f64.sqrt();
    let mut points = Vec::new();
    for row in (low.y / rise).floor() as i64..=(high.y / rise).ceil() as i64 {
        let shift = if row.rem_euclid(2) == 1 { 0.5 } else { 0.0 };
        for column in (low.x / pitch).floor() as i64 - 1..=(high.x / pitch).ceil() as i64 {
            let p = DVec2::new((column as f64 + shift) * pitch, row as f64 * rise);
            if polygon::contains(rim, p) && polygon::distance(rim, p) > SEED_CLEARANCE * pitch {
                points.push(p);
            }
        }
    }
    points
}

/// The circumcentre, or the centroid where the circumcentre lies far off.
fn centre([a, b, c]: [DVec2; 3]) -> DVec2 {
    let (ab, ac) = (b - a, c - a);
    let doubled = 2.0 * ab.perp(&ac);
    let (u, w) = (ab.norm_squared(), ac.norm_squared());
    let circumcentre = a + DVec2::new(u * ac.y - w * ab.y, w * ab.x - u * ac.x) / doubled;
    let centroid = (a + b + c) / 3.0;
    if (circumcentre - centroid).norm() < doubled.abs().sqrt() * 0.5 { circumcentre } else { centroid }
}

impl Remesh {
    fn graded(points: Vec<DVec2>, rim: usize, rounds: u32) -> Result<Self, LeafError> {
        let topology = triangulated(&points, rim)?;
        let quality = graded(&points, rim, &topology);
        Ok(Self { points, rim, topology, quality, rounds })
    }

    /// One round: relocate, then reconnect.
    fn relaxed(&self, spacing: f64) -> Result<Self, LeafError> {
        let count = self.points.len();
        let (mut sums, mut areas) = (vec![DVec2::zeros(); count], vec![0.0; count]);
        let mut beside_rim = vec![false; count];
        for triangle in &self.topology.triangles {
            let corners = triangle.map(|v| self.points[v as usize]);
            let area = (corners[1] - corners[0]).perp(&(corners[2] - corners[0]));
            let rim = triangle.iter().any(|&v| (v as usize) < self.rim);
            for &v in triangle {
                sums[v as usize] += centre(corners) * area;
                areas[v as usize] += area;
                beside_rim[v as usize] |= rim;
            }
        }
        let rim_points = &self.points[..self.rim];
        let mut points = self.points.clone();
        for v in self.rim..count {
            let target = sums[v] / areas[v];
            let clear =
                || polygon::contains(rim_points, target) && polygon::distance(rim_points, target) > CLEARANCE * spacing;
            if areas[v] > 0.0 && (!beside_rim[v] || clear()) {
                points[v] = target;
            }
        }
        Self::graded(points, self.rim, self.rounds + 1)
    }

    /// Rounds until the score settles; keeps the best round.
    fn settle(&mut self, spacing: f64, iterations: u32) -> Result<(), LeafError> {
        let mut current = self.clone();
        let mut still = 0;
        while current.rounds < iterations && still < 4 {
            let next = current.relaxed(spacing)?;
            let gain = next.quality.score() - current.quality.score();
            still = if gain.abs() < SETTLED { still + 1 } else { 0 };
            current = next;
            if current.quality.score() >= self.quality.score() {
                *self = current.clone();
            }
        }
        self.rounds = current.rounds;
        Ok(())
    }

    /// Collapses or splits at the worst triangles as long as it helps.
    fn repair(&mut self, spacing: f64, iterations: u32, wanted: usize) -> Result<(), LeafError> {
        let mut refused: Vec<DVec2> = Vec::new();
        for _ in 0..REPAIRS {
            let Some((place, options)) = self.worst(&refused, spacing) else { break };
            let start = self.rounds;
            let mut better: Option<Self> = None;
            for points in options {
                if points.len().abs_diff(wanted) as f64 > (SLACK * wanted as f64).max(1.0) {
                    continue;
                }
                let mut trial = Self::graded(points, self.rim, self.rounds)?;
                trial.settle(spacing, iterations.min(start + REPAIR_ROUNDS))?;
                self.rounds = self.rounds.max(trial.rounds);
                let bar = better.as_ref().map_or(self.quality.score(), |b| b.quality.score());
                if trial.quality.score() > bar + SETTLED {
                    better = Some(trial);
                }
            }
            let rounds = self.rounds;
            match better {
                Some(trial) => *self = trial,
                None => refused.push(place),
            }
            self.rounds = rounds;
            if self.rounds >= iterations {
                break;
            }
        }
        Ok(())
    }

    /// The worst triangle that was not refused yet, and what may mend it: a vertex less, a vertex more, one moved.
    fn worst(&self, refused: &[DVec2], spacing: f64) -> Option<(DVec2, Vec<Vec<DVec2>>)> {
        let sharp = sharp_rim(&self.points, self.rim);
        let corners = |t: &[u32; 3]| t.map(|v| self.points[v as usize]);
        let middle = |t: &[u32; 3]| corners(t).iter().sum::<DVec2>() / 3.0;
        let excused = |t: &[u32; 3]| t.iter().any(|&v| sharp.get(v as usize).copied().unwrap_or(false));
        let known = |t: &[u32; 3]| refused.iter().any(|p| (p - middle(t)).norm() < 0.3 * spacing);
        let smallest = |t: &[u32; 3]| angles(corners(t)).into_iter().fold(9.0, f64::min);
        let candidates = self.topology.triangles.iter().filter(|t| !excused(t) && !known(t));
        let triangle = candidates.min_by(|a, b| smallest(a).total_cmp(&smallest(b)))?;
        if smallest(triangle) > 0.66 {
            return None;
        }
        let mut options: Vec<Vec<DVec2>> = triangle.iter().filter_map(|&v| self.without(v as usize)).collect();
        let place = middle(triangle);
        for p in [place, centre(corners(triangle))] {
            options.extend(self.with(p, spacing));
        }
        Some((place, options))
    }

    fn without(&self, vertex: usize) -> Option<Vec<DVec2>> {
        (vertex >= self.rim).then(|| {
            let mut points = self.points.clone();
            points.remove(vertex);
            points
        })
    }

    fn with(&self, point: DVec2, spacing: f64) -> Option<Vec<DVec2>> {
        let rim = &self.points[..self.rim];
        let fits = polygon::contains(rim, point) && polygon::distance(rim, point) > 0.3 * spacing;
        fits.then(|| self.points.iter().copied().chain([point]).collect())
    }
}
