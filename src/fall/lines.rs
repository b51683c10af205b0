//! Vertical lines on a grid through a mesh.

use crate::base::vector::{DVec2, DVec3};

/// Steepest slope that is told: steeper surfaces have next to no extent on the ground.
const STEEPEST: f64 = 1.5;
/// Distance from which two surfaces on a line are told apart, metres.
const APART: f64 = 3e-4;

/// Where a line meets a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    /// Metres.
    pub height: f64,
    /// How the mesh rises there along x and z.
    pub slope: DVec2,
}

/// A line with the lowest and the highest of the points in which it meets the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// Along x and z, metres.
    pub place: DVec2,
    pub low: End,
    pub high: End,
}

/// The lines of a grid that meet a mesh.
pub(super) struct Lines {
    /// Distance of neighbours, metres.
    pub step: f64,
    pub lines: Vec<Line>,
}

impl Lines {
    /// Lines `step` metres apart, or farther, such that there are at most `most` along a side.
    pub(super) fn new(points: &[DVec3], triangles: &[[u32; 3]], step: f64, most: f64) -> Self {
        let flat = |p: &DVec3| DVec2::new(p.x, p.z);
        let Some(first) = points.first().map(flat) else { return Self { step, lines: Vec::new() } };
        let (low, high) = points.iter().map(flat).fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
        let step = step.max((high - low).max() / most);
        let [columns, rows] = [(high.x - low.x) / step, (high.y - low.y) / step].map(|count| count as usize + 1);
        // A grid about the middle of the box, so that thin blades have a line along their midrib.
        let origin = (low + high) * 0.5 - DVec2::new((columns - 1) as f64, (rows - 1) as f64) * (0.5 * step);
        let mut grid: Vec<Option<[End; 2]>> = vec![None; columns * rows];
        for triangle in triangles {
            let corners = triangle.map(|v| points[v as usize]);
            met(corners, (origin, step), [columns, rows], |cell, end| {
                let [low, high] = grid[cell].get_or_insert([end; 2]);
                if end.height < low.height {
                    *low = end;
                }
                if end.height > high.height {
                    *high = end;
                }
            });
        }
        let line = |(number, ends): (usize, &Option<[End; 2]>)| {
            let place = origin + DVec2::new((number % columns) as f64, (number / columns) as f64) * step;
            ends.map(|[low, high]| Line { place, low, high })
        };
        Self { step, lines: grid.iter().enumerate().filter_map(line).collect() }
    }

    /// The ends of all lines; one of each line where both are close.
    pub(super) fn ends(&self) -> impl Iterator<Item = (DVec2, End)> {
        let of = |line: &Line| {
            let high = (line.high.height - line.low.height > APART).then_some((line.place, line.high));
            std::iter::once((line.place, line.low)).chain(high)
        };
        self.lines.iter().flat_map(of)
    }
}

/// Visits the grid's places below a triangle.
fn met(
    corners: [DVec3; 3],
    (origin, step): (DVec2, f64),
    [columns, rows]: [usize; 2],
    mut visit: impl FnMut(usize, End),
) {
    let [a, b, c] = corners.map(|p| (DVec2::new(p.x, p.z) - origin) / step);
    let (u, v) = (b - a, c - a);
    let area = u.perp(&v);
    if area.abs() < 1e-12 {
        return;
    }
    let [rise_u, rise_v] = [corners[1].y - corners[0].y, corners[2].y - corners[0].y];
    let slope = DVec2::new(rise_u * v.y - rise_v * u.y, rise_v * u.x - rise_u * v.x) / (area * step);
    let slope = slope * (STEEPEST / slope.norm().max(STEEPEST));
    let (from, to) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
    let range = |from: f64, to: f64, count: usize| {
        (from.ceil().max(0.0) as usize)..((to.floor() + 1.0).clamp(0.0, count as f64) as usize)
    };
    for row in range(from.y, to.y, rows) {
        for column in range(from.x, to.x, columns) {
            let at = DVec2::new(column as f64, row as f64) - a;
            let (s, t) = (at.perp(&v) / area, u.perp(&at) / area);
            if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
                visit(row * columns + column, End { height: corners[0].y + s * rise_u + t * rise_v, slope });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_meet_both_sheets_of_a_fold_at_their_heights_and_slopes() {
        let sheet = |x: f64, z: f64, fold: f64| DVec3::new(x, 0.02 + fold + 0.3 * x - 0.2 * z, z);
        let corners = [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1)];
        let points: Vec<DVec3> = [0.0, 0.01].iter().flat_map(|&f| corners.map(|(x, z)| sheet(x, z, f))).collect();
        let found = Lines::new(&points, &[[0, 1, 2], [3, 4, 5]], 0.005, 100.0);
        assert!((found.lines.len() as f64 * 0.005 * 0.005 / 0.005 - 1.0).abs() < 0.2);
        for line in &found.lines {
            for (end, fold) in [(line.low, 0.0), (line.high, 0.01)] {
                assert!((end.height - sheet(line.place.x, line.place.y, fold).y).abs() < 1e-9);
                assert!((end.slope - DVec2::new(0.3, -0.2)).norm() < 1e-9);
            }
        }
        assert_eq!(found.ends().count(), 2 * found.lines.len());
    }
}
