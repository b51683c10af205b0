//! A triangle mesh that can be changed in place and changed back: each triangle knows its neighbours, each vertex one of its
//! triangles, and while a trial runs every write is noted so that it can be undone.

use crate::base::vector::DVec2;

/// No triangle, no vertex.
pub const NONE: u32 = u32::MAX;

/// What a write replaced.
#[derive(Clone, Copy, Debug)]
pub(super) enum Change {
    Triangle(u32, [u32; 3], [u32; 3]),
    First(u32, u32),
    Point(u32, DVec2),
    NewTriangle,
    NewVertex,
}

/// Triangles, their neighbours, and the vertices' places.
#[derive(Clone, Debug, Default)]
pub struct Web {
    pub(super) points: Vec<DVec2>,
    /// Corners, counter-clockwise; `NONE` in removed triangles.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The triangle opposite to each corner, `NONE` beyond the rim.
    pub(super) beside: Vec<[u32; 3]>,
    /// A triangle of each vertex, `NONE` for removed vertices.
    pub(super) first: Vec<u32>,
    log: Option<Vec<Change>>,
}

/// The same triangle from its corner `i`.
pub fn turned<T: Copy>(t: [T; 3], i: usize) -> [T; 3] {
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

    pub(super) fn note(&mut self, change: Change) {
        if let Some(log) = &mut self.log {
            log.push(change);
        }
    }

    pub(super) fn set(&mut self, t: u32, corners: [u32; 3], beside: [u32; 3]) {
        self.note(Change::Triangle(t, self.triangles[t as usize], self.beside[t as usize]));
        self.triangles[t as usize] = corners;
        self.beside[t as usize] = beside;
    }

    pub(super) fn set_first(&mut self, v: u32, t: u32) {
        self.note(Change::First(v, self.first[v as usize]));
        self.first[v as usize] = t;
    }

    /// In triangle `t` (if any) the neighbour `old` becomes `new`.
    pub(super) fn relink(&mut self, t: u32, old: u32, new: u32) {
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

    pub(super) fn new_triangle(&mut self) -> u32 {
        self.note(Change::NewTriangle);
        self.triangles.push([NONE; 3]);
        self.beside.push([NONE; 3]);
        (self.triangles.len() - 1) as u32
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
