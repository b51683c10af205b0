//! A triangle mesh that can be changed in place and changed back: each triangle knows its neighbours, each vertex one of its
//! triangles, and while a trial runs every write is noted so that it can be undone.

use crate::base::vector::DVec2;

/// No triangle, no vertex.
pub const NONE: u32 = u32::MAX;

/// What a write replaced.
#[derive(Clone, Copy, Debug)]
enum Change {
    Triangle(u32, [u32; 3], [u32; 3]),
    First(u32, u32),
    Point(u32, DVec2),
    NewTriangle,
    NewVertex,
}

/// Triangles, their neighbours, and the vertices' places.
#[derive(Clone, Debug, Default)]
pub struct Web {
    points: Vec<DVec2>,
    /// Corners, counter-clockwise; `NONE` in removed triangles.
    triangles: Vec<[u32; 3]>,
    /// The triangle opposite to each corner, `NONE` beyond the rim.
    beside: Vec<[u32; 3]>,
    /// A triangle of each vertex, `NONE` for removed vertices.
    first: Vec<u32>,
    log: Option<Vec<Change>>,
}

/// The same triangle from its corner `i`.
fn turned<T: Copy>(t: [T; 3], i: usize) -> [T; 3] {
    [t[i], t[(i + 1) % 3], t[(i + 2) % 3]]
}

impl Web {
    /// Links triangles. `None` unless every edge has one triangle on each side, or one alone where it is an edge of the loops'
    /// rim, and every point is used.
    pub fn new(points: Vec<DVec2>, triangles: Vec<[u32; 3]>, rim_edges: usize) -> Option<Self> {
        let mut halves: Vec<(u32, u32, u32, u32)> = Vec::with_capacity(triangles.len() * 3);
        for (t, corners) in triangles.iter().enumerate() {
            for i in 0..3 {
                let [_, a, b] = turned(*corners, i);
                halves.push((a.min(b), a.max(b), u32::from(a > b), (t * 3 + i) as u32));
            }
        }
        halves.sort_unstable();
        let mut web =
            Self { beside: vec![[NONE; 3]; triangles.len()], first: vec![NONE; points.len()], ..Self::default() };
        let (mut i, mut open) = (0, 0);
        while i < halves.len() {
            let pair = halves.get(i + 1).filter(|next| (next.0, next.1) == (halves[i].0, halves[i].1));
            if let Some(other) = pair {
                let (a, b) = (halves[i].3 as usize, other.3 as usize);
                (web.beside[a / 3][a % 3], web.beside[b / 3][b % 3]) = ((b / 3) as u32, (a / 3) as u32);
                if halves[i].2 == other.2 {
                    return None;
                }
            } else {
                open += 1;
            }
            i += 1 + usize::from(pair.is_some());
        }
        for (t, corners) in triangles.iter().enumerate() {
            corners.iter().for_each(|&v| web.first[v as usize] = t as u32);
        }
        web.points = points;
        web.triangles = triangles;
        (open == rim_edges && web.first.iter().all(|&t| t != NONE)).then_some(web)
    }

    /// Number of vertex places, removed ones included.
    pub fn places(&self) -> usize {
        self.points.len()
    }

    /// Number of triangle places, removed ones included.
    pub fn triangles_made(&self) -> usize {
        self.triangles.len()
    }

    /// Whether a vertex is there.
    pub fn is_vertex(&self, v: u32) -> bool {
        self.first[v as usize] != NONE
    }

    /// The place of a vertex.
    pub fn point(&self, v: u32) -> DVec2 {
        self.points[v as usize]
    }

    /// Places of all vertices, removed ones included.
    pub fn points(&self) -> &[DVec2] {
        &self.points
    }

    /// All triangles, with the number of each.
    pub fn triangles(&self) -> impl Iterator<Item = (u32, [u32; 3])> + '_ {
        let live = |(t, corners): (usize, &[u32; 3])| (corners[0] != NONE).then_some((t as u32, *corners));
        self.triangles.iter().enumerate().filter_map(live)
    }

    /// The corners of a triangle, `NONE` if it was removed.
    pub fn corners(&self, t: u32) -> [u32; 3] {
        self.triangles[t as usize]
    }

    /// The triangle opposite to a corner.
    pub fn opposite(&self, t: u32, i: usize) -> u32 {
        self.beside[t as usize][i]
    }

    /// Which corner of a triangle a vertex is.
    pub fn corner(&self, t: u32, v: u32) -> usize {
        let corners = self.triangles[t as usize];
        usize::from(corners[1] == v) + 2 * usize::from(corners[2] == v)
    }

    /// The triangles round a vertex, counter-clockwise, from the rim if it lies there: number and the two other corners.
    pub fn fan(&self, v: u32, fan: &mut Vec<(u32, u32, u32)>) {
        fan.clear();
        let start = self.first[v as usize];
        let mut from = start;
        loop {
            let before = self.beside[from as usize][(self.corner(from, v) + 2) % 3];
            if before == NONE || before == start {
                break;
            }
            from = before;
        }
        let mut t = if self.beside[from as usize][(self.corner(from, v) + 2) % 3] == NONE { from } else { start };
        let end = t;
        loop {
            let i = self.corner(t, v);
            let [_, a, b] = turned(self.triangles[t as usize], i);
            fan.push((t, a, b));
            t = self.beside[t as usize][(i + 1) % 3];
            if t == NONE || t == end {
                return;
            }
        }
    }

    /// How many triangles a vertex has.
    pub fn degree(&self, v: u32) -> usize {
        let start = self.first[v as usize];
        let (mut t, mut count) = (start, 0);
        // Once round, or to the rim and from the start to the rim the other way.
        for way in [1, 2] {
            while t != NONE {
                count += 1;
                t = self.beside[t as usize][(self.corner(t, v) + way) % 3];
                if t == start {
                    return count;
                }
            }
            t = self.beside[start as usize][(self.corner(start, v) + 2) % 3];
        }
        count
    }

    fn note(&mut self, change: Change) {
        if let Some(log) = &mut self.log {
            log.push(change);
        }
    }

    fn set(&mut self, t: u32, corners: [u32; 3], beside: [u32; 3]) {
        self.note(Change::Triangle(t, self.triangles[t as usize], self.beside[t as usize]));
        self.triangles[t as usize] = corners;
        self.beside[t as usize] = beside;
    }

    fn set_first(&mut self, v: u32, t: u32) {
        self.note(Change::First(v, self.first[v as usize]));
        self.first[v as usize] = t;
    }

    /// In triangle `t` (if any) the neighbour `old` becomes `new`.
    fn relink(&mut self, t: u32, old: u32, new: u32) {
        if t != NONE {
            let beside = self.beside[t as usize].map(|n| if n == old { new } else { n });
            self.set(t, self.triangles[t as usize], beside);
        }
    }

    /// Moves a vertex.
    pub fn place(&mut self, v: u32, point: DVec2) {
        self.note(Change::Point(v, self.points[v as usize]));
        self.points[v as usize] = point;
    }

    /// Starts a trial: what follows can be undone.
    pub fn begin(&mut self) {
        self.log = Some(Vec::new());
    }

    /// Ends a trial, keeping it or putting everything back.
    pub fn end(&mut self, keep: bool) {
        for change in self.log.take().into_iter().flatten().rev().filter(|_| !keep) {
            match change {
                Change::Triangle(t, corners, beside) => {
                    (self.triangles[t as usize], self.beside[t as usize]) = (corners, beside);
                }
                Change::First(v, t) => self.first[v as usize] = t,
                Change::Point(v, point) => self.points[v as usize] = point,
                Change::NewTriangle => {
                    self.triangles.pop();
                    self.beside.pop();
                }
                Change::NewVertex => {
                    self.points.pop();
                    self.first.pop();
                }
            }
        }
    }

    fn new_triangle(&mut self) -> u32 {
        self.note(Change::NewTriangle);
        self.triangles.push([NONE; 3]);
        self.beside.push([NONE; 3]);
        (self.triangles.len() - 1) as u32
    }

    /// The four corners round the edge opposite to corner `i`: the corner, edge start, far corner, edge end, and the far
    /// triangle. `None` on the rim.
    pub fn diamond(&self, t: u32, i: usize) -> Option<([u32; 4], u32)> {
        let u = self.beside[t as usize][i];
        (u != NONE).then(|| {
            let [p, a, b] = turned(self.triangles[t as usize], i);
            let j = (self.corner(u, a) + 1) % 3;
            ([p, a, self.triangles[u as usize][j], b], u)
        })
    }

    /// Turns the edge opposite to corner `i` of triangle `t` into the other diagonal of its diamond.
    pub fn flip(&mut self, t: u32, i: usize) {
        let Some(([p, a, q, b], u)) = self.diamond(t, i) else { return };
        let [_, ta, tb] = turned(self.beside[t as usize], i);
        let [_, ub, ua] = turned(self.beside[u as usize], self.corner(u, q));
        self.set(t, [p, a, q], [ub, u, tb]);
        self.set(u, [q, b, p], [ta, t, ua]);
        self.relink(ub, u, t);
        self.relink(ta, t, u);
        for (v, first) in [(a, t), (p, t), (b, u), (q, u)] {
            self.set_first(v, first);
        }
    }

    /// Puts a new vertex on the edge opposite to corner `i` of triangle `t`. `None` on the rim.
    pub fn split(&mut self, t: u32, i: usize, point: DVec2) -> Option<u32> {
        let ([p, a, q, b], u) = self.diamond(t, i)?;
        let [_, ta, tb] = turned(self.beside[t as usize], i);
        let [_, ub, ua] = turned(self.beside[u as usize], self.corner(u, q));
        self.note(Change::NewVertex);
        self.points.push(point);
        self.first.push(NONE);
        let m = (self.points.len() - 1) as u32;
        let (t2, u2) = (self.new_triangle(), self.new_triangle());
        self.set(t, [p, a, m], [u2, t2, tb]);
        self.set(t2, [p, m, b], [u, ta, t]);
        self.set(u, [q, b, m], [t2, u2, ua]);
        self.set(u2, [q, m, a], [t, ub, u]);
        self.relink(ta, t, t2);
        self.relink(ub, u, u2);
        for (v, first) in [(p, t), (a, t), (b, u), (q, u), (m, t)] {
            self.set_first(v, first);
        }
        Some(m)
    }

    /// Puts a new vertex on the rim's edge opposite to corner `i` of triangle `t`. `None` within.
    pub fn split_rim(&mut self, t: u32, i: usize, point: DVec2) -> Option<u32> {
        let [p, a, b] = turned(self.triangles[t as usize], i);
        let [across, ta, tb] = turned(self.beside[t as usize], i);
        (across == NONE).then(|| {
            self.note(Change::NewVertex);
            self.points.push(point);
            self.first.push(NONE);
            let m = (self.points.len() - 1) as u32;
            let t2 = self.new_triangle();
            self.set(t, [p, a, m], [NONE, t2, tb]);
            self.set(t2, [p, m, b], [NONE, ta, t]);
            self.relink(ta, t, t2);
            for (v, first) in [(p, t), (a, t), (b, t2), (m, t)] {
                self.set_first(v, first);
            }
            m
        })
    }

    /// Removes the rim's vertex `v` by drawing it along the rim into its neighbour `w`; false, and nothing done, where that
    /// would fold the mesh.
    pub fn collapse_rim(&mut self, v: u32, w: u32) -> bool {
        let (mut around, mut other) = (Vec::new(), Vec::new());
        self.fan(v, &mut around);
        self.fan(w, &mut other);
        let touches = |x: u32| other.iter().any(|&(_, a, b)| a == x || b == x);
        let neighbours = around.iter().map(|f| f.1).chain(around.last().map(|f| f.2));
        let Some(&(t, a, b)) = around.iter().find(|&&(_, a, b)| a == w || b == w) else { return false };
        let p = if a == w { b } else { a };
        let inner = self.beside[t as usize][self.corner(t, w)];
        let outer = self.beside[t as usize][self.corner(t, v)];
        if neighbours.filter(|&x| touches(x)).count() != 1 || outer == NONE {
            return false;
        }
        for &(triangle, ..) in around.iter().filter(|f| f.0 != t) {
            let corners = self.triangles[triangle as usize].map(|x| if x == v { w } else { x });
            self.set(triangle, corners, self.beside[triangle as usize]);
        }
        self.relink(inner, t, outer);
        self.relink(outer, t, inner);
        self.set_first(p, outer);
        self.set_first(w, outer);
        self.set(t, [NONE; 3], [NONE; 3]);
        self.set_first(v, NONE);
        true
    }

    /// Removes the inner vertex `v` by drawing it into its neighbour `w`; false, and nothing done, where that would fold the
    /// mesh (the two share more neighbours than the two beside their edge).
    pub fn collapse(&mut self, v: u32, w: u32) -> bool {
        let (mut around, mut other) = (Vec::new(), Vec::new());
        self.fan(v, &mut around);
        self.fan(w, &mut other);
        let touches = |x: u32| other.iter().any(|&(_, a, b)| a == x || b == x);
        if around.len() < 4 || around.iter().filter(|&&(_, a, _)| touches(a)).count() != 2 {
            return false;
        }
        let Some(&(t, _, p)) = around.iter().find(|&&(_, a, _)| a == w) else { return false };
        let Some(&(u, q, _)) = around.iter().find(|&&(_, _, b)| b == w) else { return false };
        for &(triangle, ..) in around.iter().filter(|f| f.0 != t && f.0 != u) {
            let corners = self.triangles[triangle as usize].map(|x| if x == v { w } else { x });
            self.set(triangle, corners, self.beside[triangle as usize]);
        }
        for (gone, third) in [(t, p), (u, q)] {
            let inner = self.beside[gone as usize][self.corner(gone, w)];
            let outer = self.beside[gone as usize][self.corner(gone, v)];
            self.relink(inner, gone, outer);
            self.relink(outer, gone, inner);
            self.set_first(third, inner);
            self.set_first(w, inner);
        }
        self.set(t, [NONE; 3], [NONE; 3]);
        self.set(u, [NONE; 3], [NONE; 3]);
        self.set_first(v, NONE);
        true
    }

    /// Whether the mesh holds together: links go both ways and join the same edge, vertices know a triangle of theirs.
    #[cfg(test)]
    pub fn is_sound(&self) -> bool {
        let linked = |t: u32, i: usize| {
            let u = self.beside[t as usize][i];
            let [_, a, b] = turned(self.triangles[t as usize], i);
            u == NONE
                || (0..3)
                    .any(|j| self.beside[u as usize][j] == t && turned(self.triangles[u as usize], j)[1..] == [b, a])
        };
        let known = |v: usize| self.first[v] == NONE || self.triangles[self.first[v] as usize].contains(&(v as u32));
        self.triangles().all(|(t, _)| (0..3).all(|i| linked(t, i))) && (0..self.places()).all(known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hexagon round vertex 6, with vertex 7 beyond the side 0-1.
    fn wheel() -> Web {
        let corners = [(2, 0), (1, 2), (-1, 2), (-2, 0), (-1, -2), (1, -2), (0, 0), (3, 2)];
        let points = corners.iter().map(|&(x, y)| DVec2::new(f64::from(x), f64::from(y))).collect();
        let mut triangles: Vec<[u32; 3]> = (0..6).map(|i| [i, (i + 1) % 6, 6]).collect();
        triangles.push([1, 0, 7]);
        Web::new(points, triangles, 7).unwrap()
    }

    fn shape(web: &Web) -> Vec<[u32; 3]> {
        web.triangles.clone()
    }

    #[test]
    fn fans_run_round() {
        let (web, mut fan) = (wheel(), Vec::new());
        web.fan(6, &mut fan);
        assert_eq!(fan.len(), 6);
        assert!((0..6).all(|i| fan[i].2 == fan[(i + 1) % 6].1));
        web.fan(0, &mut fan);
        assert_eq!(fan.iter().map(|f| (f.1, f.2)).collect::<Vec<_>>(), vec![(7, 1), (1, 6), (6, 5)]);
    }

    #[test]
    fn every_change_is_sound_and_can_be_undone() {
        let mut web = wheel();
        let before = (shape(&web), web.beside.clone(), web.points.clone());
        let changes: [(usize, fn(&mut Web) -> bool); 7] = [
            (7, |web| {
                web.flip(0, 2);
                true
            }),
            (7, |web| web.split(0, 2, DVec2::new(1.5, 1.0)) == Some(8)),
            (7, |web| web.collapse(6, 3)),
            (7, |web| web.split(3, 0, DVec2::new(-0.5, -1.0)).is_some_and(|m| web.collapse(6, m))),
            (8, |web| web.split_rim(6, 0, DVec2::new(2.0, 2.0)) == Some(8)),
            (6, |web| web.collapse_rim(7, 1)),
            (6, |web| web.collapse_rim(3, 4)),
        ];
        for (rim, change) in changes {
            web.begin();
            assert!(change(&mut web) && web.is_sound());
            let vertices = web.first.iter().filter(|&&t| t != NONE).count();
            assert_eq!(web.triangles().count(), 2 * vertices - rim - 2, "Euler's formula");
            let mut fan = Vec::new();
            for v in (0..web.places() as u32).filter(|&v| web.is_vertex(v)) {
                web.fan(v, &mut fan);
                assert_eq!(fan.len(), web.degree(v));
            }
            web.end(false);
            assert!(web.is_sound());
            assert_eq!((shape(&web), web.beside.clone(), web.points.clone()), before);
        }
    }

    #[test]
    fn open_or_twisted_meshes_are_refused() {
        let points = wheel().points;
        assert!(Web::new(points.clone(), wheel().triangles, 6).is_none());
        assert!(Web::new(points, vec![[0, 1, 6], [0, 1, 7]], 4).is_none());
    }
}
