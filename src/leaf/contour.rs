//! The outline of a two-valued picture with sub-pixel places: marching squares (Lorensen and Cline 1987, in the plane) at the
//! half level of the lightly blurred picture.

use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;

const RIM: usize = 4;
const NONE: u32 = u32::MAX;

/// The closed half-level lines of a mask, the longest first (of equals the first from the top), in pixels with the centre of
/// the top left pixel at (0.5, 0.5). Seen with rows running down, the mask lies to the left of a line: an outline runs
/// counter-clockwise and has a negative [`crate::leaf::polygon::doubled_area`], the rim of a hole runs clockwise.
pub fn outlined(mask: &Grid<bool>) -> Vec<Vec<DVec2>> {
    let field = blurred(&mask.padded(RIM));
    let next = links(&field);
    let mut seen = vec![false; next.len()];
    let mut lines: Vec<Vec<DVec2>> = Vec::new();
    let shift = DVec2::repeat(0.5 - RIM as f64);
    for start in 0..next.len() {
        let mut line = Vec::new();
        let mut edge = start as u32;
        while next[edge as usize] != NONE && !seen[edge as usize] {
            seen[edge as usize] = true;
            line.push(place(&field, edge) + shift);
            edge = next[edge as usize];
        }
        if !line.is_empty() {
            lines.push(line);
        }
    }
    lines.sort_by_key(|line| std::cmp::Reverse(line.len()));
    lines
}

/// Binomial blur of variance 1.
fn blurred(mask: &Grid<bool>) -> Grid<f32> {
    let source = mask.map(|c| if c { 1.0f32 } else { 0.0 });
    let pass = |grid: &Grid<f32>, step: usize, inside: &dyn Fn(usize) -> bool| -> Grid<f32> {
        let value = |i: usize| {
            let c = &grid.cells;
            let far = c[i - 2 * step] + c[i + 2 * step];
            (far + 4.0 * (c[i - step] + c[i + step]) + 6.0 * c[i]) / 16.0
        };
        let cells = (0..grid.cells.len()).map(|i| if inside(i) { value(i) } else { 0.0 }).collect();
        Grid { width: grid.width, height: grid.height, cells }
    };
    let (width, height) = (mask.width, mask.height);
    let along = pass(&source, 1, &|i| (2..width - 2).contains(&(i % width)));
    pass(&along, width, &|i| (2..height - 2).contains(&(i / width)))
}

/// For each lattice edge (twice its left or upper end's number, plus 1 if it runs down) the edge where the line goes on. A
/// line enters a square where its corners, taken in one sense, turn from out to in, and leaves at the next turn back.
fn links(field: &Grid<f32>) -> Vec<u32> {
    let mut next = vec![NONE; field.cells.len() * 2];
    for y in 0..field.height - 1 {
        for x in 0..field.width - 1 {
            let i = y * field.width + x;
            let below = i + field.width;
            let inside = [i, i + 1, below + 1, below].map(|c| field.cells[c] > 0.5);
            let edges = [2 * i, 2 * (i + 1) + 1, 2 * below, 2 * i + 1];
            for side in 0..4 {
                if inside[side] || !inside[(side + 1) % 4] {
                    continue;
                }
                let leave = (1..4).map(|k| (side + k) % 4).find(|&s| inside[s] && !inside[(s + 1) % 4]);
                if let Some(leave) = leave {
                    next[edges[side]] = edges[leave] as u32;
                }
            }
        }
    }
    next
}

fn place(field: &Grid<f32>, edge: u32) -> DVec2 {
    let (i, down) = (edge as usize / 2, edge % 2 == 1);
    let j = if down { i + field.width } else { i + 1 };
    let (a, b) = (f64::from(field.cells[i]), f64::from(field.cells[j]));
    let t = (0.5 - a) / (b - a);
    let start = DVec2::new((i % field.width) as f64, (i / field.width) as f64);
    start + if down { DVec2::new(0.0, t) } else { DVec2::new(t, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::leaf::polygon;

    #[test]
    fn a_disc_is_outlined_to_a_third_of_a_pixel() {
        let inside = |i: i32| {
            let (x, y) = (f64::from(i % 80) + 0.5 - 40.0, f64::from(i / 80) + 0.5 - 35.0);
            x * x + y * y < 30.0 * 30.0
        };
        let grid = Grid { width: 80, height: 70, cells: (0..80 * 70).map(inside).collect() };
        let lines = outlined(&grid);
        let line = &lines[0];
        assert_eq!(lines.len(), 1);
        for p in line {
            assert!(((p - DVec2::new(40.0, 35.0)).norm() - 30.0).abs() < 0.5, "{p}");
        }
        let area = polygon::doubled_area(line) / -2.0;
        assert!((area / (900.0 * std::f64::consts::PI) - 1.0).abs() < 5e-3, "{area}");
    }
}
