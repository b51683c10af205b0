//! The rim of a mesh: vertices that slide on the loops of the outline, set off so far that the rim encloses the outline's area.

use crate::base::vector::DVec2;
use crate::leaf::LeafError;
use crate::leaf::polygon;
use crate::leaf::remesh::curve::Curve;
use crate::leaf::remesh::ring;
use crate::leaf::remesh::sizing::{LONG, Sizing};
use crate::leaf::remesh::straying::Straying;

/// How often chords that cross are halved.
const HALVINGS: u32 = 14;
/// How often chords that are too long for their place are halved.
const FINER: u32 = 3;

/// No vertex, no curve.
const NONE: u32 = u32::MAX;

/// How a vertex lies on the outline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// Number of its curve, `NONE` for inner vertices.
    owner: u32,
    /// The vertices before and after it on the loop.
    beside: [u32; 2],
    /// Arc length on the curve.
    arc: f64,
    /// Whether it does not slide: corners of the curve.
    is_fixed: bool,
    /// Whether it and the chords beside it stay as they are.
    pub(super) is_frozen: bool,
    /// How far it stands off the curve.
    pub(super) shift: DVec2,
    /// How far it tries to slide.
    slide: f64,
}

const INNER: Spot = Spot {
    owner: NONE,
    beside: [NONE; 2],
    arc: 0.0,
    is_fixed: false,
    is_frozen: false,
    shift: DVec2::new(0.0, 0.0),
    slide: 0.0,
};

/// How the vertices of a mesh lie on the loops of the outline; like the mesh it can be changed and changed back.
#[derive(Clone, Debug)]
pub struct Rim<'a> {
    pub(super) curves: &'a [Curve<'a>],
    /// By vertex; inner vertices after the last entry.
    pub(super) spots: Vec<Spot>,
    /// The vertex that starts each loop, nearest arc length 0 of its curve; it is never taken out.
    firsts: Vec<u32>,
    /// What a trial replaced, and the number of entries before it.
    log: Option<(Vec<(u32, Spot)>, usize)>,
}

impl<'a> Rim<'a> {
    /// Simple loops of vertices at about `spacing`.
    ///
    /// # Errors
    /// [`LeafError::Mesh`] when the curves themselves touch or cross.
    pub fn fitted(
        curves: &'a [Curve<'a>],
        (spacing, sizing): (f64, Sizing),
        straying: Straying,
    ) -> Result<Self, LeafError> {
        let mut rings: Vec<Vec<f64>> = curves.iter().map(|curve| ring::fitted(curve, spacing, straying)).collect();
        for _ in 0..FINER {
            let long = long_chords(&rings, curves, (spacing, sizing));
            halve(&mut rings, curves, &long);
        }
        for _ in 0..HALVINGS {
            let polygons: Vec<Vec<DVec2>> =
                rings.iter().zip(curves).map(|(ring, curve)| ring.iter().map(|&arc| curve.at(arc)).collect()).collect();
            let crossings = polygon::crossings(&polygons);
            if crossings.is_empty() {
                return Ok(Self::of(curves, &rings, spacing));
            }
            halve(&mut rings, curves, &crossings.into_iter().flatten().collect::<Vec<_>>());
        }
        Err(LeafError::Mesh { what: "the outline touches or crosses itself; move its points apart there".to_owned() })
    }

    fn of(curves: &'a [Curve<'a>], rings: &[Vec<f64>], spacing: f64) -> Self {
        let mut rim = Self { curves, spots: Vec::new(), firsts: Vec::new(), log: None };
        for (number, ring) in rings.iter().enumerate() {
            let (first, count) = (rim.spots.len(), ring.len());
            let off = |&i: &usize| ring[i].min(curves[number].length() - ring[i]);
            let start = (0..count).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
            let ring = [&ring[start..], &ring[..start]].concat();
            rim.firsts.push(first as u32);
            rim.spots.extend(ring.iter().enumerate().map(|(i, &arc)| Spot {
                owner: number as u32,
                beside: [i + count - 1, i + 1].map(|i| (first + i % count) as u32),
                arc,
                is_fixed: curves[number].corners().contains(&arc),
                slide: f64::INFINITY,
                ..INNER
            }));
        }
        rim.set_off(spacing);
        if !rim.is_simple() {
            rim.spots.iter_mut().for_each(|spot| spot.shift = DVec2::zeros());
        }
        rim
    }

    /// Whether a vertex lies on the outline.
    pub fn holds(&self, v: u32) -> bool {
        self.spots.get(v as usize).is_some_and(|spot| spot.owner != NONE)
    }

    /// Whether a vertex lies on a corner of the outline.
    pub(super) fn is_fixed(&self, v: u32) -> bool {
        self.spots.get(v as usize).is_some_and(|spot| spot.is_fixed)
    }

    /// Whether a vertex starts a loop.
    pub(super) fn is_first(&self, v: u32) -> bool {
        self.firsts.contains(&v)
    }

    /// Whether a vertex slides.
    pub fn slides(&self, v: u32) -> bool {
        self.spots.get(v as usize).is_some_and(|spot| spot.owner != NONE && !spot.is_fixed && !spot.is_frozen)
    }

    /// Whether a vertex may leave its loop.
    pub fn may_go(&self, v: u32) -> bool {
        let [before, after] = self.beside(v);
        let is_least = self.beside(before)[0] == after;
        !is_least && !self.is_first(v) && ![before, v, after].iter().any(|&v| self.spots[v as usize].is_frozen)
    }

    /// Whether a vertex may come between `v` and the next.
    pub fn may_come(&self, v: u32) -> bool {
        ![v, self.beside(v)[1]].iter().any(|&v| self.spots[v as usize].is_frozen)
    }

    /// The curve that a vertex slides on.
    pub fn curve(&self, v: u32) -> &'a Curve<'a> {
        &self.curves[self.spots[v as usize].owner as usize]
    }

    /// The arc length of a vertex.
    pub fn arc(&self, v: u32) -> f64 {
        self.spots[v as usize].arc
    }

    /// Where a vertex stands if it is moved to an arc length of its curve.
    pub fn at(&self, v: u32, arc: f64) -> DVec2 {
        self.curve(v).at(arc) + self.spots[v as usize].shift
    }

    /// The vertices before and after a vertex on its loop.
    pub fn beside(&self, v: u32) -> [u32; 2] {
        self.spots[v as usize].beside
    }

    /// The vertices in order, loop by loop.
    pub fn loops(&self) -> Vec<Vec<u32>> {
        let round = |&first: &u32| {
            let next = |&v: &u32| Some(self.beside(v)[1]).filter(|&next| next != first);
            std::iter::successors(Some(first), next).collect()
        };
        self.firsts.iter().map(round).collect()
    }

    /// Places of all vertices, loop by loop.
    pub fn points(&self) -> Vec<Vec<DVec2>> {
        let points = |ring: Vec<u32>| ring.into_iter().map(|v| self.at(v, self.arc(v))).collect();
        self.loops().into_iter().map(points).collect()
    }

    /// Whether the loops neither cross nor touch.
    pub fn is_simple(&self) -> bool {
        polygon::crossings(&self.points()).is_empty()
    }

    /// The vertices of chords that touch or cross.
    pub fn crossing(&self) -> Vec<u32> {
        let (loops, crossings) = (self.loops(), polygon::crossings(&self.points()));
        let ends = |(k, i): (usize, usize)| [loops[k][i], loops[k][(i + 1) % loops[k].len()]];
        crossings.into_iter().flatten().flat_map(ends).collect()
    }

    /// Keeps vertices, if they are on the rim, and the chords beside them as they are; all vertices if these are already.
    pub fn freeze(&mut self, vertices: &[u32]) {
        let thaws = |rim: &Self, v: u32| rim.holds(v) && !rim.spots[v as usize].is_frozen;
        let mut cold: Vec<u32> = vertices.iter().copied().filter(|&v| thaws(self, v)).collect();
        if cold.is_empty() {
            cold = (0..self.spots.len() as u32).collect();
        }
        cold.into_iter().for_each(|v| self.spots[v as usize].is_frozen = true);
    }

    /// Starts a trial.
    pub fn begin(&mut self) {
        self.log = Some((Vec::new(), self.spots.len()));
    }

    /// Ends a trial, keeping it or putting everything back.
    pub fn end(&mut self, keep: bool) {
        if let Some((log, count)) = self.log.take().filter(|_| !keep) {
            log.into_iter().rev().for_each(|(v, spot)| self.spots[v as usize] = spot);
            self.spots.truncate(count);
        }
    }

    fn change(&mut self, v: u32, change: impl FnOnce(&mut Spot)) {
        if let Some((log, _)) = &mut self.log {
            log.push((v, self.spots[v as usize]));
        }
        change(&mut self.spots[v as usize]);
    }

    /// How far a vertex tries to slide, at most.
    pub fn slide(&self, v: u32) -> f64 {
        self.spots[v as usize].slide
    }

    /// Slides a vertex to an arc length; `slide` is how far it tries next.
    pub fn move_to(&mut self, v: u32, arc: f64, slide: f64) {
        self.change(v, |spot| (spot.arc, spot.slide) = (arc, slide));
    }

    /// Vertex `new` stands between `v` and the next: on a corner if the curve has one there, else half way.
    pub fn insert(&mut self, v: u32, new: u32, arc: f64) -> DVec2 {
        let (spot, curve) = (self.spots[v as usize], self.curve(v));
        let after = spot.beside[1];
        let end = self.arc(after) + if self.arc(after) <= spot.arc { curve.length() } else { 0.0 };
        let corner = curve
            .corners()
            .iter()
            .flat_map(|&corner| [corner, corner + curve.length()])
            .find(|&corner| corner > spot.arc && corner < end);
        let arc = curve.wrapped(corner.unwrap_or(arc));
        let shift =
            if corner.is_some() { DVec2::zeros() } else { (spot.shift + self.spots[after as usize].shift) * 0.5 };
        let count = self.spots.len().max(new as usize + 1);
        self.spots.resize(count, INNER);
        self.change(new, |s| *s = Spot { beside: [v, after], arc, is_fixed: corner.is_some(), shift, ..spot });
        self.change(v, |spot| spot.beside[1] = new);
        self.change(after, |spot| spot.beside[0] = new);
        self.at(new, arc)
    }

    /// Stands a vertex on its curve at an arc length.
    pub fn stand(&mut self, v: u32, arc: f64) -> DVec2 {
        self.change(v, |spot| (spot.arc, spot.shift, spot.slide) = (arc, DVec2::zeros(), f64::INFINITY));
        self.at(v, arc)
    }

    /// Takes a vertex out of its loop.
    pub fn remove(&mut self, v: u32) {
        let [before, after] = self.beside(v);
        self.change(before, |spot| spot.beside[1] = after);
        self.change(after, |spot| spot.beside[0] = before);
        self.change(v, |spot| *spot = INNER);
    }
}

/// The chords (loop, place) that are too long where edges are wanted short.
fn long_chords(rings: &[Vec<f64>], curves: &[Curve], (spacing, sizing): (f64, Sizing)) -> Vec<(usize, usize)> {
    if sizing.is_even() {
        return Vec::new();
    }
    let is_long = |number: usize, i: usize| {
        let [a, b] = [i, i + 1].map(|i| curves[number].at(rings[number][i % rings[number].len()]));
        let wanted = sizing.at((a + b) * 0.5);
        wanted < 1.0 && (b - a).norm() > LONG * wanted * spacing
    };
    let of = |number: usize| (0..rings[number].len()).filter(move |&i| is_long(number, i)).map(move |i| (number, i));
    (0..rings.len()).flat_map(of).collect()
}

/// Puts a vertex on the middle of the curve over each of these chords (loop, place).
fn halve(rings: &mut [Vec<f64>], curves: &[Curve], chords: &[(usize, usize)]) {
    for (number, ring) in rings.iter_mut().enumerate() {
        let mut more: Vec<usize> = chords.iter().filter(|chord| chord.0 == number).map(|chord| chord.1).collect();
        more.sort_unstable();
        more.dedup();
        let ahead = |i: usize| curves[number].wrapped(ring[(i + 1) % ring.len()] - ring[i]);
        let middles: Vec<f64> = more.into_iter().map(|i| curves[number].wrapped(ring[i] + ahead(i) * 0.5)).collect();
        ring.extend(middles);
        ring.sort_by(f64::total_cmp);
    }
}
