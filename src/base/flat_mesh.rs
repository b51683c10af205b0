//! The mesh of a leaf lying flat: what the leaf stage makes and the deformation stage bends.

use crate::base::vector::{DVec2, Vec2};

/// Texture coordinates of blades keep this far from the picture's rim, so that minified texels hold leaf and nothing else.
pub const BLADE_UV_MARGIN: f64 = 0.03;

/// A leaf blade in its plane. The petiole's joint is the origin, the blade extends along +y, its upper side faces +z.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlatMesh {
    /// Vertex positions, metres.
    pub positions: Vec<DVec2>,
    /// Texture coordinates (u right, v down, 0..1): one scale for both axes, centred, `BLADE_UV_MARGIN` free on every side.
    pub uvs: Vec<Vec2>,
    /// Vertex numbers of each triangle, counter-clockwise seen from +z.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices of the rim in order, counter-clockwise.
    pub rim: Vec<u32>,
    /// The lines that the loops of its rim stand for, metres: the outline without small teeth, then those of the holes, either
    /// sense. What is derived from them does not depend on the mesh. None where the rim is all that is known.
    pub lines: Vec<Vec<DVec2>>,
    /// The vertices that the petiole holds.
    pub held: Vec<u32>,
    /// Mask grey of each vertex, 0 (moves most) to 255 (stays), as the paper's mask map.
    pub greys: Vec<f64>,
    /// How the plane maps to texture coordinates: (u, v) = (`uv_origin.x` + `uv_scale` x, `uv_origin.y` - `uv_scale` y).
    pub uv_scale: f64,
    /// The texture coordinates of the joint.
    pub uv_origin: DVec2,
}

impl FlatMesh {
    /// The texture coordinates of a point of the plane.
    #[must_use]
    pub fn uv(&self, point: DVec2) -> Vec2 {
        let u = self.uv_origin.x + self.uv_scale * point.x;
        let v = self.uv_origin.y - self.uv_scale * point.y;
        Vec2::new(u as f32, v as f32)
    }

    /// Twice the signed area of a triangle, square metres.
    #[must_use]
    pub fn doubled_area(&self, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
        (b - a).perp(&(c - a))
    }

    /// Area of the blade, square metres.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|&t| self.doubled_area(t) * 0.5).sum()
    }

    /// The lower left and the upper right corner of the box about its lines, or about its vertices where it has none.
    #[must_use]
    pub fn bounds(&self) -> Option<[DVec2; 2]> {
        let points = self.lines.first().unwrap_or(&self.positions);
        let first = *points.first()?;
        Some(points.iter().fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]))
    }

    /// Every edge once, as (smaller, larger) vertex number, sorted.
    #[must_use]
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_share_one_edge() {
        let mesh = FlatMesh {
            positions: [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uv_scale: 0.5,
            uv_origin: DVec2::new(0.25, 0.75),
            ..FlatMesh::default()
        };
        assert_eq!(mesh.edges(), vec![[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]);
        assert!((mesh.area() - 1.0).abs() < 1e-15);
        assert_eq!(mesh.uv(DVec2::new(1.0, 1.0)), Vec2::new(0.75, 0.25));
    }
}
