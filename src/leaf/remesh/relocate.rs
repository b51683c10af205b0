//! The first of the two steps of a round: every vertex moves to where its triangles cost least.
//!
//! Inner vertices take a Newton step, shortened until the cost falls; rim vertices slide along the curve. One after another
//! in the order of their numbers (Gauss and Seidel), so that the cost of the mesh never rises. A vertex that came to rest
//! sleeps until one beside it moves.

use crate::base::vector::DVec2;
use crate::leaf::remesh::energy::{Energy, Slope};
use crate::leaf::remesh::rim::Rim;
use crate::leaf::remesh::web::Web;

/// A vertex rests when it moves by less than this share of the spacing.
const REST: f64 = 1e-3;
/// How often a Newton step is halved.
const HALVINGS: u32 = 4;
/// What the square of the curve's straying from a chord (in spacings) costs: keeps vertices on round tips and sinuses.
const STRAYING: f64 = 4.0;
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
    /// Aim of the edges' length.
    pub spacing: f64,
    /// Vertices that may have something to gain.
    pub awake: Vec<bool>,
    /// How far each rim vertex tries to slide.
    slides: Vec<f64>,
    /// Scratch.
    fan: Vec<Blade>,
    sides: Vec<(DVec2, DVec2)>,
    /// Arc lengths before a trial.
    pub slid: Option<Vec<(usize, f64)>>,
}

impl<'a> Mesher<'a> {
    /// A mesh at its start.
    pub fn new(web: Web, rim: Rim<'a>, energy: Energy, spacing: f64) -> Self {
        let (awake, slides) = (vec![true; web.places()], vec![SLIDE * spacing; rim.len()]);
        Self { web, rim, energy, spacing, awake, slides, fan: Vec::new(), sides: Vec::new(), slid: None }
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
        let rim = (v as usize) < self.rim.len();
        if rim && self.rim.fixed[v as usize] {
            return 0.0;
        }
        self.look_round(v);
        if rim { self.slide(v as usize) } else { self.step(v) }
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
        let (before, mut step) = (self.cost_at(start), slope.step());
        for _ in 0..=HALVINGS {
            if self.cost_at(start + step) < before {
                self.web.place(v, start + step);
                return step.norm();
            }
            step *= 0.5;
        }
        0.0
    }

    fn slide(&mut self, v: usize) -> f64 {
        let (before, after) = self.rim.beside(v);
        let (before, after, arc) = (self.rim.arcs[before], self.rim.arcs[after], self.rim.arcs[v]);
        let curve = self.rim.curve(v);
        let length = curve.length();
        let room = |from: f64, to: f64| if to > from { to - from } else { to - from + length };
        let slide = self.slides[v].min(0.25 * room(before, arc)).min(0.25 * room(arc, after));
        let cost = |arc: f64| {
            let [back, ahead] = [curve.straying(before, arc), curve.straying(arc, after)].map(|s| s / self.spacing);
            self.cost_at(self.rim.at(v, arc)) + STRAYING * (back * back + ahead * ahead)
        };
        let [low, here, high] = [cost(arc - slide), cost(arc), cost(arc + slide)];
        // The lowest point of the parabola through the three, if it opens upwards.
        let bend = low + high - 2.0 * here;
        let best = if bend > 0.0 {
            (0.5 * (low - high) / bend).clamp(-1.0, 1.0)
        } else if low < high {
            -1.0
        } else {
            1.0
        };
        let target = curve.wrapped(arc + best * slide);
        let gains = best != 0.0 && cost(target) < here;
        let next = if best.abs() > 0.5 { slide * 2.0 } else { slide * 0.5 };
        self.slides[v] = next.clamp(1e-3 * self.spacing, SLIDE * self.spacing);
        if !gains {
            return 0.0;
        }
        if let Some(slid) = &mut self.slid {
            slid.push((v, arc));
        }
        self.rim.arcs[v] = target;
        self.web.place(v as u32, self.rim.at(v, target));
        best.abs() * slide
    }

    /// What the curve's straying from the chords beside a rim vertex costs.
    pub fn straying_cost(&self, v: usize) -> f64 {
        let (before, after) = self.rim.beside(v);
        let [before, here, after] = [before, v, after].map(|v| self.rim.arcs[v]);
        let curve = self.rim.curve(v);
        let [back, ahead] = [curve.straying(before, here), curve.straying(here, after)].map(|s| s / self.spacing);
        STRAYING * (back * back + ahead * ahead)
    }

    /// Sets the rim off the curve anew, where that folds no triangle.
    pub fn set_off(&mut self) {
        self.rim.set_off(self.spacing);
        for v in 0..self.rim.len() {
            self.look_round(v as u32);
            let (here, there) = (self.web.point(v as u32), self.rim.at(v, self.rim.arcs[v]));
            let moves = here != there && self.cost_at(there) < 2.0 * self.cost_at(here) + 0.1;
            if moves {
                self.web.place(v as u32, there);
            } else {
                self.rim.keep_off(v, here);
            }
        }
    }
}
