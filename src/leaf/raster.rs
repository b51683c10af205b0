//! Polygons and lines drawn into grids.

use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;

/// The cells whose middles lie within closed polygons, by the non-zero rule over all of them: where a line crosses itself
/// its lobes overlap, and a loop run the other way round cuts a hole. The middle of the first cell is (0.5, 0.5).
pub fn filled(polygons: &[&[DVec2]], width: usize, height: usize) -> Grid<bool> {
    let mut crossings: Vec<Vec<(f64, i32)>> = vec![Vec::new(); height];
    for polygon in polygons {
        for (i, a) in polygon.iter().enumerate() {
            cross_rows(*a, polygon[(i + 1) % polygon.len()], &mut crossings);
        }
    }
    let mut cells = vec![false; width * height];
    for (row, turns) in cells.chunks_exact_mut(width.max(1)).zip(&mut crossings) {
        turns.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut winding = 0;
        for pair in 0..turns.len().saturating_sub(1) {
            winding += turns[pair].1;
            if winding != 0 {
                let cell = |x: f64| (x - 0.5).ceil().clamp(0.0, width as f64) as usize;
                let (from, to) = (cell(turns[pair].0), cell(turns[pair + 1].0));
                row[from..to.max(from)].fill(true);
            }
        }
    }
    Grid { width, height, cells }
}

/// Notes where a side crosses the middle lines of the rows, and in which sense.
fn cross_rows(a: DVec2, b: DVec2, rows: &mut [Vec<(f64, i32)>]) {
    let (low, high, sense) = if a.y < b.y { (a, b, 1) } else { (b, a, -1) };
    let row = |y: f64| (y - 0.5).ceil().clamp(0.0, rows.len() as f64) as usize;
    for y in row(low.y)..row(high.y) {
        let share = (y as f64 + 0.5 - low.y) / (high.y - low.y);
        rows[y].push((low.x + (high.x - low.x) * share, sense));
    }
}

/// Marks the cells that a line passes, sampled at quarters of a cell; what lies beyond the grid is left out.
pub fn draw_line(grid: &mut Grid<bool>, line: &[DVec2]) {
    for ends in line.windows(2) {
        let count = ((ends[1] - ends[0]).norm() * 4.0).ceil().clamp(1.0, 1e6) as usize;
        for i in 0..=count {
            let p = ends[0] + (ends[1] - ends[0]) * (i as f64 / count as f64);
            if let Some(cell) = cell_of(grid.width, grid.height, p) {
                grid.cells[cell] = true;
            }
        }
    }
}

/// The number of the cell that holds a point.
pub fn cell_of(width: usize, height: usize, p: DVec2) -> Option<usize> {
    let fits = p.x >= 0.0 && p.y >= 0.0 && p.x < width as f64 && p.y < height as f64;
    fits.then(|| p.y as usize * width + p.x as usize)
}

/// The middle of a cell.
pub fn middle_of(width: usize, cell: usize) -> DVec2 {
    DVec2::new((cell % width) as f64 + 0.5, (cell / width) as f64 + 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Vec<DVec2> {
        [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| DVec2::new(x, y)).to_vec()
    }

    #[test]
    fn squares_have_their_area_and_holes_theirs() {
        let (outer, mut inner) = (square(2.0, 10.0), square(4.0, 7.0));
        assert_eq!(filled(&[&outer], 12, 12).area(), 64);
        assert_eq!(filled(&[&outer, &inner], 12, 12).area(), 64, "the same sense: non-zero");
        inner.reverse();
        assert_eq!(filled(&[&outer, &inner], 12, 12).area(), 55);
    }

    #[test]
    fn polygons_beyond_the_grid_are_clipped() {
        assert_eq!(filled(&[&square(-50.0, 50.0)], 5, 4).area(), 20);
        assert_eq!(filled(&[&square(60.0, 70.0)], 5, 4).area(), 0);
        assert_eq!(filled(&[&[], &[DVec2::new(1.0, 1.0)]], 5, 4).area(), 0);
    }

    #[test]
    fn a_line_marks_every_cell_on_its_way() {
        let mut grid = Grid { width: 6, height: 3, cells: vec![false; 18] };
        draw_line(&mut grid, &[DVec2::new(0.5, 1.5), DVec2::new(9.0, 1.5)]);
        assert_eq!((grid.area(), grid.at(0, 1), grid.at(5, 1)), (6, true, true));
    }
}
