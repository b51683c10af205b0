//! The second of the two steps of a round: edges flip where that costs less, and where the mesh is not regular, vertices are
//! tried with one edge flipped, split or collapsed.
//!
//! A trial changes one edge, relaxes the patch round it, and is undone unless the patch then costs less: dislocations of
//! the lattice glide (flip) and climb (split, collapse) until they meet and vanish or rest at the rim. Only changes that
//! do not add to the squared misses of the vertices' triangle counts (6 inside, one for each 60 degrees at the rim) are
//! tried.

use crate::leaf::remesh::relocate::Mesher;
use crate::leaf::remesh::triangulation::corner_angle;
use crate::leaf::remesh::web::{NONE, Web};

/// Passes of flipping, at most, in a round and in a trial.
const PASSES: u32 = 8;
/// The square of an edge may grow by this factor in a flip.
const LONGER: f64 = 1.6;
/// A change must lower the cost by this to be kept.
const WORTH: f64 = 1e-6;
/// Vertices of a triangle that costs more are tried though their triangle counts are right.
const POOR: f64 = 0.5;
/// A trial may raise the squared misses by this.
const LEEWAY: i64 = 2;

/// A change of one edge: that opposite to a corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Flip(u32, usize),
    Split(u32, usize),
    /// The first vertex is drawn into the second.
    Collapse(u32, u32),
    /// A rim edge gets a vertex between this one and the next.
    SplitRim(u32),
    /// The first rim vertex is drawn into the second, its neighbour on the loop.
    CollapseRim(u32, u32),
}

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

/// Marks of what was looked at, by number.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    stamps: Vec<u32>,
    stamp: u32,
}

impl Marks {
    fn clear(&mut self, count: usize) {
        self.stamp += 1;
        self.stamps.resize(count.max(self.stamps.len()), 0);
    }

    fn is_marked(&self, i: u32) -> bool {
        self.stamps[i as usize] == self.stamp
    }

    /// Marks a number; false if it was marked.
    fn mark(&mut self, i: u32) -> bool {
        let stamp = &mut self.stamps[i as usize];
        let is_new = *stamp != self.stamp;
        *stamp = self.stamp;
        is_new
    }
}

/// Vertices that a trial relaxes, those next to the change first.
#[derive(Debug)]
struct Patch {
    vertices: Vec<u32>,
    /// How many are next to the change.
    inner: usize,
}

impl Patch {
    fn gain(&mut self, new: Option<u32>) {
        self.vertices.splice(0..0, new);
        self.inner += usize::from(new.is_some());
    }

    fn lose(&mut self, v: u32) {
        if let Some(at) = self.vertices.iter().position(|&x| x == v) {
            self.vertices.remove(at);
            self.inner -= usize::from(at < self.inner);
        }
    }
}

impl Mesher<'_> {
    /// Flips edges while that lowers the cost; how many were flipped.
    pub fn flip_all(&mut self) -> usize {
        let mut flipped = 0;
        let mut numbers: Vec<u32> = self.web.triangles().map(|(t, _)| t).collect();
        numbers.retain(|&t| self.web.corners(t).iter().any(|&v| self.awake[v as usize]));
        for _ in 0..PASSES {
            let count = self.flip_among(&numbers, |_| true);
            flipped += count;
            if count == 0 {
                break;
            }
        }
        flipped
    }

    fn flip_among(&mut self, triangles: &[u32], may: impl Fn(u32) -> bool) -> usize {
        let mut flipped = 0;
        for &t in triangles {
            for i in 0..3 {
                if self.web.corners(t)[0] != NONE && self.gains_by_flip(t, i) && may(self.web.opposite(t, i)) {
                    let [a, b, c] = self.web.corners(t);
                    self.web.flip(t, i);
                    [a, b, c].iter().chain(&self.web.corners(t)).for_each(|&v| self.awake[v as usize] = true);
                    flipped += 1;
                }
            }
        }
        flipped
    }

    fn gains_by_flip(&self, t: u32, i: usize) -> bool {
        let Some((corners, _)) = self.web.diamond(t, i) else { return false };
        let [p, a, q, b] = corners.map(|v| self.web.point(v));
        if (q - p).norm_squared() > LONGER * (b - a).norm_squared() {
            return false;
        }
        let now = self.energy.of(p, a, b) + self.energy.of(q, b, a);
        self.energy.of(p, a, q) + self.energy.of(q, b, p) < now - WORTH
    }

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

    /// Whether a vertex has a triangle that costs much.
    fn is_poor(&self, v: u32) -> bool {
        let mut fan = Vec::new();
        self.web.fan(v, &mut fan);
        let p = self.web.point(v);
        fan.iter().any(|&(_, a, b)| self.energy.of(p, self.web.point(a), self.web.point(b)) > POOR)
    }

    /// Tries changes at all vertices with a wrong number of triangles that were not tried since something changed there; how
    /// many were kept.
    pub fn reconnect(&mut self, count: &mut Count, tried: &mut Vec<bool>, marks: &mut Marks) -> usize {
        let mut kept = 0;
        for v in 0..self.web.places() as u32 {
            tried.resize(self.web.places(), false);
            if !self.web.is_vertex(v) || tried[v as usize] || (self.excess(v) == 0 && !self.is_poor(v)) {
                continue;
            }
            tried[v as usize] = true;
            if let Some(touched) = self.change_at(v, count, tried, marks) {
                tried.resize(self.web.places(), false);
                touched.into_iter().for_each(|w| tried[w as usize] = false);
                kept += 1;
            }
        }
        kept
    }

    /// The first change at the edges round a vertex that lowers the cost is kept; the vertices it touched.
    fn change_at(&mut self, v: u32, count: &mut Count, tried: &[bool], marks: &mut Marks) -> Option<Vec<u32>> {
        let mut fan = Vec::new();
        self.web.fan(v, &mut fan);
        let mut changes = Vec::new();
        let leeway = if self.is_poor(v) { 8 } else { LEEWAY };
        // What was tried from another corner of the same diamond need not be tried again.
        let is_new = |t: u32, i: usize| {
            self.web.diamond(t, i).is_some_and(|(corners, _)| corners.iter().all(|&x| x == v || !tried[x as usize]))
        };
        for &(t, ..) in &fan {
            let i = self.web.corner(t, v);
            for corner in [i, (i + 2) % 3] {
                if is_new(t, corner) {
                    changes.extend(self.promising(t, corner, count, leeway));
                }
            }
        }
        if self.rim.holds(v) {
            let [before, after] = self.rim.beside(v);
            if count.now < count.most {
                let open = [before, v].into_iter().filter(|&v| self.rim.may_come(v));
                changes.extend(open.map(|v| (1, Change::SplitRim(v))));
            }
            if count.now > count.least && self.rim.may_go(v) {
                changes.extend([before, after].map(|w| (0, Change::CollapseRim(v, w))));
            }
        }
        changes.sort_by_key(|change: &(i64, Change)| change.0);
        changes.into_iter().find_map(|(_, change)| self.tried(change, count, marks))
    }

    /// Changes of an edge that do not make the triangle counts much worse, with what they do to them.
    fn promising(&self, t: u32, i: usize, count: &Count, leeway: i64) -> Vec<(i64, Change)> {
        let Some((corners, _)) = self.web.diamond(t, i) else { return Vec::new() };
        let [p, a, q, b] = corners.map(|v| self.excess(v));
        let square = |x: i64| x * x;
        let now: i64 = [p, a, q, b].into_iter().map(square).sum();
        let mut changes =
            vec![(square(p + 1) + square(q + 1) + square(a - 1) + square(b - 1) - now, Change::Flip(t, i))];
        if count.now < count.most {
            changes.push((square(p + 1) + square(q + 1) + square(a) + square(b) + 1 - now, Change::Split(t, i)));
        }
        let [_, from, _, to] = corners;
        let (from, to) = if self.rim.holds(from) { (to, from) } else { (from, to) };
        if count.now > count.least && !self.rim.holds(from) {
            // Of the 6 triangles that the vertex drawn in should have, two are lost twice.
            let joined = a + b + 2;
            changes.push((square(p - 1) + square(q - 1) + square(joined) - now, Change::Collapse(from, to)));
        }
        changes.retain(|change| change.0 <= leeway);
        changes
    }

    /// Makes a change, relaxes, and keeps it if the patch costs less; the vertices of the patch if so.
    fn tried(&mut self, change: Change, count: &mut Count, marks: &mut Marks) -> Option<Vec<u32>> {
        let centre = match change {
            Change::Flip(t, i) | Change::Split(t, i) => self.web.diamond(t, i)?.0.to_vec(),
            Change::Collapse(v, w) | Change::CollapseRim(v, w) => vec![v, w],
            Change::SplitRim(v) => vec![v, self.rim.beside(v)[1]],
        };
        let mut patch = self.patch(&centre, marks);
        let before = self.cost_of(&self.triangles_of(&patch.vertices, marks), &patch.vertices);
        self.web.begin();
        self.rim.begin();
        let better = self.made(change, &mut patch) && self.relaxes_below(before - WORTH, change, &patch, marks);
        self.web.end(better);
        self.rim.end(better);
        self.awake.resize(self.web.places(), true);
        better.then(|| {
            match change {
                Change::Flip(..) => {}
                Change::Split(..) | Change::SplitRim(..) => count.now += 1,
                Change::Collapse(..) | Change::CollapseRim(..) => count.now -= 1,
            }
            patch.vertices.iter().for_each(|&v| self.awake[v as usize] = true);
            patch.vertices
        })
    }

    /// Makes a change; false, the mesh perhaps half changed, where it cannot be.
    fn made(&mut self, change: Change, patch: &mut Patch) -> bool {
        let middle = |web: &Web, a: u32, b: u32| (web.point(a) + web.point(b)) * 0.5;
        let new = match change {
            Change::Flip(t, i) => {
                self.web.flip(t, i);
                return true;
            }
            Change::Collapse(v, w) => {
                if !self.rim.holds(w) {
                    self.web.place(w, middle(&self.web, v, w));
                }
                patch.lose(v);
                return self.web.collapse(v, w);
            }
            Change::CollapseRim(v, w) => {
                patch.lose(v);
                self.rim.remove(v);
                return self.web.collapse_rim(v, w);
            }
            Change::Split(t, i) => {
                let [_, a, b] = [0, 1, 2].map(|k| self.web.corners(t)[(i + k) % 3]);
                self.web.split(t, i, middle(&self.web, a, b))
            }
            Change::SplitRim(v) => {
                let new = self.web.places() as u32;
                let point = self.rim.insert(v, new);
                let mut fan = Vec::new();
                self.web.fan(v, &mut fan);
                let t = fan[0].0;
                let i = (self.web.corner(t, v) + 2) % 3;
                self.web.split_rim(t, i, point)
            }
        };
        patch.gain(new);
        self.awake.resize(self.web.places(), true);
        new.is_some()
    }

    fn relaxes_below(&mut self, bar: f64, change: Change, patch: &Patch, marks: &mut Marks) -> bool {
        let triangles = self.triangles_of(&patch.vertices, marks);
        if !self.cost_of(&triangles, &patch.vertices).is_finite() {
            return false;
        }
        let hopeless = match change {
            Change::Flip(..) => [2.5, 1.0, 0.4, 0.0],
            Change::Split(..) | Change::SplitRim(..) => [5.0, 2.0, 0.6, 0.0],
            Change::Collapse(..) | Change::CollapseRim(..) => [1.2, 0.4, 0.15, 0.0],
        };
        for (sweep, hopeless) in hopeless.into_iter().enumerate() {
            let reach = if sweep < 2 { patch.inner } else { patch.vertices.len() };
            for &v in &patch.vertices[..reach] {
                self.moved(v);
            }
            if !matches!(change, Change::Flip(..)) || sweep > 1 {
                self.flip_among(&triangles, |u| marks.is_marked(u));
            }
            let cost = self.cost_of(&triangles, &patch.vertices);
            if cost < bar || cost > bar + hopeless {
                return cost < bar;
            }
        }
        false
    }

    /// The vertices within two edges of some.
    fn patch(&self, centre: &[u32], marks: &mut Marks) -> Patch {
        marks.clear(self.web.places());
        let mut vertices: Vec<u32> = centre.iter().copied().filter(|&v| marks.mark(v)).collect();
        let mut fan = Vec::new();
        let (mut start, mut inner) = (0, 0);
        for _ in 0..2 {
            inner = vertices.len();
            for k in start..inner {
                self.web.fan(vertices[k], &mut fan);
                for &(_, a, b) in &fan {
                    vertices.extend([a, b].into_iter().filter(|&w| marks.mark(w)));
                }
            }
            start = inner;
        }
        Patch { vertices, inner }
    }

    fn triangles_of(&self, vertices: &[u32], marks: &mut Marks) -> Vec<u32> {
        marks.clear(self.web.triangles_made());
        let mut fan = Vec::new();
        let mut triangles = Vec::new();
        for &v in vertices {
            self.web.fan(v, &mut fan);
            triangles.extend(fan.iter().map(|f| f.0).filter(|&t| marks.mark(t)));
        }
        triangles
    }

    /// What triangles cost, and the rim's straying at vertices.
    fn cost_of(&self, triangles: &[u32], vertices: &[u32]) -> f64 {
        let of = |&t: &u32| {
            let [a, b, c] = self.web.corners(t).map(|v| self.web.point(v));
            self.energy.of(a, b, c)
        };
        let straying = |&v: &u32| if self.rim.holds(v) { self.straying_cost(v) } else { 0.0 };
        triangles.iter().map(of).sum::<f64>() + vertices.iter().map(straying).sum::<f64>()
    }
}
