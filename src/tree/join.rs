//! Where a branch leaves its parent: a sleeve from the parent's surface to the branch's first free ring.
//!
//! Each line along the branch is followed out of the parent. Where it crosses the parent's surface is a corner; the sleeve
//! rounds the corner by a quadratic Bezier curve from a foot on the parent's surface, with the parent's normal, to the
//! branch's surface, with the branch's. So both surfaces and their shading run into each other without a crease, broad
//! below and tight in the axil as collars are. The parent's curve near the fork is its Hermite curve to second order.

use super::axis::Knot;
use super::path::{Ring, radius, tangent};
use crate::base::maths::cos;
use crate::base::vector::DVec3;
use std::f64::consts::PI;

/// Reach of the collar on the parent, in radii of the branch: at its sides, and less or more in the axil and below.
const COLLAR: f64 = 0.75;
const AXIL: f64 = 0.35;
/// Reach on the branch over that on the parent.
const RISE: f64 = 1.5;
/// Places on the Bezier curve of thick and of thin branches.
const THICK_ROWS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const THIN_ROWS: [f64; 3] = [0.0, 0.45, 1.0];
/// Radius from which a branch counts as thick here, metres.
const THICK: f64 = 0.012;

/// The parent's surface near one of its knots.
pub(super) struct Joint {
    node: Knot,
    tangent: DVec3,
    /// The knots before and after with the second derivatives of the curve there.
    below: Option<(Knot, f64, DVec3)>,
    above: Option<(Knot, f64, DVec3)>,
}

/// A vertex of a sleeve.
#[derive(Clone, Copy, Debug)]
pub(super) struct SleeveVertex {
    pub position: DVec3,
    pub normal: DVec3,
    /// Length along the branch's axis, metres, as its rings count it.
    pub length: f64,
}

/// Rows of vertices, one for each side of the ring they lead to, from the foot.
pub(super) struct Sleeve {
    /// Number of the ring that the sleeve leads to.
    pub ring: usize,
    pub rows: Vec<Vec<SleeveVertex>>,
}

impl Joint {
    pub(super) fn new(knots: &[Knot], at: usize) -> Self {
        let node = knots[at];
        let here = tangent(knots, at);
        let below = at.checked_sub(1).map(|last| {
            let (last, from) = (knots[last], tangent(knots, last));
            let chord = node.position - last.position;
            let span = chord.norm().max(1e-9);
            (last, span, (chord * -6.0 + (from * 2.0 + here * 4.0) * span) / (span * span))
        });
        let above = knots.get(at + 1).map(|next| {
            let to = tangent(knots, at + 1);
            let chord = next.position - node.position;
            let span = chord.norm().max(1e-9);
            (*next, span, (chord * 6.0 - (here * 4.0 + to * 2.0) * span) / (span * span))
        });
        Self { node, tangent: here, below, above }
    }

    /// The middle and the radius of the parent beside a point.
    fn section(&self, point: DVec3) -> (DVec3, f64) {
        let height = self.tangent.dot(&(point - self.node.position));
        let side = if height < 0.0 { &self.below } else { &self.above };
        let Some((other, span, bend)) = side else { return (self.node.position, self.node.radius) };
        let held = height.abs().min(0.7 * span);
        let centre = self.node.position + self.tangent * height + bend * (0.5 * held * held);
        let radius = if height < 0.0 {
            radius(other, &self.node, *span, span + height)
        } else {
            radius(&self.node, other, *span, height)
        };
        (centre, radius)
    }

    /// How far a point lies outside the parent, metres; negative inside.
    fn outside(&self, point: DVec3) -> f64 {
        let (centre, radius) = self.section(point);
        (point - centre).norm() - radius
    }

    /// The point moved onto the parent's facets, slightly sunk, and the normal there.
    fn foot(&self, point: DVec3, sides: u32) -> (DVec3, DVec3) {
        let (centre, radius) = self.section(point);
        let normal = (point - centre).try_normalize(1e-12).unwrap_or(self.tangent);
        // Facets lie below the circle by their sagitta.
        let sunk = radius * (cos(PI / f64::from(sides)) - 0.006);
        (centre + normal * sunk, normal)
    }

    /// Where the line through `points` last comes out of the parent, and the number of the point after.
    fn corner(&self, points: &[DVec3]) -> Option<(DVec3, usize)> {
        let inside = (0..points.len() - 1).rev().find(|&at| self.outside(points[at]) <= 0.0)?;
        let (mut low, mut high) = (points[inside], points[inside + 1]);
        for _ in 0..12 {
            let middle = (low + high) * 0.5;
            *(if self.outside(middle) <= 0.0 { &mut low } else { &mut high }) = middle;
        }
        Some(((low + high) * 0.5, inside + 1))
    }

    /// The sleeve of a branch with these rings, or `None` where it does not come out of the parent (or was never in it).
    /// `parent_sides` are those of the parent's tube, `sides` gives the number and circle of a ring's vertices.
    pub(super) fn sleeve<'a>(
        &self,
        rings: &[Ring],
        parent_sides: u32,
        sides: impl Fn(f64) -> &'a [(f64, f64)],
    ) -> Option<Sleeve> {
        let first = rings[0];
        let free = |ring: &&(usize, &Ring)| {
            let circle = sides(ring.1.radius);
            circle.iter().all(|&turn| self.outside(point(ring.1, turn)) > 0.25 * ring.1.radius)
        };
        let candidates: Vec<(usize, &Ring)> = rings.iter().enumerate().skip(1).take(12).collect();
        let &(number, ring) = candidates.iter().find(free)?;
        let circle = sides(ring.radius);
        let lines: Vec<(DVec3, DVec3, DVec3)> = circle
            .iter()
            .map(|&turn| {
                let inner = point(&first, turn) - first.tangent * self.node.radius;
                let outer = rings[..=number].iter().map(|ring| point(ring, turn));
                let points: Vec<DVec3> = std::iter::once(inner).chain(outer).collect();
                let (corner, next) = self.corner(&points)?;
                Some((corner, points[next], points[number + 1]))
            })
            .collect::<Option<_>>()?;
        let middle = lines.iter().map(|line| line.0).sum::<DVec3>() / lines.len() as f64;
        let places: &[f64] = if ring.radius >= THICK { &THICK_ROWS } else { &THIN_ROWS };
        let mut rows = vec![Vec::with_capacity(circle.len()); places.len()];
        for (&line, &turn) in lines.iter().zip(circle) {
            let curve = self.curve(line, middle, (&first, ring), turn, parent_sides);
            for (row, &place) in rows.iter_mut().zip(places) {
                row.push(curve.at(place));
            }
        }
        Some(Sleeve { ring: number, rows })
    }

    fn curve(
        &self,
        (corner, _, end): (DVec3, DVec3, DVec3),
        middle: DVec3,
        (first, ring): (&Ring, &Ring),
        turn: (f64, f64),
        sides: u32,
    ) -> Curve {
        let (centre, parent) = self.section(corner);
        let surface = (corner - centre).try_normalize(1e-12).unwrap_or(self.tangent);
        let away = corner - middle;
        let away = (away - surface * surface.dot(&away)).try_normalize(1e-12).unwrap_or(self.tangent);
        // 1 in the axil, -1 below the branch.
        let lean = self.tangent.dot(&first.tangent);
        let outward = first.side * turn.0 + first.tangent.cross(&first.side) * turn.1;
        let axil = outward.dot(&self.tangent) * lean.signum() / (1.0 - lean * lean).sqrt().max(0.1);
        let reach = (ring.radius * (COLLAR - AXIL * axil.clamp(-1.0, 1.0))).min(0.8 * parent);
        let (foot, from) = self.foot(corner + away * reach, sides);
        let leg = end - corner;
        let long = leg.norm().max(1e-9);
        let top = corner + leg * ((RISE * reach).min(0.9 * long) / long);
        let outward = ring.side * turn.0 + ring.tangent.cross(&ring.side) * turn.1;
        let to = (outward - ring.tangent * ring.slope).normalize();
        Curve { foot, corner, top, from, to, length: ring.length - (end - top).norm() }
    }
}

/// The rounding of a corner.
struct Curve {
    foot: DVec3,
    corner: DVec3,
    top: DVec3,
    /// Normals at foot and top.
    from: DVec3,
    to: DVec3,
    /// Length of the axis at the top.
    length: f64,
}

impl Curve {
    fn at(&self, t: f64) -> SleeveVertex {
        let s = 1.0 - t;
        let position = self.foot * (s * s) + self.corner * (2.0 * s * t) + self.top * (t * t);
        let normal = (self.from * s + self.to * t).try_normalize(1e-9).unwrap_or(self.to);
        let legs = (self.corner - self.foot).norm() + (self.top - self.corner).norm();
        SleeveVertex { position, normal, length: self.length - s * legs }
    }
}

/// The vertex of a ring at a turn given by cosine and sine.
pub(super) fn point(ring: &Ring, (cosine, sine): (f64, f64)) -> DVec3 {
    ring.centre + (ring.side * cosine + ring.tangent.cross(&ring.side) * sine) * ring.radius
}
