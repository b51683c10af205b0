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
    for round in 0..ROUNDS {
        grid.fill(shoots, &lit, if round == 0 { 1.0 } else { 0.5 });
        let sky = grid.sky(depth);
        for (shoot, lit) in shoots.iter().zip(&mut lit) {
            let axis = shoot.segment.map_or(shoot.id, |number| axes[skeleton.segments[number as usize].axis as usize]);
            let needed = NEEDED + NEEDED_SPREAD * (f64::from(hash_unit(axis, 0x5AD)) - 0.5);
            *lit = sky[grid.cell(shoot.position)] >= needed;
        }
    }
    lit
}

/// The share of the sky that each shoot sees, 0 to 1, behind leaves of which `depth` a square metre dim light to 1/e; 1 for all
/// when `depth` is 0.
pub(super) fn light(shoots: &[Shoot], depth: f64) -> Vec<f64> {
    let grid = Grid::around(shoots).filter(|_| depth > 0.0);
    let Some(mut grid) = grid else { return vec![1.0; shoots.len()] };
    grid.fill(shoots, &vec![true; shoots.len()], 1.0);
    let sky = grid.sky(depth);
    shoots.iter().map(|shoot| sky[grid.cell(shoot.position)]).collect()
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
    fn fill(&mut self, shoots: &[Shoot], lit: &[bool], share: f64) {
        self.leaves.iter_mut().for_each(|leaves| *leaves *= 1.0 - share);
        for (shoot, _) in shoots.iter().zip(lit).filter(|(_, lit)| **lit) {
            let cell = self.cell(shoot.position);
            self.leaves[cell] += share * shoot.scale * shoot.scale;
        }
    }

    /// The share of the sky that each cell sees.
    fn sky(&self, depth: f64) -> Vec<f64> {
        let rays = rays();
        let total: f64 = rays.iter().map(|ray| ray.1).sum();
        let [width, _, breadth] = self.size;
        let seen = |cell: usize| {
            let (x, z, y) = (cell % width, cell / width % breadth, cell / width / breadth);
            let from = DVec3::new(x as f64, y as f64, z as f64) + DVec3::repeat(0.5);
            let through = |ray: &(DVec3, f64)| ray.1 * exp(-self.leaves_along(from, ray.0) / depth);
            rays.iter().map(through).sum::<f64>() / total
        };
        (0..self.leaves.len()).map(|cell| if self.leaves[cell] > 0.0 { seen(cell) } else { 1.0 }).collect()
    }

    /// Leaves a square metre that stand in the way from a place (in cells) to the sky.
    fn leaves_along(&self, from: DVec3, direction: DVec3) -> f64 {
        let mut sum = 0.0;
        let mut place = from + direction;
        loop {
            let inside = (0..3).all(|axis| place[axis] >= 0.0 && place[axis] < self.size[axis] as f64);
            if !inside {
                return sum / (self.cell * self.cell);
            }
            let [x, y, z] = [0, 1, 2].map(|axis| place[axis] as usize);
            sum += self.leaves[(y * self.size[2] + z) * self.size[0] + x];
            place += direction;
        }
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
