//! A tree of veins through a field of ridge strength. It starts as the petiole's joint; again and again the way of least
//! cost that gains most joins it, until none gains enough. A way gains where the ridge is stronger than that of the share
//! of the blade which major veins cover, and loses where it is weaker: so gaps are closed and stray ridges stay outside.

use super::paths::{Ground, NONE, Ways};
use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;

/// What a way must gain to become a vein, in lengths of full strength: share of the blade's size.
const LEAST_GAIN: f64 = 0.05;
/// Veins that are sought at most: a guard, not a setting.
const MOST: usize = 200;

/// Ways that hang together. Cells are numbered as in the grid.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The next cell towards the joint for each cell of the tree; `NONE` for the joint's and all others.
    pub up: Vec<u32>,
    /// The cells of the tree, each after the one that it hangs on.
    pub cells: Vec<u32>,
    /// What all ways gained, in cells.
    pub gain: f64,
}

/// Strength as shares of the threshold -> what a way gains in a cell.
fn gain(strength: f32) -> f32 {
    strength.min(FULL) - 1.0
}

/// Strength, in thresholds, from which a ridge is no better for being stronger.
const FULL: f32 = 2.0;

/// Strength as shares of the threshold -> what a way costs in a cell.
fn cost(strength: f32) -> u16 {
    let s = strength.max(0.0);
    (3.0 + 60.0 / (1.0 + 4.0 * s * s)) as u16
}

/// Grows the tree. `strength` is in thresholds; `inside` tells where ways may lead, `inner` where they gain or lose;
/// `joint` are the cells from which it starts; `size` is the square root of the blade's area in cells.
pub fn grown(
    strength: &Grid<f32>,
    inside: &Grid<bool>,
    inner: &Grid<bool>,
    joint: &[u32],
    from: DVec2,
    size: f64,
) -> Tree {
    let count = strength.cells.len();
    let each = |f: &dyn Fn(usize) -> f32| Grid { cells: (0..count).map(f).collect(), ..*strength };
    let gains = each(&|i| if inner.cells[i] { gain(strength.cells[i]) } else { -0.25 });
    let costs = (0..count).map(|i| if inside.cells[i] { cost(strength.cells[i]) } else { 0 }).collect();
    let costs = Grid { cells: costs, width: strength.width, height: strength.height };
    let ground = Ground { from: Some(from), costs: &costs, gains: &gains };
    let mut ways = Ways::new(count);
    let mut tree = Tree { up: vec![NONE; count], cells: joint.to_vec(), gain: 0.0 };
    ways.add(&ground, joint);
    let least = (LEAST_GAIN * size) as f32;
    for _ in 0..MOST {
        let better = |best: u32, i: usize| if ways.gains[i] > ways.gains[best as usize] { i as u32 } else { best };
        let best = (0..count).fold(0, better);
        if ways.gains[best as usize] < least {
            break;
        }
        tree.gain += f64::from(ways.gains[best as usize]);
        let way = ways.way(best);
        for pair in way.windows(2) {
            tree.up[pair[1] as usize] = pair[0];
        }
        tree.cells.extend_from_slice(&way[1..]);
        ways.add(&ground, &way[1..]);
    }
    tree
}
