//! The outline of a two-valued picture with sub-pixel places: marching squares (Lorensen and Cline 1987, in the plane) at the
//! half level of the lightly blurred picture.

use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;

const RIM: usize = 4;
/// Level of a blurred picture far within its mask, and the level that is followed.
const FULL: u16 = 256;
const HALF: u16 = FULL / 2;

/// The closed half-level lines of a mask, the longest first (of equals the first from the top), in pixels with the centre of
/// the top left pixel at (0.5, 0.5). Seen with rows running down, the mask lies to the left of a line: an outline runs
/// counter-clockwise and has a negative `doubled_area`, the rim of a hole runs clockwise.
pub fn outlined(mask: &Grid<bool>) -> Vec<Vec<DVec2>> {
    let field = blurred(&mask.padded(RIM));
    let (mut next, starts) = links(&field);
    let mut lines: Vec<Vec<DVec2>> = Vec::new();
    let shift = DVec2::repeat(0.5 - RIM as f64);
    for start in starts {
        let mut line = Vec::new();
        let mut edge = start;
        // a link that was followed is taken away
        while let Some(ahead) = std::mem::take(&mut next[edge as usize]).checked_sub(1) {
            line.push(place(&field, edge) + shift);
            edge = ahead;
        }
        if !line.is_empty() {
            lines.push(line);
        }
    }
    lines.sort_by_key(|line| std::cmp::Reverse(line.len()));
    lines
}

/// Binomial blur of variance 1, in 256ths.
fn blurred(mask: &Grid<bool>) -> Grid<u16> {
    let width = mask.width;
    let source: Vec<u16> = mask.cells.iter().map(|&c| u16::from(c)).collect();
    let mut along = vec![0u16; source.len()];
    for (to, from) in along.chunks_exact_mut(width).zip(source.chunks_exact(width)) {
        binomial(&mut to[2..width - 2], [0, 1, 2, 3, 4].map(|shift| &from[shift..]));
    }
    let mut cells = vec![0u16; source.len()];
    for y in 2..mask.height - 2 {
        let rows = [0, 1, 2, 3, 4].map(|shift| &along[(y + shift - 2) * width..]);
        binomial(&mut cells[y * width..(y + 1) * width], rows);
    }
    Grid { width, height: mask.height, cells }
}

/// Sixteen times the binomial mean of five rows. Levels are 256 at most, so that nothing wraps, which is said so that many
/// cells can be taken at once.
fn binomial(to: &mut [u16], [a, b, c, d, e]: [&[u16]; 5]) {
    let count = to.len();
    let (a, b, c, d, e) = (&a[..count], &b[..count], &c[..count], &d[..count], &e[..count]);
    for i in 0..count {
        let near = b[i].wrapping_add(d[i]).wrapping_mul(4);
        to[i] = a[i].wrapping_add(e[i]).wrapping_add(near).wrapping_add(c[i].wrapping_mul(6));
    }
}

/// For each lattice edge (twice its left or upper end's number, plus 1 if it runs down) one more than the edge where the line
/// goes on, 0 where there is none; and the edges with a line, in order. A line enters a square where its corners, taken in
/// one sense, turn from out to in, and leaves at the next turn back.
fn links(field: &Grid<u16>) -> (Vec<u32>, Vec<u32>) {
    let mut next = vec![0; field.cells.len() * 2];
    let mut starts = Vec::new();
    let width = field.width;
    let rows = field.cells.chunks_exact(width).zip(field.cells.chunks_exact(width).skip(1));
    for (y, (upper, lower)) in rows.enumerate() {
        for (x, (above, below)) in upper.windows(2).zip(lower.windows(2)).enumerate() {
            let inside = [above[0] > HALF, above[1] > HALF, below[1] > HALF, below[0] > HALF];
            if inside == [inside[0]; 4] {
                continue;
            }
            let i = y * width + x;
            let edges = [2 * i, 2 * (i + 1) + 1, 2 * (i + width), 2 * i + 1];
            for side in (0..4).filter(|&side| !inside[side] && inside[(side + 1) % 4]) {
                let leave = (1..4).map(|k| (side + k) % 4).find(|&s| inside[s] && !inside[(s + 1) % 4]);
                if let Some(leave) = leave {
                    next[edges[side]] = edges[leave] as u32 + 1;
                    starts.push(edges[side] as u32);
                }
            }
        }
    }
    starts.sort_unstable();
    (next, starts)
}

fn place(field: &Grid<u16>, edge: u32) -> DVec2 {
    let (i, down) = (edge as usize / 2, edge % 2 == 1);
    let j = if down { i + field.width } else { i + 1 };
    let (a, b) = (f64::from(field.cells[i]), f64::from(field.cells[j]));
    let t = (f64::from(HALF) - a) / (b - a);
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
