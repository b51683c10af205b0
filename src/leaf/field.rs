//! Grids of numbers and how they are smoothed: Gaussian blurs by short kernels where they are narrow, by running boxes where
//! they are wide. Sums are taken in a fixed order, so that results are the same for any number of threads.

use crate::base::maths::exp;
use crate::leaf::grid::Grid;
use rayon::prelude::*;

/// Kernels reach this many standard deviations.
const REACH: f64 = 3.0;

/// A grid of the same size, each row made from the row of the same number.
fn by_rows(source: &Grid<f32>, row: impl Fn(&[f32], &mut [f32]) + Sync) -> Grid<f32> {
    let mut made = Grid { cells: vec![0.0; source.cells.len()], ..*source };
    let width = source.width.max(1);
    made.cells.par_chunks_mut(width).zip(source.cells.par_chunks(width)).for_each(|(to, from)| row(from, to));
    made
}

/// Rows and columns exchanged.
fn transposed(source: &Grid<f32>) -> Grid<f32> {
    let (width, height) = (source.height, source.width);
    let mut cells = vec![0.0; source.cells.len()];
    cells.par_chunks_mut(width.max(1)).enumerate().for_each(|(x, column)| {
        for (y, cell) in column.iter_mut().enumerate() {
            *cell = source.cells[y * source.width + x];
        }
    });
    Grid { width, height, cells }
}

/// Convolution with a Gaussian; beyond the grid everything is 0. `deviation` in cells.
pub fn blurred(source: &Grid<f32>, deviation: f64) -> Grid<f32> {
    let kernel = gaussian(deviation);
    let across = by_rows(source, |from, to| convolve(from, to, &kernel));
    transposed(&by_rows(&transposed(&across), |from, to| convolve(from, to, &kernel)))
}

/// Half of a Gaussian kernel from its middle outwards; the whole sums to 1.
fn gaussian(deviation: f64) -> Vec<f32> {
    let reach = (REACH * deviation).ceil().max(1.0) as usize;
    let weight = |i: usize| {
        let x = i as f64 / deviation.max(1e-3);
        exp(-0.5 * x * x)
    };
    let total: f64 = weight(0) + 2.0 * (1..=reach).map(weight).sum::<f64>();
    (0..=reach).map(|i| (weight(i) / total) as f32).collect()
}

fn convolve(from: &[f32], to: &mut [f32], kernel: &[f32]) {
    let count = from.len();
    for (value, cell) in from.iter().zip(to.iter_mut()) {
        *cell = value * kernel[0];
    }
    for (shift, &weight) in kernel.iter().enumerate().skip(1).take_while(|(shift, _)| *shift < count) {
        for (cell, value) in to[shift..].iter_mut().zip(from) {
            *cell += value * weight;
        }
        for (cell, value) in to.iter_mut().zip(&from[shift..]) {
            *cell += value * weight;
        }
    }
}

/// Nearly a Gaussian of large deviation (cells): three running means one after the other, 0 beyond the grid.
pub fn widely_blurred(source: &Grid<f32>, deviation: f64) -> Grid<f32> {
    // Three boxes of 2 r + 1 cells have the variance r (r + 1).
    let radius = ((0.25 + deviation * deviation).sqrt() - 0.5).round().max(1.0) as usize;
    let thrice = |from: &[f32], to: &mut [f32]| {
        let mut other = from.to_vec();
        running_mean(from, to, radius);
        running_mean(to, &mut other, radius);
        running_mean(&other, to, radius);
    };
    transposed(&by_rows(&transposed(&by_rows(source, thrice)), thrice))
}

fn running_mean(from: &[f32], to: &mut [f32], radius: usize) {
    let count = from.len();
    let share = 1.0 / (2 * radius + 1) as f64;
    let mut sum: f64 = from.iter().take(radius).map(|&v| f64::from(v)).sum();
    for x in 0..count {
        sum += from.get(x + radius).map_or(0.0, |&v| f64::from(v));
        to[x] = (sum * share) as f32;
        sum -= x.checked_sub(radius).map_or(0.0, |i| f64::from(from[i]));
    }
}

/// The value below which a share of the values lies; 0 of none.
pub fn quantile(mut values: Vec<f32>, share: f64) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = ((values.len() - 1) as f64 * share.clamp(0.0, 1.0)) as usize;
    *values.select_nth_unstable_by(rank, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(side: usize) -> Grid<f32> {
        let mut cells = vec![0.0; side * side];
        cells[side * (side / 2) + side / 2] = 1.0;
        Grid { width: side, height: side, cells }
    }

    /// Sum and variance along x.
    fn moments(grid: &Grid<f32>) -> (f64, f64) {
        let middle = (grid.width / 2) as f64;
        let values = grid.cells.iter().enumerate().map(|(i, &v)| ((i % grid.width) as f64 - middle, f64::from(v)));
        values.fold((0.0, 0.0), |(sum, square), (x, v)| (sum + v, square + v * x * x))
    }

    #[test]
    fn blurs_keep_the_sum_and_have_their_variance() {
        let (sum, variance) = moments(&blurred(&dot(41), 3.0));
        assert!((sum - 1.0).abs() < 1e-5 && (variance / 9.0 - 1.0).abs() < 0.03, "{sum} {variance}");
        let (sum, variance) = moments(&widely_blurred(&dot(101), 8.0));
        assert!((sum - 1.0).abs() < 1e-5 && (variance / 64.0 - 1.0).abs() < 0.15, "{sum} {variance}");
    }

    #[test]
    fn a_row_shorter_than_the_kernel_is_blurred() {
        let row = Grid { width: 2, height: 1, cells: vec![1.0, 0.0] };
        let made = blurred(&row, 5.0);
        assert!(made.cells[0] > made.cells[1] && made.cells[1] > 0.0);
        assert!(widely_blurred(&row, 50.0).cells.iter().all(|v| *v > 0.0));
    }

    #[test]
    fn quantiles_of_a_ladder() {
        let ladder: Vec<f32> = (0..101).map(|i| i as f32).collect();
        assert_eq!(quantile(ladder.clone(), 0.5), 50.0);
        assert_eq!(quantile(ladder, 0.92), 92.0);
        assert_eq!(quantile(Vec::new(), 0.5), 0.0);
    }
}
