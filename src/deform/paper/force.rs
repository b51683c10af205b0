//! The external force of step (4) in the paper's section 4.2, which the paper leaves to its reader: the same on every vertex
//! (constant, towards a point, along the normal), or the field of [`curl`](super::curl).

use crate::base::flat_mesh::FlatMesh;
use crate::base::vector::DVec3;
use crate::deform::paper::curl;
use crate::deform::settings::{Field, Settings};

/// The external force on the vertices of one variant.
#[derive(Clone, Debug, PartialEq)]
pub enum Force {
    /// One vector for all, N.
    Constant(DVec3),
    /// Towards a place (metres) with one strength (N).
    Point(DVec3, f64),
    /// Along the vertices' current upper normals, a strength (N) for each.
    Normal(Vec<f64>),
}

impl Force {
    /// The force that the settings ask for. Only the field "curl" differs between variants.
    pub fn new(settings: &Settings, mesh: &FlatMesh, seed: u64, variant: u32) -> Self {
        let strength = settings.force;
        match settings.field {
            Field::Constant => {
                let direction = DVec3::from(settings.direction);
                Self::Constant(direction.try_normalize(0.0).unwrap_or_else(DVec3::zeros) * strength)
            }
            Field::Point => Self::Point(DVec3::from(settings.point) * 1e-3, strength),
            Field::Normal => Self::Normal(vec![strength; mesh.positions.len()]),
            Field::Curl => Self::Normal(curl::strengths(mesh, strength, seed, variant)),
        }
    }

    /// The force on each vertex, N. A vertex at the very place of the pull is not pulled.
    pub fn on(&self, positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
        match self {
            Self::Constant(force) => vec![*force; positions.len()],
            Self::Point(place, strength) => {
                let pull = |p: &DVec3| (place - p).try_normalize(0.0).unwrap_or_else(DVec3::zeros) * *strength;
                positions.iter().map(pull).collect()
            }
            Self::Normal(strengths) => normals(positions, triangles)
                .iter()
                .zip(strengths)
                .map(|(normal, strength)| normal * *strength)
                .collect(),
        }
    }
}

/// Unit normals of the vertices, weighted by the triangles' areas; upwards where there is none.
fn normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::zeros(); positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize]);
        let doubled_area = (b - a).cross(&(c - a));
        for &v in triangle {
            sums[v as usize] += doubled_area;
        }
    }
    sums.iter().map(|sum| sum.try_normalize(0.0).unwrap_or_else(DVec3::z)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_pulls_towards_itself_and_not_at_itself() {
        let place = DVec3::new(0.0, 0.0, 2.0);
        let forces = Force::Point(place, 3.0).on(&[DVec3::zeros(), DVec3::new(4.0, 0.0, 2.0), place], &[]);
        assert_eq!(forces, [DVec3::new(0.0, 0.0, 3.0), DVec3::new(-3.0, 0.0, 0.0), DVec3::zeros()]);
    }

    #[test]
    fn the_direction_of_a_constant_force_counts_not_its_length() {
        let settings =
            Settings { field: Field::Constant, direction: [0.0, 0.6, 0.8], force: 5.0, ..Settings::default() };
        let short = Settings { direction: [0.0, 0.06, 0.08], ..settings.clone() };
        let force =
            |settings: &Settings| Force::new(settings, &FlatMesh::default(), 1, 0).on(&[DVec3::zeros()], &[])[0];
        assert!((force(&settings) - DVec3::new(0.0, 3.0, 4.0)).norm() < 1e-15);
        assert!((force(&settings) - force(&short)).norm() < 1e-14);
    }

    #[test]
    fn an_even_normal_force_is_up_on_a_flat_leaf_and_follows_a_turned_one() {
        let force = Force::Normal(vec![2.0; 3]);
        let flat = [DVec3::zeros(), DVec3::x(), DVec3::y()];
        assert_eq!(force.on(&flat, &[[0, 1, 2]]), [DVec3::z() * 2.0; 3]);
        let turned = [DVec3::zeros(), DVec3::y(), DVec3::z()];
        assert_eq!(force.on(&turned, &[[0, 1, 2]]), [DVec3::x() * 2.0; 3]);
    }
}
