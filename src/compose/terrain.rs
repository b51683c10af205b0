//! Uneven ground: its surface as a mesh, and what grows on it laid along it.

use crate::base::mesh::Mesh;
use crate::base::vector::{Affine, DVec2, DVec3, Vec2, Vec3};
use crate::fall::HeightMap;
use nalgebra::UnitQuaternion;

/// The surface, a square of the map as two triangles; one repeat of its texture covers `tile` metres.
pub(super) fn mesh(map: &HeightMap, tile: f32) -> Mesh {
    let (columns, rows) = (map.columns, map.heights.len() / map.columns.max(1));
    let place =
        |number: usize| map.origin + DVec2::new((number % columns) as f64, (number / columns) as f64) * map.step;
    let position = |number: usize| {
        let place = place(number);
        DVec3::new(place.x, map.heights[number], place.y).cast::<f32>()
    };
    let square = |number: usize| {
        let (row, column) = (number / (columns - 1), number % (columns - 1));
        let [a, b] = [row * columns + column, (row + 1) * columns + column].map(|corner| corner as u32);
        [[a, b, a + 1], [a + 1, b, b + 1]]
    };
    let positions: Vec<Vec3> = (0..columns * rows).map(position).collect();
    Mesh {
        uvs: positions.iter().map(|p| Vec2::new(p.x / tile, -p.z / tile)).collect(),
        normals: (0..columns * rows).map(|number| map.normal(place(number)).cast::<f32>()).collect(),
        triangles: (0..(columns - 1) * (rows - 1)).flat_map(square).collect(),
        positions,
    }
}

/// What lies on level ground, laid on this: raised to it, and turned to face as it does.
pub(super) fn laid(map: &HeightMap, level: Affine) -> Affine {
    let at = level.translation;
    let place = DVec2::new(f64::from(at.x), f64::from(at.z));
    let turn = UnitQuaternion::rotation_between(&DVec3::y(), &map.normal(place)).unwrap_or_default();
    let translation = at + Vec3::y() * map.at(place) as f32;
    Affine { linear: turn.to_rotation_matrix().into_inner().cast::<f32>() * level.linear, translation }
}

/// How far grass that is laid along uneven ground may stand off it or in it, metres.
const OFF: f64 = 0.05;

/// Whether what reaches so far over level ground lies on this where it was laid: patches over crests and hollows do not.
pub(super) fn lies(map: &HeightMap, laid: &Affine, reach: f32) -> bool {
    let ends = [(reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach)];
    ends.into_iter().all(|(x, z)| {
        let end = laid.point(Vec3::new(x, 0.0, z)).cast::<f64>();
        (end.y - map.at(DVec2::new(end.x, end.z))).abs() <= OFF
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hill() -> HeightMap {
        let rows = vec![vec![0.0, 0.4, 0.2], vec![0.5, 1.5, 0.3], vec![0.1, 0.6, -0.3]];
        HeightMap::smoothed(&rows, 3.0).expect("heights")
    }

    #[test]
    fn the_mesh_lies_on_the_map_and_faces_up() {
        let (map, mesh) = (hill(), mesh(&hill(), 1.28));
        assert_eq!(mesh.check(), Ok(()));
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
            assert!((b - a).cross(&(c - a)).y > 0.0);
        }
        for (p, normal) in mesh.positions.iter().zip(&mesh.normals) {
            let height = map.at(DVec2::new(p.x.into(), p.z.into()));
            assert!((f64::from(p.y) - height).abs() < 1e-5 && normal.y > 0.5);
        }
    }

    #[test]
    fn what_is_laid_on_it_stands_on_it_and_along_its_normal() {
        let map = hill();
        let translation = Vec3::new(1.0, 0.0, -0.7);
        let found = laid(&map, Affine { translation, ..Affine::identity() });
        let place = DVec2::new(1.0, f64::from(-0.7f32));
        assert!((f64::from(found.translation.y) - map.at(place)).abs() < 1e-6);
        assert!((found.linear.column(1) - map.normal(place).cast::<f32>()).norm() < 1e-6);
    }

    #[test]
    fn patches_lie_on_slopes_and_not_over_crests() {
        let slope: Vec<Vec<f64>> = (0..12).map(|_| (0..12).map(|x| 0.4 * f64::from(x)).collect()).collect();
        let crest: Vec<Vec<f64>> =
            (0..12).map(|_| (0..12).map(|x| -1.5 * f64::from((x - 5i32).abs())).collect()).collect();
        let lies_on = |rows: &[Vec<f64>]| {
            let map = HeightMap::smoothed(rows, 1.0).expect("heights");
            let at = Affine { translation: Vec3::new(-0.5, 0.0, 0.3), ..Affine::identity() };
            lies(&map, &laid(&map, at), 1.2)
        };
        assert!(lies_on(&slope) && !lies_on(&crest));
    }
}
