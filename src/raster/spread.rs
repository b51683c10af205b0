//! Coarser versions of meshes, spread until they have the area of the whole: a leaf that lost its teeth would let more of the sky
//! through. As much of a picture as before is covered then on the mean over all directions, which is a quarter of a convex body's
//! area (Cauchy 1841).

use super::simplify::{Simplified, distance_to_segment, distance_to_triangle};
use crate::base::mesh::Mesh;
use crate::base::vector::DVec3;

/// How far a version may be spread: beyond, it would no longer look like what it stands for.
const MOST: f64 = 1.3;
/// Spreading by less than this is left.
const LEAST: f64 = 1.002;

/// A mesh whose versions are spread.
pub(super) struct Whole<'a> {
    mesh: &'a Mesh,
    area: f64,
    rim: Vec<[u32; 2]>,
    edges: Vec<Part<2>>,
    /// The vertices that are not on the rim.
    inner: Vec<DVec3>,
}

impl<'a> Whole<'a> {
    /// A mesh.
    pub(super) fn new(mesh: &'a Mesh) -> Self {
        let rim = rim(mesh);
        let mut is_on_rim = vec![false; mesh.positions.len()];
        rim.iter().flatten().for_each(|&v| is_on_rim[v as usize] = true);
        let inner = mesh.positions.iter().zip(&is_on_rim).filter(|(_, is_on_rim)| !**is_on_rim);
        let inner = inner.map(|(position, _)| position.cast()).collect();
        let edges = rim.iter().map(|edge| Part::new(mesh, *edge)).collect();
        Self { mesh, area: mesh.area(), rim, edges, inner }
    }

    /// A version of the mesh with the mesh's area, and the largest distance of either's vertices from the other, metres: along
    /// the rim from the other's rim, elsewhere from its surface.
    pub(super) fn spread(&self, version: Simplified) -> (Mesh, f64) {
        let (mut coarse, error) = version.of(self.mesh);
        let factor = (self.area / coarse.area().max(1e-300)).sqrt().min(MOST);
        if factor < LEAST {
            return (coarse, error);
        }
        let middle = middle(&coarse);
        for position in &mut coarse.positions {
            *position = (middle + (position.cast::<f64>() - middle) * factor).cast::<f32>();
        }
        let error = self.distance(&coarse);
        (coarse, error)
    }

    fn distance(&self, coarse: &Mesh) -> f64 {
        let at = |mesh: &Mesh, v: u32| -> DVec3 { mesh.positions[v as usize].cast() };
        let mut error = 0.0f64;
        let rim = rim(coarse);
        if rim.is_empty() {
            // Without a rim a version stands out by as much as it was spread.
            let moved = |v: &u32| (at(coarse, *v) - at(self.mesh, *v)).norm();
            error = coarse.triangles.iter().flatten().map(moved).fold(error, f64::max);
        } else {
            let edges: Vec<Part<2>> = rim.iter().map(|edge| Part::new(coarse, *edge)).collect();
            let of_whole = self.rim.iter().map(|&[v, _]| at(self.mesh, v));
            let of_version = rim.iter().map(|&[v, _]| at(coarse, v));
            let rims = [
                farthest(of_whole, &edges, distance_to_segment),
                farthest(of_version, &self.edges, distance_to_segment),
            ];
            error = rims[0].max(rims[1]);
        }
        let triangles: Vec<Part<3>> = coarse.triangles.iter().map(|triangle| Part::new(coarse, *triangle)).collect();
        error.max(farthest(self.inner.iter().copied(), &triangles, distance_to_triangle))
    }
}

/// The centre of a mesh's area.
fn middle(mesh: &Mesh) -> DVec3 {
    let (mut sum, mut area) = (DVec3::zeros(), 0.0);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].cast::<f64>());
        let doubled = (b - a).cross(&(c - a)).norm();
        sum += (a + b + c) * (doubled / 3.0);
        area += doubled;
    }
    sum / area.max(1e-300)
}

/// The edges that have a triangle on one side only.
fn rim(mesh: &Mesh) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    let is_rim = |&[a, b]: &[u32; 2]| edges.binary_search(&[b, a]).is_err();
    edges.iter().copied().filter(is_rim).collect()
}

/// A segment or a triangle in a ball about it, which tells at once that most of them are not the nearest.
struct Part<const N: usize> {
    corners: [DVec3; N],
    middle: DVec3,
    radius: f64,
}

impl<const N: usize> Part<N> {
    fn new(mesh: &Mesh, numbers: [u32; N]) -> Self {
        let corners = numbers.map(|v| mesh.positions[v as usize].cast::<f64>());
        let middle = corners.iter().sum::<DVec3>() / N as f64;
        let radius = corners.iter().map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
        Self { corners, middle, radius }
    }
}

/// The largest distance of any of some points, which follow one another along a surface or a rim, from the nearest of its parts.
fn farthest<const N: usize>(
    points: impl Iterator<Item = DVec3>,
    parts: &[Part<N>],
    distance: impl Fn(DVec3, [DVec3; N]) -> f64,
) -> f64 {
    let (mut farthest, mut last) = (0.0f64, 0);
    for point in points {
        // What was nearest to the point before tells of most parts that they are not.
        let mut least = parts.get(last).map_or(f64::INFINITY, |part| distance(point, part.corners));
        for (number, part) in parts.iter().enumerate() {
            let reach = least + part.radius;
            if number != last && (point - part.middle).norm_squared() < reach * reach {
                let found = distance(point, part.corners);
                if found < least {
                    (least, last) = (found, number);
                }
            }
            // Points that are no farther than another was do not matter.
            if least <= farthest {
                break;
            }
        }
        farthest = farthest.max(least);
    }
    farthest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::{Vec2, Vec3};
    use crate::raster::simplify::simplified;

    /// A fan of teeth around a middle, like a star, of radii 1 and 0.8.
    fn star(teeth: u32) -> Mesh {
        let mut mesh = Mesh { positions: vec![Vec3::zeros()], normals: vec![Vec3::z()], ..Mesh::default() };
        for k in 0..2 * teeth {
            let (sine, cosine) = crate::base::maths::sincosf(k as f32 / teeth as f32 * std::f32::consts::PI);
            let radius = if k % 2 == 0 { 1.0 } else { 0.8 };
            mesh.positions.push(Vec3::new(cosine, sine, 0.0) * radius);
            mesh.normals.push(Vec3::z());
            mesh.triangles.push([0, k + 1, (k + 1) % (2 * teeth) + 1]);
        }
        mesh.uvs = vec![Vec2::zeros(); mesh.positions.len()];
        mesh
    }

    #[test]
    fn what_loses_its_teeth_keeps_its_area() {
        let mesh = star(30);
        let versions = simplified(&mesh, &[50, 36, 24, 16]);
        assert_eq!(versions.len(), 4);
        for version in versions {
            let lost = Mesh { triangles: version.triangles.clone(), ..mesh.clone() }.area() / mesh.area();
            let (coarse, error) = Whole::new(&mesh).spread(version);
            assert!((coarse.area() / mesh.area() - 1.0).abs() < 1e-3, "{lost}");
            // Nothing lies farther out than a tip that was moved, and no tip farther from the new rim than it was cut off.
            assert!(error > 0.0 && error < 0.2, "{error}");
        }
    }

    #[test]
    fn the_error_of_a_square_that_grows_is_how_far_its_sides_move() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut mesh = Mesh {
            positions: corners.iter().chain(&[[0.5, -0.5]]).map(|[x, y]| Vec3::new(*x, *y, 0.0)).collect(),
            normals: vec![Vec3::z(); 5],
            uvs: vec![Vec2::zeros(); 5],
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 4, 1]],
        };
        // The square without the triangle that stands on one of its sides: from an area of 1.25 to 1.
        let version = Simplified { triangles: vec![[0, 1, 2], [0, 2, 3]], error: 0.5 };
        let (coarse, error) = Whole::new(&mesh).spread(version.clone());
        let by = (1.25f64.sqrt() - 1.0) * 0.5;
        assert!((f64::from(coarse.positions[0].y) + by).abs() < 1e-6);
        assert!((error - (0.5 - by)).abs() < 1e-6, "{error}");
        mesh.triangles.pop();
        assert_eq!(Whole::new(&mesh).spread(version).1, 0.5, "nothing to make up for");
    }
}
