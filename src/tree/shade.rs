//! Shedding of shaded shoots. A shoot that sees too little sky through the other leaves loses its leaves, and wood that bears
//! no leaf any more is shed, so that the crown is hollow, the bole clear and gaps are where light falls.
//!
//! Light is counted in a grid of leaf density as in Palubicki et al., "Self-organizing tree models for image synthesis"
//! (2009), but along rays to the sky instead of a pyramid below each bud. Not a radiosity: leaves only block.

use super::skeleton::{Shoot, Skeleton};
use crate::base::maths::{cos, exp, sin};
use crate::base::random::hash_unit;
use crate::base::vector::DVec3;

/// Side of the grid's cells, metres.
const CELL: f64 = 0.3;
/// Cells along the grid's longest side at most; larger trees get larger cells.
const CELLS_LIMIT: f64 = 64.0;
/// Rounds of shading and shedding; the third hardly changes anything.
const ROUNDS: usize = 3;
/// Share of open sky that a shoot needs, and its spread between shoots.
const NEEDED: f64 = 0.3;
const NEEDED_SPREAD: f64 = 0.14;

/// Zenith angles of the rays (degrees), how many of each, and their weight, that of a cloudy sky on a level leaf.
const RINGS: [(f64, u32, f64); 3] = [(0.0, 1, 1.0), (32.0, 6, 0.85), (62.0, 8, 0.6)];

/// Which leaves stay, given that light falls to 1/e behind `depth` leaves a square metre.
pub(super) fn lit(shoots: &[Shoot], skeleton: &Skeleton, depth: f64) -> Vec<bool> {
    let mut lit = vec![true; shoots.len()];
    let Some(mut grid) = Grid::around(shoots) else { return lit };
    let axes = axis_ids(skeleton);
    let needed = |shoot: &Shoot| {
        let axis = shoot.segment.map_or(shoot.id, |number| axes[skeleton.segments[number as usize].axis as usize]);
        NEEDED + NEEDED_SPREAD * (f64::from(hash_unit(axis, 0x5AD)) - 0.5)
    };
    let leaf = |shoot: &Shoot| Leaf {
        cell: grid.cell(shoot.position),
        area: shoot.scale * shoot.scale,
        needed: needed(shoot),
    };
    let leaves: Vec<Leaf> = shoots.iter().map(leaf).collect();
    for round in 0..ROUNDS {
        grid.fill(&leaves, &lit, if round == 0 { 1.0 } else { 0.5 });
        let sky = grid.sky(depth);
        for (leaf, lit) in leaves.iter().zip(&mut lit) {
            *lit = sky[leaf.cell] >= leaf.needed;
        }
    }
    lit
}

/// The share of the sky that each shoot sees, 0 to 1, behind leaves of which `depth` a square metre dim light to 1/e; 1 for all
/// when `depth` is 0.
pub(super) fn light(shoots: &[Shoot], depth: f64) -> Vec<f64> {
    let grid = Grid::around(shoots).filter(|_| depth > 0.0);
    let Some(mut grid) = grid else { return vec![1.0; shoots.len()] };
    let leaf = |shoot: &Shoot| Leaf { cell: grid.cell(shoot.position), area: shoot.scale * shoot.scale, needed: 0.0 };
    let leaves: Vec<Leaf> = shoots.iter().map(leaf).collect();
    grid.fill(&leaves, &vec![true; leaves.len()], 1.0);
    let sky = grid.sky(depth);
    leaves.iter().map(|leaf| sky[leaf.cell]).collect()
}

/// What shading knows of a leaf.
struct Leaf {
    /// The grid's cell it stands in.
    cell: usize,
    /// Its area, in mean leaves.
    area: f64,
    /// Share of open sky without which it falls.
    needed: f64,
}

/// The stable id of each axis: that of its first segment.
fn axis_ids(skeleton: &Skeleton) -> Vec<u64> {
    let mut ids = Vec::new();
    for segment in &skeleton.segments {
        if segment.axis as usize == ids.len() {
            ids.push(segment.id);
        }
    }
    ids
}

/// Marks the segments that bear a leaf or carry one that does.
pub(super) fn alive(skeleton: &Skeleton, shoots: &[Shoot], lit: &[bool]) -> Vec<bool> {
    let mut alive = vec![false; skeleton.segments.len()];
    for (shoot, _) in shoots.iter().zip(lit).filter(|(_, lit)| **lit) {
        if let Some(number) = shoot.segment {
            alive[number as usize] = true;
        }
    }
    for number in (0..alive.len()).rev() {
        if let (true, Some(parent)) = (alive[number], skeleton.segments[number].parent) {
            alive[parent as usize] = true;
        }
    }
    alive
}

struct Grid {
    origin: DVec3,
    cell: f64,
    size: [usize; 3],
    /// Leaves in each cell.
    leaves: Vec<f64>,
}

impl Grid {
    fn around(shoots: &[Shoot]) -> Option<Self> {
        let first = shoots.first()?.position;
        let (low, high) = shoots.iter().fold((first, first), |(l, h), s| (l.inf(&s.position), h.sup(&s.position)));
        let cell = CELL.max((high - low).max() / CELLS_LIMIT);
        let size = [0, 1, 2].map(|axis| ((high[axis] - low[axis]) / cell) as usize + 1);
        Some(Self { origin: low, cell, size, leaves: vec![0.0; size.iter().product()] })
    }

    fn cell(&self, position: DVec3) -> usize {
        let at = |axis: usize| (((position[axis] - self.origin[axis]) / self.cell) as usize).min(self.size[axis] - 1);
        (at(1) * self.size[2] + at(2)) * self.size[0] + at(0)
    }

    /// Mixes the leaves that are lit into the counts, `share` new to 1 - `share` old.
    fn fill(&mut self, leaves: &[Leaf], lit: &[bool], share: f64) {
        self.leaves.iter_mut().for_each(|leaves| *leaves *= 1.0 - share);
        for (leaf, _) in leaves.iter().zip(lit).filter(|(_, lit)| **lit) {
            self.leaves[leaf.cell] += share * leaf.area;
        }
    }

    /// The share of the sky that each cell with leaves sees; 1 for the others, which nobody asks. A leaf stands behind all
    /// leaves of its own cell too: shoots that crowd shade each other most, and where they are thinned the rest stand evenly.
    fn sky(&self, depth: f64) -> Vec<f64> {
        let rays: Vec<Ray> = rays().iter().map(|&(direction, weight)| Ray::new(direction, weight, self.size)).collect();
        let total: f64 = rays.iter().map(|ray| ray.weight).sum();
        let [width, _, breadth] = self.size;
        let seen = |cell: usize| {
            let place = [cell % width, cell / width / breadth, cell / width % breadth];
            let through = |ray: &Ray| {
                let leaves = ray
                    .cells_from(place)
                    .iter()
                    .fold(self.leaves[cell], |sum, step| sum + self.leaves[cell.wrapping_add(*step)]);
                ray.weight * exp(-(leaves / (self.cell * self.cell)) / depth)
            };
            rays.iter().map(through).sum::<f64>() / total
        };
        (0..self.leaves.len()).map(|cell| if self.leaves[cell] > 0.0 { seen(cell) } else { 1.0 }).collect()
    }
}

/// A ray from the middle of any cell to the sky, by the cells that it meets at whole steps of a cell's side. They are the same
/// from every cell, but for where the grid ends.
struct Ray {
    weight: f64,
    /// How far each step's cell stands from the first in the grid's order (modulo 2^64).
    steps: Vec<usize>,
    /// For each axis: how many steps stay inside from each place on it.
    inside: [Vec<usize>; 3],
}

impl Ray {
    fn new(direction: DVec3, weight: f64, size: [usize; 3]) -> Self {
        // A unit step goes at least 1 in the sum of the axes, so no ray takes more steps than that.
        let longest = size.iter().sum();
        let offset = |axis: usize, step: usize| (0.5 + direction[axis] * step as f64).floor() as isize;
        let stays = |axis: usize, from: usize, step: usize| {
            from.checked_add_signed(offset(axis, step)).is_some_and(|place| place < size[axis])
        };
        let reach = |axis: usize, from: usize| (1..=longest).take_while(|&step| stays(axis, from, step)).count();
        let inside = [0, 1, 2].map(|axis| (0..size[axis]).map(|from| reach(axis, from)).collect());
        let [width, _, breadth] = size.map(|count| count as isize);
        let order = |step| (offset(1, step) * breadth + offset(2, step)) * width + offset(0, step);
        Self { weight, steps: (1..=longest).map(|step| order(step) as usize).collect(), inside }
    }

    /// The steps from a cell (x, y, z) to the grid's end.
    fn cells_from(&self, place: [usize; 3]) -> &[usize] {
        let count = (0..3).map(|axis| self.inside[axis][place[axis]]).fold(self.steps.len(), usize::min);
        &self.steps[..count]
    }
}

/// Directions to the sky with their weights.
fn rays() -> Vec<(DVec3, f64)> {
    let mut rays = Vec::new();
    for (zenith, count, weight) in RINGS {
        let zenith = zenith.to_radians();
        for number in 0..count {
            let azimuth = std::f64::consts::TAU * (f64::from(number) + 0.25) / f64::from(count);
            let direction = DVec3::new(sin(zenith) * cos(azimuth), cos(zenith), sin(zenith) * sin(azimuth));
            rays.push((direction, weight));
        }
    }
    rays
}
