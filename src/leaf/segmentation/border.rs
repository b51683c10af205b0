//! Whether the picture's border cuts the blade off. A tip that only meets the border, or a petiole that runs out, is fine.

use crate::leaf::LeafError;
use crate::leaf::grid::Grid;

/// Width of a petiole, share of the square root of the leaf's area: a longer contact with the border is looked at.
const PETIOLE: f64 = 0.07;
/// Share of the square root of the area that may be missing beyond a border that a blade meets at a tangent.
const MISSING: f64 = 0.01;

/// Refuses a blade that goes on beyond the border.
///
/// # Errors
/// [`LeafError::Picture`] naming the side.
pub fn whole(blade: &Grid<bool>) -> Result<(), LeafError> {
    let size = (blade.area() as f64).sqrt();
    let least = blade.width.min(blade.height);
    for side in ["left", "right", "top", "bottom"] {
        let line = |depth: usize| -> Vec<bool> {
            let (last_row, last_column) = (blade.height - 1 - depth, blade.width - 1 - depth);
            match side {
                "left" => (0..blade.height).map(|y| blade.at(depth, y)).collect(),
                "right" => (0..blade.height).map(|y| blade.at(last_column, y)).collect(),
                "top" => (0..blade.width).map(|x| blade.at(x, depth)).collect(),
                _ => (0..blade.width).map(|x| blade.at(x, last_row)).collect(),
            }
        };
        let contact = longest_run(&line(0));
        if contact as f64 <= (PETIOLE * size).max(3.0) {
            continue;
        }
        let depth = (contact / 8).max(2).min(least / 4);
        if missing(contact, longest_run(&line(depth)), depth) > (MISSING * size).max(1.5) {
            let what = format!(
                "the picture's {side} border cuts the leaf off along {contact} pixels; scan or crop it again with \
                 background on every side of the leaf"
            );
            return Err(LeafError::picture(&what));
        }
    }
    Ok(())
}

/// How far a round end goes on beyond a border that cuts it in a chord, when the chord at some depth inside is known: the
/// square of a circle's chord grows evenly with depth.
fn missing(at_border: usize, inside: usize, depth: usize) -> f64 {
    let square = |chord: usize| (chord * chord) as f64;
    let growth = square(inside) - square(at_border);
    if growth <= 0.0 { f64::INFINITY } else { depth as f64 * square(at_border) / growth }
}

fn longest_run(line: &[bool]) -> usize {
    line.split(|&c| !c).map(<[bool]>::len).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(x: f64, y: f64, radius: f64) -> Grid<bool> {
        let inside = |i: usize| {
            let (dx, dy) = ((i % 300) as f64 + 0.5 - x, (i / 300) as f64 + 0.5 - y);
            dx * dx + dy * dy < radius * radius
        };
        Grid { width: 300, height: 200, cells: (0..300 * 200).map(inside).collect() }
    }

    #[test]
    fn a_disc_may_meet_the_border_but_not_go_on_beyond_it() {
        assert_eq!(whole(&disc(150.0, 100.0, 80.0)), Ok(()));
        assert_eq!(whole(&disc(80.0, 100.0, 80.5)), Ok(()));
        for (x, y, side) in
            [(60.0, 100.0, "left"), (240.0, 100.0, "right"), (150.0, 60.0, "top"), (150.0, 140.0, "bottom")]
        {
            let refused = whole(&disc(x, y, 80.0)).unwrap_err().to_string();
            assert!(refused.contains(&format!("{side} border")), "{refused}");
        }
    }

    #[test]
    fn a_petiole_may_run_out() {
        let mut grid = disc(150.0, 100.0, 60.0);
        (160..200).for_each(|y| grid.cells[y * 300 + 147..y * 300 + 153].fill(true));
        assert_eq!(whole(&grid), Ok(()));
    }
}
