//! How good the mesh of a blade is: angles, evenness, and how near its rim is to the outline.

use crate::base::blade::Blade;
use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::acos;
use crate::base::vector::DVec2;
use std::collections::BTreeSet;

/// Rim corners sharper than this excuse the triangles in them, degrees.
const SHARP: f64 = 60.0;

/// The figures of a mesh. Angles are in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grade {
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Smallest angle of the triangles that touch no sharp corner of the rim.
    pub min_angle: f64,
    /// 1st percentile of the smallest angles of those triangles.
    pub angle_p01: f64,
    /// Mean of the smallest angles.
    pub mean_min_angle: f64,
    /// Standard deviation of the edges' lengths over their mean.
    pub edge_cv: f64,
    /// Mean of twice the incircle's radius over the circumcircle's.
    pub mean_rr: f64,
    /// The least of it over the triangles that touch no sharp corner.
    pub worst_rr: f64,
    /// Share of the inner vertices that have six neighbours.
    pub valence_six: f64,
    /// Area of the mesh over that of the outline, less 1.
    pub area_error: f64,
    /// Farthest distance between rim and outline, in extents of the blade.
    pub hausdorff: f64,
}

impl Grade {
    /// The targets that are missed, each with its figure.
    #[must_use]
    pub fn missed_targets(&self) -> Vec<String> {
        let least = [
            ("smallest angle", self.min_angle, 25.0),
            ("1st percentile", self.angle_p01, 33.0),
            ("mean smallest angle", self.mean_min_angle, 54.0),
            ("mean 2r/R", self.mean_rr, 0.95),
            ("worst 2r/R", self.worst_rr, 0.5),
            ("valence 6", self.valence_six, 0.7),
        ];
        let most = [
            ("edge variation", self.edge_cv, 0.12),
            ("area", self.area_error.abs(), 1e-3),
            ("rim", self.hausdorff, 1e-3),
        ];
        let below =
            least.iter().filter(|(_, found, asked)| found.partial_cmp(asked).is_none_or(std::cmp::Ordering::is_lt));
        let above =
            most.iter().filter(|(_, found, asked)| found.partial_cmp(asked).is_none_or(std::cmp::Ordering::is_gt));
        below.chain(above).map(|(name, found, _)| format!("{name} {found:.4}")).collect()
    }
}

/// Grades a blade's mesh.
#[must_use]
pub fn grade(blade: &Blade) -> Grade {
    let mesh = &blade.mesh;
    let sharp = sharp_corners(mesh);
    let is_free = |triangle: &[u32; 3]| !triangle.iter().any(|v| sharp.contains(v));
    let all: Vec<(f64, f64)> = mesh.triangles.iter().map(|t| of_triangle(mesh, *t)).collect();
    let free: Vec<(f64, f64)> = mesh.triangles.iter().zip(&all).filter(|(t, _)| is_free(t)).map(|(_, g)| *g).collect();
    let mut angles: Vec<f64> = free.iter().map(|graded| graded.0).collect();
    angles.sort_by(f64::total_cmp);
    let mean = |of: fn(&(f64, f64)) -> f64| all.iter().map(of).sum::<f64>() / all.len().max(1) as f64;
    let extent = extent(&blade.outline);
    let holes: f64 = blade.holes.iter().map(|hole| doubled_area(hole).abs()).sum();
    Grade {
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        min_angle: angles.first().copied().unwrap_or(0.0),
        angle_p01: angles.get(angles.len() / 100).copied().unwrap_or(0.0),
        mean_min_angle: mean(|graded| graded.0),
        edge_cv: edge_variation(mesh),
        mean_rr: mean(|graded| graded.1),
        worst_rr: free.iter().map(|graded| graded.1).fold(1.0, f64::min),
        valence_six: valence_six(mesh),
        area_error: 2.0 * mesh.area() / (doubled_area(&blade.outline).abs() - holes) - 1.0,
        hausdorff: hausdorff(mesh, &blade.outline) / extent,
    }
}

/// Smallest angle in degrees and 2r/R of a triangle.
fn of_triangle(mesh: &FlatMesh, triangle: [u32; 3]) -> (f64, f64) {
    let points = triangle.map(|v| mesh.positions[v as usize]);
    let squares = [0, 1, 2].map(|i| (points[(i + 1) % 3] - points[i]).norm_squared());
    let [a, b, c] = squares.map(f64::sqrt);
    let cosine = |i: usize| {
        let (next, last) = (squares[(i + 1) % 3], squares[(i + 2) % 3]);
        (next + last - squares[i]) / (2.0 * (next * last).sqrt())
    };
    let largest = [0, 1, 2].map(cosine).into_iter().fold(-1.0, f64::max);
    (acos(largest.min(1.0)).to_degrees(), (b + c - a) * (c + a - b) * (a + b - c) / (a * b * c))
}

/// Rim vertices at which the rim turns back on itself.
fn sharp_corners(mesh: &FlatMesh) -> BTreeSet<u32> {
    let count = mesh.rim.len();
    let place = |i: usize| mesh.positions[mesh.rim[i % count] as usize];
    let is_sharp = |&i: &usize| {
        let (before, here, after) = (place(i + count - 1), place(i), place(i + 1));
        let (a, b) = (before - here, after - here);
        acos((a.dot(&b) / (a.norm() * b.norm())).clamp(-1.0, 1.0)).to_degrees() < SHARP
    };
    (0..count).filter(is_sharp).map(|i| mesh.rim[i]).collect()
}

fn edge_variation(mesh: &FlatMesh) -> f64 {
    let length = |&[a, b]: &[u32; 2]| (mesh.positions[b as usize] - mesh.positions[a as usize]).norm();
    let lengths: Vec<f64> = mesh.edges().iter().map(length).collect();
    let mean = lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
    let square = lengths.iter().map(|length| (length - mean) * (length - mean)).sum::<f64>();
    (square / lengths.len().max(1) as f64).sqrt() / mean
}

fn valence_six(mesh: &FlatMesh) -> f64 {
    let mut valences = vec![0u32; mesh.positions.len()];
    let mut inner = vec![0i32; mesh.positions.len()];
    for edge in mesh.edges() {
        edge.iter().for_each(|&v| valences[v as usize] += 1);
    }
    // A vertex inside has as many triangles as neighbours; one on a rim has one fewer.
    mesh.triangles.iter().flatten().for_each(|&v| inner[v as usize] += 1);
    let is_inner = |v: &usize| inner[*v] == valences[*v] as i32;
    let count = (0..valences.len()).filter(is_inner).count();
    let six = (0..valences.len()).filter(is_inner).filter(|&v| valences[v] == 6).count();
    six as f64 / count.max(1) as f64
}

fn doubled_area(points: &[DVec2]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| a.perp(b)).sum()
}

fn extent(points: &[DVec2]) -> f64 {
    let Some(first) = points.first() else { return 1.0 };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).max()
}

/// Farthest distance between the rim and the outline, both ways, from vertex to line.
fn hausdorff(mesh: &FlatMesh, outline: &[DVec2]) -> f64 {
    let rim: Vec<DVec2> = mesh.rim.iter().map(|&v| mesh.positions[v as usize]).collect();
    farthest(&rim, outline).max(farthest(outline, &rim))
}

fn farthest(points: &[DVec2], line: &[DVec2]) -> f64 {
    let sides = || line.iter().zip(line.iter().cycle().skip(1));
    let nearest = |p: &DVec2| sides().map(|(a, b)| squared_distance(p, a, b)).fold(f64::INFINITY, f64::min);
    points.iter().map(nearest).fold(0.0, f64::max).sqrt()
}

fn squared_distance(p: &DVec2, a: &DVec2, b: &DVec2) -> f64 {
    let side = b - a;
    let along = ((p - a).dot(&side) / side.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (p - (a + side * along)).norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hexagon of six equilateral triangles, 1 wide.
    fn hexagon() -> Blade {
        let corner = |i: u32| {
            let (sine, cosine) = crate::base::maths::sincos(f64::from(i) * std::f64::consts::FRAC_PI_3);
            DVec2::new(cosine, sine)
        };
        let outline: Vec<DVec2> = (0..6).map(corner).collect();
        let mut positions = outline.clone();
        positions.push(DVec2::zeros());
        let triangles = (0..6).map(|i| [i, (i + 1) % 6, 6]).collect();
        let mesh = FlatMesh { positions, triangles, rim: (0..6).collect(), ..FlatMesh::default() };
        Blade { mesh, outline, ..Blade::default() }
    }

    #[test]
    fn an_even_mesh_that_is_its_outline_is_perfect() {
        let grade = grade(&hexagon());
        assert!((grade.min_angle - 60.0).abs() < 1e-9 && (grade.mean_rr - 1.0).abs() < 1e-12);
        assert!(grade.edge_cv < 1e-12 && grade.hausdorff < 1e-12 && grade.area_error.abs() < 1e-12);
        assert_eq!((grade.valence_six, grade.vertices), (1.0, 7));
        assert!(grade.missed_targets().is_empty());
    }

    #[test]
    fn a_rim_that_misses_its_outline_is_as_far_as_it_is() {
        let mut blade = hexagon();
        blade.outline.push(DVec2::new(0.0, -2.0));
        blade.outline.swap(6, 5);
        let grade = grade(&blade);
        assert!(grade.hausdorff > 0.2 && grade.area_error < -0.05);
        assert!(grade.missed_targets().iter().any(|fault| fault.starts_with("rim")));
    }
}
