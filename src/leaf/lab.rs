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
    /// The lightness function of CIE 15 at each step of its argument, one more than `ROOTS` for interpolation.
    roots: Vec<f32>,
}

impl Tables {
    fn new() -> Self {
        let linear = (0..STEPS).map(|i| srgb_to_linear(i as f32 * 16.0 / 65_280.0)).collect();
        let root = |i: usize| lightness(i as f32 * HIGHEST / ROOTS as f32);
        Self { linear, roots: (0..ROOTS + 2).map(root).collect() }
    }

    /// Converts row `y`.
    fn fill(&self, picture: &Picture, y: usize, row: &mut [[f32; 3]]) {
        let (width, height) = (picture.width as usize, picture.height as i64);
        let rows = [-2, -1, 0, 1, 2].map(|d| (y as i64 + d).clamp(0, height - 1) as usize * width);
        let [a, b, c, d, e] = rows.map(|start| &picture.pixels[start..start + width]);
        let sum = |x: usize| {
            let channel = |i: usize| {
                let far = u32::from(a[x][i]) + u32::from(e[x][i]);
                far + 4 * (u32::from(b[x][i]) + u32::from(d[x][i])) + 6 * u32::from(c[x][i])
            };
            [channel(0), channel(1), channel(2)]
        };
        // two columns continued on either side
        let sums: Vec<[u32; 3]> = (0..width + 4).map(|x| sum(x.saturating_sub(2).min(width - 1))).collect();
        for (cell, taps) in row.iter_mut().zip(sums.windows(5)) {
            let code = |i: usize| taps[0][i] + 4 * (taps[1][i] + taps[3][i]) + 6 * taps[2][i] + taps[4][i];
            // 256 times the code, at most 65,280
            *cell = self.lab([0, 1, 2].map(|i| self.linear[((code(i) + 8) / 16) as usize]));
        }
    }

    /// CIELAB of linear sRGB, white D65 (CIE 15; matrix of IEC 61966-2-1).
    fn lab(&self, [r, g, b]: [f32; 3]) -> [f32; 3] {
        let x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
        let [x, y, z] = [x, y, z].map(|t| self.root(t));
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    fn root(&self, t: f32) -> f32 {
        let place = (t * (ROOTS as f32 / HIGHEST)).clamp(0.0, ROOTS as f32);
        let step = place as usize;
        let part = place - step as f32;
        self.roots[step] * (1.0 - part) + self.roots[step + 1] * part
    }
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
