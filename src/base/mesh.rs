//! Triangle meshes in space, as arrays of vertices and index triples.

use crate::base::vector::{Vec2, Vec3};
use thiserror::Error;

/// A triangle mesh. The three vertex arrays have one length; triangles wind counter-clockwise seen from the front.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions, metres.
    pub positions: Vec<Vec3>,
    /// Unit vertex normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates: u to the right, v downwards, 0..1 over the picture.
    pub uvs: Vec<Vec2>,
    /// Vertex numbers of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// What can be wrong with a mesh.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum MeshFault {
    /// The vertex arrays differ in length.
    #[error("{positions} positions, {normals} normals and {uvs} texture coordinates do not match")]
    Lengths {
        /// Number of positions.
        positions: usize,
        /// Number of normals.
        normals: usize,
        /// Number of texture coordinates.
        uvs: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names a vertex beyond the last")]
    Index {
        /// Its number.
        triangle: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} is not finite")]
    NotFinite {
        /// Its number.
        vertex: usize,
    },
    /// A normal is not of unit length.
    #[error("the normal of vertex {vertex} is not of unit length")]
    Normal {
        /// Its number.
        vertex: usize,
    },
}

impl Mesh {
    /// Checks everything that must hold for a mesh.
    ///
    /// # Errors
    /// The first fault found.
    pub fn check(&self) -> Result<(), MeshFault> {
        let (positions, normals, uvs) = (self.positions.len(), self.normals.len(), self.uvs.len());
        if positions != normals || positions != uvs {
            return Err(MeshFault::Lengths { positions, normals, uvs });
        }
        if let Some(triangle) = self.triangles.iter().position(|t| t.iter().any(|&v| v as usize >= positions)) {
            return Err(MeshFault::Index { triangle });
        }
        let finite = |v: usize| {
            self.positions[v].iter().chain(self.normals[v].iter()).chain(self.uvs[v].iter()).all(|x| x.is_finite())
        };
        if let Some(vertex) = (0..positions).find(|&v| !finite(v)) {
            return Err(MeshFault::NotFinite { vertex });
        }
        match self.normals.iter().position(|n| (n.norm() - 1.0).abs() > 1e-4) {
            Some(vertex) => Err(MeshFault::Normal { vertex }),
            None => Ok(()),
        }
    }

    /// Adds the triangles and vertices of another mesh.
    pub fn append(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.normals.extend_from_slice(&other.normals);
        self.uvs.extend_from_slice(&other.uvs);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    }

    /// Replaces the normals by the area-weighted mean of the adjoining triangles' (upwards where there is none).
    pub fn recompute_normals(&mut self) {
        let mut sums = vec![Vec3::zeros(); self.positions.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
            let doubled_area = (b - a).cross(&(c - a));
            for &v in triangle {
                sums[v as usize] += doubled_area;
            }
        }
        self.normals = sums.iter().map(|sum| sum.try_normalize(1e-20).unwrap_or_else(Vec3::y)).collect();
    }

    /// Smallest and largest coordinates; `None` without vertices.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p))))
    }

    /// Area of all triangles, square metres.
    #[must_use]
    pub fn area(&self) -> f64 {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            f64::from((b - a).cross(&(c - a)).norm()) * 0.5
        };
        self.triangles.iter().map(area).sum()
    }
}

/// The triangles between two rings of a tube, whose vertices follow one another ring by ring, `sides` in each. Who makes a tube
/// and who knows one by its triangles both call this.
pub fn between_rings([from, to]: [usize; 2], sides: usize) -> impl Iterator<Item = [u32; 3]> {
    let vertex = move |ring: usize, side: usize| (ring * sides + side % sides) as u32;
    (0..sides).flat_map(move |side| {
        let [a, b] = [vertex(from, side), vertex(from, side + 1)];
        let [c, d] = [vertex(to, side), vertex(to, side + 1)];
        [[a, d, b], [a, c, d]]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Mesh {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)];
        let mut mesh = Mesh {
            positions: corners.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect(),
            uvs: corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            normals: Vec::new(),
        };
        mesh.recompute_normals();
        mesh
    }

    #[test]
    fn a_rectangle_has_its_area_bounds_and_normal() {
        let mesh = square();
        assert_eq!(mesh.check(), Ok(()));
        assert!((mesh.area() - 2.0).abs() < 1e-12);
        assert_eq!(mesh.bounds(), Some((Vec3::zeros(), Vec3::new(2.0, 1.0, 0.0))));
        assert!(mesh.normals.iter().all(|n| *n == Vec3::z()));
    }

    #[test]
    fn faults_are_found() {
        let mut mesh = square();
        mesh.triangles.push([0, 1, 4]);
        assert_eq!(mesh.check(), Err(MeshFault::Index { triangle: 2 }));
        let mut mesh = square();
        mesh.positions[1].x = f32::NAN;
        assert_eq!(mesh.check(), Err(MeshFault::NotFinite { vertex: 1 }));
        let mut mesh = square();
        mesh.normals[3] *= 2.0;
        assert_eq!(mesh.check(), Err(MeshFault::Normal { vertex: 3 }));
    }

    #[test]
    fn appending_shifts_the_vertex_numbers() {
        let mut mesh = square();
        mesh.append(&square());
        assert_eq!(mesh.triangles[2], [4, 5, 6]);
        assert_eq!(mesh.check(), Ok(()));
    }
}
