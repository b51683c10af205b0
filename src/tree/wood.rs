//! The mesh of the wood: a tube along each axis with as many sides as its radius deserves. Where a branch leaves, a sleeve
//! leads its surface into the parent's (`join`); trunks run out into the ground (`flare`).
//!
//! What is watertight: each tube by itself, with its sleeve, foot and tip, across the meshes that its girth puts it in:
//! every edge is met by exactly two triangles once equal positions are one. Tubes overlap where they meet and are not
//! one surface; nor are the two pieces of a thick tube where its bark changes, each of which is closed.
//!
//! The wood is cut into meshes by girth, each class twice as thick as the last, since bark differs by girth. A class has
//! bark of one size: u counts its repeats around, a whole number of them, v its repeats along. As a class spans a factor
//! of two, bark is drawn out or pressed together around by at most the root of two.

use super::axis::axes;
use super::skeleton::Skeleton;
use super::weave::{Circles, Weaver};
use crate::base::mesh::Mesh;
use rayon::prelude::*;
use std::f64::consts::{SQRT_2, TAU};
use std::sync::Arc;

/// Radius that the thinnest class of wood stays below, metres.
const THINNEST: f64 = 0.006;
/// Number of classes; the last has no upper bound.
pub(super) const CLASSES: usize = 10;
/// The class whose bark goes once around; thicker ones repeat it.
const ONCE: usize = 5;
/// Axes that one thread weaves at a time.
const CHUNK: usize = 256;

/// Wood of one class of girth.
#[derive(Clone, Debug, PartialEq)]
pub struct Wood {
    /// Number of the class: 0 below 6 mm of radius, each further one up to twice as thick.
    pub class: usize,
    /// The surface; texture coordinates count repeats of the bark.
    pub mesh: Arc<Mesh>,
    /// Radius in the middle of the class, metres.
    pub radius: f64,
    /// Metres that one repeat of the bark covers around; along the axis it covers twice as much.
    pub repeat: f64,
}

/// The wood, thinnest class first, classes without wood left out.
pub(super) fn meshes(skeleton: &Skeleton) -> Vec<Wood> {
    let axes = axes(skeleton);
    let circles = Circles::new();
    let chunks: Vec<Vec<Mesh>> = axes
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut weaver = Weaver::new(&circles);
            chunk.iter().for_each(|axis| weaver.weave(axis, &axes));
            weaver.into_meshes()
        })
        .collect();
    let mut wood = Vec::new();
    for class in 0..CLASSES {
        let sum = |length: fn(&Mesh) -> usize| chunks.iter().map(|chunk| length(&chunk[class])).sum::<usize>();
        let vertices = sum(|mesh| mesh.positions.len());
        let mut mesh = Mesh {
            positions: Vec::with_capacity(vertices),
            normals: Vec::with_capacity(vertices),
            uvs: Vec::with_capacity(vertices),
            triangles: Vec::with_capacity(sum(|mesh| mesh.triangles.len())),
        };
        chunks.iter().for_each(|chunk| mesh.append(&chunk[class]));
        if !mesh.triangles.is_empty() {
            let radius = middle(class);
            wood.push(Wood { class, mesh: Arc::new(mesh), radius, repeat: TAU * radius / repeats(class) });
        }
    }
    wood
}

pub(super) fn class(radius: f64) -> usize {
    let (mut class, mut border) = (0, THINNEST);
    while radius >= border && class + 1 < CLASSES {
        class += 1;
        border *= 2.0;
    }
    class
}

/// Radius in the middle of a class, metres.
pub(super) fn middle(class: usize) -> f64 {
    THINNEST / SQRT_2 * f64::from(1u32 << class)
}

/// Repeats of the bark around wood of a class.
pub(super) fn repeats(class: usize) -> f64 {
    f64::from(1u32 << class.saturating_sub(ONCE))
}

#[cfg(test)]
mod tests {
    use super::super::join::Joint;
    use super::super::path::rings;
    use super::super::weave::sides;
    use super::super::{Settings, grow};
    use super::*;
    use crate::base::limits::Limits;
    use crate::base::vector::DVec3;
    use std::collections::BTreeMap;
    use std::f64::consts::PI;

    fn grown(axiom: &str) -> Vec<Wood> {
        let settings = Settings { axiom: axiom.to_owned(), iterations: 0, ..Settings::default() };
        grow(&settings, 1, &Limits::default()).unwrap().0.wood
    }

    /// How many triangles meet each edge, equal positions being one; the sum of directions is kept beside.
    fn edges(wood: &[Wood]) -> BTreeMap<[[u32; 3]; 2], (i32, i32)> {
        let mut edges = BTreeMap::new();
        for mesh in wood.iter().map(|wood| &wood.mesh) {
            let place = |v: u32| -> [u32; 3] { mesh.positions[v as usize].map(f32::to_bits).into() };
            for &[a, b, c] in &mesh.triangles {
                for [p, q] in [[a, b], [b, c], [c, a]] {
                    let (p, q) = (place(p), place(q));
                    let entry = edges.entry([p.min(q), p.max(q)]).or_insert((0, 0));
                    entry.0 += 1;
                    entry.1 += if p < q { 1 } else { -1 };
                }
            }
        }
        edges
    }

    const TREES: [&str; 4] = [
        "!(30)F(1)+(10)F(1)+(10)F(1)",
        "!(40)F(2)[+(70)!(4)F(1)F(1)]F(1)",
        // A fork, laterals of many girths, twigs.
        "!(20)F(0.8)[&(28)!(14.5)F(0.5)[+!(3)F(0.3)!(0.4)F(0.2)]F(0.5)][^(25)!(14)F(0.5)[-!(0.6)F(0.3)]F(0.5)]",
        "!(2)F(0.3)[+(40)!(0.7)F(0.2)[-!(0.3)F(0.1)]F(0.2)]F(0.3)",
    ];

    #[test]
    fn every_tube_is_closed_and_faces_outward() {
        for axiom in TREES {
            let wood = grown(axiom);
            assert!(wood.iter().all(|wood| wood.mesh.check() == Ok(())));
            let edges = edges(&wood);
            assert!(edges.len() > 30);
            let open = edges.values().filter(|&&(count, turn)| count != 2 || turn != 0).count();
            assert_eq!(open, 0, "{axiom}");
        }
    }

    #[test]
    fn a_trunk_holds_the_volume_of_its_cylinder() {
        // 2 m of 40 cm and the 30 cm below the ground, without the swelling of the foot but with what its waves add.
        let wood = grown("!(40)F(2)F(2)F(2)");
        let mut volume = 0.0;
        for mesh in wood.iter().map(|wood| &wood.mesh) {
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|v| mesh.positions[v as usize].cast::<f64>());
                volume += a.dot(&b.cross(&c)) / 6.0;
            }
        }
        let cylinder = PI * 0.04 * 6.3;
        assert!((0.9..1.25).contains(&(volume / cylinder)), "{}", volume / cylinder);
    }

    #[test]
    fn a_sleeve_starts_on_its_parent_with_its_normal_and_ends_on_the_branch() {
        let circles = Circles::new();
        let settings = Settings {
            axiom: "!(20)F(1)[&(50)!(10)F(0.5)F(0.5)]!(18)F(1)F(1)".to_owned(),
            iterations: 0,
            ..Settings::default()
        };
        let axes = axes(&grow(&settings, 1, &Limits::default()).unwrap().0.skeleton);
        let mut branch = Vec::new();
        rings(&axes[1], &mut branch);
        let joint = Joint::new(&axes[0].knots, 1);
        let sleeve = joint.sleeve(&branch, sides(0.1), |radius| circles.of(radius)).unwrap();
        let (foot, top) = (&sleeve.rows[0], &sleeve.rows[sleeve.rows.len() - 1]);
        assert_eq!(foot.len() as u32, sides(0.05));
        for vertex in foot {
            let off = (vertex.position.x * vertex.position.x + vertex.position.z * vertex.position.z).sqrt();
            assert!(off < 0.1 && off > 0.085, "{off}");
            let outward = DVec3::new(vertex.position.x, 0.0, vertex.position.z).normalize();
            assert!(vertex.normal.dot(&outward) > 0.9999);
        }
        let (start, along) = (branch[0].centre, branch[0].tangent);
        for vertex in top {
            let offset = vertex.position - start;
            let off = (offset - along * along.dot(&offset)).norm();
            assert!((off - 0.05).abs() < 2e-3, "{off}");
        }
    }

    #[test]
    fn bark_goes_whole_times_around_and_is_drawn_out_by_less_than_half() {
        for radius in [0.006, 0.011, 0.013, 0.05, 0.1, 0.19, 0.3, 0.6, 1.1] {
            let class = class(radius);
            assert_eq!(repeats(class).fract(), 0.0);
            let stretch = radius / middle(class);
            assert!((0.66..1.5).contains(&stretch), "{radius} {stretch}");
        }
        for wood in grown("!(50)F(2)[+!(4)F(1)]F(1)!(8)F(1)") {
            let width = wood.mesh.uvs.iter().map(|uv| uv.x).fold(0.0f32, f32::max);
            assert!(width >= repeats(wood.class) as f32 && wood.repeat < 0.9);
        }
    }
}
