//! The rim of a mesh: vertices that slide on the loops of the outline, set off so far that the rim encloses the outline's area.

use crate::base::vector::DVec2;
use crate::leaf::LeafError;
use crate::leaf::polygon;
use crate::leaf::remesh::curve::Curve;
use crate::leaf::remesh::ring;
use std::ops::Range;

/// A vertex is set off by at most this share of the spacing.
const FARTHEST: f64 = 0.2;
/// How often chords that cross are halved.
const HALVINGS: u32 = 14;

/// Vertices on the loops, loop by loop.
#[derive(Clone, Debug)]
pub struct Rim<'a> {
    curves: &'a [Curve<'a>],
    /// Vertex numbers of each loop.
    pub loops: Vec<Range<usize>>,
    /// Which loop each vertex belongs to.
    owner: Vec<u32>,
    /// Arc length of each vertex on its loop.
    pub arcs: Vec<f64>,
    /// Vertices that do not slide: the first of each loop, and corners of the curve.
    pub fixed: Vec<bool>,
    /// How far each vertex stands off the curve.
    shifts: Vec<DVec2>,
}

impl<'a> Rim<'a> {
    /// Simple loops of vertices at about `spacing`.
    ///
    /// # Errors
    /// [`LeafError::Mesh`] when the curves themselves touch or cross.
    pub fn fitted(curves: &'a [Curve<'a>], spacing: f64) -> Result<Self, LeafError> {
        let mut rings: Vec<Vec<f64>> = curves.iter().map(|curve| ring::fitted(curve, spacing)).collect();
        for _ in 0..HALVINGS {
            let polygons: Vec<Vec<DVec2>> =
                rings.iter().zip(curves).map(|(ring, curve)| ring.iter().map(|&arc| curve.at(arc)).collect()).collect();
            let crossings = polygon::crossings(&polygons);
            if crossings.is_empty() {
                return Ok(Self::of(curves, &rings, spacing));
            }
            halve(&mut rings, curves, &crossings.into_iter().flatten().collect::<Vec<_>>());
        }
        Err(LeafError::Mesh { what: "the outline touches or crosses itself; move its points apart there".to_owned() })
    }

    fn of(curves: &'a [Curve<'a>], rings: &[Vec<f64>], spacing: f64) -> Self {
        let mut rim = Self {
            curves,
            loops: Vec::new(),
            owner: Vec::new(),
            arcs: Vec::new(),
            fixed: Vec::new(),
            shifts: Vec::new(),
        };
        for (number, ring) in rings.iter().enumerate() {
            rim.loops.push(rim.arcs.len()..rim.arcs.len() + ring.len());
            rim.owner.extend(ring.iter().map(|_| number as u32));
            rim.arcs.extend(ring);
            let corners = curves[number].corners();
            rim.fixed.extend(ring.iter().map(|&arc| arc == 0.0 || corners.contains(&arc)));
        }
        rim.shifts = vec![DVec2::zeros(); rim.arcs.len()];
        rim.set_off(spacing);
        if !rim.is_simple(&rim.points()) {
            rim.shifts.fill(DVec2::zeros());
        }
        rim
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.arcs.len()
    }

    /// The curve that a vertex slides on.
    pub fn curve(&self, v: usize) -> &Curve<'a> {
        &self.curves[self.owner[v] as usize]
    }

    /// Where a vertex stands if it is moved to an arc length of its curve.
    pub fn at(&self, v: usize, arc: f64) -> DVec2 {
        self.curve(v).at(arc) + self.shifts[v]
    }

    /// Places of all vertices.
    pub fn points(&self) -> Vec<DVec2> {
        (0..self.len()).map(|v| self.at(v, self.arcs[v])).collect()
    }

    /// The vertices before and after a vertex on its loop.
    pub fn beside(&self, v: usize) -> (usize, usize) {
        let range = &self.loops[self.owner[v] as usize];
        let before = if v == range.start { range.end - 1 } else { v - 1 };
        (before, if v + 1 == range.end { range.start } else { v + 1 })
    }

    /// Whether loops through these places neither cross nor touch.
    pub fn is_simple(&self, points: &[DVec2]) -> bool {
        let polygons: Vec<Vec<DVec2>> = self.loops.iter().map(|range| points[range.clone()].to_vec()).collect();
        polygon::crossings(&polygons).is_empty()
    }

    /// Sets every vertex off by what the chords beside it cut off, so that area is kept place by place: half of each, all of
    /// it where the other end is a corner, which stays.
    pub fn set_off(&mut self, spacing: f64) {
        let cuts: Vec<f64> = (0..self.len()).map(|v| self.cut(v)).collect();
        let is_corner = |v: usize| self.fixed[v] && self.arcs[v] != 0.0;
        let share = |v: usize, other: usize| if is_corner(other) && !is_corner(v) { 1.0 } else { 0.5 };
        let shift = |v: usize| {
            let (before, after) = self.beside(v);
            let [a, b, c] = [before, v, after].map(|v| self.curve(v).at(self.arcs[v]));
            let across = (c - a).norm().max(((b - a).norm() + (c - b).norm()) * 0.35);
            let area = 2.0 * (cuts[before] * share(v, before) + cuts[v] * share(v, after));
            let far = (area / across).clamp(-FARTHEST * spacing, FARTHEST * spacing);
            let outward = DVec2::new(c.y - a.y, a.x - c.x).try_normalize(0.0).unwrap_or_default();
            if is_corner(v) { DVec2::zeros() } else { outward * far }
        };
        self.shifts = (0..self.len()).map(shift).collect();
    }

    /// Leaves a vertex off the curve as it stands.
    pub fn keep_off(&mut self, v: usize, point: DVec2) {
        self.shifts[v] = point - self.curve(v).at(self.arcs[v]);
    }

    /// Area between the curve and the chord after a vertex.
    fn cut(&self, v: usize) -> f64 {
        self.curve(v).cut(self.arcs[v], self.arcs[self.beside(v).1])
    }
}

/// Puts a vertex on the middle of the curve over each of these chords (loop, place).
fn halve(rings: &mut [Vec<f64>], curves: &[Curve], chords: &[(usize, usize)]) {
    for (number, ring) in rings.iter_mut().enumerate() {
        let mut more: Vec<usize> = chords.iter().filter(|chord| chord.0 == number).map(|chord| chord.1).collect();
        more.sort_unstable();
        more.dedup();
        let end = |i: usize| ring.get(i + 1).copied().unwrap_or(curves[number].length());
        let middles: Vec<f64> = more.into_iter().map(|i| (ring[i] + end(i)) * 0.5).collect();
        ring.extend(middles);
        ring.sort_by(f64::total_cmp);
    }
}
