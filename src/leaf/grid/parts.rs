//! Connected parts of the true cells of a grid. Runs along the rows are joined to those that they touch in the row above.

use super::bits::Bits;
use super::{Grid, Run};
use std::cmp::Reverse;

/// The connected parts (4 neighbours), numbered from 1 in the order of their first cells.
pub struct Parts {
    width: usize,
    height: usize,
    runs: Vec<Run>,
    /// The part of each run.
    numbers: Vec<u32>,
    /// Cells of each part; those in none for part 0.
    pub areas: Vec<usize>,
}

impl Parts {
    /// The parts of a grid's true cells.
    pub fn of(grid: &Grid<bool>) -> Self {
        let runs = Bits::of(grid).runs();
        let roots = joined_runs(&runs);
        let mut numbers = vec![0u32; runs.len()];
        let mut areas = vec![grid.cells.len()];
        for (rank, run) in runs.iter().enumerate() {
            // a root is the first run of its part
            if roots[rank] == rank {
                numbers[rank] = areas.len() as u32;
                areas.push(0);
            }
            numbers[rank] = numbers[roots[rank]];
            areas[numbers[rank] as usize] += run.end - run.start;
            areas[0] -= run.end - run.start;
        }
        Self { width: grid.width, height: grid.height, runs, numbers, areas }
    }

    /// Number of parts.
    pub fn count(&self) -> u32 {
        self.areas.len() as u32 - 1
    }

    /// Number of the part of each cell, 0 elsewhere.
    pub fn labels(&self) -> Grid<u32> {
        self.drawn(|number| number)
    }

    /// The cells of the parts that are wanted.
    pub fn only(&self, is_wanted: impl Fn(u32) -> bool) -> Grid<bool> {
        self.drawn(is_wanted)
    }

    /// The largest part, the first of equals.
    pub fn largest(&self) -> Option<u32> {
        (1..=self.count()).max_by_key(|&part| (self.areas[part as usize], Reverse(part)))
    }

    /// The part of a cell; 0 of none.
    pub fn at(&self, cell: usize) -> u32 {
        let (x, row) = (cell % self.width, cell / self.width);
        let rank = self.runs.partition_point(|run| (run.row, run.end) <= (row, x));
        let run = self.runs.get(rank).filter(|run| run.row == row && run.start <= x);
        run.map_or(0, |_| self.numbers[rank])
    }

    /// The cells of all parts, row by row, with the numbers of their parts.
    pub fn cells(&self) -> impl Iterator<Item = (usize, u32)> + '_ {
        let cells = |(run, &number): (&Run, &u32)| {
            let start = run.row * self.width;
            (start + run.start..start + run.end).map(move |cell| (cell, number))
        };
        self.runs.iter().zip(&self.numbers).flat_map(cells)
    }

    /// The cells of each part with the value of its number, all others with the default.
    fn drawn<T: Copy + Default>(&self, value: impl Fn(u32) -> T) -> Grid<T> {
        let mut cells = vec![T::default(); self.width * self.height];
        for (run, &number) in self.runs.iter().zip(&self.numbers) {
            let start = run.row * self.width;
            cells[start + run.start..start + run.end].fill(value(number));
        }
        Grid { width: self.width, height: self.height, cells }
    }
}

/// For each run the first run of its part: union-find whose roots are the smaller numbers.
fn joined_runs(runs: &[Run]) -> Vec<usize> {
    let mut roots: Vec<usize> = (0..runs.len()).collect();
    let mut above = 0;
    for (rank, run) in runs.iter().enumerate() {
        let before = |other: &Run| other.row + 1 < run.row || (other.row + 1 == run.row && other.end <= run.start);
        while above < rank && before(&runs[above]) {
            above += 1;
        }
        let beside = |other: &Run| other.row + 1 == run.row && other.start < run.end;
        for other in (above..rank).take_while(|&other| beside(&runs[other])) {
            let (a, b) = (root(&mut roots, rank), root(&mut roots, other));
            roots[a.max(b)] = a.min(b);
        }
    }
    (0..roots.len()).map(|rank| root(&mut roots, rank)).collect()
}

/// The root of a run; the path to it is halved on the way.
fn root(roots: &mut [usize], mut rank: usize) -> usize {
    while roots[rank] != rank {
        roots[rank] = roots[roots[rank]];
        rank = roots[rank];
    }
    rank
}
