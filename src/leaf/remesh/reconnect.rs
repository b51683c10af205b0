//! The second of the two steps of a round: where the mesh is not regular, edges are tried flipped, split or collapsed.
//!
//! A change is kept if the patch round it, relaxed, costs less: dislocations of the lattice glide (flip) and climb (split,
//! collapse) until they meet and vanish or rest at the rim. Only changes that add little to the squared misses of the
//! vertices' triangle counts (6 inside, one for each 60 degrees at the rim; Frey and Field 1991) are tried.

use crate::leaf::remesh::relocate::Mesher;
use crate::leaf::remesh::trial::Change;
use crate::leaf::remesh::triangulation::corner_angle;

/// Vertices of a triangle that costs more are tried though their triangle counts are right.
const POOR: f64 = 0.5;
/// So are rim vertices where the curve's straying costs more, and vertices are tried where it strays by this share of the
/// spacing.
const STRAYED: f64 = 0.2;
const FAR: f64 = 0.08;
/// A trial may raise the squared misses by this.
const LEEWAY: i64 = 2;

/// How many vertices there may be.
#[derive(Clone, Copy, Debug)]
pub struct Count {
    /// Vertices now.
    pub now: usize,
    /// Fewest allowed.
    pub least: usize,
    /// Most allowed.
    pub most: usize,
}

impl Count {
    fn may_grow(&self) -> bool {
        self.now < self.most
    }

    fn may_shrink(&self) -> bool {
        self.now > self.least
    }
}

impl Mesher<'_> {
    /// How many triangles a vertex has beyond what it should have.
    fn excess(&self, v: u32) -> i64 {
        self.web.degree(v) as i64 - self.wanted(v)
    }

    fn wanted(&self, v: u32) -> i64 {
        if !self.rim.holds(v) {
            return 6;
        }
        let [before, after] = self.rim.beside(v);
        let [a, b, c] = [before, v, after].map(|v| self.web.point(v));
        ((corner_angle(a, b, c) / std::f64::consts::FRAC_PI_3).round() as i64).clamp(1, 5)
    }

    /// Whether a vertex has a triangle that costs much, or the curve strays from it.
    fn is_poor(&self, v: u32) -> bool {
        let mut fan = Vec::new();
        self.web.fan(v, &mut fan);
        let p = self.web.point(v);
        let strayed = self.rim.holds(v) && self.straying_cost(v) > STRAYED;
        strayed || fan.iter().any(|&(_, a, b)| self.energy.of(p, self.web.point(a), self.web.point(b)) > POOR)
    }

    /// Tries changes at all vertices with a wrong number of triangles that were not tried since something changed there; how
    /// many were kept.
    pub fn reconnect(&mut self) -> usize {
        let mut kept = 0;
        for v in 0..self.web.places() as u32 {
            self.tried.resize(self.web.places(), false);
            if !self.web.is_vertex(v) || self.tried[v as usize] || (self.excess(v) == 0 && !self.is_poor(v)) {
                continue;
            }
            self.tried[v as usize] = true;
            if let Some(touched) = self.change_at(v) {
                self.tried.resize(self.web.places(), false);
                touched.into_iter().for_each(|w| self.tried[w as usize] = false);
                kept += 1;
            }
        }
        kept
    }

    /// The first change at the edges round a vertex that lowers the cost is kept; the vertices it touched.
    fn change_at(&mut self, v: u32) -> Option<Vec<u32>> {
        let mut fan = Vec::new();
        self.web.fan(v, &mut fan);
        let mut changes: Vec<(i64, Change)> = Vec::new();
        for &(t, ..) in &fan {
            let i = self.web.corner(t, v);
            for corner in [i, (i + 2) % 3] {
                changes.extend(self.promising(v, t, corner));
            }
        }
        if self.rim.holds(v) {
            changes.extend(self.along_the_rim(v));
        }
        changes.sort_by_key(|change| change.0);
        changes.into_iter().find_map(|(_, change)| self.keeps(change))
    }

    /// Splits of the rim beside a vertex, and collapses of it.
    fn along_the_rim(&self, v: u32) -> Vec<(i64, Change)> {
        let [before, after] = self.rim.beside(v);
        let mut changes = Vec::new();
        if self.count.may_grow() {
            let open = [before, v].into_iter().filter(|&v| self.rim.may_come(v));
            changes.extend(open.map(|v| (1, Change::SplitRim(v, self.midway(v)))));
        }
        if self.count.may_shrink() && self.rim.may_go(v) {
            changes.extend([before, after].map(|w| (0, Change::CollapseRim(v, w))));
        }
        for start in [before, v] {
            changes.extend(self.at_the_farthest(v, start));
        }
        changes
    }

    /// Where the curve strays most from the chord that starts at `start`: `v` moved there, and a new vertex.
    fn at_the_farthest(&self, v: u32, start: u32) -> Vec<(i64, Change)> {
        let ends = [start, self.rim.beside(start)[1]];
        let curve = self.rim.curve(start);
        let (far, arc) = curve.farthest(ends.map(|v| self.rim.arc(v)), ends.map(|v| self.web.point(v)));
        if far < FAR * self.spacing {
            return Vec::new();
        }
        let moved = (self.rim.slides(v) && !self.rim.is_first(v)).then_some((1, Change::Stand(v, arc)));
        let comes = self.count.may_grow() && self.rim.may_come(start);
        moved.into_iter().chain(comes.then_some((2, Change::SplitRim(start, arc)))).collect()
    }

    /// The arc length half way between a rim vertex and the next.
    fn midway(&self, v: u32) -> f64 {
        let (start, end) = (self.rim.arc(v), self.rim.arc(self.rim.beside(v)[1]));
        let length = if end <= start { self.rim.curve(v).length() } else { 0.0 };
        self.rim.curve(v).wrapped((start + end + length) * 0.5)
    }

    /// Changes of the edge opposite to a corner of a triangle that do not make the triangle counts much worse, with what they
    /// do to them. None if they were tried from another corner of the two triangles than `v`.
    fn promising(&self, v: u32, t: u32, i: usize) -> Vec<(i64, Change)> {
        let Some((corners, _)) = self.web.diamond(t, i) else { return Vec::new() };
        if corners.iter().any(|&x| x != v && self.tried[x as usize]) {
            return Vec::new();
        }
        let [p, a, q, b] = corners.map(|v| self.excess(v));
        let square = |x: i64| x * x;
        let now: i64 = [p, a, q, b].into_iter().map(square).sum();
        let mut changes =
            vec![(square(p + 1) + square(q + 1) + square(a - 1) + square(b - 1) - now, Change::Flip(t, i))];
        if self.count.may_grow() {
            // The new vertex has four triangles; flips that follow bring one more.
            changes.push((square(p + 1) + square(q + 1) + square(a) + square(b) + 1 - now, Change::Split(t, i)));
        }
        let [_, from, _, to] = corners;
        let (from, to) = if self.rim.holds(from) { (to, from) } else { (from, to) };
        if self.count.may_shrink() && !self.rim.holds(from) {
            // Of the 6 triangles that the vertex drawn in should have, two are lost twice.
            changes.push((square(p - 1) + square(q - 1) + square(a + b + 2) - now, Change::Collapse(from, to)));
        }
        changes.retain(|change| change.0 <= LEEWAY);
        changes
    }
}
