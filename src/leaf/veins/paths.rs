//! Ways of least cost over a grid, from a set of cells that may grow (Dijkstra 1959; costs are whole numbers, so that the
//! order of ties is the same everywhere). When cells join the set, only what gets nearer is worked over again.

use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;
use crate::leaf::raster::middle_of;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// No cell.
pub const NONE: u32 = u32::MAX;
/// Lengths of a straight and of a diagonal step; their ratio is within 1 % of the square root of 2.
const STEPS: [u32; 2] = [5, 7];

/// For every cell the way to the set.
#[derive(Clone, Debug)]
pub struct Ways {
    /// Cost of the way; `NONE` where no way leads.
    pub costs: Vec<u32>,
    /// The next cell towards the set; `NONE` for the set's own cells and where no way leads.
    pub parents: Vec<u32>,
    /// What is gained along the way, added up in steps of one cell.
    pub gains: Vec<f32>,
}

/// What a step into each cell costs (0: it cannot be entered) and gains.
pub struct Ground<'a> {
    /// The place (cells) from which ways lead outwards: steps towards it cost more.
    pub from: Option<DVec2>,
    /// Cost of a cell, for one fifth of a cell's side.
    pub costs: &'a Grid<u16>,
    /// Gain of a cell, for a cell's side.
    pub gains: &'a Grid<f32>,
}

/// How much more a step towards the place of origin costs; nothing is gained by it either.
const INWARDS: u32 = 3;

impl Ground<'_> {
    /// Whether a step leads back towards the origin, by more than a tenth of its length.
    fn leads_back(&self, cell: usize, next: usize) -> bool {
        self.from.is_some_and(|from| {
            let (here, there) = (middle_of(self.costs.width, cell), middle_of(self.costs.width, next));
            let (step, out) = (there - here, here - from);
            step.dot(&out) < -0.1 * (step.norm_squared() * out.norm_squared()).sqrt()
        })
    }
}

impl Ways {
    /// No ways yet.
    pub fn new(cells: usize) -> Self {
        Self { costs: vec![NONE; cells], parents: vec![NONE; cells], gains: vec![0.0; cells] }
    }

    /// Adds cells to the set and shortens the ways that lead to them.
    pub fn add(&mut self, ground: &Ground, cells: &[u32]) {
        let mut heap = BinaryHeap::new();
        for &cell in cells {
            let i = cell as usize;
            (self.costs[i], self.parents[i], self.gains[i]) = (0, NONE, 0.0);
            heap.push(Reverse((0u32, cell)));
        }
        while let Some(Reverse((cost, cell))) = heap.pop() {
            if cost == self.costs[cell as usize] {
                self.relax(ground, cell, &mut heap);
            }
        }
    }

    fn relax(&mut self, ground: &Ground, cell: u32, heap: &mut BinaryHeap<Reverse<(u32, u32)>>) {
        for (next, diagonal) in neighbours(ground.costs.width, ground.costs.height, cell as usize) {
            let inwards = ground.leads_back(cell as usize, next);
            let step =
                u32::from(ground.costs.cells[next]) * STEPS[usize::from(diagonal)] * if inwards { INWARDS } else { 1 };
            let cost = self.costs[cell as usize].saturating_add(step);
            if step > 0 && cost < self.costs[next] {
                let gain = ground.gains.cells[next].min(if inwards { 0.0 } else { f32::INFINITY });
                let length = if diagonal { std::f32::consts::SQRT_2 } else { 1.0 };
                self.costs[next] = cost;
                self.parents[next] = cell;
                self.gains[next] = self.gains[cell as usize] + gain * length;
                heap.push(Reverse((cost, next as u32)));
            }
        }
    }

    /// The way from a cell to the set, both ends included, turned round: the set's cell first.
    pub fn way(&self, end: u32) -> Vec<u32> {
        let mut way = vec![end];
        while let Some(&parent) = way.last().map(|&c| &self.parents[c as usize]).filter(|p| **p != NONE) {
            way.push(parent);
        }
        way.reverse();
        way
    }
}

/// The up to eight cells round a cell, and whether they lie diagonally.
fn neighbours(width: usize, height: usize, cell: usize) -> impl Iterator<Item = (usize, bool)> {
    let (x, y) = ((cell % width) as i64, (cell / width) as i64);
    const AROUND: [(i64, i64); 8] = [(0, -1), (-1, 0), (1, 0), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
    AROUND.into_iter().filter_map(move |(dx, dy)| {
        let (x, y) = (x + dx, y + dy);
        let fits = x >= 0 && y >= 0 && x < width as i64 && y < height as i64;
        fits.then(|| (y as usize * width + x as usize, dx != 0 && dy != 0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(width: usize, height: usize) -> (Grid<u16>, Grid<f32>) {
        let cells = width * height;
        (Grid { width, height, cells: vec![10; cells] }, Grid { width, height, cells: vec![1.0; cells] })
    }

    #[test]
    fn on_even_ground_ways_are_straight() {
        let (costs, gains) = even(9, 5);
        let ground = Ground { from: None, costs: &costs, gains: &gains };
        let mut ways = Ways::new(45);
        ways.add(&ground, &[18]);
        assert_eq!(ways.costs[26], 8 * 50);
        assert_eq!(ways.way(26), (18..27).collect::<Vec<u32>>());
        assert!((ways.gains[26] - 8.0).abs() < 1e-6);
    }

    #[test]
    fn a_grown_set_gives_the_ways_of_one_that_was_whole_from_the_start() {
        let (mut costs, gains) = even(23, 17);
        for (i, cost) in costs.cells.iter_mut().enumerate() {
            *cost = (i * 7919 % 31) as u16;
        }
        let ground = Ground { from: None, costs: &costs, gains: &gains };
        let (mut grown, mut whole) = (Ways::new(391), Ways::new(391));
        for cell in [5, 200, 390, 37] {
            grown.add(&ground, &[cell]);
        }
        whole.add(&ground, &[5, 37, 200, 390]);
        assert_eq!(grown.costs, whole.costs);
    }

    #[test]
    fn walls_are_not_crossed() {
        let (mut costs, gains) = even(5, 3);
        for y in 0..3 {
            costs.cells[y * 5 + 2] = 0;
        }
        let mut ways = Ways::new(15);
        ways.add(&Ground { from: None, costs: &costs, gains: &gains }, &[5]);
        assert_eq!((ways.costs[9], ways.parents[9]), (NONE, NONE));
    }
}
