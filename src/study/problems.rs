//! The built-in problems: blades and lattices whose meshes are given by a formula, so that no other stage is needed.

use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::sincos;
use crate::base::vector::{DVec2, DVec3, Vec2};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Extent of [`ovate`], metres.
pub const OVATE_EXTENT: f64 = 0.08;

/// An ovate blade 80 mm long and 56 mm wide of `rings` rings of triangles about its middle: 1 + 3 n (n + 1) vertices. The mask
/// is white along the midrib and black at the margin; the petiole holds a patch at the base.
#[must_use]
pub fn ovate(rings: u32) -> FlatMesh {
    let mut mesh = FlatMesh::default();
    for ring in 0..=rings {
        let radius = f64::from(ring) / f64::from(rings.max(1));
        for i in 0..(6 * ring).max(1) {
            let (sine, cosine) = sincos(TAU * f64::from(i) / f64::from((6 * ring).max(1)));
            let width = 0.028 * (1.0 - 0.25 * radius * sine);
            mesh.positions.push(DVec2::new(radius * cosine * width, 0.04 + 0.04 * radius * sine));
        }
    }
    let first = |ring: u32| if ring == 0 { 0 } else { 1 + 3 * ring * (ring - 1) };
    for ring in 1..=rings {
        let (outer, inner) = (6 * ring, 6 * (ring - 1));
        let out = |i: u32| first(ring) + i % outer;
        let within = |i: u32| if inner == 0 { 0 } else { first(ring - 1) + i % inner };
        for (sector, i) in (0..6).flat_map(|sector| (0..ring).map(move |i| (sector, i))) {
            let (o, n) = (sector * ring + i, sector * (ring - 1) + i);
            mesh.triangles.push([out(o), out(o + 1), within(n)]);
            if i + 1 < ring {
                mesh.triangles.push([within(n), out(o + 1), within(n + 1)]);
            }
        }
    }
    let grey = |p: &DVec2| 255.0 * (1.0 - (p.x / 0.028).abs()).clamp(0.0, 1.0);
    mesh.greys = mesh.positions.iter().map(grey).collect();
    mesh.uvs = mesh.positions.iter().map(|p| Vec2::new(p.x as f32, p.y as f32)).collect();
    mesh.rim = (first(rings)..first(rings + 1)).collect();
    mesh.held = (0..mesh.positions.len() as u32).filter(|&v| mesh.positions[v as usize].y < 0.0058).collect();
    mesh
}

/// The flat blade's vertices in extents, as the integrators count.
#[must_use]
pub fn flat(mesh: &FlatMesh, extent: f64) -> Vec<DVec3> {
    mesh.positions.iter().map(|p| DVec3::new(p.x, p.y, 0.0) / extent).collect()
}

/// Nineteen particles of an equilateral lattice, 4 mm apart, black, that nothing holds.
#[must_use]
pub fn hexagon() -> FlatMesh {
    let mut numbers = BTreeMap::new();
    let mut mesh = FlatMesh::default();
    for (row, column) in (-2i32..=2).flat_map(|row| (-2i32..=2).map(move |column| (row, column))) {
        if (row + column).abs() <= 2 {
            numbers.insert((row, column), mesh.positions.len() as u32);
            let place = DVec2::new(f64::from(column) + 0.5 * f64::from(row), f64::from(row) * 0.75f64.sqrt());
            mesh.positions.push(place * 0.004);
        }
    }
    for (&(row, column), &a) in &numbers {
        let at = |row: i32, column: i32| numbers.get(&(row, column)).copied();
        if let (Some(b), Some(c)) = (at(row, column + 1), at(row + 1, column)) {
            mesh.triangles.push([a, b, c]);
        }
        if let (Some(b), Some(c)) = (at(row + 1, column), at(row + 1, column - 1)) {
            mesh.triangles.push([a, b, c]);
        }
    }
    mesh.greys = vec![0.0; mesh.positions.len()];
    mesh.uvs = vec![Vec2::zeros(); mesh.positions.len()];
    mesh
}

/// Root mean square distance of two shapes over that of the second from a third: the error as a share of the deformation.
#[must_use]
pub fn relative_distance(found: &[DVec3], exact: &[DVec3], flat: &[DVec3]) -> f64 {
    let square = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(p, q)| (p - q).norm_squared()).sum::<f64>();
    (square(found, exact) / square(exact, flat)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blades_have_the_vertices_and_the_area_of_their_formulae() {
        let mesh = ovate(14);
        assert_eq!(mesh.positions.len(), 631);
        assert!(mesh.triangles.iter().all(|&t| mesh.doubled_area(t) > 0.0));
        // An ellipse of half axes 28 mm and 40 mm; the taper adds as much above as it takes below.
        assert!((mesh.area() / (std::f64::consts::PI * 0.028 * 0.04) - 1.0).abs() < 0.02);
        let lattice = hexagon();
        assert_eq!((lattice.positions.len(), lattice.triangles.len(), lattice.edges().len()), (19, 24, 42));
    }

    #[test]
    fn the_distance_is_a_share_of_the_deformation() {
        let line = |height: f64| vec![DVec3::new(0.0, 0.0, height), DVec3::new(1.0, 0.0, height)];
        assert!((relative_distance(&line(1.1), &line(1.0), &line(0.0)) - 0.1).abs() < 1e-12);
    }
}
