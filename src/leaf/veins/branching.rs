//! A tree of cells taken apart into veins: at a fork the vein goes on along the branch that reaches farthest straight ahead,
//! the others begin there.

use super::paths::NONE;
use super::tree::Tree;
use crate::base::vector::DVec2;
use crate::leaf::raster::middle_of;

/// How far the heading before and after a fork is looked at, share of the size.
const LOOK: f64 = 0.08;

/// A vein as cells.
#[derive(Clone, Debug)]
pub struct Branch {
    /// The cells from the one on which it hangs (a cell of its parent or of the joint) to its end.
    pub cells: Vec<u32>,
    /// The branch on which it hangs.
    pub parent: Option<usize>,
}

/// Takes a tree apart; `width` is the grid's, `size` the square root of the blade's area in cells. Parents come first.
pub fn branches(tree: &Tree, width: usize, size: f64) -> Vec<Branch> {
    let family = Family::new(tree, width);
    let look = ((LOOK * size) as usize).max(2);
    let mut made: Vec<Branch> = Vec::new();
    let roots = tree.cells.iter().copied().filter(|&c| tree.up[c as usize] == NONE);
    let mut begun: Vec<(u32, u32, Option<usize>)> =
        roots.flat_map(|root| family.children(root).iter().map(move |&c| (root, c, None))).collect();
    begun.reverse();
    while let Some((from, first, parent)) = begun.pop() {
        let mut cells = vec![from, first];
        let number = made.len();
        loop {
            let last = cells[cells.len() - 1];
            let behind = cells[cells.len().saturating_sub(look)];
            let Some(next) = family.onward(behind, last, look) else { break };
            begun.extend(family.children(last).iter().filter(|&&c| c != next).map(|&c| (last, c, Some(number))));
            cells.push(next);
        }
        made.push(Branch { cells, parent });
    }
    made
}

/// Who hangs on whom, and how far each cell's farthest descendant is (cells).
struct Family {
    width: usize,
    starts: Vec<u32>,
    children: Vec<u32>,
    reach: Vec<f32>,
}

impl Family {
    fn new(tree: &Tree, width: usize) -> Self {
        let count = tree.up.len();
        let mut starts = vec![0u32; count + 1];
        for &cell in &tree.cells {
            if tree.up[cell as usize] != NONE {
                starts[tree.up[cell as usize] as usize + 1] += 1;
            }
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut children = vec![0u32; starts[count] as usize];
        let mut reach = vec![0.0f32; count];
        for &cell in &tree.cells {
            let up = tree.up[cell as usize];
            if up != NONE {
                children[next[up as usize] as usize] = cell;
                next[up as usize] += 1;
            }
        }
        // Each cell comes after the one on which it hangs, so backwards the far ends come first.
        for &cell in tree.cells.iter().rev().filter(|&&c| tree.up[c as usize] != NONE) {
            let up = tree.up[cell as usize] as usize;
            let step = (middle_of(width, cell as usize) - middle_of(width, up)).norm() as f32;
            reach[up] = reach[up].max(reach[cell as usize] + step);
        }
        Self { width, starts, children, reach }
    }

    fn children(&self, cell: u32) -> &[u32] {
        &self.children[self.starts[cell as usize] as usize..self.starts[cell as usize + 1] as usize]
    }

    fn place(&self, cell: u32) -> DVec2 {
        middle_of(self.width, cell as usize)
    }

    /// The child with which a vein that comes from `behind` goes on after `last`.
    fn onward(&self, behind: u32, last: u32, look: usize) -> Option<u32> {
        let children = self.children(last);
        if children.len() < 2 {
            return children.first().copied();
        }
        let heading = (self.place(last) - self.place(behind)).try_normalize(0.0).unwrap_or_default();
        let merit = |child: u32| {
            let ahead = self.ahead(child, look);
            let straight = (self.place(ahead) - self.place(last)).try_normalize(0.0).unwrap_or_default().dot(&heading);
            f64::from(self.reach[child as usize]) * straight.max(0.0) * straight.max(0.0)
        };
        let mut best = children[0];
        for &child in &children[1..] {
            if merit(child) > merit(best) {
                best = child;
            }
        }
        Some(best)
    }

    /// The cell `look` steps ahead along the farthest-reaching children.
    fn ahead(&self, mut cell: u32, look: usize) -> u32 {
        for _ in 0..look {
            let reach = |c: &u32| self.reach[*c as usize];
            match self.children(cell).iter().max_by(|a, b| reach(a).total_cmp(&reach(b)).then(b.cmp(a))) {
                Some(&next) => cell = next,
                None => break,
            }
        }
        cell
    }
}
