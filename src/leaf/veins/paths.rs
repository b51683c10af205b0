//! Ways of least cost over a grid, from a set of cells that may grow (Dijkstra 1959; costs are whole numbers, so that the
//! order of ties is the same everywhere). When cells join the set, only what gets nearer is worked over again.

use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;
use crate::leaf::raster::middle_of;

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
    /// The way from the origin to a cell; none without an origin.
    fn out(&self, cell: usize) -> DVec2 {
        self.from.map_or_else(DVec2::zeros, |from| middle_of(self.costs.width, cell) - from)
    }

    /// The largest cost of a step.
    fn dearest(&self) -> u32 {
        u32::from(self.costs.cells.iter().copied().max().unwrap_or(0)) * STEPS[1] * INWARDS
    }
}

impl Ways {
    /// No ways yet.
    pub fn new(cells: usize) -> Self {
        Self { costs: vec![NONE; cells], parents: vec![NONE; cells], gains: vec![0.0; cells] }
    }

    /// Adds cells to the set and shortens the ways that lead to them.
    pub fn add(&mut self, ground: &Ground, cells: &[u32]) {
        let mut queue = Queue::new(ground.dearest());
        for &cell in cells {
            let i = cell as usize;
            (self.costs[i], self.parents[i], self.gains[i]) = (0, NONE, 0.0);
            queue.push(0, cell);
        }
        while let Some((cost, cells)) = queue.pop() {
            for cell in cells {
                if cost == self.costs[cell as usize] {
                    self.relax(ground, cell, &mut queue);
                }
            }
        }
    }

    fn relax(&mut self, ground: &Ground, cell: u32, queue: &mut Queue) {
        let i = cell as usize;
        let out = ground.out(i);
        for (next, step_to) in neighbours(ground.costs.width, ground.costs.height, i) {
            let diagonal = step_to[0] != 0 && step_to[1] != 0;
            let outwards = u32::from(ground.costs.cells[next]) * STEPS[usize::from(diagonal)];
            let is_nearer = |ways: &Self, step: u32| ways.costs[i].saturating_add(step) < ways.costs[next];
            // a step towards the origin costs more still: most need not be looked at
            if outwards == 0 || !is_nearer(self, outwards) {
                continue;
            }
            let inwards = leads_back(out, step_to);
            let step = if inwards { outwards * INWARDS } else { outwards };
            if is_nearer(self, step) {
                let gain = ground.gains.cells[next].min(if inwards { 0.0 } else { f32::INFINITY });
                let length = if diagonal { std::f32::consts::SQRT_2 } else { 1.0 };
                self.costs[next] = self.costs[i].saturating_add(step);
                self.parents[next] = cell;
                self.gains[next] = self.gains[i] + gain * length;
                queue.push(self.costs[next], next as u32);
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

/// Cells in the order of their costs, those of equal cost in the order of their numbers. Costs of cells in the queue lie
/// less than a number of buckets apart, each of which holds the cells of one cost (Dial 1969).
struct Queue {
    buckets: Vec<Vec<u32>>,
    /// The lowest cost that may be there, and how many cells there are.
    cost: u32,
    count: usize,
}

impl Queue {
    /// An empty queue for steps of at most this cost.
    fn new(dearest: u32) -> Self {
        Self { buckets: vec![Vec::new(); dearest as usize + 1], cost: 0, count: 0 }
    }

    fn push(&mut self, cost: u32, cell: u32) {
        let place = cost as usize % self.buckets.len();
        self.buckets[place].push(cell);
        self.count += 1;
    }

    /// The cells of least cost.
    fn pop(&mut self) -> Option<(u32, Vec<u32>)> {
        if self.count == 0 {
            return None;
        }
        let mut place = self.cost as usize % self.buckets.len();
        while self.buckets[place].is_empty() {
            self.cost += 1;
            place = if place + 1 == self.buckets.len() { 0 } else { place + 1 };
        }
        let mut cells = std::mem::take(&mut self.buckets[place]);
        cells.sort_unstable();
        self.count -= cells.len();
        Some((self.cost, cells))
    }
}

/// Whether a step leads back towards the origin, by more than a tenth of its length.
fn leads_back(out: DVec2, step: [i8; 2]) -> bool {
    let step = DVec2::new(f64::from(step[0]), f64::from(step[1]));
    let ahead = step.dot(&out);
    ahead < 0.0 && ahead < -0.1 * (step.norm_squared() * out.norm_squared()).sqrt()
}

/// The up to eight cells round a cell, and the steps to them.
fn neighbours(width: usize, height: usize, cell: usize) -> impl Iterator<Item = (usize, [i8; 2])> {
    let (x, y) = (cell % width, cell / width);
    let (left, right, up, down) = (x > 0, x + 1 < width, y > 0, y + 1 < height);
    let (above, below) = (cell.wrapping_sub(width), cell + width);
    let around = [
        (up, above, [0, -1]),
        (left, cell.wrapping_sub(1), [-1, 0]),
        (right, cell + 1, [1, 0]),
        (down, below, [0, 1]),
        (up && left, above.wrapping_sub(1), [-1, -1]),
        (up && right, above.wrapping_add(1), [1, -1]),
        (down && left, below.wrapping_sub(1), [-1, 1]),
        (down && right, below + 1, [1, 1]),
    ];
    around.into_iter().filter(|(fits, ..)| *fits).map(|(_, next, step)| (next, step))
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
