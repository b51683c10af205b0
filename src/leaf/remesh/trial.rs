//! A change of one edge, tried: made, the patch round it relaxed, and undone unless the patch then costs less.

use crate::leaf::remesh::relocate::Mesher;
use crate::leaf::remesh::web::Web;

/// A change must lower the cost by this to be kept.
const WORTH: f64 = 1e-6;

/// A change of one edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The edge opposite to a corner of a triangle becomes the other diagonal.
    Flip(u32, usize),
    /// The edge opposite to a corner of a triangle gets a vertex.
    Split(u32, usize),
    /// The first vertex is drawn into the second.
    Collapse(u32, u32),
    /// A rim edge gets a vertex between this one and the next, at an arc length of the curve.
    SplitRim(u32, f64),
    /// A rim vertex stands at another arc length.
    Stand(u32, f64),
    /// The first rim vertex is drawn into the second, its neighbour on the loop.
    CollapseRim(u32, u32),
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
    /// Makes a change, relaxes, and keeps it if the patch costs less; the vertices of the patch if so.
    pub fn keeps(&mut self, change: Change) -> Option<Vec<u32>> {
        let centre = match change {
            Change::Flip(t, i) | Change::Split(t, i) => self.web.diamond(t, i)?.0.to_vec(),
            Change::Collapse(v, w) | Change::CollapseRim(v, w) => vec![v, w],
            Change::Stand(v, _) => vec![v],
            Change::SplitRim(v, _) => vec![v, self.rim.beside(v)[1]],
        };
        let mut patch = self.patch(&centre);
        let before = {
            let triangles = self.triangles_of(&patch.vertices);
            self.cost_of(&triangles, &patch.vertices)
        };
        self.web.begin();
        self.rim.begin();
        let better = self.made(change, &mut patch) && self.relaxes_below(before - WORTH, change, &patch);
        self.web.end(better);
        self.rim.end(better);
        self.awake.resize(self.web.places(), true);
        better.then(|| {
            match change {
                Change::Flip(..) | Change::Stand(..) => {}
                Change::Split(..) | Change::SplitRim(..) => self.count.now += 1,
                Change::Collapse(..) | Change::CollapseRim(..) => self.count.now -= 1,
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
            Change::Stand(v, arc) => {
                let point = self.rim.stand(v, arc);
                self.web.place(v, point);
                return true;
            }
            Change::SplitRim(v, arc) => {
                let new = self.web.places() as u32;
                let point = self.rim.insert(v, new, arc);
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

    fn relaxes_below(&mut self, bar: f64, change: Change, patch: &Patch) -> bool {
        let triangles = self.triangles_of(&patch.vertices);
        if !self.cost_of(&triangles, &patch.vertices).is_finite() {
            return false;
        }
        let hopeless = match change {
            Change::Flip(..) | Change::Stand(..) => [2.5, 1.0, 0.4, 0.0],
            Change::Split(..) | Change::SplitRim(..) => [5.0, 2.0, 0.6, 0.0],
            Change::Collapse(..) | Change::CollapseRim(..) => [1.2, 0.4, 0.15, 0.0],
        };
        for (sweep, hopeless) in hopeless.into_iter().enumerate() {
            let reach = if sweep < 2 { patch.inner } else { patch.vertices.len() };
            for &v in &patch.vertices[..reach] {
                self.moved(v);
            }
            if !matches!(change, Change::Flip(..)) || sweep > 1 {
                let marks = std::mem::take(&mut self.marks);
                self.flip_among(&triangles, |u| marks.is_marked(u));
                self.marks = marks;
            }
            let cost = self.cost_of(&triangles, &patch.vertices);
            if cost < bar || cost > bar + hopeless {
                return cost < bar;
            }
        }
        false
    }

    /// The vertices within two edges of some.
    fn patch(&mut self, centre: &[u32]) -> Patch {
        self.marks.clear(self.web.places());
        let mut vertices: Vec<u32> = centre.iter().copied().filter(|&v| self.marks.mark(v)).collect();
        let mut fan = Vec::new();
        let (mut start, mut inner) = (0, 0);
        for _ in 0..2 {
            inner = vertices.len();
            for k in start..inner {
                self.web.fan(vertices[k], &mut fan);
                for &(_, a, b) in &fan {
                    vertices.extend([a, b].into_iter().filter(|&w| self.marks.mark(w)));
                }
            }
            start = inner;
        }
        Patch { vertices, inner }
    }

    fn triangles_of(&mut self, vertices: &[u32]) -> Vec<u32> {
        self.marks.clear(self.web.triangles_made());
        let mut fan = Vec::new();
        let mut triangles = Vec::new();
        for &v in vertices {
            self.web.fan(v, &mut fan);
            triangles.extend(fan.iter().map(|f| f.0).filter(|&t| self.marks.mark(t)));
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
