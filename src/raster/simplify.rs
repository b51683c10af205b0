//! Coarser versions of small meshes for what is seen small: edges collapse onto one of their ends, cheapest first, by the
//! squared distances to the planes that met there (Garland and Heckbert 1997), with planes along the rim so that the outline
//! holds. No vertex moves, so normals and texture coordinates stay true. What is lost is measured, not estimated: each vertex
//! that went is kept with the triangle or the rim's edge that stands for it now.

use super::quadric::Quadric;
use crate::base::mesh::Mesh;
use crate::base::vector::DVec3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Weight of the planes that hold the rim, against those of the surface.
const RIM_WEIGHT: f64 = 2.0;
/// A triangle may not turn by more than this cosine when an edge collapses.
const LEAST_COSINE: f64 = 0.3;
/// No vertex.
const NONE: u32 = u32::MAX;

/// Some triangles of a mesh that stand for all of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Simplified {
    /// Vertex numbers of the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// Largest distance of a vertex of the mesh from what stands for it, metres: for the rim's from the new rim, for others
    /// from the new surface.
    pub error: f64,
}

impl Simplified {
    /// The version as a mesh, its vertices where they were, with its error.
    pub(super) fn of(self, mesh: &Mesh) -> (Mesh, f64) {
        (Mesh { triangles: self.triangles, ..mesh.clone() }, self.error)
    }
}

/// Versions of a mesh with at most each of `counts` triangles (falling), as far as collapses allow; fewer versions where
/// nothing more can go.
pub(super) fn simplified(mesh: &Mesh, counts: &[usize]) -> Vec<Simplified> {
    let mut state = State::new(mesh);
    let mut versions = Vec::new();
    for &count in counts {
        let before = state.left;
        while state.left > count && state.collapse_cheapest() {}
        if state.left > count && state.left == before {
            break;
        }
        if state.left == before {
            continue;
        }
        versions
            .push(Simplified { triangles: state.triangles.iter().flatten().copied().collect(), error: state.error });
    }
    versions
}

/// A collapse by its cost (the bits of a number that is not negative), the vertex that goes, the vertex that it becomes, and
/// how often what they hold had changed when it was priced.
type Collapse = Reverse<(u64, u32, u32, [u32; 2])>;

struct State {
    positions: Vec<DVec3>,
    quadrics: Vec<Quadric>,
    /// The triangles; those that are gone are empty.
    triangles: Vec<Option<[u32; 3]>>,
    /// How many are left.
    left: usize,
    /// The triangles around each vertex.
    around: Vec<Vec<u32>>,
    /// The vertices before and after each along the rim, in the sense of its triangles; `NONE` inside.
    rim: Vec<[u32; 2]>,
    /// Vertices of the rim that must stay: there two rims meet.
    is_fixed: Vec<bool>,
    /// The vertices that each triangle stands for, and those that the rim's edge after each vertex stands for.
    inner: Vec<Vec<u32>>,
    outer: Vec<Vec<u32>>,
    changes: Vec<u32>,
    heap: BinaryHeap<Collapse>,
    /// What could not be done when it was the cheapest.
    set_aside: Vec<Collapse>,
    error: f64,
}

impl State {
    fn new(mesh: &Mesh) -> Self {
        let positions: Vec<DVec3> = mesh.positions.iter().map(|p| p.cast::<f64>()).collect();
        let count = positions.len();
        let mut state = Self {
            positions,
            quadrics: vec![Quadric::default(); count],
            triangles: mesh.triangles.iter().copied().map(Some).collect(),
            left: mesh.triangles.len(),
            around: vec![Vec::new(); count],
            rim: vec![[NONE; 2]; count],
            is_fixed: vec![false; count],
            inner: vec![Vec::new(); mesh.triangles.len()],
            outer: vec![Vec::new(); count],
            changes: vec![0; count],
            heap: BinaryHeap::new(),
            set_aside: Vec::new(),
            error: 0.0,
        };
        let mut directed = BTreeMap::new();
        for (number, triangle) in mesh.triangles.iter().enumerate() {
            for k in 0..3 {
                state.around[triangle[k] as usize].push(number as u32);
                directed.insert([triangle[k], triangle[(k + 1) % 3]], *triangle);
            }
            state.hold_surface(triangle);
        }
        for (&[a, b], triangle) in &directed {
            if !directed.contains_key(&[b, a]) {
                state.hold_rim([a, b], triangle);
            }
        }
        for &[a, b] in directed.keys() {
            if a < b || !directed.contains_key(&[b, a]) {
                state.price(a, b);
            }
        }
        state
    }

    fn hold_surface(&mut self, triangle: &[u32; 3]) {
        let normal = self.doubled_area(triangle);
        let area = normal.norm() * 0.5;
        if area > 0.0 {
            let plane = Quadric::plane(normal / (2.0 * area), self.positions[triangle[0] as usize], area);
            for &v in triangle {
                self.quadrics[v as usize] = self.quadrics[v as usize].plus(&plane);
            }
        }
    }

    /// Notes an edge of the rim and adds the plane that stands on it at right angles to its triangle.
    fn hold_rim(&mut self, [a, b]: [u32; 2], triangle: &[u32; 3]) {
        for (v, side, other) in [(a, 1, b), (b, 0, a)] {
            self.is_fixed[v as usize] |= self.rim[v as usize][side] != NONE;
            self.rim[v as usize][side] = other;
        }
        let along = self.positions[b as usize] - self.positions[a as usize];
        let upright = along.cross(&self.doubled_area(triangle));
        if let Some(normal) = upright.try_normalize(1e-30) {
            let plane = Quadric::plane(normal, self.positions[a as usize], along.norm_squared() * RIM_WEIGHT);
            for v in [a, b] {
                self.quadrics[v as usize] = self.quadrics[v as usize].plus(&plane);
            }
        }
    }

    fn doubled_area(&self, triangle: &[u32; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
        (b - a).cross(&(c - a))
    }

    fn is_on_rim(&self, v: u32) -> bool {
        self.rim[v as usize] != [NONE; 2]
    }

    /// Puts the two collapses of an edge among the candidates, where they may be made at all.
    fn price(&mut self, a: u32, b: u32) {
        let both = self.quadrics[a as usize].plus(&self.quadrics[b as usize]);
        let is_rim = self.rim[a as usize].contains(&b);
        for (from, to) in [(a, b), (b, a)] {
            if self.is_fixed[from as usize] || (self.is_on_rim(from) && !is_rim) {
                continue;
            }
            let cost = both.distance(self.positions[to as usize]);
            let stamp = [self.changes[from as usize], self.changes[to as usize]];
            self.heap.push(Reverse((cost.to_bits(), from, to, stamp)));
        }
    }

    /// Makes the cheapest collapse that may be made; says whether there was one.
    fn collapse_cheapest(&mut self) -> bool {
        while let Some(candidate) = self.heap.pop() {
            let Reverse((_, from, to, stamp)) = candidate;
            if stamp != [self.changes[from as usize], self.changes[to as usize]] {
                continue;
            }
            if self.stays_a_surface(from, to) && self.keeps_facing(from, to) {
                self.collapse(from, to);
                // Around what changed, what could not be done may be possible now.
                self.heap.extend(std::mem::take(&mut self.set_aside));
                return true;
            }
            self.set_aside.push(candidate);
        }
        false
    }

    /// The vertices that share a triangle with `v`, each as often as it does.
    fn neighbours(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let triangles = self.around[v as usize].iter().filter_map(|&t| self.triangles[t as usize]);
        triangles.flatten().filter(move |&other| other != v)
    }

    /// Whether the ends of an edge share just the corners of its triangles: only then does the surface stay one.
    fn stays_a_surface(&self, from: u32, to: u32) -> bool {
        let mut shared: Vec<u32> =
            self.neighbours(from).filter(|&v| self.neighbours(to).any(|other| other == v)).collect();
        shared.sort_unstable();
        shared.dedup();
        let at_edge = self.neighbours(from).filter(|&v| v == to).count();
        shared.len() == at_edge
    }

    /// Whether no triangle turns over when `from` becomes `to`.
    fn keeps_facing(&self, from: u32, to: u32) -> bool {
        let triangles = self.around[from as usize].iter().filter_map(|&t| self.triangles[t as usize]);
        triangles.filter(|triangle| !triangle.contains(&to)).all(|triangle| {
            let moved = triangle.map(|v| if v == from { to } else { v });
            let (before, after) = (self.doubled_area(&triangle), self.doubled_area(&moved));
            after.dot(&before) > LEAST_COSINE * after.norm() * before.norm()
        })
    }

    fn collapse(&mut self, from: u32, to: u32) {
        let mut homeless = Vec::new();
        for number in std::mem::take(&mut self.around[from as usize]) {
            let place = number as usize;
            let Some(triangle) = self.triangles[place] else { continue };
            homeless.append(&mut self.inner[place]);
            if triangle.contains(&to) {
                self.triangles[place] = None;
                self.left -= 1;
                for v in triangle {
                    self.around[v as usize].retain(|&t| t != number);
                }
            } else {
                self.triangles[place] = Some(triangle.map(|v| if v == from { to } else { v }));
                self.around[to as usize].push(number);
            }
        }
        if self.is_on_rim(from) {
            self.join_rim(from, to);
        } else {
            homeless.push(from);
        }
        for v in homeless {
            self.house(v, to);
        }
        self.quadrics[to as usize] = self.quadrics[to as usize].plus(&self.quadrics[from as usize]);
        self.changes[from as usize] += 1;
        self.changes[to as usize] += 1;
        let mut ring: Vec<u32> = self.neighbours(to).collect();
        ring.sort_unstable();
        ring.dedup();
        for v in ring {
            self.price(v, to);
        }
    }

    /// Gives a vertex that is gone to the nearest triangle around `to`.
    fn house(&mut self, v: u32, to: u32) {
        let point = self.positions[v as usize];
        let mut nearest = (f64::INFINITY, 0);
        for &number in &self.around[to as usize] {
            if let Some(triangle) = self.triangles[number as usize] {
                let distance = distance_to_triangle(point, triangle.map(|v| self.positions[v as usize]));
                if distance < nearest.0 {
                    nearest = (distance, number);
                }
            }
        }
        if nearest.0.is_finite() {
            self.error = self.error.max(nearest.0);
            self.inner[nearest.1 as usize].push(v);
        }
    }

    /// Closes the rim where `from` was, and measures how far what went lies from it.
    fn join_rim(&mut self, from: u32, to: u32) {
        let [before, after] = self.rim[from as usize];
        let mut gone = std::mem::take(&mut self.outer[from as usize]);
        gone.push(from);
        self.rim[before as usize][1] = after;
        self.rim[after as usize][0] = before;
        self.outer[before as usize].append(&mut gone);
        debug_assert!(to == before || to == after);
        let ends = [before, after].map(|v| self.positions[v as usize]);
        for &v in &self.outer[before as usize] {
            self.error = self.error.max(distance_to_segment(self.positions[v as usize], ends));
        }
    }
}

/// Distance of a point from a segment.
pub(super) fn distance_to_segment(point: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = b - a;
    let share = (point - a).dot(&along) / along.norm_squared().max(1e-300);
    (point - (a + along * share.clamp(0.0, 1.0))).norm()
}

/// Distance of a point from a triangle.
pub(super) fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let is_inside = |from: DVec3, to: DVec3| (to - from).cross(&(point - from)).dot(&normal) >= 0.0;
    if normal.norm_squared() > 0.0 && is_inside(a, b) && is_inside(b, c) && is_inside(c, a) {
        return ((point - a).dot(&normal) / normal.norm()).abs();
    }
    [[a, b], [b, c], [c, a]].into_iter().map(|side| distance_to_segment(point, side)).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::{Vec2, Vec3};

    /// A grid of `n` x `n` squares over the unit square, lifted by `height`.
    fn grid(n: u32, height: impl Fn(f32, f32) -> f32) -> Mesh {
        let mut mesh = Mesh::default();
        for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
            let (x, y) = (i as f32 / n as f32, j as f32 / n as f32);
            mesh.positions.push(Vec3::new(x, y, height(x, y)));
            mesh.uvs.push(Vec2::new(x, y));
        }
        for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
            let a = j * (n + 1) + i;
            mesh.triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
        mesh.recompute_normals();
        mesh
    }

    fn area(mesh: &Mesh, triangles: &[[u32; 3]]) -> f64 {
        Mesh { triangles: triangles.to_vec(), ..mesh.clone() }.area()
    }

    #[test]
    fn a_flat_square_needs_two_triangles_and_loses_nothing() {
        let mesh = grid(8, |_, _| 0.0);
        let versions = simplified(&mesh, &[40, 2]);
        assert_eq!(versions.len(), 2);
        assert_eq!(versions[1].triangles.len(), 2);
        assert!(versions[1].error < 1e-6);
        for version in &versions {
            assert!((area(&mesh, &version.triangles) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_error_grows_with_what_is_left_out_and_bounds_a_bump() {
        let mesh = grid(10, |x, y| 0.1 * (x - 0.5) * (x - 0.5) + 0.05 * y * y);
        let versions = simplified(&mesh, &[100, 50, 25, 12]);
        assert_eq!(versions.len(), 4);
        assert!(versions.windows(2).all(|pair| pair[0].error <= pair[1].error));
        assert!(versions[0].error > 1e-6 && versions[3].error < 0.05);
        for version in &versions {
            assert!((area(&mesh, &version.triangles) / mesh.area() - 1.0).abs() < 0.02);
        }
    }

    #[test]
    fn the_error_is_how_far_what_went_lies_from_what_stands_for_it() {
        // A strip with a tooth of 0.03 in its long side: once the tooth has gone, it is the largest error.
        let mut mesh = grid(10, |_, _| 0.0);
        mesh.positions[5].y = -0.03;
        let versions = simplified(&mesh, &[100, 50, 2]);
        let error = |triangles: usize| versions.iter().find(|v| v.triangles.len() <= triangles).map(|v| v.error);
        assert!(error(2).is_some_and(|error| (error - 0.03).abs() < 1e-6), "{versions:?}");
        assert!(error(50).is_some_and(|error| error < 1e-6), "the tooth goes last");
    }
}
