//! Constrained Delaunay triangulation of loops and the points within, by spade (exact predicates).

use crate::base::maths::atan2;
use crate::base::vector::DVec2;
use crate::leaf::LeafError;
use crate::leaf::polygon;
use spade::handles::{DirectedEdgeHandle, FixedFaceHandle, PossiblyOuterTag};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};
use std::ops::Range;

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

impl Topology {
    /// The topology of triangles in any order.
    pub fn of(triangles: impl Iterator<Item = [u32; 3]>) -> Self {
        let mut triangles: Vec<[u32; 3]> = triangles.map(turned).collect();
        triangles.sort_unstable();
        let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut edges: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        edges.dedup();
        Self { triangles, edges }
    }
}

/// The angle inside a counter-clockwise polygon at `b` between its neighbours `a` (before) and `c` (after), 0 to 2 pi.
pub fn corner_angle(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (ahead, back) = (c - b, a - b);
    let angle = atan2(ahead.perp(&back), ahead.dot(&back));
    if angle < 0.0 { angle + std::f64::consts::TAU } else { angle }
}

/// Triangulates points: the loops (the first counter-clockwise, the others clockwise within it) are simple polygons that do
/// not touch, the other points lie between them.
///
/// # Errors
/// [`LeafError::Mesh`] when spade refuses a coordinate, or the triangles do not fill the loops.
pub fn triangulated(points: &[DVec2], loops: &[Range<usize>]) -> Result<Topology, LeafError> {
    let site = |(i, p): (usize, &DVec2)| Site { position: Point2::new(p.x, p.y), number: i as u32 };
    let sites: Vec<Site> = points.iter().enumerate().map(site).collect();
    let round = |range: &Range<usize>| {
        let range = range.clone();
        range.clone().map(move |i| [i, if i + 1 == range.end { range.start } else { i + 1 }])
    };
    let web = ConstrainedDelaunayTriangulation::<Site>::try_bulk_load_cdt(
        sites,
        loops.iter().flat_map(round).collect(),
        |_| {},
    )
    .map_err(|fault| LeafError::Mesh { what: fault.to_string() })?;
    let inside = inside(&web);
    let faces = web.inner_faces().filter(|face| inside[face.index()]);
    let topology = Topology::of(faces.map(|face| face.vertices().map(|v| v.data().number)));
    let doubled: f64 = topology.triangles.iter().map(|t| t.map(|v| points[v as usize])).map(doubled_area).sum();
    let enclosed: f64 = loops.iter().map(|range| polygon::doubled_area(&points[range.clone()])).sum();
    if (doubled - enclosed).abs() > 1e-6 * enclosed {
        return Err(LeafError::Mesh { what: "the outline is too narrow to be triangulated".to_owned() });
    }
    Ok(topology)
}

fn doubled_area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp(&(c - a))
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

/// Which faces lie inside the loops, by number: those that an odd number of loops separates from the outer face.
fn inside(web: &ConstrainedDelaunayTriangulation<Site>) -> Vec<bool> {
    let mut parity: Vec<Option<bool>> = vec![None; web.num_all_faces()];
    let mut reached: Vec<(FixedFaceHandle<PossiblyOuterTag>, bool)> =
        web.convex_hull().map(|edge| edge.rev()).map(|edge| (edge.face().fix(), edge.is_constraint_edge())).collect();
    while let Some((face, is_inside)) = reached.pop() {
        let Some(inner) = web.face(face).as_inner().filter(|_| parity[face.index()].is_none()) else { continue };
        parity[face.index()] = Some(is_inside);
        let beyond = |edge: &DirectedEdgeHandle<_, _, CdtEdge<_>, _>| {
            (edge.rev().face().fix(), is_inside != edge.is_constraint_edge())
        };
        reached.extend(inner.adjacent_edges().iter().map(beyond));
    }
    parity.into_iter().map(|is_inside| is_inside == Some(true)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(places: &[(f64, f64)]) -> Vec<DVec2> {
        places.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
    }

    #[test]
    fn a_notch_stays_empty() {
        let notched = points(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (2.0, 0.5), (0.0, 3.0)]);
        let topology = triangulated(&notched, std::slice::from_ref(&(0..5))).unwrap();
        let doubled: f64 = topology.triangles.iter().map(|t| t.map(|v| notched[v as usize])).map(doubled_area).sum();
        assert!((doubled - polygon::doubled_area(&notched)).abs() < 1e-14);
        assert_eq!(topology.triangles.len(), 3);
        assert_eq!(topology.edges.len(), 7);
    }

    #[test]
    fn a_hole_stays_empty() {
        let square = [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)];
        let hole = [(1.0, 1.0), (1.0, 2.0), (2.0, 2.0), (2.0, 1.0)];
        let topology = triangulated(&points(&[square, hole].concat()), &[0..4, 4..8]).unwrap();
        assert_eq!((topology.triangles.len(), topology.edges.len()), (8, 16));
    }

    #[test]
    fn what_is_not_simple_is_refused() {
        let bow_tie = points(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 3.0)]);
        assert!(matches!(triangulated(&bow_tie, std::slice::from_ref(&(0..4))), Err(LeafError::Mesh { .. })));
    }
}
