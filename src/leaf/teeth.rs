//! The margin between key points: how the flanks of teeth bend, how notches are rounded, and the small teeth upon teeth.
//!
//! Key points stand at tips and notches; straight between them a margin looks cut with scissors. Flanks bulge or are hollow,
//! one kind on the side of the base and another on that of the tip, notches are round where the species has them so, and long
//! flanks carry a tooth of the second order (Ellis et al. 2009, "Manual of Leaf Architecture", on tooth shapes: flanks are
//! convex, straight or concave). It makes the line that is painted and drawn; the mesh that bends is that of the keys alone.

use crate::base::random::hash_unit;
use crate::base::vector::DVec2;
use crate::leaf::polygon;
use crate::leaf::spline::Spline;
use crate::settings;

settings! {
    /// How the margin runs between key points at tips and notches.
    pub struct Teeth {
        /// How far a tooth's longer flank, that of the base, bulges beyond its chord, in chords; hollow when negative.
        belly: f64 = 0.0, range -0.3 => 0.3;
        /// How far the flank on the side of the tip lies within its chord, in chords; bulging when negative.
        hollow: f64 = 0.0, range -0.3 => 0.3;
        /// How narrowly a notch is rounded: the part of the flanks beside it that its curve takes; 0 for one wide curve.
        notch: f64 = 0.0, range 0.0 => 0.45;
        /// Height of the teeth of the second order on the longer flanks, in chords; none at 0.
        second: f64 = 0.0, range 0.0 => 0.3;
        /// Shortest flank that has such a tooth.
        second_least: f64 = 2.0, unit "mm", range 0.1 => 100.0;
    }
}

/// Turning beyond which an inward key is a notch, radians.
const NOTCH: f64 = 0.6;
/// Unevenness of all shapes, relative.
const UNEVEN: f64 = 0.5;

/// What a key is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// The curve breaks its direction outwards.
    Tip,
    /// It turns inwards.
    Notch,
    /// It runs on.
    Smooth,
}

/// The margin through the keys (counter-clockwise, metres, the first at the joint), sharp where the keys turn by more than
/// `corner`; `None` where the teeth would cross each other.
pub fn margin(keys: &[DVec2], corner: f64, teeth: &Teeth) -> Option<Spline> {
    if *teeth == Teeth::default() || keys.len() < 3 {
        return None;
    }
    let mut line = Line { keys, corner, teeth, points: Vec::new(), corners: Vec::new() };
    (0..keys.len()).for_each(|i| line.add(i));
    let spline = Spline::broken_at(&line.points, line.corners);
    polygon::crossing(&spline.polyline(6)).is_none().then_some(spline)
}

/// A margin as it is made.
struct Line<'a> {
    keys: &'a [DVec2],
    corner: f64,
    teeth: &'a Teeth,
    points: Vec<DVec2>,
    corners: Vec<bool>,
}

impl Line<'_> {
    fn key(&self, i: usize) -> DVec2 {
        self.keys[i % self.keys.len()]
    }

    fn kind(&self, i: usize) -> Kind {
        let count = self.keys.len();
        let (a, b, c) = (self.key(i + count - 1), self.key(i), self.key(i + 1));
        let turn = crate::leaf::spline::turning(a, b, c);
        // The curves that meet at the joint are the petiole's business.
        let is_outwards = i.is_multiple_of(count) || (b - a).perp(&(c - b)) > 0.0;
        match is_outwards {
            true if turn > self.corner => Kind::Tip,
            false if turn > NOTCH => Kind::Notch,
            _ => Kind::Smooth,
        }
    }

    fn push(&mut self, point: DVec2, is_corner: bool) {
        self.points.push(point);
        self.corners.push(is_corner);
    }

    /// A number in -1..1 that belongs to a key.
    fn own(&self, i: usize, salt: u64) -> f64 {
        2.0 * f64::from(hash_unit(salt, (i % self.keys.len()) as u64)) - 1.0
    }

    /// Adds a key and the flank that follows it.
    fn add(&mut self, i: usize) {
        let (kind, next) = (self.kind(i), self.kind(i + 1));
        let (from, to) = (self.key(i), self.key(i + 1));
        let notch = self.teeth.notch;
        if kind == Kind::Notch && notch > 0.0 {
            let before = self.key(i + self.keys.len() - 1);
            let reach = notch * (before - from).norm().min((to - from).norm());
            for side in [before, to] {
                let way = (side - from).try_normalize(0.0).unwrap_or_default();
                self.push(from + way * (reach * (1.0 + 0.4 * self.own(i, 3))), false);
            }
        } else {
            self.push(from, kind == Kind::Tip);
        }
        match (kind, next) {
            (Kind::Tip, Kind::Tip) | (Kind::Smooth | Kind::Notch, Kind::Smooth | Kind::Notch) => {}
            (_, Kind::Tip) => self.add_flank(from, to, i, self.is_basal(i, i + 1)),
            (Kind::Tip, _) => self.add_flank(to, from, i, self.is_basal(i, i)),
        }
    }

    /// Whether the side that starts at a key is the longer flank of a tip.
    fn is_basal(&self, side: usize, tip: usize) -> bool {
        let other = if side == tip { tip + self.keys.len() - 1 } else { tip };
        let length = |i: usize| (self.key(i + 1) - self.key(i)).norm();
        length(side) >= length(other)
    }

    /// The points between a notch and the tip of a tooth, in the order of the margin.
    fn add_flank(&mut self, notch: DVec2, tip: DVec2, i: usize, is_basal: bool) {
        let chord = tip - notch;
        let length = chord.norm();
        // Outwards is to the right of the margin's way round, which is from the notch to the tip or back.
        let ascends = self.key(i) == notch;
        let right = DVec2::new(chord.y, -chord.x);
        let out = if ascends { right } else { -right };
        let at = |along: f64, off: f64| notch + chord * along + out * off;
        let uneven = 1.0 + UNEVEN * self.own(i, 1);
        let bend = if is_basal { self.teeth.belly } else { -self.teeth.hollow } * uneven;
        let long = length >= self.teeth.second_least * 1e-3;
        let mut flank = if is_basal && long && self.teeth.second > 0.0 {
            let (height, shift) = (self.teeth.second * uneven, 0.07 * self.own(i, 2));
            vec![
                (at(0.26 + shift, 0.8 * bend + 0.35 * height), false),
                (at(0.46 + shift, bend + height), true),
                (at(0.54 + shift, bend), false),
                (at(0.76 + 0.5 * shift, 0.8 * bend), false),
            ]
        } else if bend == 0.0 {
            Vec::new()
        } else {
            vec![(at(0.5, bend), false)]
        };
        if !ascends {
            flank.reverse();
        }
        flank.into_iter().for_each(|(point, is_corner)| self.push(point, is_corner));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::sincos;
    use std::f64::consts::TAU;

    /// A round blade 40 mm long with sixteen forward teeth, the joint in its first notch.
    fn keys() -> Vec<DVec2> {
        let point = |angle: f64, radius: f64| DVec2::new(sincos(angle).0, -sincos(angle).1) * radius;
        let tooth = |i: u32| TAU * f64::from(i) / 16.0;
        let origin = point(0.0, 0.018);
        (0..16).flat_map(|i| [point(tooth(i), 0.018), point(tooth(i) + 0.28, 0.021)]).map(|p| p - origin).collect()
    }

    #[test]
    fn without_teeth_there_is_nothing_to_do() {
        assert!(margin(&keys(), 1.1, &Teeth::default()).is_none());
    }

    #[test]
    fn tips_stay_where_they_are_and_flanks_bend_outwards_or_inwards() {
        let keys = keys();
        let area = |belly: f64, hollow: f64| {
            let teeth = Teeth { belly, hollow, notch: 1e-3, ..Teeth::default() };
            let line = margin(&keys, 1.1, &teeth).unwrap().polyline(8);
            for tip in keys.iter().skip(1).step_by(2) {
                assert!(line.iter().any(|p| (p - tip).norm() < 1e-12));
            }
            polygon::doubled_area(&line)
        };
        let straight = polygon::doubled_area(&keys);
        assert!(area(0.1, -0.05) > straight && straight > area(-0.1, 0.05));
    }

    #[test]
    fn teeth_of_the_second_order_are_as_many_as_long_flanks() {
        let keys = keys();
        let tips = |second: f64, second_least: f64| {
            let teeth = Teeth { belly: 0.02, second, second_least, notch: 0.1, ..Teeth::default() };
            let spline = margin(&keys, 1.1, &teeth).unwrap();
            (0..spline.spans()).filter(|&key| spline.is_corner(key)).count()
        };
        let plain = tips(0.0, 1.0);
        // The flank that begins at the joint has none.
        assert_eq!(tips(0.08, 1.0), plain + 15);
        assert_eq!(tips(0.08, 50.0), plain);
    }

    #[test]
    fn teeth_that_would_cross_are_left_out() {
        let narrow = [(0.0, 0.0), (1.0, 0.1), (0.05, 0.2), (1.0, 0.21), (0.05, 0.3), (1.0, 0.4), (0.0, 0.5)];
        let keys: Vec<DVec2> = narrow.map(|(x, y)| DVec2::new(x, y)).to_vec();
        assert!(margin(&keys, 1.1, &Teeth { belly: 0.3, hollow: -0.3, ..Teeth::default() }).is_none());
    }
}
