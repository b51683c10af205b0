//! A rectangle of values, and the operations on two-valued ones: distance, opening, parts.

mod bits;
mod parts;

use bits::Bits;
pub use parts::Parts;

/// Values row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    /// Values in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The values.
    pub cells: Vec<T>,
}

/// Stands for "no such cell near" in squared distances.
const FAR: f64 = 1e18;

impl<T: Copy> Grid<T> {
    /// The value at a column and row.
    pub fn at(&self, x: usize, y: usize) -> T {
        self.cells[y * self.width + x]
    }

    /// A grid of the same size with each value mapped.
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> Grid<U> {
        Grid { width: self.width, height: self.height, cells: self.cells.iter().map(|&c| f(c)).collect() }
    }
}

impl Grid<bool> {
    /// Number of true cells.
    pub fn area(&self) -> usize {
        self.cells.iter().filter(|&&c| c).count()
    }

    /// The same with `rim` false cells added on every side.
    pub fn padded(&self, rim: usize) -> Self {
        let (width, height) = (self.width + 2 * rim, self.height + 2 * rim);
        let mut cells = vec![false; width * height];
        for (y, row) in self.cells.chunks_exact(self.width).enumerate() {
            let start = (y + rim) * width + rim;
            cells[start..start + self.width].copy_from_slice(row);
        }
        Self { width, height, cells }
    }

    /// The same without `rim` cells on every side.
    pub fn trimmed(&self, rim: usize) -> Self {
        let (width, height) = (self.width - 2 * rim, self.height - 2 * rim);
        let mut cells = Vec::with_capacity(width * height);
        for y in rim..rim + height {
            cells.extend_from_slice(&self.cells[y * self.width + rim..y * self.width + rim + width]);
        }
        Self { width, height, cells }
    }

    /// Squared distance of each cell to the nearest true one (Felzenszwalb and Huttenlocher 2012: lower envelope of
    /// parabolas, first down the columns, then along the rows).
    pub fn squared_distances(&self) -> Grid<f64> {
        let mut field = self.map(|c| if c { 0.0 } else { FAR });
        let mut column = vec![0.0; self.height];
        for x in 0..self.width {
            for (y, value) in column.iter_mut().enumerate() {
                *value = field.cells[y * self.width + x];
            }
            for (y, value) in envelope(&column).into_iter().enumerate() {
                field.cells[y * self.width + x] = value;
            }
        }
        for row in field.cells.chunks_exact_mut(self.width) {
            let lowered = envelope(row);
            row.copy_from_slice(&lowered);
        }
        field
    }

    /// The cells whose centre lies within `radius` of a true cell's.
    pub fn dilated(&self, radius: f64) -> Self {
        Bits::of(self).dilated(radius).grid()
    }

    /// The cells farther than `radius` from every false one; what lies outside the grid is false.
    pub fn eroded(&self, radius: f64) -> Self {
        Bits::of(self).eroded(radius).grid()
    }

    /// Opening by a disc: what a disc of this radius can cover from within.
    pub fn opened(&self, radius: f64) -> Self {
        Bits::of(self).eroded(radius).dilated(radius).grid()
    }

    /// The cells for which `keep` holds of this value and that of another grid of the same size.
    pub fn joined(&self, other: &Self, keep: impl Fn(bool, bool) -> bool) -> Self {
        let cells = self.cells.iter().zip(&other.cells).map(|(&a, &b)| keep(a, b)).collect();
        Self { cells, ..*self }
    }

    /// The cells beside a cell.
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let (x, y, width, height) = (cell % self.width, cell / self.width, self.width, self.height);
        let left = (x > 0).then(|| cell - 1);
        let right = (x + 1 < width).then(|| cell + 1);
        let up = (y > 0).then(|| cell - width);
        let down = (y + 1 < height).then(|| cell + width);
        [left, right, up, down].into_iter().flatten()
    }

    /// The largest part (the first of equals); all false without one.
    pub fn largest_part(&self) -> Self {
        let parts = Parts::of(self);
        let largest = parts.largest();
        parts.only(|part| Some(part) == largest)
    }

    /// With the holes filled: false parts that do not reach the rim.
    pub fn filled(&self) -> Self {
        let parts = Parts::of(&self.padded(1).map(|c| !c));
        debug_assert!(parts.count() >= 1);
        parts.only(|part| part == 1).map(|outside| !outside).trimmed(1)
    }
}

/// True cells beside each other in a row, from column `start` to before column `end`.
#[derive(Clone, Copy)]
struct Run {
    row: usize,
    start: usize,
    end: usize,
}

/// Lower envelope of parabolas rooted at the cells of a line.
fn envelope(line: &[f64]) -> Vec<f64> {
    let meet = |p: usize, q: usize| {
        let (a, b) = (p as f64, q as f64);
        ((line[q] + b * b) - (line[p] + a * a)) / (2.0 * b - 2.0 * a)
    };
    let mut roots: Vec<(usize, f64)> = Vec::with_capacity(line.len());
    for (q, _) in line.iter().enumerate().filter(|(_, value)| **value < FAR) {
        while roots.last().is_some_and(|&(p, from)| meet(p, q) <= from) {
            roots.pop();
        }
        let from = roots.last().map_or(f64::NEG_INFINITY, |&(p, _)| meet(p, q));
        roots.push((q, from));
    }
    let mut rank = 0;
    (0..line.len())
        .map(|x| {
            while rank + 1 < roots.len() && roots[rank + 1].1 < x as f64 {
                rank += 1;
            }
            roots.get(rank).map_or(FAR, |&(p, _)| {
                let reach = x as f64 - p as f64;
                reach * reach + line[p]
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(rows: &[&str]) -> Grid<bool> {
        let cells = rows.iter().flat_map(|r| r.chars()).map(|c| c == '#').collect();
        Grid { width: rows[0].len(), height: rows.len(), cells }
    }

    #[test]
    fn distances_are_those_of_brute_force() {
        let grid = drawn(&["#....", ".....", "...#.", "....."]);
        let found = grid.squared_distances();
        for y in 0..4 {
            for x in 0..5 {
                let far = |cx: i32, cy: i32| f64::from((x - cx) * (x - cx) + (y - cy) * (y - cy));
                assert_eq!(found.at(x as usize, y as usize), far(0, 0).min(far(3, 2)));
            }
        }
    }

    /// Cells true with a chance of `share`, from a small linear generator.
    fn scattered(width: usize, height: usize, share: u32, seed: u32) -> Grid<bool> {
        let mut state = seed;
        let mut cell = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) % 100 < share
        };
        let cells = (0..width * height).map(|_| cell()).collect();
        Grid { width, height, cells }
    }

    #[test]
    fn dilation_agrees_with_distances() {
        for (width, height, seed) in [(1, 1, 1), (7, 1, 2), (1, 9, 3), (140, 31, 4), (33, 64, 5)] {
            let grid = scattered(width, height, 4, seed);
            let distances = grid.squared_distances();
            for radius in [0.0, 1.0, 1.5, 2.9, 6.0, 80.0] {
                assert_eq!(
                    grid.dilated(radius),
                    distances.map(|d| d <= radius * radius),
                    "{width} x {height}, {radius}"
                );
                let rim = radius as usize + 1;
                let from_false = grid.padded(rim).map(|c| !c).squared_distances().map(|d| d > radius * radius);
                assert_eq!(grid.eroded(radius), from_false.trimmed(rim));
            }
        }
    }

    #[test]
    fn parts_are_those_of_flooding() {
        for (width, height, seed) in [(1, 1, 7), (1, 20, 8), (20, 1, 9), (30, 40, 10), (61, 23, 11)] {
            let grid = scattered(width, height, 60, seed);
            let parts = Parts::of(&grid);
            let mut flooded = grid.map(|_| 0u32);
            let mut number = 0;
            for start in (0..grid.cells.len()).filter(|&i| grid.cells[i]) {
                if flooded.cells[start] == 0 {
                    number += 1;
                    let mut stack = vec![start];
                    while let Some(cell) = stack.pop() {
                        flooded.cells[cell] = number;
                        stack.extend(grid.neighbours(cell).filter(|&n| grid.cells[n] && flooded.cells[n] == 0));
                    }
                }
            }
            assert_eq!((parts.labels(), parts.count()), (flooded.clone(), number));
            assert_eq!(parts.areas.iter().sum::<usize>(), grid.cells.len());
            assert!((0..grid.cells.len()).all(|cell| parts.at(cell) == flooded.cells[cell]));
        }
    }

    #[test]
    fn holes_fill_and_the_largest_part_stays() {
        let grid = drawn(&["###..", "#.#.#", "###.."]);
        assert_eq!(grid.largest_part().area(), 8);
        assert_eq!(grid.largest_part().filled().area(), 9);
    }

    #[test]
    fn opening_takes_a_stalk_and_keeps_a_disc() {
        let disc = |x: i32, y: i32| (x - 30) * (x - 30) + (y - 20) * (y - 20) <= 225 || (x < 20 && (y - 20).abs() <= 1);
        let cells = (0..40).flat_map(|y| (0..50).map(move |x| disc(x, y))).collect();
        let grid = Grid { width: 50, height: 40, cells };
        let opened = grid.opened(5.0);
        assert!(!opened.at(5, 20) && opened.at(30, 6) && opened.at(44, 20));
    }
}
