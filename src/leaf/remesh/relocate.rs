//! The first of the two steps of a round: every vertex moves to where its triangles cost least.
//!
//! Inner vertices take a Newton step, shortened until the cost falls; rim vertices slide along the curve. One after another
//! in the order of their numbers (Gauss and Seidel), so that the cost of the mesh never rises. A vertex that came to rest
//! sleeps until one beside it moves.

use crate::base::vector::DVec2;
use crate::leaf::remesh::energy::{Energy, Slope};
use crate::leaf::remesh::reconnect::Count;
use crate::leaf::remesh::rim::Rim;
use crate::leaf::remesh::sizing::Sizing;
use crate::leaf::remesh::straying::{SLID, Straying};
use crate::leaf::remesh::trial::Marks;
use crate::leaf::remesh::web::Web;

/// A vertex rests when it moves by less than this share of the spacing.
const REST: f64 = 1e-3;
/// How often a Newton step is halved.
const HALVINGS: u32 = 4;
/// What the triangles of a rim vertex may cost beyond twice their cost when it is set off the curve anew.
const MISFIT: f64 = 3.0;
/// The first vertex of a loop does not slide farther than this share of the spacing from its first key.
const ASIDE: f64 = 0.15;
/// First and longest slide along the curve, in spacings.
const SLIDE: f64 = 0.04;

/// A triangle of a fan: its number and its other two corners.
pub type Blade = (u32, u32, u32);

/// A mesh under way.
#[derive(Clone, Debug)]
pub struct Mesher<'a> {
    /// Triangles and places.
    pub web: Web,
    /// How the first vertices lie on the outline.
    pub rim: Rim<'a>,
    /// The cost of a triangle.
    pub energy: Energy,
    /// The cost of the curve's straying from a chord: keeps vertices on tips and sinuses.
    pub straying: Straying,
    /// Aim of the edges' length.
    pub spacing: f64,
    /// How many vertices there may be.
    pub count: Count,
    /// Vertices that may have something to gain by a move.
    pub awake: Vec<bool>,
    /// Vertices at which every change was tried since something changed there.
    pub tried: Vec<bool>,
    /// Scratch.
    pub marks: Marks,
    /// Scratch.
    fan: Vec<Blade>,
    sides: Vec<(DVec2, DVec2)>,
}

impl<'a> Mesher<'a> {
    /// A mesh at its start.
    pub fn new(web: Web, rim: Rim<'a>, (spacing, sizing): (f64, Sizing), count: Count) -> Self {
        Self {
            energy: Energy::of_spacing(spacing, sizing),
            straying: SLID.among(count.now),
            awake: vec![true; web.places()],
            tried: vec![false; web.places()],
            marks: Marks::default(),
            fan: Vec::new(),
            sides: Vec::new(),
            web,
            rim,
            spacing,
            count,
        }
    }

    /// Makes thin triangles cost more, and has their vertices tried and moved again.
    pub fn stiffen(&mut self) {
        self.energy.stiffen();
        for (_, corners) in self.web.triangles() {
            let [a, b, c] = corners.map(|v| self.web.point(v));
            if self.energy.is_thin(a, b, c) {
                corners.iter().for_each(|&v| (self.awake[v as usize], self.tried[v as usize]) = (true, false));
            }
        }
    }

    /// Moves every vertex that is awake; the longest move.
    pub fn relocate(&mut self) -> f64 {
        let mut longest = 0.0f64;
        for v in 0..self.web.places() as u32 {
            if self.awake[v as usize] && self.web.is_vertex(v) {
                self.awake[v as usize] = false;
                let moved = self.moved(v);
                longest = longest.max(moved);
                if moved > REST * self.spacing {
                    self.awake[v as usize] = true;
                    for &(_, a, b) in &self.fan {
                        (self.awake[a as usize], self.awake[b as usize]) = (true, true);
                    }
                }
            }
        }
        longest
    }

    /// Moves one vertex to where its triangles cost less; how far.
    pub fn moved(&mut self, v: u32) -> f64 {
        let (holds, slides) = (self.rim.holds(v), self.rim.slides(v));
        if holds && !slides {
            return 0.0;
        }
        self.look_round(v);
        if slides { self.slide(v) } else { self.step(v) }
    }

    fn look_round(&mut self, v: u32) {
        self.web.fan(v, &mut self.fan);
        self.sides.clear();
        self.sides.extend(self.fan.iter().map(|&(_, a, b)| (self.web.point(a), self.web.point(b))));
    }

    /// What the triangles round the vertex last looked at cost if it stood at `p`.
    fn cost_at(&self, p: DVec2) -> f64 {
        self.sides.iter().map(|&(a, b)| self.energy.of(p, a, b)).sum()
    }

    fn step(&mut self, v: u32) -> f64 {
        let start = self.web.point(v);
        let mut slope = Slope::default();
        self.sides.iter().for_each(|&(a, b)| self.energy.add_slope(start, a, b, &mut slope));
        let (before, mut step) = (slope.value, slope.step());
        for _ in 0..=HALVINGS {
            if self.cost_at(start + step) < before {
                self.web.place(v, start + step);
                return step.norm();
            }
            step *= 0.5;
        }
        0.0
    }

    fn slide(&mut self, v: u32) -> f64 {
        let ends = self.rim.beside(v).map(|v| (self.rim.arc(v), self.web.point(v)));
        let arc = self.rim.arc(v);
        let curve = self.rim.curve(v);
        let length = curve.length();
        let room = |from: f64, to: f64| if to > from { to - from } else { to - from + length };
        let most = self.rim.slide(v).min(SLIDE * self.spacing);
        let slide = most.min(0.25 * room(ends[0].0, arc)).min(0.25 * room(arc, ends[1].0));
        let cost = |arc: f64| {
            let (arc, point) = (curve.wrapped(arc), self.rim.at(v, arc));
            self.cost_at(point) + self.straying_beside(v, (arc, point), ends)
        };
        let [low, here, high] = [cost(arc - slide), cost(arc), cost(arc + slide)];
        // The lowest point of the parabola through the three, if it opens upwards.
        let bend = low + high - 2.0 * here;
        let best = if bend > 0.0 && bend.is_finite() {
            (0.5 * (low - high) / bend).clamp(-1.0, 1.0)
        } else if low.min(high) < here {
            if low < high { -1.0 } else { 1.0 }
        } else {
            0.0
        };
        let target = curve.wrapped(arc + best * slide);
        let aside = |arc: f64| arc.min(length - arc);
        let strays = self.rim.is_first(v) && aside(target) > aside(arc).max(ASIDE * self.spacing);
        let gains = best != 0.0 && !strays && cost(target) < here;
        let next = (if best.abs() > 0.5 { slide * 2.0 } else { slide * 0.5 }).max(1e-3 * self.spacing);
        self.rim.move_to(v, if gains { target } else { arc }, next);
        if !gains {
            return 0.0;
        }
        self.web.place(v, self.rim.at(v, target));
        best.abs() * slide
    }

    /// What the curve's straying from the chords beside a rim vertex costs if it stood at this arc length and place.
    fn straying_beside(&self, v: u32, here: (f64, DVec2), [before, after]: [(f64, DVec2); 2]) -> f64 {
        let straying = |a: (f64, DVec2), b: (f64, DVec2)| {
            let straying = self.rim.curve(v).straying([a.0, b.0], [a.1, b.1]) / self.spacing;
            self.straying.of(straying)
        };
        straying(before, here) + straying(here, after)
    }

    /// What the curve's straying from the chords beside a rim vertex costs.
    pub fn straying_cost(&self, v: u32) -> f64 {
        let [before, after] = self.rim.beside(v);
        let [before, here, after] = [before, v, after].map(|v| (self.rim.arc(v), self.web.point(v)));
        self.straying_beside(v, here, [before, after])
    }

    /// Sets the rim off the curve anew, where that folds no triangle.
    pub fn set_off(&mut self) {
        self.rim.set_off(self.spacing);
        for v in self.rim.loops().into_iter().flatten() {
            self.look_round(v);
            let (here, there) = (self.web.point(v), self.rim.at(v, self.rim.arc(v)));
            if self.cost_at(there) < 2.0 * self.cost_at(here) + MISFIT {
                self.web.place(v, there);
            } else {
                self.rim.keep_off(v, here);
            }
        }
    }
}
