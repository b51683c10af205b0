//! A picture in CIELAB, lightly blurred against noise and the blocks of JPEG.

use crate::base::maths::{cbrt, srgb_to_linear};
use crate::base::picture::Picture;
use crate::leaf::grid::Grid;
use rayon::prelude::*;

/// Steps of a channel's blurred code in the table of linear values: 16 to each of the 256 codes.
const STEPS: usize = 4096;
/// Steps of the table of cube roots over 0 to 1.1.
const ROOTS: usize = 8192;
const HIGHEST: f32 = 1.1;

/// CIELAB (D65) of the picture, blurred by a binomial filter of variance 1 on the codes.
pub fn lab_of(picture: &Picture) -> Grid<[f32; 3]> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let mut cells = vec![[0.0; 3]; width * height];
    let tables = Tables::new();
    let fill = |(y, row): (usize, &mut [[f32; 3]])| tables.fill(picture, y, row);
    cells.par_chunks_exact_mut(width.max(1)).enumerate().for_each(fill);
    Grid { width, height, cells }
}

/// The transcendental functions of the conversion, tabled: a lookup is as exact as an 8-bit code deserves (within 0.01).
struct Tables {
    /// Linear value of each step of an encoded value.
    linear: Vec<f32>,
    /// The lightness function of CIE 15 at each step of its argument, and at the next.
    roots: Vec<[f32; 2]>,
}

impl Tables {
    fn new() -> Self {
        let linear = (0..STEPS).map(|i| srgb_to_linear(i as f32 * 16.0 / 65_280.0)).collect();
        let root = |i: usize| lightness(i as f32 * HIGHEST / ROOTS as f32);
        Self { linear, roots: (0..=ROOTS).map(|i| [root(i), root(i + 1)]).collect() }
    }

    /// Converts row `y`.
    fn fill(&self, picture: &Picture, y: usize, row: &mut [[f32; 3]]) {
        let (width, height) = (picture.width as usize, picture.height as i64);
        let rows = [-2, -1, 0, 1, 2].map(|d| (y as i64 + d).clamp(0, height - 1) as usize * width);
        let [a, b, c, d, e] = rows.map(|start| picture.pixels[start..start + width].as_flattened());
        // two pixels continued on either side; every sum fits: 256 times a code is at most 65,280
        let mut sums = vec![0u16; 4 * (width + 4)];
        for (i, sum) in sums[8..4 * (width + 2)].iter_mut().enumerate() {
            *sum = binomial([a[i], b[i], c[i], d[i], e[i]].map(u16::from));
        }
        sums.copy_within(8..12, 4);
        sums.copy_within(8..12, 0);
        sums.copy_within(4 * (width + 1)..4 * (width + 2), 4 * (width + 2));
        sums.copy_within(4 * (width + 1)..4 * (width + 2), 4 * (width + 3));
        let mut steps = vec![0u16; 4 * width];
        for (i, step) in steps.iter_mut().enumerate() {
            *step = binomial([sums[i], sums[i + 4], sums[i + 8], sums[i + 12], sums[i + 16]]).wrapping_add(8) / 16;
        }
        for (cell, step) in row.iter_mut().zip(steps.as_chunks::<4>().0) {
            let linear = |channel: usize| self.linear[usize::from(step[channel])];
            *cell = self.lab([linear(0), linear(1), linear(2)]);
        }
    }

    /// CIELAB of linear sRGB, white D65 (CIE 15; matrix of IEC 61966-2-1).
    fn lab(&self, [r, g, b]: [f32; 3]) -> [f32; 3] {
        let x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
        let (x, y, z) = (self.root(x), self.root(y), self.root(z));
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    fn root(&self, t: f32) -> f32 {
        let place = (t * (ROOTS as f32 / HIGHEST)).clamp(0.0, ROOTS as f32);
        let step = place as u16;
        let part = place - f32::from(step);
        let [here, next] = self.roots[usize::from(step)];
        here * (1.0 - part) + next * part
    }
}

/// Sixteen times the binomial mean of five neighbours; it never wraps, which is said so that it can be taken of many at once.
fn binomial([a, b, c, d, e]: [u16; 5]) -> u16 {
    let far = a.wrapping_add(e);
    let near = b.wrapping_add(d);
    far.wrapping_add(near.wrapping_mul(4)).wrapping_add(c.wrapping_mul(6))
}

/// The function of CIE 15 through which CIELAB takes its values: a cube root, a straight line near black.
fn lightness(t: f32) -> f32 {
    if t > 0.008_856 { cbrt(f64::from(t)) as f32 } else { 7.787 * t + 16.0 / 116.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_and_grey_have_their_lab() {
        let tables = Tables::new();
        let [l, a, b] = tables.lab([1.0; 3]);
        assert!((l - 100.0).abs() < 0.01 && a.abs() < 0.05 && b.abs() < 0.05);
        let [l, ..] = tables.lab([0.184_187; 3]);
        assert!((l - 50.0).abs() < 0.01);
    }

    #[test]
    fn the_table_of_roots_is_exact_enough() {
        let tables = Tables::new();
        for i in 0..10_000 {
            let t = i as f32 / 10_000.0;
            assert!((tables.root(t) - lightness(t)).abs() < 2e-5, "{t}");
        }
    }

    #[test]
    fn a_plain_picture_is_plain_up_to_its_rim() {
        let lab = lab_of(&Picture::filled(3, 2, [120, 60, 200, 255]));
        assert!(lab.cells.iter().all(|c| *c == lab.cells[0]));
        // the exact conversion gives L 40.2376
        assert!((lab.cells[0][0] - 40.2376).abs() < 0.02, "{:?}", lab.cells[0]);
    }
}
