//! What of the factorisation depends on the couplings alone, done once per blade: the order of elimination and, for each
//! piece of the dissection, its front: the vertices eliminated in it and the later ones that these reach.

use super::dense::{TILE, padded, triangle_start};
use super::ordering::{Graph, dissected};
use crate::base::vector::DVec2;

/// A dense part of the factor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Front {
    /// Elimination numbers of the vertices eliminated here, consecutive.
    pub own: std::ops::Range<u32>,
    /// Later vertices reached, by elimination number, ascending.
    pub boundary: Vec<u32>,
    /// Fronts (by number) whose updates are taken in here.
    pub children: Vec<usize>,
    /// Where its panel starts in the factor.
    pub start: usize,
}

impl Front {
    /// Columns of the panel: three for each own vertex, and as many more as fill a tile.
    pub fn width(&self) -> usize {
        padded(3 * self.own.len())
    }

    /// Rows below the own ones, filled up likewise.
    pub fn below(&self) -> usize {
        padded(3 * self.boundary.len())
    }

    /// Numbers of four in the panel.
    pub fn quads(&self) -> usize {
        (self.width() + self.below()) / TILE * self.width()
    }

    /// Row or column of a vertex in the front's dense matrix.
    pub fn row(&self, number: u32) -> usize {
        if number < self.own.end {
            return 3 * (number - self.own.start) as usize;
        }
        self.width() + 3 * self.boundary.binary_search(&number).unwrap_or(0)
    }
}

/// The order and the fronts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbolic {
    /// The elimination number of each vertex.
    pub numbers: Vec<u32>,
    /// Fronts in the order of elimination.
    pub fronts: Vec<Front>,
    /// Numbers of four in the factor.
    pub quads: usize,
}

impl Symbolic {
    /// Of vertices at places with couplings between them.
    pub fn new(places: &[DVec2], couplings: impl Iterator<Item = [u32; 2]>) -> Self {
        let graph = Graph::new(places.len(), couplings);
        let pieces = dissected(&graph, places);
        let mut numbers = vec![0; places.len()];
        for (number, &v) in pieces.iter().flat_map(|piece| &piece.own).enumerate() {
            numbers[v as usize] = number as u32;
        }
        let mut fronts: Vec<Front> = Vec::with_capacity(pieces.len());
        let (mut first, mut start) = (0, 0);
        for piece in pieces {
            let own = first..first + piece.own.len() as u32;
            let reached = piece.own.iter().flat_map(|&v| graph.of(v)).map(|&u| numbers[u as usize]);
            let handed_up = piece.children.iter().flat_map(|&child| fronts[child].boundary.iter().copied());
            let mut boundary: Vec<u32> = reached.chain(handed_up).filter(|&number| number >= own.end).collect();
            boundary.sort_unstable();
            boundary.dedup();
            first = own.end;
            let front = Front { own, boundary, children: piece.children, start };
            start += front.quads();
            fronts.push(front);
        }
        Self { numbers, fronts, quads: start }
    }

    /// Bytes that a numeric factor takes at most: the panels and the updates that wait for their parents.
    pub fn bytes(&self) -> f64 {
        let waiting: usize = self.fronts.iter().map(|front| triangle_start(front.below() / TILE)).max().unwrap_or(0);
        ((self.quads + 3 * waiting) * size_of::<[f64; TILE]>()) as f64
    }
}
