//! Coarser versions of small meshes for what is seen small: edges collapse onto one of their ends, cheapest first, by the
//! squared distances to the planes that met there (Garland and Heckbert 1997), with planes along the rim so that the outline
//! holds. No vertex moves, so normals and texture coordinates stay true; what is lost is stated as a distance in metres.

use crate::base::mesh::Mesh;
use crate::base::vector::DVec3;
use std::collections::BTreeMap;

/// Weight of the planes that hold the rim, against those of the surface.
const RIM_WEIGHT: f64 = 2.0;
/// A triangle may not turn by more than this cosine when an edge collapses.
const LEAST_COSINE: f64 = 0.3;

/// Some triangles of a mesh that stand for all of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Simplified {
    /// Vertex numbers of the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// Distance from the full mesh, metres (root mean square over what was removed at the worst place).
    pub error: f64,
}

/// Squared distance to a set of planes, weighted: x^T A x + 2 b x + c, and the sum of weights.
#[derive(Clone, Copy, Debug, Default)]
struct Quadric {
    a: [f64; 6],
    b: DVec3,
    c: f64,
    weight: f64,
}

impl Quadric {
    fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let d = -normal.dot(&point);
        let n = normal;
        let a = [n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z, n.z * n.z].map(|value| value * weight);
        Self { a, b: n * (d * weight), c: d * d * weight, weight }
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            a: std::array::from_fn(|k| self.a[k] + other.a[k]),
            b: self.b + other.b,
            c: self.c + other.c,
            weight: self.weight + other.weight,
        }
    }

    /// Root mean square distance of a point from the planes.
    fn distance(&self, p: DVec3) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        let square = xx * p.x * p.x
            + yy * p.y * p.y
            + zz * p.z * p.z
            + 2.0 * (xy * p.x * p.y + xz * p.x * p.z + yz * p.y * p.z)
            + 2.0 * self.b.dot(&p)
            + self.c;
        (square.max(0.0) / self.weight.max(1e-30)).sqrt()
    }
}

/// Versions of a mesh with at most each of `counts` triangles (falling), as far as collapses allow; fewer versions where
/// nothing more can go.
pub(super) fn simplified(mesh: &Mesh, counts: &[usize]) -> Vec<Simplified> {
    let mut state = State::new(mesh);
    let mut versions = Vec::new();
    let mut error = 0.0f64;
    for &count in counts {
        let before = state.triangles.len();
        while state.triangles.len() > count {
            match state.collapse_some(count) {
                Some(cost) => error = error.max(cost),
                None => break,
            }
        }
        if state.triangles.len() == before {
            break;
        }
        versions.push(Simplified { triangles: state.triangles.clone(), error });
    }
    versions
}

/// What a collapse costs, the vertex that goes, the vertex that it becomes.
type Collapse = (f64, u32, u32);
/// The vertices that share an edge with each vertex.
type Neighbours = Vec<Vec<u32>>;

struct State {
    positions: Vec<DVec3>,
    quadrics: Vec<Quadric>,
    triangles: Vec<[u32; 3]>,
}

impl State {
    fn new(mesh: &Mesh) -> Self {
        let positions: Vec<DVec3> = mesh.positions.iter().map(|p| p.cast::<f64>()).collect();
        let mut state =
            Self { quadrics: vec![Quadric::default(); positions.len()], positions, triangles: mesh.triangles.clone() };
        for triangle in &mesh.triangles {
            let normal = state.doubled_area(triangle);
            let area = normal.norm() * 0.5;
            if area > 0.0 {
                let plane = Quadric::plane(normal / (2.0 * area), state.positions[triangle[0] as usize], area);
                for &v in triangle {
                    state.quadrics[v as usize] = state.quadrics[v as usize].plus(&plane);
                }
            }
        }
        for (edge, (count, triangle)) in state.edges() {
            if count == 1 {
                state.hold_rim(edge, triangle);
            }
        }
        state
    }

    /// Adds the plane that stands on a rim edge at right angles to its triangle.
    fn hold_rim(&mut self, [a, b]: [u32; 2], triangle: usize) {
        let along = self.positions[b as usize] - self.positions[a as usize];
        let upright = along.cross(&self.doubled_area(&self.triangles[triangle]));
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

    /// Every edge (smaller vertex first) with the number of its triangles and one of them.
    fn edges(&self) -> BTreeMap<[u32; 2], (usize, usize)> {
        let mut edges = BTreeMap::new();
        for (number, &[a, b, c]) in self.triangles.iter().enumerate() {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                let entry = edges.entry([p.min(q), p.max(q)]).or_insert((0, number));
                entry.0 += 1;
            }
        }
        edges
    }

    /// Makes the cheapest collapses that do not touch one another, at most a tenth of the edges' number and no more than
    /// needed for `count` triangles; the largest cost, or `None` when nothing may collapse.
    fn collapse_some(&mut self, count: usize) -> Option<f64> {
        let (candidates, around) = self.candidates();
        let mut touched = vec![false; self.positions.len()];
        let mut left = candidates.len() / 20 + 1;
        let mut largest = None;
        for (cost, from, to) in candidates {
            if left == 0 || self.triangles.len() <= count {
                break;
            }
            if touched[from as usize] || touched[to as usize] || !self.keeps_facing(from, to) {
                continue;
            }
            for v in around[from as usize].iter().chain(&around[to as usize]) {
                touched[*v as usize] = true;
            }
            self.collapse(from, to);
            largest = Some(cost);
            left -= 1;
        }
        largest
    }

    /// The collapses that keep the surface a disc, cheapest first, and each vertex's neighbours.
    fn candidates(&self) -> (Vec<Collapse>, Neighbours) {
        let edges = self.edges();
        let mut on_rim = vec![false; self.positions.len()];
        let mut around: Neighbours = vec![Vec::new(); self.positions.len()];
        for (&[a, b], &(count, _)) in &edges {
            around[a as usize].push(b);
            around[b as usize].push(a);
            if count == 1 {
                on_rim[a as usize] = true;
                on_rim[b as usize] = true;
            }
        }
        let mut candidates: Vec<Collapse> = Vec::with_capacity(edges.len() * 2);
        for (&[a, b], &(count, _)) in &edges {
            let shared = around[a as usize].iter().filter(|v| around[b as usize].contains(v)).count();
            // Only then does the surface stay a disc: an edge's ends share just the corners of its triangles.
            if shared != count {
                continue;
            }
            for (from, to) in [(a, b), (b, a)] {
                if on_rim[from as usize] && count == 2 {
                    continue;
                }
                let both = self.quadrics[from as usize].plus(&self.quadrics[to as usize]);
                candidates.push((both.distance(self.positions[to as usize]), from, to));
            }
        }
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        (candidates, around)
    }

    /// Whether no triangle turns over when `from` becomes `to`.
    fn keeps_facing(&self, from: u32, to: u32) -> bool {
        let touched = self.triangles.iter().filter(|t| t.contains(&from) && !t.contains(&to));
        touched.into_iter().all(|triangle| {
            let moved = triangle.map(|v| if v == from { to } else { v });
            let (before, after) = (self.doubled_area(triangle), self.doubled_area(&moved));
            after.dot(&before) > LEAST_COSINE * after.norm() * before.norm()
        })
    }

    fn collapse(&mut self, from: u32, to: u32) {
        self.quadrics[to as usize] = self.quadrics[to as usize].plus(&self.quadrics[from as usize]);
        self.triangles.retain(|t| !(t.contains(&from) && t.contains(&to)));
        for v in self.triangles.iter_mut().flatten().filter(|v| **v == from) {
            *v = to;
        }
    }
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
}
