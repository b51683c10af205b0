//! The height of uneven ground.

use crate::base::vector::{DVec2, DVec3};

/// Distance of nodes that smoothed heights are brought to, metres, and most nodes along a side: litter is laid and the ground is
/// drawn on them.
const FINE: f64 = 0.25;
const MOST_NODES: usize = 512;
/// Nodes at height 0 about given heights, so that smoothed ones come to the level around them without a kink.
const LEVEL: usize = 2;

/// Heights at the nodes of a grid, bilinear between them, the rim's beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// The node with the smallest x and z, metres.
    pub origin: DVec2,
    /// Distance of nodes, metres.
    pub step: f64,
    /// Nodes along x.
    pub columns: usize,
    /// Heights row by row (rows along z), metres.
    pub heights: Vec<f64>,
}

impl HeightMap {
    /// Heights given row by row (rows along z, each along x), `step` metres apart about the origin, made smooth by Catmull and Rom's
    /// cubic (1974) between them and level at 0 beyond. None for no heights.
    #[must_use]
    pub fn smoothed(rows: &[Vec<f64>], step: f64) -> Option<Self> {
        let counts = [rows.first()?.len(), rows.len()];
        let parts = counts.map(|count| MOST_NODES / (count + 2 * LEVEL)).into_iter().min()?;
        let parts = ((step / FINE).ceil() as usize).clamp(1, parts.max(1));
        let nodes = counts.map(|count| (count + 2 * LEVEL - 1) * parts + 1);
        let given = |row: isize, column: isize| {
            let at = |index: isize| usize::try_from(index).ok();
            at(row).and_then(|row| rows.get(row)).and_then(|row| row.get(at(column)?)).copied().unwrap_or(0.0)
        };
        let cell = |node: usize| ((node / parts) as isize - LEVEL as isize, (node % parts) as f64 / parts as f64);
        let height = |number: usize| {
            let ((row, down), (column, along)) = (cell(number / nodes[0]), cell(number % nodes[0]));
            let line = |row: isize| cubic([-1, 0, 1, 2].map(|k| given(row, column + k)), along);
            cubic([-1, 0, 1, 2].map(|k| line(row + k)), down)
        };
        let first = |count: usize| -step * (0.5 * (count as f64 - 1.0) + LEVEL as f64);
        Some(Self {
            origin: DVec2::new(first(counts[0]), first(counts[1])),
            step: step / parts as f64,
            columns: nodes[0],
            heights: (0..nodes[0] * nodes[1]).map(height).collect(),
        })
    }

    /// The unit normal of the ground at a place (x, z).
    #[must_use]
    pub fn normal(&self, place: DVec2) -> DVec3 {
        let slope = |aside: DVec2| (self.at(place + aside) - self.at(place - aside)) / (2.0 * self.step);
        let (x, z) = (slope(DVec2::new(self.step, 0.0)), slope(DVec2::new(0.0, self.step)));
        DVec3::new(-x, 1.0, -z).normalize()
    }

    /// Height at a place (x, z), metres.
    #[must_use]
    pub fn at(&self, place: DVec2) -> f64 {
        let rows = self.heights.len() / self.columns.max(1);
        if rows == 0 {
            return 0.0;
        }
        let across = self.between(place.x - self.origin.x, self.columns);
        let (near, share) = self.between(place.y - self.origin.y, rows);
        let line = |row: usize| self.along(&self.heights[row * self.columns..][..self.columns], across);
        let near = near as usize;
        line(near) * (1.0 - share) + line((near + 1).min(rows - 1)) * share
    }

    /// The nodes of `count` along an axis about a place, metres from the first.
    fn between(&self, at: f64, count: usize) -> Between {
        let at = (at / self.step).clamp(0.0, (count - 1) as f64);
        let node = (at as u32).min(count.saturating_sub(2) as u32);
        (node, at - f64::from(node))
    }

    /// The height between nodes of a row.
    fn along(&self, row: &[f64], (left, share): Between) -> f64 {
        let left = left as usize;
        row[left] * (1.0 - share) + row[(left + 1).min(self.columns - 1)] * share
    }

    /// A bound of the slope within the squares between these columns and rows of nodes and beside them, metres a metre.
    fn steepest(&self, columns: [usize; 2], rows: [usize; 2]) -> f64 {
        let beside = |[low, high]: [usize; 2], count: usize| [low.saturating_sub(1), (high + 2).min(count - 1)];
        let (columns, rows) = (beside(columns, self.columns), beside(rows, self.heights.len() / self.columns.max(1)));
        let height = |row: usize, column: usize| self.heights[row * self.columns + column];
        let (mut along, mut across) = (0.0f64, 0.0f64);
        for row in rows[0]..=rows[1] {
            for column in columns[0]..=columns[1] {
                if column < columns[1] {
                    along = along.max((height(row, column + 1) - height(row, column)).abs());
                }
                if row < rows[1] {
                    across = across.max((height(row + 1, column) - height(row, column)).abs());
                }
            }
        }
        (along * along + across * across).sqrt() / self.step
    }
}

/// Nodes along one axis about even places: the first of the two about each place, and the share of the way to the second.
type Between = (u32, f64);

/// The heights below the cells of a lattice: `HeightMap::at` of their middles, to the bit, and quick to look up.
#[derive(Clone, Debug, Default)]
pub(super) struct Floor {
    /// The heights of rows of nodes above every column of cells, metres: one row of nodes after another.
    lines: Vec<f64>,
    /// The nodes about each column of cells.
    across: Vec<Between>,
    /// For each row of cells the rows of nodes about it, as places in `lines`, and the share between them.
    rows: Vec<(u32, u32, f64)>,
    /// Steepest slope of the ground below, metres a metre.
    pub steepest: f64,
}

impl Floor {
    /// Takes up the ground of a map below columns and rows of cells with these middles, metres.
    pub(super) fn lay(&mut self, map: &HeightMap, x: impl Iterator<Item = f64>, z: impl Iterator<Item = f64>) {
        self.lines.clear();
        self.rows.clear();
        let count = map.heights.len() / map.columns.max(1);
        if count == 0 {
            return;
        }
        self.across.clear();
        self.across.extend(x.map(|x| map.between(x - map.origin.x, map.columns)));
        let mut nodes: Option<[usize; 2]> = None;
        for z in z {
            let (near, share) = map.between(z - map.origin.y, count);
            let (near, far) = (near as usize, (near as usize + 1).min(count - 1));
            let [first, last] = nodes.unwrap_or([near, near.wrapping_sub(1)]);
            for row in last.wrapping_add(1)..=far {
                let line = &map.heights[row * map.columns..][..map.columns];
                self.lines.extend(self.across.iter().map(|&place| map.along(line, place)));
            }
            nodes = Some([first, far]);
            let start = |row: usize| ((row - first) * self.across.len()) as u32;
            self.rows.push((start(near), start(far), share));
        }
        let ends = [self.across.first(), self.across.last()].map(|end| end.map_or(0, |(node, _)| *node as usize));
        self.steepest = map.steepest(ends, nodes.unwrap_or_default());
    }

    /// The height below a cell, metres.
    #[inline]
    pub(super) fn at(&self, column: usize, row: usize) -> f32 {
        let Some(&(near, far, share)) = self.rows.get(row) else { return 0.0 };
        let line = |start: u32| self.lines.get(start as usize + column).copied().unwrap_or(0.0);
        (line(near) * (1.0 - share) + line(far) * share) as f32
    }
}

/// The curve through the middle two of four even points, at a share of the way between them.
fn cubic([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    let (bend, sway) = (2.0 * a - 5.0 * b + 4.0 * c - d, 3.0 * (b - c) + d - a);
    b + 0.5 * t * (c - a + t * (bend + t * sway))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_height_map_is_bilinear_and_goes_on_beyond_its_rim() {
        let map = HeightMap { origin: DVec2::zeros(), step: 2.0, columns: 2, heights: vec![0.0, 1.0, 2.0, 3.0] };
        assert_eq!(map.at(DVec2::new(1.0, 1.0)), 1.5);
        assert_eq!((map.at(DVec2::new(-9.0, 0.0)), map.at(DVec2::new(9.0, 9.0))), (0.0, 3.0));
    }

    #[test]
    fn smoothed_heights_pass_through_the_given_ones_and_end_level() {
        let rows = vec![vec![0.3, 1.0, -0.2], vec![0.8, 2.0, 0.1]];
        let map = HeightMap::smoothed(&rows, 3.0).unwrap();
        for (row, column) in (0..2).flat_map(|row| (0..3).map(move |column| (row, column))) {
            let place = DVec2::new(3.0 * (column as f64 - 1.0), 3.0 * (row as f64 - 0.5));
            assert!((map.at(place) - rows[row][column]).abs() < 1e-12, "{place:?}");
        }
        for place in [DVec2::new(9.0, 0.0), DVec2::new(0.0, -7.5), DVec2::new(50.0, -70.0)] {
            assert!(map.at(place).abs() < 1e-12 && (map.normal(place) - DVec3::y()).norm() < 0.02, "{place:?}");
        }
        assert_eq!(map.normal(DVec2::new(90.0, 0.0)), DVec3::y());
        assert!(HeightMap::smoothed(&[], 3.0).is_none());
    }

    #[test]
    fn a_plane_stays_a_plane_inside_and_its_normal_is_known() {
        let rows: Vec<Vec<f64>> =
            (0..8).map(|row| (0..9).map(|x| 0.2 * f64::from(x) - 0.1 * f64::from(row)).collect()).collect();
        let map = HeightMap::smoothed(&rows, 2.0).unwrap();
        let expected = DVec3::new(-0.1, 1.0, 0.05).normalize();
        for place in [DVec2::new(0.0, 0.0), DVec2::new(1.3, -2.7), DVec2::new(-3.1, 2.2)] {
            assert!((map.at(place) - (0.1 * place.x - 0.05 * place.y + 0.45)).abs() < 1e-12, "{place:?}");
            assert!((map.normal(place) - expected).norm() < 1e-12);
        }
    }

    #[test]
    fn large_maps_keep_to_the_nodes_that_are_allowed() {
        let map = HeightMap::smoothed(&vec![vec![1.0; 300]; 4], 10.0).unwrap();
        assert!(map.columns <= MOST_NODES && map.heights.len() / map.columns <= MOST_NODES);
    }
}
