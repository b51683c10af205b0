//! Constrained Delaunay triangulation of a rim and the points within, by spade (exact predicates).

use crate::base::maths::atan2;
use crate::base::vector::DVec2;
use crate::leaf::LeafError;
use crate::leaf::polygon;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// A point that remembers its number.
struct Site {
    position: Point2<f64>,
    number: u32,
}

impl HasPosition for Site {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// Which vertices are joined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Triangles inside the rim, counter-clockwise, smallest number first, sorted.
    pub triangles: Vec<[u32; 3]>,
    /// Edges once, smaller number first, sorted.
    pub edges: Vec<[u32; 2]>,
}

/// The angle inside a counter-clockwise polygon at `b` between its neighbours `a` (before) and `c` (after), 0 to 2 pi.
pub fn corner_angle(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (ahead, back) = (c - b, a - b);
    let angle = atan2(ahead.perp(&back), ahead.dot(&back));
    if angle < 0.0 { angle + std::f64::consts::TAU } else { angle }
}

/// Triangulates points of which the first `rim` are a simple counter-clockwise polygon and the others lie within it.
///
/// # Errors
/// [`LeafError::Mesh`] when spade refuses a coordinate.
pub fn triangulated(points: &[DVec2], rim: usize) -> Result<Topology, LeafError> {
    let site = |(i, p): (usize, &DVec2)| Site { position: Point2::new(p.x, p.y), number: i as u32 };
    let sites: Vec<Site> = points.iter().enumerate().map(site).collect();
    let edges: Vec<[usize; 2]> = (0..rim).map(|i| [i, (i + 1) % rim]).collect();
    let web = ConstrainedDelaunayTriangulation::<Site>::try_bulk_load_cdt(sites, edges, |_| {})
        .map_err(|fault| LeafError::Mesh { what: fault.to_string() })?;
    let mut triangles: Vec<[u32; 3]> = web
        .inner_faces()
        .map(|face| turned(face.vertices().map(|v| v.data().number)))
        .filter(|&t| is_inside(points, rim, t))
        .collect();
    triangles.sort_unstable();
    let mut edges: Vec<[u32; 2]> =
        triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.dedup();
    Ok(Topology { triangles, edges })
}

/// The same triangle from its smallest number.
fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// A triangle with an inner vertex is inside; one of three rim vertices is if its centre is.
fn is_inside(points: &[DVec2], rim: usize, triangle: [u32; 3]) -> bool {
    let centre = triangle.iter().map(|&v| points[v as usize]).sum::<DVec2>() / 3.0;
    triangle.iter().any(|&v| v as usize >= rim) || polygon::contains(&points[..rim], centre)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_notch_stays_empty() {
        let notched = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (2.0, 0.5), (0.0, 3.0)].map(|(x, y)| DVec2::new(x, y));
        let topology = triangulated(&notched, 5).unwrap();
        let area: f64 = topology
            .triangles
            .iter()
            .map(|t| t.map(|v| notched[v as usize]))
            .map(|[a, b, c]| (b - a).perp(&(c - a)) / 2.0)
            .sum();
        assert!((area - polygon::doubled_area(&notched) / 2.0).abs() < 1e-14);
        assert_eq!(topology.triangles.len(), 3);
        assert_eq!(topology.edges.len(), 7);
    }
}
