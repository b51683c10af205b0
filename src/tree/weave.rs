//! Tubes woven from rings: rows of vertices zipped together, closed at both ends, cut where the class of girth changes.
//!
//! Where thick wood changes class its bark changes too, which would show as a line around the stem. There the two pieces
//! overlap, and the lower one's surface wavers about the upper one's, so that old bark gives way to young in patches.

use super::axis::Axis;
use super::flare::Flare;
use super::join::{Joint, Sleeve, point};
use super::path::{Ring, THIN, rings};
use super::wood::{CLASSES, class, middle, repeats};
use crate::base::maths::sincos;
use crate::base::mesh::Mesh;
use crate::base::random::{hash, hash_unit};
use crate::base::vector::{DVec3, Vec2, Vec3};
use std::f64::consts::TAU;

/// Most sides of a tube, and of a trunk.
const MOST_SIDES: u32 = 40;
/// Thinnest branch that gets a sleeve, metres of radius.
const SLEEVED: f64 = 0.0025;
/// Thinnest wood whose bark changes in patches, metres of radius: thinner bark is alike on both sides.
const PATCHED: f64 = 0.02;
/// Length over which bark changes, in radii, and how far its surface wavers.
const PATCH_LENGTH: f64 = 2.4;
const PATCH_DEPTH: f64 = 0.006;
/// Rings across such a change.
const PATCH_ROWS: u32 = 7;

/// Sides of a tube: no side of the trunk is wide enough to be seen, twigs are triangular.
pub(super) fn sides(radius: f64) -> u32 {
    (1.8 * (radius * 1000.0).sqrt()).round().clamp(3.0, f64::from(MOST_SIDES)) as u32
}

/// Cosines and sines of the turns of every number of sides.
pub(super) struct Circles(Vec<Vec<(f64, f64)>>);

impl Circles {
    pub(super) fn new() -> Self {
        let turn = |vertex: u32, count: u32| {
            let (sine, cosine) = sincos(TAU * f64::from(vertex) / f64::from(count));
            (cosine, sine)
        };
        Self((0..=MOST_SIDES).map(|count| (0..count).map(|vertex| turn(vertex, count)).collect()).collect())
    }

    pub(super) fn of(&self, radius: f64) -> &[(f64, f64)] {
        &self.0[sides(radius) as usize]
    }
}

/// A ring or row in a mesh: class, first vertex, number of sides. The first vertex stands again at the end, at the seam.
#[derive(Clone, Copy)]
struct Row {
    class: usize,
    first: u32,
    count: u32,
}

/// Weaves tubes into a mesh for each class.
pub(super) struct Weaver<'a> {
    meshes: Vec<Mesh>,
    circles: &'a Circles,
    rings: Vec<Ring>,
}

/// What every vertex of a tube shares.
struct Tube {
    flare: Option<Flare>,
    /// Where in the bark it begins, repeats.
    offset: Vec2,
    id: u64,
}

impl<'a> Weaver<'a> {
    pub(super) fn new(circles: &'a Circles) -> Self {
        Self { meshes: vec![Mesh::default(); CLASSES], circles, rings: Vec::new() }
    }

    pub(super) fn into_meshes(self) -> Vec<Mesh> {
        self.meshes
    }

    /// Adds the tube of an axis; `axes` are all of them.
    pub(super) fn weave(&mut self, axis: &Axis, axes: &[Axis]) {
        let mut taken = std::mem::take(&mut self.rings);
        rings(axis, &mut taken);
        let offset = Vec2::new(hash_unit(axis.id, 0xBA), hash_unit(axis.id, 0xBB));
        let flare = axis.origin.is_none().then(|| Flare::new(axis.id, &taken[1]));
        let tube = Tube { flare, offset, id: axis.id };
        let sleeve = axis.origin.filter(|_| axis.knots[0].radius >= SLEEVED).and_then(|origin| {
            let knots = &axes[origin.axis].knots;
            let parent = knots[origin.knot].radius;
            let joint = (parent > THIN).then(|| Joint::new(knots, origin.knot))?;
            joint.sleeve(&taken, sides(parent), |radius| self.circles.of(radius))
        });
        self.tube(&tube, &taken, sleeve.as_ref());
        self.rings = taken;
    }

    fn tube(&mut self, tube: &Tube, rings: &[Ring], sleeve: Option<&Sleeve>) {
        let first = sleeve.map_or(0, |sleeve| sleeve.ring);
        let last = rings.len() - 1;
        let mut open: Option<Row> = None;
        if let Some(sleeve) = sleeve {
            let class = class(rings[first].radius);
            open = Some(self.sleeve(tube, sleeve, &rings[first], class));
        }
        let class_of = |at: usize| class(0.5 * (rings[at].radius + rings[at + 1].radius));
        let long = |at: usize| rings[at + 1].length - rings[at].length;
        for at in first..last {
            let class = class_of(at);
            let from = match open {
                Some(row) if row.class == class => row,
                Some(row) => self.change(tube, [&rings[at], &rings[at + 1]], false, row, class),
                None => {
                    let row = self.ring(tube, &rings[at], class);
                    self.cap(row);
                    row
                }
            };
            // A change lies in the longer of the pieces that it parts.
            if at + 1 < last && class_of(at + 1) != class && long(at) >= long(at + 1) {
                open = Some(self.change(tube, [&rings[at], &rings[at + 1]], true, from, class_of(at + 1)));
                continue;
            }
            if at + 1 == last && sides(rings[last].radius) == 3 {
                // The last piece of a twig is a cone.
                self.tip(from, rings[last].centre, rings[last].tangent);
                return;
            }
            let to = self.ring(tube, &rings[at + 1], class);
            self.zip(from, to);
            open = Some(to);
        }
        if let Some(row) = open {
            let ring = &rings[last];
            self.tip(row, ring.centre + ring.tangent * ring.radius, ring.tangent);
        }
    }

    /// Goes over from the class of `open`, a row at the first ring, to `class`, at the end of the piece between the rings or
    /// at its beginning: the row from which the tube goes on.
    fn change(&mut self, tube: &Tube, [a, b]: [&Ring; 2], at_end: bool, open: Row, class: usize) -> Row {
        let long = b.length - a.length;
        // What is left of the piece must not be a sliver.
        let length = (PATCH_LENGTH * a.radius).min(if at_end { long } else { 0.9 * long });
        let mut open = open;
        if a.radius < PATCHED || length < 0.5 * a.radius {
            if at_end {
                let end = self.ring(tube, b, open.class);
                self.zip(open, end);
            }
            return self.ring(tube, if at_end { b } else { a }, class);
        }
        let (mut from, mut to) = (0.0, length / long);
        if at_end {
            from = if to < 0.9 { 1.0 - to } else { 0.0 };
            to = 1.0;
        }
        let ring = &blend(a, b, from);
        let sides = open.count as usize;
        if from > 0.0 {
            let row = self.row(tube, ring, sides, open.class, |_| 1.0);
            self.zip(open, row);
            open = row;
        }
        let start = self.row(tube, ring, sides, class, |_| 1.0 - PATCH_DEPTH);
        self.cap(start);
        let (mut lower, mut upper) = (open, start);
        for number in 1..=PATCH_ROWS {
            let rise = f64::from(number) / f64::from(PATCH_ROWS);
            let here = blend(a, b, from + (to - from) * rise);
            let waver = |vertex: u64| {
                let chance = f64::from(hash_unit(tube.id, hash(u64::from(number), vertex))) - 0.5;
                1.0 + PATCH_DEPTH * if number == PATCH_ROWS { -1.0 } else { 1.0 - 2.0 * rise + 1.8 * chance }
            };
            let rows = [(&mut lower, open.class, true), (&mut upper, class, false)];
            for (last, class, wavers) in rows {
                let row = self.row(tube, &here, sides, class, |vertex| if wavers { waver(vertex) } else { 1.0 });
                self.zip(*last, row);
                *last = row;
            }
        }
        self.lid(lower);
        upper
    }

    /// The rows of a sleeve, the foot closed, up to its ring.
    fn sleeve(&mut self, tube: &Tube, sleeve: &Sleeve, ring: &Ring, class: usize) -> Row {
        let mut open: Option<Row> = None;
        for row in &sleeve.rows {
            let count = row.len() as u32;
            let mesh = &mut self.meshes[class];
            let first = mesh.positions.len() as u32;
            for vertex in 0..=row.len() {
                let at = row[vertex % row.len()];
                mesh.positions.push(at.position.cast::<f32>());
                mesh.normals.push(at.normal.cast::<f32>());
                mesh.uvs.push(tube.uv(vertex as f64 / f64::from(count), at.length, class));
            }
            let row = Row { class, first, count };
            match open {
                Some(open) => self.zip(open, row),
                None => self.cap(row),
            }
            open = Some(row);
        }
        let to = self.ring(tube, ring, class);
        if let Some(open) = open {
            self.zip(open, to);
        }
        to
    }

    fn ring(&mut self, tube: &Tube, ring: &Ring, class: usize) -> Row {
        self.row(tube, ring, self.circles.of(ring.radius).len(), class, |_| 1.0)
    }

    /// A ring of so many sides whose vertices lie at `factor` of their radius.
    fn row(&mut self, tube: &Tube, ring: &Ring, sides: usize, class: usize, factor: impl Fn(u64) -> f64) -> Row {
        let circle = &self.circles.0[sides];
        let mesh = &mut self.meshes[class];
        let first = mesh.positions.len() as u32;
        for (vertex, &turn) in circle.iter().enumerate() {
            let around = vertex as f64 / sides as f64;
            let ring = Ring { radius: ring.radius * factor(vertex as u64), ..*ring };
            let (position, normal) = tube.vertex(&ring, turn, TAU * around);
            mesh.positions.push(position);
            mesh.normals.push(normal);
            mesh.uvs.push(tube.uv(around, ring.length, class));
        }
        // The seam's two vertices are one point to the last bit.
        mesh.positions.push(mesh.positions[first as usize]);
        mesh.normals.push(mesh.normals[first as usize]);
        mesh.uvs.push(tube.uv(1.0, ring.length, class));
        Row { class, first, count: sides as u32 }
    }

    /// Joins two rows by triangles in the order of their angles.
    fn zip(&mut self, a: Row, b: Row) {
        let triangles = &mut self.meshes[a.class].triangles;
        let (mut i, mut j) = (0, 0);
        while i < a.count || j < b.count {
            // Compares the shares (i + 1) / a.count and (j + 1) / b.count without division.
            if i < a.count && (j == b.count || (i + 1) * b.count <= (j + 1) * a.count) {
                triangles.push([a.first + i, a.first + i + 1, b.first + j]);
                i += 1;
            } else {
                triangles.push([a.first + i, b.first + j + 1, b.first + j]);
                j += 1;
            }
        }
    }

    /// Closes a tube's beginning, which lies inside its parent or in the ground.
    fn cap(&mut self, row: Row) {
        let fan = (1..row.count - 1).map(|vertex| [row.first, row.first + vertex + 1, row.first + vertex]);
        self.meshes[row.class].triangles.extend(fan);
    }

    /// Closes a piece's end, which lies inside the next.
    fn lid(&mut self, row: Row) {
        let fan = (1..row.count - 1).map(|vertex| [row.first, row.first + vertex, row.first + vertex + 1]);
        self.meshes[row.class].triangles.extend(fan);
    }

    /// Closes a tube's end by a cone.
    fn tip(&mut self, row: Row, apex: DVec3, tangent: DVec3) {
        let mesh = &mut self.meshes[row.class];
        let tip = mesh.positions.len() as u32;
        let (a, b) = (mesh.uvs[row.first as usize], mesh.uvs[(row.first + row.count) as usize]);
        mesh.positions.push(apex.cast::<f32>());
        mesh.normals.push(unit(tangent));
        mesh.uvs.push(Vec2::new(0.5 * (a.x + b.x), a.y));
        mesh.triangles.extend((0..row.count).map(|vertex| [row.first + vertex, row.first + vertex + 1, tip]));
    }
}

impl Tube {
    fn vertex(&self, ring: &Ring, turn: (f64, f64), angle: f64) -> (Vec3, Vec3) {
        let other = ring.tangent.cross(&ring.side);
        let outward = ring.side * turn.0 + other * turn.1;
        let Some(flare) = &self.flare else {
            return (point(ring, turn).cast::<f32>(), unit(outward - ring.tangent * ring.slope));
        };
        // The slopes of the buttresses tilt the normal.
        let (factor, around, rise) = flare.factor(ring, angle);
        let tangent = other * turn.0 - ring.side * turn.1;
        let slope = ring.slope * factor + ring.radius * rise;
        let normal = outward - tangent * (around / factor) - ring.tangent * slope;
        ((ring.centre + outward * (ring.radius * factor)).cast::<f32>(), unit(normal))
    }

    /// Texture coordinates at a share of the turn and a length of the axis.
    fn uv(&self, around: f64, length: f64, class: usize) -> Vec2 {
        let repeats = repeats(class);
        let along = 2.0 * TAU * middle(class) / repeats;
        Vec2::new((around * repeats) as f32, (length / along) as f32) + self.offset
    }
}

/// The ring at a share of the way from `a` to `b`.
fn blend(a: &Ring, b: &Ring, share: f64) -> Ring {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    let tangent = (a.tangent * (1.0 - share) + b.tangent * share).normalize();
    let side = a.side * (1.0 - share) + b.side * share;
    let side = (side - tangent * tangent.dot(&side)).normalize();
    Ring {
        centre: a.centre * (1.0 - share) + b.centre * share,
        tangent,
        side,
        radius: mix(a.radius, b.radius),
        slope: mix(a.slope, b.slope),
        length: mix(a.length, b.length),
    }
}

fn unit(vector: DVec3) -> Vec3 {
    vector.try_normalize(1e-12).unwrap_or_else(DVec3::y).cast::<f32>()
}
