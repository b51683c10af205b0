//! A coarser mesh of the same blade, and the way back: a fine sheet starts from the coarse one's shape, so that the many steps
//! from flat to dry are taken where they are cheap, and few where they are dear (nested iteration).
//!
//! Vertices are drawn onto a neighbour (half-edge collapse, Hoppe 1996) in rounds of such as do not touch, which keeps the
//! triangles even; the rim keeps its shape within a share of the coarse edges. Shapes are carried back as
//! sum b_i (x_i + G_i (p - p_i) / 2) over a triangle's corners, G_i the mean gradients about them: with the true gradients that
//! is exact for quadratics, hence smoother over the coarse edges than straight interpolation.

use crate::base::flat_mesh::FlatMesh;
use crate::base::vector::{DVec2, DVec3};
use nalgebra::Matrix3x2;

/// Least area of a triangle after a collapse, as a share of the square on its longest edge; an even one has 0.43.
const LEAST_AREA: f64 = 0.12;
/// How far a rim vertex that goes may lie from the new rim, in edges of the coarse mesh.
const OFF_RIM: f64 = 0.25;
/// Vertices that stay held.
const FEWEST_HELD: usize = 8;

/// A mesh of about `target` of its vertices. Its vertices are some of the fine ones, in their order.
pub fn coarsened(fine: &FlatMesh, target: usize) -> FlatMesh {
    let mut collapse = Collapse::new(fine, (fine.area().abs() / target.max(1) as f64).sqrt() * OFF_RIM);
    while collapse.left > target && collapse.round(target) {}
    collapse.mesh(fine)
}

/// A mesh whose vertices go one after the other.
struct Collapse<'a> {
    places: &'a [DVec2],
    triangles: Vec<[u32; 3]>,
    /// Triangles about each vertex; none about one that has gone.
    about: Vec<Vec<u32>>,
    held: Vec<bool>,
    held_left: usize,
    left: usize,
    off_rim: f64,
}

impl<'a> Collapse<'a> {
    fn new(mesh: &'a FlatMesh, off_rim: f64) -> Self {
        let mut about = vec![Vec::new(); mesh.positions.len()];
        for (number, triangle) in mesh.triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| about[v as usize].push(number as u32));
        }
        let mut held = vec![false; mesh.positions.len()];
        mesh.held.iter().for_each(|&v| held[v as usize] = true);
        let (held_left, left) = (mesh.held.len(), mesh.positions.len());
        Self { places: &mesh.positions, triangles: mesh.triangles.clone(), about, held, held_left, left, off_rim }
    }

    /// Draws away vertices that do not touch each other; false when none can go.
    fn round(&mut self, target: usize) -> bool {
        let mut touched = vec![false; self.places.len()];
        let before = self.left;
        for v in 0..self.places.len() as u32 {
            if self.left <= target {
                break;
            }
            if touched[v as usize] || self.about[v as usize].is_empty() {
                continue;
            }
            let around = self.around(v);
            let Some(onto) = self.best(v, &around) else { continue };
            around.iter().for_each(|&(u, _)| touched[u as usize] = true);
            self.draw(v, onto);
        }
        self.left < before
    }

    /// The neighbours of a vertex, each with the number of triangles at the edge to it.
    fn around(&self, v: u32) -> Vec<(u32, usize)> {
        let corners = self.about[v as usize].iter().flat_map(|&t| self.triangles[t as usize]);
        let mut around: Vec<u32> = corners.filter(|&u| u != v).collect();
        around.sort_unstable();
        around.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect()
    }

    /// The neighbour onto which a vertex is best drawn.
    fn best(&self, v: u32, around: &[(u32, usize)]) -> Option<u32> {
        if self.held[v as usize] && self.held_left <= FEWEST_HELD {
            return None;
        }
        let rim: Vec<u32> = around.iter().filter(|(_, sides)| *sides == 1).map(|(u, _)| *u).collect();
        if !rim.is_empty() && (rim.len() != 2 || self.off_line(v, rim[0], rim[1]) > self.off_rim) {
            return None;
        }
        let candidates = around
            .iter()
            .filter(|(u, sides)| (rim.is_empty() || *sides == 1) && (!self.held[v as usize] || self.held[*u as usize]));
        let mut best = (LEAST_AREA, None);
        for &(u, sides) in candidates {
            let shared = self.around(u).iter().filter(|(w, _)| around.binary_search_by_key(w, |x| x.0).is_ok()).count();
            let quality = self.quality(v, u);
            if shared == sides && quality > best.0 {
                best = (quality, Some(u));
            }
        }
        best.1
    }

    fn off_line(&self, v: u32, a: u32, b: u32) -> f64 {
        let [v, a, b] = [v, a, b].map(|i| self.places[i as usize]);
        (b - a).perp(&(v - a)).abs() / (b - a).norm().max(1e-300)
    }

    /// The worst triangle when a vertex is drawn onto another.
    fn quality(&self, v: u32, onto: u32) -> f64 {
        let kept = self.about[v as usize].iter().map(|&t| self.triangles[t as usize]).filter(|t| !t.contains(&onto));
        let quality = |t: [u32; 3]| {
            let [a, b, c] = t.map(|w| self.places[if w == v { onto } else { w } as usize]);
            let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
            0.5 * (b - a).perp(&(c - a)) / longest.max(1e-300)
        };
        kept.map(quality).fold(f64::INFINITY, f64::min)
    }

    fn draw(&mut self, v: u32, onto: u32) {
        for t in std::mem::take(&mut self.about[v as usize]) {
            let triangle = self.triangles[t as usize];
            if triangle.contains(&onto) {
                triangle.iter().for_each(|&w| self.about[w as usize].retain(|&other| other != t));
                self.triangles[t as usize] = [u32::MAX; 3];
            } else {
                self.triangles[t as usize] = triangle.map(|w| if w == v { onto } else { w });
                self.about[onto as usize].push(t);
            }
        }
        self.left -= 1;
        self.held_left -= usize::from(self.held[v as usize]);
    }

    fn mesh(&self, fine: &FlatMesh) -> FlatMesh {
        let kept: Vec<usize> = (0..self.places.len()).filter(|&v| !self.about[v].is_empty()).collect();
        let mut numbers = vec![u32::MAX; self.places.len()];
        kept.iter().enumerate().for_each(|(number, &v)| numbers[v] = number as u32);
        let number = |&v: &u32| Some(numbers[v as usize]).filter(|number| *number != u32::MAX);
        FlatMesh {
            positions: kept.iter().map(|&v| fine.positions[v]).collect(),
            uvs: kept.iter().filter_map(|&v| fine.uvs.get(v).copied()).collect(),
            greys: kept.iter().map(|&v| fine.greys[v]).collect(),
            triangles: self
                .triangles
                .iter()
                .filter(|t| t[0] != u32::MAX)
                .map(|t| t.map(|v| numbers[v as usize]))
                .collect(),
            rim: fine.rim.iter().filter_map(number).collect(),
            held: fine.held.iter().filter_map(number).collect(),
            lines: fine.lines.clone(),
            ..*fine
        }
    }
}

/// The way back from a coarse mesh to a fine one.
pub struct Return {
    coarse: FlatMesh,
    /// For each fine vertex its triangle and the shares of the corners.
    places: Vec<(u32, [f64; 3])>,
    fine: Vec<DVec2>,
}

impl Return {
    /// From a coarse mesh with the vertices of a fine one, in the same units as the shapes to carry.
    pub fn new(coarse: FlatMesh, fine: &[DVec2]) -> Self {
        let cells = Cells::new(&coarse);
        let places = fine.iter().map(|&p| cells.triangle(&coarse, p)).collect();
        Self { places, fine: fine.to_vec(), coarse }
    }

    /// A shape of the fine mesh that follows one of the coarse.
    pub fn carried(&self, shape: &[DVec3]) -> Vec<DVec3> {
        let gradients = self.gradients(shape);
        let at = |(p, (triangle, shares)): (&DVec2, &(u32, [f64; 3]))| {
            let corners = self.coarse.triangles[*triangle as usize];
            let from = |(&v, share): (&u32, &f64)| {
                let v = v as usize;
                (shape[v] + gradients[v] * (p - self.coarse.positions[v]) * 0.5) * *share
            };
            corners.iter().zip(shares).map(from).sum()
        };
        self.fine.iter().zip(&self.places).map(at).collect()
    }

    /// Mean gradient about each vertex.
    fn gradients(&self, shape: &[DVec3]) -> Vec<Matrix3x2<f64>> {
        let mut sums = vec![Matrix3x2::zeros(); shape.len()];
        let mut areas = vec![0.0; shape.len()];
        for &corners in &self.coarse.triangles {
            let [a, b, c] = corners.map(|v| self.coarse.positions[v as usize]);
            let [x, y, z] = corners.map(|v| shape[v as usize]);
            let (u, v) = (b - a, c - a);
            // Twice the area times the gradient.
            let (to_y, to_z) = (DVec2::new(v.y, -v.x), DVec2::new(-u.y, u.x));
            let gradient = (y - x) * to_y.transpose() + (z - x) * to_z.transpose();
            for corner in corners {
                sums[corner as usize] += gradient;
                areas[corner as usize] += u.perp(&v);
            }
        }
        sums.iter().zip(areas).map(|(sum, area)| sum / f64::max(area, 1e-300)).collect()
    }
}

/// Which triangles meet which cells of a square grid.
struct Cells {
    low: DVec2,
    size: f64,
    /// Cell and triangle, sorted.
    entries: Vec<([i32; 2], u32)>,
}

impl Cells {
    fn new(mesh: &FlatMesh) -> Self {
        let low = mesh.positions.iter().copied().reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let size = (mesh.area().abs() / mesh.triangles.len().max(1) as f64).sqrt() * 1.5;
        let mut cells = Self { low, size, entries: Vec::new() };
        for (number, corners) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
            let (first, last) = (cells.cell(a.inf(&b).inf(&c)), cells.cell(a.sup(&b).sup(&c)));
            for y in first[1]..=last[1] {
                cells.entries.extend((first[0]..=last[0]).map(|x| ([x, y], number as u32)));
            }
        }
        cells.entries.sort_unstable();
        cells
    }

    fn cell(&self, p: DVec2) -> [i32; 2] {
        let at = (p - self.low) / self.size;
        [at.x.floor() as i32, at.y.floor() as i32]
    }

    /// The triangle that holds a place, or the one that it is least outside of, and the shares of its corners.
    fn triangle(&self, mesh: &FlatMesh, p: DVec2) -> (u32, [f64; 3]) {
        let [x, y] = self.cell(p);
        let mut best = (f64::NEG_INFINITY, (0, [1.0, 0.0, 0.0]));
        for reach in 0..4 {
            for cell in (y - reach..=y + reach).flat_map(|y| (x - reach..=x + reach).map(move |x| [x, y])) {
                let start = self.entries.partition_point(|entry| entry.0 < cell);
                for entry in self.entries[start..].iter().take_while(|entry| entry.0 == cell) {
                    let [a, b, c] = mesh.triangles[entry.1 as usize].map(|v| mesh.positions[v as usize]);
                    let area = (b - a).perp(&(c - a));
                    let shares = [(c - b).perp(&(p - b)), (a - c).perp(&(p - c)), (b - a).perp(&(p - a))];
                    let shares = shares.map(|share| share / area);
                    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
                    if least > best.0 {
                        best = (least, (entry.1, shares));
                    }
                }
            }
            if best.0 > -0.5 {
                break;
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 30 x 30 places, the lower corner held.
    fn square() -> FlatMesh {
        let at = |x: u32, y: u32| y * 30 + x;
        let place = |i: u32| DVec2::new(f64::from(i % 30), f64::from(i / 30)) / 29.0;
        let two = |x: u32, y: u32| {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            if (x + y).is_multiple_of(2) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        };
        FlatMesh {
            positions: (0..900).map(place).collect(),
            triangles: (0..29).flat_map(|y| (0..29).flat_map(move |x| two(x, y))).collect(),
            greys: vec![0.0; 900],
            held: (0..4).flat_map(|y| (0..4).map(move |x| at(x, y))).collect(),
            ..FlatMesh::default()
        }
    }

    #[test]
    fn a_coarse_mesh_covers_the_same_blade_with_sound_triangles() {
        let fine = square();
        let coarse = coarsened(&fine, 150);
        assert!((100..=150).contains(&coarse.positions.len()), "{}", coarse.positions.len());
        assert!((coarse.area() - fine.area()).abs() < 1e-12);
        assert!(coarse.triangles.iter().all(|&t| coarse.doubled_area(t) > 0.0));
        assert!((3..=FEWEST_HELD).contains(&coarse.held.len()));
        // Euler's formula for a disc.
        assert_eq!(coarse.positions.len() + coarse.triangles.len(), coarse.edges().len() + 1);
    }

    #[test]
    fn planes_are_carried_back_exactly_and_quadratics_better_than_straight() {
        let fine = square();
        let coarse = coarsened(&fine, 200);
        let plane = |p: &DVec2| DVec3::new(p.x, 2.0 * p.y, 0.3 - 0.5 * p.x + p.y);
        let height = |p: &DVec2| DVec3::new(p.x, p.y, 0.7 * p.x * p.x - 0.4 * p.x * p.y + 1.1 * p.y * p.y);
        let (flat, bent): (Vec<DVec3>, Vec<DVec3>) = coarse.positions.iter().map(|p| (plane(p), height(p))).unzip();
        let triangles = coarse.triangles.clone();
        let way = Return::new(coarse, &fine.positions);
        for (p, x) in fine.positions.iter().zip(way.carried(&flat)) {
            assert!((x - plane(p)).norm() < 1e-12, "{p} {x}");
        }
        let straight = |(triangle, shares): &(u32, [f64; 3])| {
            triangles[*triangle as usize].iter().zip(shares).map(|(&v, share)| bent[v as usize] * *share).sum::<DVec3>()
        };
        let inside = |p: &DVec2| (p - DVec2::new(0.5, 0.5)).amax() < 0.25;
        let square = |(p, x): (&DVec2, DVec3)| if inside(p) { (x - height(p)).norm_squared() } else { 0.0 };
        let curved: f64 = fine.positions.iter().zip(way.carried(&bent)).map(square).sum();
        let straight: f64 = fine.positions.iter().zip(way.places.iter().map(straight)).map(square).sum();
        assert!(curved < 0.5 * straight, "{curved} {straight}");
    }
}
