//! Meshes cut into clusters: what is binned, transformed and rejected as one. Small meshes have coarser levels besides.

use super::simplify::simplified;
use super::spread::Whole;
use super::tube::shortened;
use crate::base::mesh::Mesh;
use crate::base::vector::{Vec2, Vec3};

/// Most triangles of a cluster: whole leaves stay in one piece.
const LARGEST: usize = 512;
/// Triangles of a cluster of a larger mesh: a few centimetres of a branch.
const USUAL: usize = 96;

/// Halvings of a large mesh's box along each axis by which its triangles are ordered.
const MORTON_BITS: u32 = 12;

/// Vertices that are transformed at once.
pub(super) const LANES: usize = 8;

/// Some triangles of a mesh with the vertices they use.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    /// Centre of a sphere that holds the cluster, model coordinates.
    pub centre: Vec3,
    /// Radius of that sphere.
    pub radius: f32,
    /// Positions of the vertices that are used, model coordinates.
    pub positions: Vec<Vec3>,
    /// The same by coordinates, in whole groups of `LANES`; the last position fills the last group up.
    pub coordinates: [Vec<f32>; 3],
    /// Their unit normals.
    pub normals: Vec<Vec3>,
    /// Their texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Triangles as places in `positions`.
    pub triangles: Vec<[u16; 3]>,
}

/// Triangles of the coarser levels of a small mesh.
const COARSER: [usize; 13] = [200, 150, 120, 95, 75, 60, 48, 38, 30, 22, 16, 10, 6];

/// Triangles of the smallest meshes that have coarser levels without being tubes.
const LEAST: usize = 32;

/// A mesh in some number of triangles.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// The clusters; those of a large mesh are cut along a curve through it.
    pub clusters: Vec<Cluster>,
    /// Largest distance from the full mesh, metres.
    pub error: f32,
}

/// A mesh as clusters.
#[derive(Clone, Debug)]
pub(super) struct ClusteredMesh {
    /// The full mesh first, then coarser levels.
    pub levels: Vec<Level>,
    /// Area of all triangles, square metres.
    pub area: f32,
    /// Texture units a metre, for the choice of mip level.
    pub uv_per_metre: f32,
}

impl ClusteredMesh {
    /// Cuts a mesh.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let size = if mesh.triangles.len() <= LARGEST { LARGEST } else { USUAL };
        let area = mesh.area() as f32;
        let uv_area: f32 = mesh
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| mesh.uvs[v as usize]);
                (b - a).perp(&(c - a)).abs() * 0.5
            })
            .sum();
        let uv_per_metre = if area > 0.0 { (uv_area / area).sqrt() } else { 0.0 };
        let triangles = if mesh.triangles.len() <= LARGEST { mesh.triangles.clone() } else { gathered(mesh) };
        let full = triangles.chunks(size).map(|part| cut(mesh, part)).collect();
        let mut levels = vec![Level { clusters: full, error: 0.0 }];
        if mesh.triangles.len() <= LARGEST {
            let coarser: Vec<(Mesh, f64)> = match shortened(mesh) {
                Some(versions) => versions.into_iter().map(|version| version.of(mesh)).collect(),
                None if mesh.triangles.len() < LEAST => Vec::new(),
                None => {
                    let whole = Whole::new(mesh);
                    simplified(mesh, &COARSER).into_iter().map(|version| whole.spread(version)).collect()
                }
            };
            for (coarse, error) in coarser {
                levels.push(Level { clusters: vec![cut(&coarse, &coarse.triangles)], error: error as f32 });
            }
        }
        Self { levels, area, uv_per_metre }
    }

    /// About the width of a long thin mesh of one cluster, metres: its area over its length, seen from one of three sides.
    pub(super) fn width(&self) -> f32 {
        self.full().iter().map(|cluster| self.area / (6.0 * cluster.radius.max(1e-9))).fold(f32::INFINITY, f32::min)
    }

    /// The clusters of the full mesh.
    pub(super) fn full(&self) -> &[Cluster] {
        &self.levels[0].clusters
    }

    /// The number of the coarsest level whose error is at most `tolerance` metres.
    pub(super) fn level_within(&self, tolerance: f32) -> usize {
        self.levels.iter().rposition(|level| level.error <= tolerance).unwrap_or(0)
    }
}

/// The triangles of a mesh in an order in which those that follow one another lie together: along a Morton curve, which
/// halves the mesh's box by each axis in turn.
fn gathered(mesh: &Mesh) -> Vec<[u32; 3]> {
    let corner = |triangle: &[u32; 3]| triangle.map(|v| mesh.positions[v as usize]);
    let middle = |triangle: &[u32; 3]| corner(triangle).iter().sum::<Vec3>() / 3.0;
    let middles: Vec<Vec3> = mesh.triangles.iter().map(middle).collect();
    let first = middles.first().copied().unwrap_or_default();
    let (low, high) = middles.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let side = (high - low).max().max(1e-9);
    let place = |number: usize| {
        let steps = (middles[number] - low) * (((1 << MORTON_BITS) - 1) as f32 / side);
        let bit = |axis: usize, bit: u32| u64::from(steps[axis] as u32 >> bit & 1) << (3 * bit + axis as u32);
        (0..MORTON_BITS).map(|level| bit(0, level) | bit(1, level) | bit(2, level)).sum::<u64>()
    };
    let mut order: Vec<(u64, u32)> = (0..middles.len()).map(|number| (place(number), number as u32)).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, number)| mesh.triangles[number as usize]).collect()
}

fn cut(mesh: &Mesh, triangles: &[[u32; 3]]) -> Cluster {
    let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let place = |v: u32| vertices.binary_search(&v).unwrap_or_default() as u16;
    let local = triangles.iter().map(|t| t.map(place)).collect();
    let positions: Vec<Vec3> = vertices.iter().map(|&v| mesh.positions[v as usize]).collect();
    let first = positions.first().copied().unwrap_or_default();
    let (low, high) = positions.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let centre = (low + high) * 0.5;
    let radius = positions.iter().map(|p| (p - centre).norm()).fold(0.0, f32::max);
    let padded = positions.len().next_multiple_of(LANES);
    let last = positions.last().copied().unwrap_or_default();
    let coordinates = [0, 1, 2].map(|axis| {
        let mut values: Vec<f32> = positions.iter().map(|position| position[axis]).collect();
        values.resize(padded, last[axis]);
        values
    });
    let normals = vertices.iter().map(|&v| mesh.normals[v as usize]).collect();
    let uvs = vertices.iter().map(|&v| mesh.uvs[v as usize]).collect();
    Cluster { centre, radius, positions, coordinates, normals, uvs, triangles: local }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_hold_every_triangle_inside_their_spheres() {
        let mut mesh = Mesh::default();
        for i in 0..700u32 {
            let x = i as f32 * 0.1;
            for (dx, dy) in [(0.0, 0.0), (0.1, 0.0), (0.0, 0.2)] {
                mesh.positions.push(Vec3::new(x + dx, dy, 0.0));
                mesh.normals.push(Vec3::z());
                mesh.uvs.push(Vec2::new(x + dx, dy));
            }
            mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let cut = ClusteredMesh::new(&mesh);
        assert_eq!(cut.full().iter().map(|c| c.triangles.len()).sum::<usize>(), 700);
        assert!((cut.uv_per_metre - 1.0).abs() < 1e-3);
        for cluster in cut.full() {
            assert!(cluster.positions.iter().all(|p| (p - cluster.centre).norm() <= cluster.radius * 1.000_01));
            assert!(cluster.triangles.iter().flatten().all(|&v| usize::from(v) < cluster.positions.len()));
        }
    }
}
