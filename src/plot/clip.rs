//! What lies within a panel of lines and polygons.

use super::primitive::Pixel;

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Area {
    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(super) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// Whether a point is inside, or less than `margin` pixels outside.
    pub(super) fn holds(&self, [x, y]: Pixel, margin: f64) -> bool {
        let is_in = |low: f64, value: f64, high: f64| value >= low - margin && value <= high + margin;
        is_in(self.left, x, self.right) && is_in(self.top, y, self.bottom)
    }

    /// The part of the way from `a` to `b` that is inside, as shares of it (Liang and Barsky 1984).
    fn part(&self, a: Pixel, b: Pixel) -> Option<[f64; 2]> {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for (start, step, low, high) in
            [(a[0], b[0] - a[0], self.left, self.right), (a[1], b[1] - a[1], self.top, self.bottom)]
        {
            if step == 0.0 {
                if start < low || start > high {
                    return None;
                }
                continue;
            }
            let (enter, leave) = ((low - start) / step, (high - start) / step);
            from = from.max(enter.min(leave));
            to = to.min(enter.max(leave));
        }
        (from <= to).then_some([from, to])
    }
}

/// The pieces of a line that are inside. A single point that is inside is a piece of one point.
pub(super) fn polyline(points: &[Pixel], area: &Area) -> Vec<Vec<Pixel>> {
    if let [point] = points {
        return if area.holds(*point, 0.0) { vec![vec![*point]] } else { vec![] };
    }
    let mut pieces: Vec<Vec<Pixel>> = vec![];
    let mut is_open = false;
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let Some([from, to]) = area.part(a, b) else {
            is_open = false;
            continue;
        };
        let at = |t: f64| {
            if t == 0.0 {
                a
            } else if t == 1.0 {
                b
            } else {
                [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]
            }
        };
        match pieces.last_mut() {
            Some(piece) if is_open && from == 0.0 => piece.push(at(to)),
            _ => pieces.push(vec![at(from), at(to)]),
        }
        is_open = to == 1.0;
    }
    pieces
}

/// The part of a polygon that is inside: cut at one side after the other (Sutherland and Hodgman 1974).
pub(super) fn polygon(points: &[Pixel], area: &Area) -> Vec<Pixel> {
    let mut points = points.to_vec();
    for (axis, limit, sign) in [(0, area.left, 1.0), (0, area.right, -1.0), (1, area.top, 1.0), (1, area.bottom, -1.0)]
    {
        let depth = |point: &Pixel| (point[axis] - limit) * sign;
        let mut kept = Vec::with_capacity(points.len() + 4);
        for at in 0..points.len() {
            let (a, b) = (points[at], points[(at + 1) % points.len()]);
            let (depth_a, depth_b) = (depth(&a), depth(&b));
            if depth_a >= 0.0 {
                kept.push(a);
            }
            if (depth_a >= 0.0) != (depth_b >= 0.0) {
                let t = depth_a / (depth_a - depth_b);
                kept.push([a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]);
            }
        }
        points = kept;
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: Area = Area { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };

    #[test]
    fn a_line_that_leaves_and_returns_has_two_pieces() {
        let pieces = polyline(&[[5.0, 5.0], [5.0, 15.0], [7.0, 15.0], [7.0, 5.0], [8.0, 5.0]], &AREA);
        assert_eq!(pieces, [vec![[5.0, 5.0], [5.0, 10.0]], vec![[7.0, 10.0], [7.0, 5.0], [8.0, 5.0]]]);
        assert_eq!(polyline(&[[-5.0, 5.0], [15.0, 5.0]], &AREA), [[[0.0, 5.0], [10.0, 5.0]]]);
        assert!(polyline(&[[-5.0, -5.0], [15.0, -5.0]], &AREA).is_empty());
        assert!(polyline(&[], &AREA).is_empty());
    }

    #[test]
    fn a_polygon_around_the_area_becomes_the_area() {
        let inside = polygon(&[[-5.0, -5.0], [15.0, -5.0], [15.0, 15.0], [-5.0, 15.0]], &AREA);
        let doubled: f64 = (0..inside.len())
            .map(|at| (inside[at], inside[(at + 1) % inside.len()]))
            .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
            .sum();
        assert_eq!(doubled, 200.0);
        assert!(polygon(&[[11.0, 0.0], [12.0, 0.0], [12.0, 5.0]], &AREA).is_empty());
    }
}
