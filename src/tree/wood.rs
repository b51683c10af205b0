//! The mesh of the wood: a tube along each axis with as many sides as its radius deserves, closed at its end, the trunk flared
//! into lobes at the ground. Branches start inside their parents; the tubes overlap and are not joined into one surface.

use super::axis::axes;
use super::path::{Ring, rings};
use super::skeleton::Skeleton;
use crate::base::maths::{cos, exp, sin, sincos};
use crate::base::mesh::Mesh;
use crate::base::vector::{DVec3, Vec2, Vec3};
use std::f64::consts::TAU;

/// Thinner wood is in the mesh of twigs, metres of radius.
pub(super) const BARK_RADIUS: f64 = 0.012;
/// Metres that one repeat of the bark covers.
const REPEAT: f64 = 0.5;
/// Swelling of the trunk at the ground, its share of the radius, and of the lobes.
const FLARE: f64 = 0.45;
const LOBES: f64 = 0.4;
const LOBE_COUNT: f64 = 5.0;

/// The meshes of thick and thin wood.
pub(super) fn meshes(skeleton: &Skeleton) -> (Mesh, Mesh) {
    let (mut bark, mut twigs) = (Mesh::default(), Mesh::default());
    for axis in axes(skeleton) {
        let rings = rings(&axis);
        let repeats = (TAU * rings[0].radius / REPEAT).round().max(1.0);
        let root = axis.parent_radius.is_none().then(|| (axis.knots[0].position.y, axis.knots[0].radius));
        let tube = Tube { repeats, root };
        let thick = rings.iter().take_while(|ring| ring.radius >= BARK_RADIUS).count();
        // The ring where the meshes meet belongs to both.
        let cut = if thick < 2 { 0 } else { thick - 1 };
        if cut > 0 {
            tube.add(&mut bark, &rings[..=cut], cut + 1 == rings.len());
        }
        if cut + 1 < rings.len() {
            tube.add(&mut twigs, &rings[cut..], true);
        }
    }
    (bark, twigs)
}

struct Tube {
    /// Repeats of the texture around.
    repeats: f64,
    /// Height and radius where the tube stands on the ground.
    root: Option<(f64, f64)>,
}

/// Sides of a tube: no side of the trunk is wide enough to be seen, twigs are triangular.
fn sides(radius: f64) -> u32 {
    (1.9 * (radius * 1000.0).sqrt()).round().clamp(3.0, 24.0) as u32
}

impl Tube {
    fn add(&self, mesh: &mut Mesh, rings: &[Ring], closed: bool) {
        let mut last: Option<(u32, u32)> = None;
        let (end, rings) = match rings.split_last() {
            // The last piece of a twig is a cone.
            Some((end, rings)) if closed && sides(end.radius) == 3 => (Some(end), rings),
            _ => (None, rings),
        };
        for ring in rings {
            let first = mesh.positions.len() as u32;
            let count = sides(ring.radius).max(if self.root.is_some() { 6 } else { 3 });
            for vertex in 0..=count {
                self.vertex(mesh, ring, f64::from(vertex) / f64::from(count));
            }
            if let Some(last) = last {
                zip(mesh, last, (first, count));
            }
            last = Some((first, count));
        }
        if let (true, Some((first, count)), Some(ring)) = (closed, last, rings.last()) {
            let apex = end.map_or(ring.centre + ring.tangent * ring.radius, |end| end.centre);
            close(mesh, first, count, (apex, ring.tangent));
        }
    }

    /// Adds the vertex at share `around` of the ring. On the ground the radius has lobes, whose slopes tilt the normal.
    fn vertex(&self, mesh: &mut Mesh, ring: &Ring, around: f64) {
        // The seam's two vertices must be one point to the last bit.
        let angle = if around < 1.0 { TAU * around } else { 0.0 };
        let (sine, cosine) = sincos(angle);
        let side = ring.side;
        let other = ring.tangent.cross(&side);
        let outward = side * cosine + other * sine;
        let around_tangent = other * cosine - side * sine;
        let (factor, turn, rise) = self.flare(ring, angle);
        let radius = ring.radius * factor;
        let normal =
            outward - around_tangent * (turn / factor) - ring.tangent * (ring.slope * factor + ring.radius * rise);
        mesh.positions.push((ring.centre + outward * radius).cast::<f32>());
        mesh.normals.push(unit(normal));
        mesh.uvs.push(Vec2::new((around * self.repeats) as f32, (ring.length / REPEAT) as f32));
    }

    /// Factor on the radius near the ground, its derivative by the angle, and by the length.
    fn flare(&self, ring: &Ring, angle: f64) -> (f64, f64, f64) {
        let Some((ground, radius)) = self.root else { return (1.0, 0.0, 0.0) };
        let scale = 1.6 * radius;
        let height = (ring.centre.y - ground).max(-scale);
        let swell = FLARE * exp(-height / scale);
        let phase = LOBE_COUNT * angle + 0.7 * sin(2.0 * angle);
        let turn_of_phase = LOBE_COUNT + 1.4 * cos(2.0 * angle);
        let lobes = 1.0 + LOBES * cos(phase);
        let turn = -swell * LOBES * sin(phase) * turn_of_phase;
        (1.0 + swell * lobes, turn, -swell * lobes / scale)
    }
}

fn unit(vector: DVec3) -> Vec3 {
    vector.try_normalize(1e-12).unwrap_or_else(DVec3::y).cast::<f32>()
}

/// Joins two rings, given by first vertex and number of sides, by triangles in the order of their angles.
fn zip(mesh: &mut Mesh, (a, a_count): (u32, u32), (b, b_count): (u32, u32)) {
    let (mut i, mut j) = (0, 0);
    while i < a_count || j < b_count {
        // Compares the shares (i + 1) / a_count and (j + 1) / b_count without division.
        let step_a = i < a_count && (j == b_count || (i + 1) * b_count <= (j + 1) * a_count);
        if step_a {
            mesh.triangles.push([a + i, a + i + 1, b + j]);
            i += 1;
        } else {
            mesh.triangles.push([a + i, b + j + 1, b + j]);
            j += 1;
        }
    }
}

/// Closes a tube's end by a cone.
fn close(mesh: &mut Mesh, first: u32, count: u32, (apex, tangent): (DVec3, DVec3)) {
    let tip = mesh.positions.len() as u32;
    mesh.positions.push(apex.cast::<f32>());
    mesh.normals.push(unit(tangent));
    let uv = mesh.uvs[first as usize];
    mesh.uvs.push(Vec2::new(uv.x + 0.5 * (mesh.uvs[(first + count) as usize].x - uv.x), uv.y));
    mesh.triangles.extend((0..count).map(|vertex| [first + vertex, first + vertex + 1, tip]));
}

#[cfg(test)]
mod tests {
    use super::super::{Settings, grow};
    use super::*;
    use crate::base::limits::Limits;

    fn grown(axiom: &str) -> (Mesh, Mesh) {
        let settings = Settings { axiom: axiom.to_owned(), iterations: 0, ..Settings::default() };
        let tree = grow(&settings, 1, &Limits::default()).unwrap().0;
        (tree.bark, tree.twigs)
    }

    #[test]
    fn a_branch_has_the_area_of_its_cylinder_and_starts_inside_its_parent() {
        // The second axis: 1 m of 4 cm from the middle of 40 cm, less what a polygon of 9 sides lacks, plus the collar.
        let (bark, _) = grown("!(40)F(2)[+(90)!(4)F(1)F(1)]F(1)");
        assert_eq!(bark.check(), Ok(()));
        let far = |t: &&[u32; 3]| t.iter().all(|&v| bark.positions[v as usize].x < -0.5);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| bark.positions[v as usize]);
            f64::from((b - a).cross(&(c - a)).norm()) * 0.5
        };
        let branch: f64 = bark.triangles.iter().filter(far).map(area).sum();
        assert!(branch > 0.05 && branch < 0.25, "{branch}");
        let (low, high) = bark.bounds().unwrap();
        assert!((low.y + 0.3).abs() < 1e-6 && high.y > 3.0);
    }

    #[test]
    fn triangles_face_outward_and_the_seam_closes() {
        let (bark, _) = grown("!(30)F(1)+(10)F(1)+(10)F(1)");
        let outward = bark.triangles.iter().filter(|t| {
            let [a, b, c] = t.map(|v| bark.positions[v as usize]);
            let normal = t.iter().map(|&v| bark.normals[v as usize]).sum::<Vec3>();
            (b - a).cross(&(c - a)).dot(&normal) > 0.0
        });
        assert_eq!(outward.count(), bark.triangles.len());
        // Every edge that is not at the open foot is met twice once the seam's double vertices are one.
        let bits = |v: u32| bark.positions[v as usize].iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        let mut edges: Vec<_> = bark
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (bits(a).min(bits(b)), bits(a).max(bits(b))))
            .collect();
        edges.sort();
        let single = edges.chunk_by(|a, b| a == b).filter(|edge| edge.len() != 2).count();
        let foot = sides(0.15) as usize;
        assert_eq!(single, foot);
    }

    #[test]
    fn bark_repeats_a_whole_number_of_times_around() {
        let (bark, twigs) = grown("!(50)F(2)[+!(1)F(1)]F(1)");
        let whole = |mesh: &Mesh| mesh.uvs.iter().map(|uv| uv.x).fold(0.0f32, f32::max);
        assert_eq!(whole(&bark), 3.0);
        assert_eq!(whole(&twigs), 1.0);
    }
}
