//! What stands before each place of the wood's edge: how far the crowns' relief rises over it to the left, above and to the
//! right, so that a picture can tell where the sun's light ends on it and how much of the sky it sees (Max 1988, "Horizon
//! mapping: shadows for bump-mapped surfaces").

use super::wood_canvas::{Canvas, Grid, Texel};
use rayon::prelude::*;

/// Steps along the edge for one up, in texels of the horizons: to the left, up, to the right.
const WAYS: [[i32; 2]; 3] = [[-1, 0], [0, 1], [1, 0]];
/// Steps out from a place, texels: crowns a tree's width away still shade it.
const STEPS: [i32; 10] = [1, 2, 3, 5, 7, 10, 14, 20, 29, 42];
/// Texels of the edge along one side of one of the horizons'.
const COARSER: usize = 2;
/// Depth of what lies behind all crowns, metres.
const BEHIND: f32 = -40.0;

/// Sines of the horizons' heights over the edge's plane, 0..1: to the left, up, to the right; with their columns and rows.
pub(super) fn horizons(canvas: &Canvas) -> ([usize; 2], Vec<[f32; 3]>) {
    let texel = canvas.grid.texel * COARSER as f32;
    let ([width, height], depths) = depths(canvas);
    let sine = |[column, row]: [usize; 2], [along, up]: [i32; 2]| {
        let own = depths[row * width + column];
        let slope = |step: i32| {
            // Rows are from the tops down, and over the tops stands nothing. The width is a power of two.
            let row = row.checked_add_signed((-up * step) as isize)?;
            let column = column.wrapping_add_signed((along * step) as isize) & (width - 1);
            Some((depths[row * width + column] - own) / (step as f32 * texel))
        };
        let slope = STEPS.into_iter().map_while(slope).fold(0.0, f32::max);
        slope / (1.0 + slope * slope).sqrt()
    };
    let row = |row: usize| (0..width).map(move |column| WAYS.map(|way| sine([column, row], way)));
    ([width, height], (0..height).into_par_iter().flat_map_iter(row).collect())
}

/// Mean depths of the leaves in squares of texels, metres, with their columns and rows.
fn depths(canvas: &Canvas) -> ([usize; 2], Vec<f32>) {
    let Grid { width, height, .. } = canvas.grid;
    let size = [width / COARSER, height / COARSER];
    let mean = |place: usize| {
        let (column, row) = (place % size[0] * COARSER, place / size[0] * COARSER);
        let rows = (row..row + COARSER).map(|row| &canvas.texels[row * width + column..][..COARSER]);
        let depth = |texel: &Texel| if texel.leaves > 0.5 { texel.depth.max(BEHIND) } else { BEHIND };
        rows.flatten().map(depth).sum::<f32>() / (COARSER * COARSER) as f32
    };
    (size, (0..size[0] * size[1]).into_par_iter().map(mean).collect())
}

#[cfg(test)]
mod tests {
    use super::super::wood_canvas::EMPTY;
    use super::*;

    /// A wall that stands before another from a column on, metres: 256 texels of half a metre along, 32 up, and 60 columns on no more.
    fn step(column: usize, before: f32) -> Canvas {
        let mut canvas = Canvas::new(Grid { width: 256, height: 32, texel: 0.5 });
        for (place, texel) in canvas.texels.iter_mut().enumerate() {
            let depth = if (column..column + 60).contains(&(place % 256)) { before } else { 0.0 };
            *texel = Texel { leaves: 1.0, depth, ..EMPTY };
        }
        canvas
    }

    #[test]
    fn a_step_shades_the_lower_side_by_its_height_over_its_distance() {
        let ([width, height], sines) = horizons(&step(40, 3.0));
        assert_eq!([width, height], [128, 16]);
        let at = |column: usize| sines[8 * width + column];
        // The place 5 texels of a metre before the first that stands 3 metres out.
        let [left, above, right] = at(15);
        assert!((right - 3.0 / 34.0f32.sqrt()).abs() < 1e-6, "{right}");
        assert_eq!((left, above), (0.0, 0.0));
        assert_eq!(at(21), [0.0; 3]);
    }

    #[test]
    fn what_stands_over_a_place_shades_it_from_above_and_nothing_does_over_the_tops() {
        let mut canvas = step(0, 0.0);
        canvas.texels[..256 * 16].iter_mut().for_each(|texel| texel.depth = 2.0);
        let ([width, height], sines) = horizons(&canvas);
        let above = |row: usize| sines[row * width + 3][1];
        assert!((above(height / 2) - 2.0 / 5.0f32.sqrt()).abs() < 1e-6, "{}", above(height / 2));
        assert!(above(height - 1) > 0.0 && (0..height / 2).all(|row| above(row) == 0.0));
    }
}
