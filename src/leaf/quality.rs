//! How good a flat triangle mesh is.

use crate::base::maths::acos;
use crate::base::vector::DVec2;
use crate::leaf::triangulation::{Topology, corner_angle};

/// Rim corners sharper than this excuse the triangles in them: no mesher can open a tip.
pub const SHARP_RIM: f64 = 60.0 * std::f64::consts::PI / 180.0;

/// The figures of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Smallest angle of the triangles that touch no sharp rim corner, radians.
    pub min_angle: f64,
    /// Mean of q = 2 r/R, twice the incircle's radius over the circumcircle's: 1 for an equilateral triangle.
    pub q_mean: f64,
    /// 5th percentile of q.
    pub q_p05: f64,
    /// Standard deviation of the edges' lengths over their mean.
    pub edge_cv: f64,
    /// Triangles that are excused from `min_angle`.
    pub excused: usize,
}

impl Quality {
    /// One number to compare rounds by: mean q, less what the smallest angle and the unevenness miss of the aims.
    pub fn score(&self) -> f64 {
        self.q_mean - (0.5 - self.min_angle).max(0.0) * 0.2 - (self.edge_cv - 0.1).max(0.0)
    }
}

/// The three angles of a triangle, radians.
pub fn angles(points: [DVec2; 3]) -> [f64; 3] {
    let angle = |i: usize| {
        let (a, b) = (points[(i + 1) % 3] - points[i], points[(i + 2) % 3] - points[i]);
        acos((a.dot(&b) / (a.norm() * b.norm())).clamp(-1.0, 1.0))
    };
    [angle(0), angle(1), angle(2)]
}

/// q = 8 (s-a)(s-b)(s-c) / (abc).
pub fn radius_ratio(points: [DVec2; 3]) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|i| (points[(i + 1) % 3] - points[i]).norm());
    (b + c - a) * (c + a - b) * (a + b - c) / (a * b * c)
}

/// Which rim vertices are sharp corners.
pub fn sharp_rim(points: &[DVec2], rim: usize) -> Vec<bool> {
    let angle = |i: usize| corner_angle(points[(i + rim - 1) % rim], points[i], points[(i + 1) % rim]);
    (0..rim).map(|i| angle(i) < SHARP_RIM).collect()
}

/// Grades a mesh whose first `rim` vertices are its rim in order.
pub fn graded(points: &[DVec2], rim: usize, topology: &Topology) -> Quality {
    let sharp = sharp_rim(points, rim);
    let excused = |t: &&[u32; 3]| t.iter().any(|&v| sharp.get(v as usize).copied().unwrap_or(false));
    let corners = |t: &[u32; 3]| t.map(|v| points[v as usize]);
    let triangles = &topology.triangles;
    let free = triangles.iter().filter(|t| !excused(t)).flat_map(|t| angles(corners(t)));
    let mut ratios: Vec<f64> = triangles.iter().map(|t| radius_ratio(corners(t))).collect();
    ratios.sort_by(f64::total_cmp);
    let lengths: Vec<f64> =
        topology.edges.iter().map(|e| (points[e[0] as usize] - points[e[1] as usize]).norm()).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let middle = mean(&lengths);
    let squares: Vec<f64> = lengths.iter().map(|l| (l - middle) * (l - middle)).collect();
    Quality {
        min_angle: free.fold(std::f64::consts::FRAC_PI_3, f64::min),
        q_mean: mean(&ratios),
        q_p05: ratios.get(ratios.len() / 20).copied().unwrap_or(0.0),
        edge_cv: mean(&squares).sqrt() / middle,
        excused: triangles.iter().filter(excused).count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_triangles_have_known_ratios() {
        let right = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let even = [(0.0, 0.0), (1.0, 0.0), (0.5, 0.75f64.sqrt())].map(|(x, y)| DVec2::new(x, y));
        assert!((radius_ratio(right) - (2.0 * 2f64.sqrt() - 2.0)).abs() < 1e-14);
        assert!((radius_ratio(even) - 1.0).abs() < 1e-14);
        assert!((angles(right)[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-14);
    }
}
