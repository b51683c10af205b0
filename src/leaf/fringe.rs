//! The margin as it is seen: a mesh that follows the outline within a tolerance, however coarse the mesh that was bent.
//!
//! A blade is bent on triangles of even size, too large for teeth. For drawing, the outline is followed by as many points as the
//! tolerance takes, and triangulated anew with the inner vertices. Each point is carried by the bent mesh: at the same place of its
//! triangle, or, beyond the rim, off the nearest place of the rim as the mesh lies there. It changes no shape.

use crate::base::blade::Blade;
use crate::base::flat_mesh::FlatMesh;
use crate::base::mesh::Mesh;
use crate::base::vector::{DVec2, DVec3, Vec2, Vec3};
use crate::leaf::polygon;
use crate::leaf::remesh::Topology;
use std::collections::BTreeMap;
use std::ops::Range;

/// Inner vertices keep this share of the mean edge from the finer rim.
const CLEARANCE: f64 = 0.25;
/// How often the tolerance is halved where chords would cross.
const HALVINGS: u32 = 6;
/// How often the tolerance is raised by a quarter to keep within the triangles allowed.
const RAISINGS: u32 = 40;

/// How a point hangs on the mesh that is bent.
#[derive(Clone, Copy, Debug)]
struct Hold {
    corners: [u32; 3],
    weights: [f64; 3],
    /// From the place that the weights give to the point, metres in the blade's plane.
    off: DVec2,
}

/// A finer margin for the shapes of one blade.
#[derive(Clone, Debug)]
pub struct Fringe {
    holds: Vec<Hold>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    /// The tolerance that was met, metres.
    pub tolerance: f64,
}

impl Fringe {
    /// A margin within `tolerance` (metres) of the outline and the gaps, or as near as `most` triangles allow. `None` where the mesh
    /// follows them as well by itself, or they cannot be triangulated.
    #[must_use]
    pub fn new(blade: &Blade, tolerance: f64, most: usize) -> Option<Self> {
        let mesh = &blade.mesh;
        let rim: Vec<DVec2> = mesh.rim.iter().filter_map(|&v| mesh.positions.get(v as usize).copied()).collect();
        if blade.outline.len() < 3 || rim.len() < 3 {
            return None;
        }
        let error = polygon::hausdorff(&rim, &blade.outline);
        let mut tolerance = tolerance.max(1e-6);
        for _ in 0..RAISINGS {
            if tolerance >= error {
                return None;
            }
            let made = Self::within(blade, tolerance)?;
            if made.triangles.len() <= most {
                return Some(made);
            }
            tolerance *= 1.25;
        }
        None
    }

    fn within(blade: &Blade, tolerance: f64) -> Option<Self> {
        let (loops, met) = simple_loops(blade, tolerance)?;
        let mut points = loops.concat();
        let mut end = 0;
        let ranges: Vec<Range<usize>> = loops
            .iter()
            .map(|ring| {
                end += ring.len();
                end - ring.len()..end
            })
            .collect();
        let borders = borders(&blade.mesh);
        points.extend(inner(&blade.mesh, &borders, &loops));
        let topology: Topology = crate::leaf::remesh::triangulated(&points, &ranges).ok()?;
        let bearer = Bearer { mesh: &blade.mesh, borders };
        Some(Self {
            holds: points.iter().map(|&p| bearer.hold(p)).collect(),
            uvs: points.iter().map(|&p| blade.mesh.uv(p)).collect(),
            triangles: topology.triangles,
            tolerance: met,
        })
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// A shape with this margin. `flat` is the blade's mesh, `shape` that mesh bent: vertex for vertex.
    #[must_use]
    pub fn worn_by(&self, flat: &FlatMesh, shape: &Mesh) -> Mesh {
        let places: Vec<DVec3> = shape.positions.iter().map(|p| p.cast::<f64>()).collect();
        let frames = frames(flat, &places);
        let place = |hold: &Hold| {
            let mut place = DVec3::zeros();
            for (&v, &weight) in hold.corners.iter().zip(&hold.weights) {
                let [right, up] = frames[v as usize];
                place += (places[v as usize] + right * hold.off.x + up * hold.off.y) * weight;
            }
            place.cast::<f32>()
        };
        let normal = |hold: &Hold| {
            let of = |k: usize| shape.normals[hold.corners[k] as usize] * hold.weights[k] as f32;
            (of(0) + of(1) + of(2)).try_normalize(1e-6).unwrap_or_else(Vec3::z)
        };
        Mesh {
            positions: self.holds.iter().map(place).collect(),
            normals: self.holds.iter().map(normal).collect(),
            uvs: self.uvs.clone(),
            triangles: self.triangles.clone(),
        }
    }
}

/// The outline and the gaps by as few points as the tolerance allows, clear of each other, and the tolerance used.
fn simple_loops(blade: &Blade, mut tolerance: f64) -> Option<(Vec<Vec<DVec2>>, f64)> {
    for _ in 0..HALVINGS {
        let lines = std::iter::once(&blade.outline).chain(&blade.holes);
        let loops: Vec<Vec<DVec2>> = lines.map(|line| thinned(line, tolerance)).collect();
        if loops.iter().all(|ring| ring.len() >= 3) && polygon::crossings(&loops).is_empty() {
            return Some((loops, tolerance));
        }
        tolerance *= 0.5;
    }
    None
}

/// A closed line by fewer of its points, none of the others farther from it than `tolerance` (Ramer 1972, Douglas and
/// Peucker 1973).
fn thinned(line: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let Some(&first) = line.first() else { return Vec::new() };
    let far = |&i: &usize| (line[i] - first).norm_squared();
    let middle = (0..line.len()).max_by(|a, b| far(a).total_cmp(&far(b)).then(b.cmp(a))).unwrap_or(0);
    let mut kept = vec![false; line.len() + 1];
    (kept[0], kept[middle]) = (true, true);
    let at = |i: usize| line[i % line.len()];
    let mut open = vec![(0, middle), (middle, line.len())];
    while let Some((a, b)) = open.pop() {
        let off = |i: usize| polygon::squared_segment_distance(at(i), at(a), at(b));
        let mut worst = (tolerance * tolerance, 0);
        for i in a + 1..b {
            if off(i) > worst.0 {
                worst = (off(i), i);
            }
        }
        if worst.1 > 0 {
            kept[worst.1] = true;
            open.extend([(a, worst.1), (worst.1, b)]);
        }
    }
    line.iter().zip(kept).filter(|(_, kept)| *kept).map(|(&p, _)| p).collect()
}

/// The edges that have a triangle on one side only.
fn borders(mesh: &FlatMesh) -> Vec<[u32; 2]> {
    let mut sides = BTreeMap::<[u32; 2], u32>::new();
    for &[a, b, c] in &mesh.triangles {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            *sides.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    sides.into_iter().filter(|(_, count)| *count == 1).map(|(side, _)| side).collect()
}

/// The mesh's vertices within the finer rim, clear of it.
fn inner(mesh: &FlatMesh, borders: &[[u32; 2]], loops: &[Vec<DVec2>]) -> Vec<DVec2> {
    let mut is_rim = vec![false; mesh.positions.len()];
    borders.iter().flatten().for_each(|&v| is_rim[v as usize] = true);
    let edges = mesh.edges();
    let length = |&[a, b]: &[u32; 2]| (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
    let clear = CLEARANCE * edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64;
    let fits = |p: DVec2| {
        polygon::contains(&loops[0], p)
            && !loops[1..].iter().any(|hole| polygon::contains(hole, p))
            && loops.iter().all(|ring| polygon::distance(ring, p) > clear)
    };
    mesh.positions.iter().zip(is_rim).filter(|(p, is_rim)| !is_rim && fits(**p)).map(|(&p, _)| p).collect()
}

/// The mesh that carries the points.
struct Bearer<'a> {
    mesh: &'a FlatMesh,
    borders: Vec<[u32; 2]>,
}

impl Bearer<'_> {
    fn hold(&self, p: DVec2) -> Hold {
        self.within(p).unwrap_or_else(|| self.beside(p))
    }

    /// The triangle that a point lies in, the first in order.
    fn within(&self, p: DVec2) -> Option<Hold> {
        self.mesh.triangles.iter().find_map(|&corners| {
            let [a, b, c] = corners.map(|v| self.mesh.positions[v as usize] - p);
            let parts = [b.perp(&c), c.perp(&a), a.perp(&b)];
            let whole = self.mesh.doubled_area(corners);
            let is_in = whole > 0.0 && parts.iter().all(|part| *part >= 0.0);
            is_in.then(|| Hold { corners, weights: parts.map(|part| part / whole), off: DVec2::zeros() })
        })
    }

    /// The nearest place of the rim.
    fn beside(&self, p: DVec2) -> Hold {
        let ends = |&[a, b]: &[u32; 2]| [a, b].map(|v| self.mesh.positions[v as usize]);
        let far = |side: &&[u32; 2]| {
            let [a, b] = ends(side);
            polygon::squared_segment_distance(p, a, b)
        };
        let side = self.borders.iter().min_by(|a, b| far(a).total_cmp(&far(b))).copied().unwrap_or_default();
        let [a, b] = ends(&side);
        let along = b - a;
        let t = ((p - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        Hold { corners: [side[0], side[1], side[1]], weights: [1.0 - t, t, 0.0], off: p - (a + along * t) }
    }
}

/// Where the plane's two axes point at each vertex of a bent mesh: the mean over its triangles, weighted by area.
fn frames(flat: &FlatMesh, places: &[DVec3]) -> Vec<[DVec3; 2]> {
    let mut sums = vec![([DVec3::zeros(); 2], 0.0); places.len()];
    for &triangle in &flat.triangles {
        let [a, b, c] = triangle.map(|v| flat.positions[v as usize]);
        let [p, q, r] = triangle.map(|v| places[v as usize]);
        let (u, v, area) = (b - a, c - a, flat.doubled_area(triangle));
        let (du, dv) = (q - p, r - p);
        // The gradient times the doubled area, which is its weight.
        let (right, up) = (du * v.y - dv * u.y, dv * u.x - du * v.x);
        for vertex in triangle {
            let (sum, weight) = &mut sums[vertex as usize];
            sum[0] += right;
            sum[1] += up;
            *weight += area;
        }
    }
    sums.into_iter().map(|([right, up], area)| [right / area.max(1e-30), up / area.max(1e-30)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::limits::Limits;
    use crate::base::maths::sincos;
    use crate::leaf::{Pictures, Settings, model};

    fn maple() -> Blade {
        #[derive(serde::Deserialize)]
        struct File {
            leaf: Settings,
        }
        let file: File = toml::from_str(include_str!("../species/red-maple.leaf.toml")).unwrap();
        model(&file.leaf, Pictures::default(), &Limits::default()).unwrap().0
    }

    /// The blade's mesh with each vertex where `place` puts it.
    fn bent(blade: &Blade, place: impl Fn(DVec2) -> DVec3) -> Mesh {
        let positions = blade.mesh.positions.iter().map(|&p| place(p).cast::<f32>()).collect();
        let (uvs, triangles) = (blade.mesh.uvs.clone(), blade.mesh.triangles.clone());
        let mut mesh = Mesh { positions, uvs, triangles, normals: Vec::new() };
        mesh.recompute_normals();
        mesh
    }

    #[test]
    fn a_flat_leaf_has_the_outline_within_the_tolerance_and_its_area() {
        let blade = maple();
        for tolerance in [4e-4, 1e-4, 2e-5] {
            let fringe = Fringe::new(&blade, tolerance, usize::MAX).unwrap();
            let flat = fringe.worn_by(&blade.mesh, &bent(&blade, |p| DVec3::new(p.x, p.y, 0.0)));
            assert_eq!(flat.check(), Ok(()));
            let rim = &flat.positions[..thinned(&blade.outline, fringe.tolerance).len()];
            let rim: Vec<DVec2> = rim.iter().map(|p| DVec2::new(f64::from(p.x), f64::from(p.y))).collect();
            assert!(polygon::hausdorff(&rim, &blade.outline) < 1.01 * tolerance + 1e-8);
            assert!((flat.area() / (polygon::doubled_area(&rim) * 0.5) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn a_leaf_moved_or_stretched_evenly_takes_its_margin_along() {
        let blade = maple();
        let fringe = Fringe::new(&blade, 1e-4, usize::MAX).unwrap();
        let (sine, cosine) = sincos(0.7);
        let place = |p: DVec2| DVec3::new(1.2 * p.x + 0.01, cosine * p.y, sine * p.y - 0.3 * p.x);
        let (flat, moved) = (bent(&blade, |p| DVec3::new(p.x, p.y, 0.0)), bent(&blade, place));
        let [flat, moved] = [flat, moved].map(|shape| fringe.worn_by(&blade.mesh, &shape));
        for (from, to) in flat.positions.iter().zip(&moved.positions) {
            let expected = place(DVec2::new(f64::from(from.x), f64::from(from.y)));
            assert!((to.cast::<f64>() - expected).norm() < 1e-7, "{from} {to}");
        }
    }

    #[test]
    fn no_more_triangles_than_allowed_and_none_where_the_mesh_is_as_good() {
        let blade = maple();
        let count = blade.mesh.triangles.len();
        let fringe = Fringe::new(&blade, 5e-5, count + count / 4).unwrap();
        assert!(fringe.triangles() <= count + count / 4, "{} {count}", fringe.triangles());
        assert!(fringe.tolerance > 5e-5);
        assert!(Fringe::new(&blade, 0.01, usize::MAX).is_none());
        assert!(Fringe::new(&Blade::default(), 1e-4, usize::MAX).is_none());
    }

    #[test]
    fn gaps_stay_open() {
        let gap = [[-4.0, 30.0], [4.0, 30.0], [4.0, 38.0], [-4.0, 38.0]].to_vec();
        let outline = (0..40).map(|i| sincos(std::f64::consts::TAU * f64::from(i) / 40.0));
        let outline = Some(outline.map(|(s, c)| [25.0 * s, 30.0 - 30.0 * c]).collect());
        let settings = Settings { outline, holes: vec![gap], length: 60.0, vertices: 60, ..Settings::default() };
        let blade = model(&settings, Pictures::default(), &Limits::default()).unwrap().0;
        let fringe = Fringe::new(&blade, 2e-5, usize::MAX).unwrap();
        let flat = fringe.worn_by(&blade.mesh, &bent(&blade, |p| DVec3::new(p.x, p.y, 0.0)));
        let enclosed = |line: &Vec<DVec2>| polygon::doubled_area(line) * 0.5;
        let expected = enclosed(&blade.outline) - enclosed(&blade.holes[0]).abs();
        assert!((flat.area() / expected - 1.0).abs() < 2e-3, "{} {expected}", flat.area());
    }
}
