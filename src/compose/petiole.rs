//! The stalk between twig and blade, as a thin bent tube in the leaf's own coordinates: the blade's joint is the origin, the
//! blade extends along +y, its upper side faces +z.

use crate::base::maths::{cos, sin};
use crate::base::mesh::{Mesh, between_rings};
use crate::base::vector::{Vec2, Vec3};
use crate::tree::LeafSite;
use std::f64::consts::TAU;

/// Sides of the tube: it is seen a pixel wide at most.
const SIDES: usize = 3;
/// Pieces along it, below blades of few triangles and below all others, whose bend is smooth from near too.
const PIECES: [usize; 2] = [4, 10];
/// Vertices of a blade from which its petiole has the more pieces.
const FINE: u32 = 200;
/// Radius in the middle over the length; a red maple's petiole of 75 mm is 1.3 mm thick (judged).
const SLENDERNESS: f64 = 0.009;

/// Petioles come in three lengths: each is a model of its own, and more could not be told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Petiole {
    Mean,
    Short,
    Long,
}

impl Petiole {
    /// That of a leaf.
    pub(super) fn of(site: &LeafSite) -> Self {
        match site.petiole_length {
            length if length < 0.86 => Self::Short,
            length if length > 1.14 => Self::Long,
            _ => Self::Mean,
        }
    }

    /// Length over the species' mean.
    pub(super) fn length(self) -> f64 {
        match self {
            Self::Mean => 1.0,
            Self::Short => 0.72,
            Self::Long => 1.28,
        }
    }

    /// What the names of its models end with.
    pub(super) fn suffix(self) -> &'static str {
        match self {
            Self::Mean => "",
            Self::Short => "_short",
            Self::Long => "_long",
        }
    }
}

/// Where the petiole leaves the twig, for a petiole of `length` metres that meets the blade's plane at `bend` radians.
pub(super) fn base(length: f64, bend: f64) -> Vec3 {
    Vec3::new(0.0, (-length * cos(bend)) as f32, (-length * sin(bend)) as f32)
}

/// The tube below a blade of so many vertices. It leaves the twig straight and bends into the blade's plane along a quadratic
/// Bezier curve.
pub(super) fn mesh(length: f64, bend: f64, vertices: u32) -> Mesh {
    tube(length, bend, PIECES[usize::from(vertices >= FINE)])
}

/// A tube in one piece: the petiole of a leaf that lies on the ground, where there are many.
pub(super) fn straight(length: f64, bend: f64) -> Mesh {
    tube(length, bend, 1)
}

fn tube(length: f64, bend: f64, pieces: usize) -> Mesh {
    let start = base(length, bend).cast::<f64>();
    let control = nalgebra::Vector3::new(0.0, -0.35 * length, 0.02 * length);
    let mut mesh = Mesh::default();
    for ring in 0..=pieces {
        let t = ring as f64 / pieces as f64;
        let centre = start * ((1.0 - t) * (1.0 - t)) + control * (2.0 * t * (1.0 - t));
        let along = (control - start) * (1.0 - t) - control * t;
        let across = nalgebra::Vector3::x();
        let up = across.cross(&along).normalize();
        let swelling = 1.0 + 0.8 * (1.0 - 4.0 * t).max(0.0);
        let radius = length * SLENDERNESS * swelling;
        for side in 0..SIDES {
            let angle = TAU * side as f64 / SIDES as f64;
            let outward = across * cos(angle) + up * sin(angle);
            mesh.positions.push((centre + outward * radius).cast::<f32>());
            mesh.normals.push(outward.cast::<f32>().normalize());
            mesh.uvs.push(Vec2::new(side as f32 / SIDES as f32, t as f32));
        }
    }
    mesh.triangles.extend((0..pieces).flat_map(|ring| between_rings([ring, ring + 1], SIDES)));
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tube_runs_from_the_twig_to_the_joint_and_faces_outward() {
        let tube = mesh(0.06, 0.8, FINE);
        assert_eq!(tube.check(), Ok(()));
        let ring = |r: usize| (0..SIDES).map(|s| tube.positions[r * SIDES + s]).sum::<Vec3>() / SIDES as f32;
        assert!((ring(0) - base(0.06, 0.8)).norm() < 1e-6);
        assert!(ring(PIECES[1]).norm() < 1e-6);
        assert!((ring(0).norm() - 0.06).abs() < 1e-6);
        for triangle in &tube.triangles {
            let [a, b, c] = triangle.map(|v| tube.positions[v as usize]);
            let outward: Vec3 = triangle.iter().map(|&v| tube.normals[v as usize]).sum();
            assert!((b - a).cross(&(c - a)).dot(&outward) > 0.0);
        }
    }
}
