//! How long edges should be from place to place: even, or shorter about the joint.

use crate::base::vector::DVec2;
use crate::leaf::polygon;

/// Rows and columns of the grid on which the field is summed up.
const GRID: u32 = 64;
/// A chord of the rim is halved where it is longer than this many wanted lengths.
pub const LONG: f64 = 1.42;

/// The field of the wanted lengths of edges, over the spacing: `finest` up to `reach` from the origin, 1 from `end` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizing {
    /// Share of the spacing at the origin.
    pub finest: f64,
    /// Distance from the origin, metres, up to which edges are that short.
    pub reach: f64,
    /// Distance from the origin, metres, from which on they are as long as anywhere.
    pub end: f64,
}

impl Sizing {
    /// The same everywhere.
    pub const EVEN: Self = Self { finest: 1.0, reach: 0.0, end: 1.0 };

    /// Whether it is the same everywhere.
    pub fn is_even(&self) -> bool {
        self.finest == 1.0
    }

    /// The wanted length of edges at a place, over the spacing.
    pub fn at(&self, place: DVec2) -> f64 {
        if self.is_even() {
            return 1.0;
        }
        let way = ((place.norm() - self.reach) / (self.end - self.reach)).clamp(0.0, 1.0);
        self.finest + (1.0 - self.finest) * way
    }

    /// The area of the even blade that takes as many triangles as the loops do, less the area of these.
    pub fn surplus(&self, loops: &[Vec<DVec2>]) -> f64 {
        if self.is_even() {
            return 0.0;
        }
        let cell = 2.0 * self.end / f64::from(GRID);
        let middle = |i: u32| (f64::from(i) + 0.5) * cell - self.end;
        let places = (0..GRID * GRID).map(|k| DVec2::new(middle(k % GRID), middle(k / GRID)));
        let is_inside = |p: &DVec2| loops.iter().filter(|points| polygon::contains(points, *p)).count() % 2 == 1;
        let surplus = |p: DVec2| 1.0 / (self.at(p) * self.at(p)) - 1.0;
        places.filter(|p| p.norm() < self.end && is_inside(p)).map(surplus).sum::<f64>() * cell * cell
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINER: Sizing = Sizing { finest: 0.5, reach: 0.2, end: 1.0 };

    #[test]
    fn edges_grow_evenly_between_reach_and_end() {
        let at = |x: f64| FINER.at(DVec2::new(0.0, x));
        assert_eq!([0.0, 0.2, 1.0, 7.0].map(at), [0.5, 0.5, 1.0, 1.0]);
        assert!((at(0.6) - 0.75).abs() < 1e-15);
        assert_eq!(Sizing::EVEN.at(DVec2::zeros()), 1.0);
    }

    #[test]
    fn the_surplus_of_a_half_plane_is_the_integral() {
        // Up to the reach 1/s^2 = 4; then with s = 0.5 + 0.625 (r - 0.2), r = 1.6 s - 0.6 and the integral of r / s^2 dr is
        // 1.6 (1.6 ln s + 0.6 / s) from 0.5 to 1, here 1.6 (1.6 ln 2 - 0.6).
        let disc = |r: f64| 0.5 * r * r;
        let integral = 3.0 * disc(0.2) + 1.6 * (1.6 * std::f64::consts::LN_2 - 0.6) - (disc(1.0) - disc(0.2));
        let half = [(-5.0, 0.0), (5.0, 0.0), (5.0, 5.0), (-5.0, 5.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        let found = FINER.surplus(&[half]);
        assert!((found / (std::f64::consts::PI * integral) - 1.0).abs() < 0.02, "{found} {integral}");
    }
}
