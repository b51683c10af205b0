//! The changes of a mesh's connections: an edge flipped, split or collapsed, within and on the rim.

use crate::base::vector::DVec2;
use crate::leaf::remesh::web::{Change, NONE, Web, turned};

impl Web {
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

    /// A change, and whether it was made.
    type Edit = fn(&mut Web) -> bool;

    #[test]
    fn every_change_is_sound_and_can_be_undone() {
        let mut web = wheel();
        let before = (shape(&web), web.beside.clone(), web.points.clone());
        let changes: [(usize, Edit); 7] = [
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
