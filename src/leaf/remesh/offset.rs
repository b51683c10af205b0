//! How far the rim's vertices stand off the curve: so far that the rim encloses the outline's area.
//!
//! A chord of a bulge cuts area off. Half of it is given back by each of the chord's ends, which moves outward (inward in
//! a bay); so area is kept place by place, and the rim's distance from the curve is less than with vertices on it.

use crate::base::vector::DVec2;
use crate::leaf::polygon;
use crate::leaf::remesh::curve::Curve;
use crate::leaf::remesh::rim::Rim;

/// A vertex is set off by at most this share of the spacing.
const FARTHEST: f64 = 0.12;

impl Rim<'_> {
    /// Sets every vertex off by what the chords beside it cut off, so that area is kept place by place: half of each, all of
    /// it where the other end is a corner, which stays.
    pub fn set_off(&mut self, spacing: f64) {
        let all: Vec<u32> = (0..self.spots.len() as u32).filter(|&v| self.holds(v)).collect();
        let shifts: Vec<DVec2> = all.iter().map(|&v| self.set_off_by(v, spacing)).collect();
        all.iter().zip(shifts).for_each(|(&v, shift)| self.spots[v as usize].shift = shift);
        self.make_up(&all, spacing);
    }

    /// What the area still misses is made up by all vertices but the corners together.
    fn make_up(&mut self, all: &[u32], spacing: f64) {
        let enclosed: f64 = self.points().iter().map(|points| polygon::doubled_area(points) * 0.5).sum();
        let missing = self.curves.iter().map(Curve::area).sum::<f64>() - enclosed;
        let across = |&v: &u32| {
            let [a, c] = self.beside(v).map(|w| self.at(w, self.arc(w)));
            let stays = self.is_fixed(v) || self.spots[v as usize].is_frozen;
            if stays { DVec2::zeros() } else { DVec2::new(c.y - a.y, a.x - c.x) }
        };
        let across: Vec<DVec2> = all.iter().map(across).collect();
        let length: f64 = across.iter().map(|a| a.norm() * 0.5).sum();
        let far = if length > 0.0 { (missing / length).clamp(-FARTHEST * spacing, FARTHEST * spacing) } else { 0.0 };
        for (&v, across) in all.iter().zip(across) {
            self.spots[v as usize].shift += across.try_normalize(0.0).unwrap_or_default() * far;
        }
    }

    fn set_off_by(&self, v: u32, spacing: f64) -> DVec2 {
        if self.spots[v as usize].is_frozen {
            return self.spots[v as usize].shift;
        }
        if self.is_fixed(v) {
            return DVec2::zeros();
        }
        let [before, after] = self.beside(v);
        let cut = |v: u32, next: u32| self.curve(v).cut(self.arc(v), self.arc(next));
        let share = |other: u32| if self.is_fixed(other) { 1.0 } else { 0.5 };
        let [a, b, c] = [before, v, after].map(|v| self.curve(v).at(self.arc(v)));
        let across = (c - a).norm().max(((b - a).norm() + (c - b).norm()) * 0.35);
        let area = 2.0 * (cut(before, v) * share(before) + cut(v, after) * share(after));
        let far = (area / across).clamp(-FARTHEST * spacing, FARTHEST * spacing);
        DVec2::new(c.y - a.y, a.x - c.x).try_normalize(0.0).unwrap_or_default() * far
    }

    /// Leaves a vertex off the curve as it stands.
    pub fn keep_off(&mut self, v: u32, point: DVec2) {
        self.spots[v as usize].shift = point - self.curve(v).at(self.arc(v));
    }
}
