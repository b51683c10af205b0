//! Thinning a two-valued picture to its centre lines, one cell wide and as connected as before (Zhang and Suen 1984).

use crate::leaf::grid::Grid;

/// The centre lines of the true cells.
pub fn thinned(shape: &Grid<bool>) -> Grid<bool> {
    let mut grid = shape.padded(1);
    let mut front: Vec<usize> = (0..grid.cells.len()).filter(|&i| grid.cells[i]).collect();
    let mut idle = 0;
    let mut phase = 0;
    while idle < 2 {
        let gone: Vec<usize> = front.iter().copied().filter(|&i| removable(&grid, i, phase)).collect();
        for &cell in &gone {
            grid.cells[cell] = false;
        }
        front.retain(|&i| grid.cells[i]);
        idle = if gone.is_empty() { idle + 1 } else { 0 };
        phase = 1 - phase;
    }
    grid.trimmed(1)
}

/// The eight neighbours from the upper one clockwise.
fn around(grid: &Grid<bool>, cell: usize) -> [bool; 8] {
    let width = grid.width;
    let (up, down) = (cell - width, cell + width);
    [up, up + 1, cell + 1, down + 1, down, down - 1, cell - 1, up - 1].map(|i| grid.cells[i])
}

/// Whether a cell may go in this half round: it is on the rim of the shape, not an end, and does not join its parts.
fn removable(grid: &Grid<bool>, cell: usize, phase: usize) -> bool {
    let ring = around(grid, cell);
    let count = ring.iter().filter(|&&c| c).count();
    let turns = (0..8).filter(|&i| !ring[i] && ring[(i + 1) % 8]).count();
    let [up, right, down, left] = [ring[0], ring[2], ring[4], ring[6]];
    // Each half round takes cells from two sides of the shape only, so that a line two cells wide does not vanish.
    let rim = if phase == 0 { !(right && down && (up || left)) } else { !(up && left && (right || down)) };
    (2..=6).contains(&count) && turns == 1 && rim
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::leaf::grid::Parts;

    #[test]
    fn a_bar_thins_to_its_middle_line() {
        let bar = |i: usize| (3..37).contains(&(i % 40)) && (4..9).contains(&(i / 40));
        let thin = thinned(&Grid { width: 40, height: 13, cells: (0..40 * 13).map(bar).collect() });
        let places: Vec<(usize, usize)> =
            (0..thin.cells.len()).filter(|&i| thin.cells[i]).map(|i| (i % 40, i / 40)).collect();
        assert!((28..=34).contains(&places.len()), "{places:?}");
        assert!(places.iter().filter(|(x, _)| (7..33).contains(x)).all(|(_, y)| *y == 6));
    }

    #[test]
    fn a_ring_stays_a_ring() {
        let ring = |i: usize| {
            let (x, y) = ((i % 41) as i64 - 20, (i / 41) as i64 - 20);
            (100..=256).contains(&(x * x + y * y))
        };
        let shape = Grid { width: 41, height: 41, cells: (0..41 * 41).map(ring).collect() };
        let thin = thinned(&shape);
        // Background inside and outside stay apart: each cell seen from the other only over the ring's corners.
        assert_eq!(Parts::of(&thin.map(|c| !c)).count(), 2);
        assert!(thin.area() < 120);
        assert!(thin.cells.iter().zip(&shape.cells).all(|(t, s)| !t || *s));
    }

    #[test]
    fn shapes_at_the_picture_s_rim_are_thinned() {
        let thin = thinned(&Grid { width: 5, height: 5, cells: vec![true; 25] });
        assert!((1..=5).contains(&thin.area()));
    }
}
