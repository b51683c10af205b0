//! Coarser versions of bent tubes, stalks above all: of the rings that their vertices lie in, some are left out. Collapses of
//! single edges would pinch a tube or blow it up, and what is thin must keep its width.

use super::simplify::{Simplified, distance_to_segment};
use crate::base::mesh::{Mesh, between_rings};

/// A tube: rings of as many vertices each, which follow one another in the mesh's numbers.
#[derive(Clone, Copy)]
struct Tube {
    /// Vertices of a ring.
    sides: usize,
    /// Stretches between two rings.
    pieces: usize,
}

impl Tube {
    /// A mesh as a tube; none where it is none, or its vertices come in another order.
    fn of(mesh: &Mesh) -> Option<Self> {
        // A tube of k sides and p pieces has k (p + 1) vertices and 2 k p triangles.
        let sides = mesh.positions.len().checked_sub(mesh.triangles.len() / 2).filter(|&sides| sides >= 3)?;
        let tube = Self { sides, pieces: mesh.triangles.len() / (2 * sides) };
        let between = (0..tube.pieces).flat_map(|ring| between_rings([ring, ring + 1], sides));
        mesh.triangles.iter().copied().eq(between).then_some(tube)
    }

    /// How far the vertices of the rings between two others lie from the straight tube between those, metres.
    fn bend(self, mesh: &Mesh, from: usize, to: usize) -> f64 {
        let at = |ring: usize, side: usize| mesh.positions[ring * self.sides + side].cast::<f64>();
        let between = (from + 1..to).flat_map(|ring| (0..self.sides).map(move |side| (ring, side)));
        let distance = |(ring, side)| distance_to_segment(at(ring, side), [at(from, side), at(to, side)]);
        between.map(distance).fold(0.0, f64::max)
    }

    /// The tube between some of its rings.
    fn between(self, mesh: &Mesh, kept: &[usize]) -> Simplified {
        let mut version = Simplified { triangles: Vec::with_capacity(2 * self.sides * kept.len()), error: 0.0 };
        for pair in kept.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            version.triangles.extend(between_rings([from, to], self.sides));
            version.error = version.error.max(self.bend(mesh, from, to));
        }
        version
    }
}

/// Versions of a tube with one piece less each, down to one: the ring goes that bends it least. None where the mesh is no tube.
pub(super) fn shortened(mesh: &Mesh) -> Option<Vec<Simplified>> {
    let tube = Tube::of(mesh)?;
    let mut kept: Vec<usize> = (0..=tube.pieces).collect();
    let shorter = (1..tube.pieces).map(|_| {
        let bend = |place: &usize| tube.bend(mesh, kept[place - 1], kept[place + 1]);
        let least = (1..kept.len() - 1).min_by(|one, other| bend(one).total_cmp(&bend(other)));
        if let Some(place) = least {
            kept.remove(place);
        }
        tube.between(mesh, &kept)
    });
    Some(shorter.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::{sin, sincosf};
    use crate::base::vector::{Vec2, Vec3};
    use std::f32::consts::{PI, TAU};

    /// A tube of unit length and radius 0.01 that is bent by `height` in its middle.
    fn tube(sides: usize, pieces: usize, height: f32) -> Mesh {
        let mut mesh = Mesh::default();
        for (ring, side) in (0..=pieces).flat_map(|ring| (0..sides).map(move |side| (ring, side))) {
            let (along, angle) = (ring as f32 / pieces as f32, side as f32 / sides as f32 * TAU);
            let (sine, cosine) = sincosf(angle);
            let outward = Vec3::new(0.0, sine, cosine);
            mesh.positions.push(Vec3::new(along, height * sincosf(along * PI).0, 0.0) + outward * 0.01);
            mesh.normals.push(outward);
            mesh.uvs.push(Vec2::zeros());
        }
        mesh.triangles.extend((0..pieces).flat_map(|ring| between_rings([ring, ring + 1], sides)));
        mesh
    }

    #[test]
    fn a_straight_tube_keeps_its_area_and_its_way_round_in_one_piece() {
        for (sides, pieces) in [(3, 4), (3, 10), (6, 7)] {
            let mesh = tube(sides, pieces, 0.0);
            let versions = shortened(&mesh).expect("a tube");
            let last = versions.last().expect("a version");
            assert_eq!(last.triangles.len(), 2 * sides);
            assert!(last.error < 1e-7);
            for version in &versions {
                let coarse = Mesh { triangles: version.triangles.clone(), ..mesh.clone() };
                assert!((coarse.area() / mesh.area() - 1.0).abs() < 1e-5);
                for triangle in &coarse.triangles {
                    let [a, b, c] = triangle.map(|v| coarse.positions[v as usize]);
                    let outward: Vec3 = triangle.iter().map(|&v| coarse.normals[v as usize]).sum();
                    assert!((b - a).cross(&(c - a)).dot(&outward) > 0.0);
                }
            }
        }
    }

    #[test]
    fn the_error_of_a_bent_tube_is_how_far_it_is_bent() {
        let versions = shortened(&tube(3, 4, 0.1)).expect("a tube");
        assert_eq!(versions.iter().map(|version| version.triangles.len()).collect::<Vec<_>>(), [18, 12, 6]);
        assert!((versions[2].error - 0.1).abs() < 1e-6);
        // Between the ends and the middle the sine lies 0.0207 over its chords, which slope by 1 in 5.
        let chord = 0.1 * (sin(0.25 * f64::from(PI)) - 0.5) / (1.0f64 + 0.04).sqrt();
        assert!((versions[1].error - chord).abs() < 1e-6, "{} {chord}", versions[1].error);
    }

    #[test]
    fn what_is_no_tube_is_told_apart() {
        let mut open = tube(3, 4, 0.0);
        open.triangles.pop();
        let mut crossed = tube(3, 4, 0.0);
        crossed.triangles[0] = [0, 4, 7];
        let flat = Mesh {
            positions: vec![Vec3::zeros(); 4],
            normals: vec![Vec3::z(); 4],
            uvs: vec![Vec2::zeros(); 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        for mesh in [open, crossed, flat, Mesh::default()] {
            assert!(shortened(&mesh).is_none());
        }
    }
}
