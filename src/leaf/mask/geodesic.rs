//! Ways within the blade: a lobe folded towards the joint is still far from it.

use crate::leaf::grid::Grid;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Steps to the 16 cells nearest in direction, and their lengths in thousandths of a cell. Ways along them are at most 2.8 %
/// longer than straight ones.
const STEPS: [(i64, i64, u32); 16] = [
    (1, 0, 1000),
    (0, 1, 1000),
    (-1, 0, 1000),
    (0, -1, 1000),
    (1, 1, 1414),
    (-1, 1, 1414),
    (-1, -1, 1414),
    (1, -1, 1414),
    (2, 1, 2236),
    (1, 2, 2236),
    (-1, 2, 2236),
    (-2, 1, 2236),
    (-2, -1, 2236),
    (-1, -2, 2236),
    (1, -2, 2236),
    (2, -1, 2236),
];

/// Length of the shortest way from a cell to each inside (Dijkstra 1959), in cells; infinite where none leads.
pub fn ways(inside: &Grid<bool>, from: usize) -> Grid<f32> {
    let mut lengths = inside.map(|_| u32::MAX);
    let mut heap = BinaryHeap::new();
    if inside.cells.get(from).copied().unwrap_or(false) {
        lengths.cells[from] = 0;
        heap.push(Reverse((0u32, from)));
    }
    let (width, height) = (inside.width as i64, inside.height as i64);
    while let Some(Reverse((length, cell))) = heap.pop() {
        if length > lengths.cells[cell] {
            continue;
        }
        let (x, y) = ((cell % inside.width) as i64, (cell / inside.width) as i64);
        for (dx, dy, step) in STEPS {
            let (x, y) = (x + dx, y + dy);
            if x >= 0 && y >= 0 && x < width && y < height {
                let next = (y * width + x) as usize;
                let longer = length.saturating_add(step);
                if inside.cells[next] && longer < lengths.cells[next] {
                    lengths.cells[next] = longer;
                    heap.push(Reverse((longer, next)));
                }
            }
        }
    }
    lengths.map(|l| if l == u32::MAX { f32::INFINITY } else { l as f32 / 1000.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn over_open_ground_ways_are_nearly_straight() {
        let open = Grid { width: 61, height: 61, cells: vec![true; 61 * 61] };
        let found = ways(&open, 30 * 61 + 30);
        for (i, &length) in found.cells.iter().enumerate() {
            let (x, y) = ((i % 61) as f64 - 30.0, (i / 61) as f64 - 30.0);
            let straight = (x * x + y * y).sqrt();
            assert!(
                f64::from(length) >= straight * 0.9995 && f64::from(length) <= straight * 1.028,
                "{x} {y} {length}"
            );
        }
    }

    #[test]
    fn walls_are_walked_round() {
        let mut walled = Grid { width: 21, height: 21, cells: vec![true; 441] };
        for y in 0..20 {
            for x in 9..12 {
                walled.cells[y * 21 + x] = false;
            }
        }
        let found = ways(&walled, 0);
        assert!(found.at(20, 0) > 40.0 && found.at(0, 20) == 20.0);
        assert_eq!(found.at(10, 5), f32::INFINITY);
        assert_eq!(ways(&walled, 10).at(0, 0), f32::INFINITY, "from a wall no way leads");
    }
}
