//! A scan cut out and brought to the resolution at which veins are sought, which follows from the blade's size and not from
//! the picture's: the same leaf scanned twice as finely gives the same veins.

use crate::base::maths::{cbrt, srgb_to_linear};
use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;
use crate::leaf::trace::Trace;
use rayon::prelude::*;

/// Cells along the square root of the blade's area; a smaller picture is taken as it is.
const RESOLUTION: f64 = 400.0;
/// Empty cells round the blade.
const RIM: f64 = 3.0;
/// The outermost colours, mixed with the background's, are not looked at: share of the size, and cells at least.
const MIXED: (f64, f64) = (0.003, 1.0);
/// Half the width of the broadest vein, share of the size.
const SLENDER: f64 = 0.010;
/// No ridge counts nearer to the margin than this share of the size.
const MARGIN: f64 = 0.010;
/// Weight of Lab's a* (green to red) against lightness: veins of many leaves are redder than the blade.
const REDNESS: f32 = 0.5;

/// The leaf at working resolution.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Lightness and redness, Lab units; 0 off the leaf.
    pub tone: Grid<f32>,

    /// True on the blade.
    pub inside: Grid<bool>,
    /// True where the colour is surely the blade's.
    pub sure: Grid<bool>,
    /// True away from the margin.
    pub inner: Grid<bool>,
    /// Square root of the blade's area, cells.
    pub size: f64,
    /// Pixels of the picture along a cell's side.
    pub step: f64,
    /// The picture's pixel at the grid's top left corner.
    pub origin: DVec2,
}

impl Sheet {
    /// Cuts out; `None` when there is no blade.
    pub fn new(picture: &Picture, trace: &Trace) -> Option<Self> {
        let area = trace.blade.area() as f64;
        if area < 1.0 {
            return None;
        }
        let step = (area.sqrt() / RESOLUTION).max(1.0);
        let (low, high) = extent(&trace.blade);
        let origin = low - DVec2::repeat(RIM * step);
        let cells = ((high - low) / step).map(|side| side.ceil() + 2.0 * RIM);
        let (width, height) = (cells.x as usize, cells.y as usize);
        let frame = Frame { origin, step, width };
        let sampled: Vec<Sample> =
            (0..width * height).into_par_iter().map(|cell| frame.sample(picture, trace, cell)).collect();
        let grid = |of: &dyn Fn(&Sample) -> bool| Grid { width, height, cells: sampled.iter().map(of).collect() };
        let inside = grid(&|s| s.0 > 0.5);
        let size = area.sqrt() / step;
        // What is as slender as a vein is one, though its colour be nearer to the background's than to the leaf's.
        let hidden = grid(&|s| s.0 > 0.5 && s.2 < 0.5 * s.0).opened((SLENDER * size).max(1.0));
        let other = hidden.cells.iter().zip(&inside.cells).map(|(hidden, inside)| *hidden || !inside).collect();
        let from_hidden = Grid { width, height, cells: other }.squared_distances().map(|d| d.sqrt());
        let sure = from_hidden.map(|d| d > (MIXED.0 * size).max(MIXED.1));
        let inner = from_hidden.map(|d| d > (MARGIN * size).max(2.0));
        let tones = sampled.par_iter().map(|s| if s.0 > 0.0 { tone(s.1) } else { 0.0 }).collect();
        Some(Self { tone: Grid { width, height, cells: tones }, inside, sure, inner, size, step, origin })
    }

    /// The picture's place (pixels) of a place on the grid (cells).
    pub fn pixel(&self, place: DVec2) -> DVec2 {
        self.origin + place * self.step
    }

    /// The place on the grid (cells) of a place in the picture (pixels).
    pub fn place(&self, pixel: DVec2) -> DVec2 {
        (pixel - self.origin) / self.step
    }
}

/// Share of a cell in the blade; mean encoded colour there; share of it that shows the blade's own colour.
type Sample = (f32, [f32; 3], f32);

struct Frame {
    origin: DVec2,
    step: f64,
    width: usize,
}

impl Frame {
    /// Share of a cell in the blade; mean encoded colour of the blade's pixels; share of those that show the blade's own colour.
    fn sample(&self, picture: &Picture, trace: &Trace, cell: usize) -> Sample {
        let corner = self.origin + DVec2::new((cell % self.width) as f64, (cell / self.width) as f64) * self.step;
        // Pixels count by the share of them that lies in the cell.
        let overlap = |from: f64, i: u32| (from + self.step).min(f64::from(i) + 1.0) - from.max(f64::from(i));
        let range = |from: f64, size: u32| {
            let clamp = |x: f64| x.clamp(0.0, f64::from(size)) as u32;
            clamp(from.floor())..clamp((from + self.step).ceil())
        };
        let (mut blade, mut shown, mut count) = (0.0f32, 0.0f32, 0.0f32);
        let mut sums = [0.0f32; 3];
        for y in range(corner.y, picture.height) {
            for x in range(corner.x, picture.width) {
                let weight = (overlap(corner.x, x) * overlap(corner.y, y)) as f32;
                count += weight;
                if trace.shown.at(x as usize, y as usize) {
                    shown += weight;
                }
                if trace.blade.at(x as usize, y as usize) {
                    let pixel = picture.at(x, y);
                    blade += weight;
                    sums = [0, 1, 2].map(|c| sums[c] + weight * f32::from(pixel[c]));
                }
            }
        }
        let share = |part: f32| part / count.max(1e-6);
        (share(blade), sums.map(|s| s / blade.max(1e-6)), share(shown))
    }
}

/// Corners of the box round the true cells.
fn extent(grid: &Grid<bool>) -> (DVec2, DVec2) {
    let mut low = DVec2::repeat(f64::INFINITY);
    let mut high = DVec2::repeat(f64::NEG_INFINITY);
    for (y, row) in grid.cells.chunks_exact(grid.width.max(1)).enumerate() {
        let first = row.iter().position(|&c| c);
        let last = row.iter().rposition(|&c| c);
        if let (Some(first), Some(last)) = (first, last) {
            low = low.inf(&DVec2::new(first as f64, y as f64));
            high = high.sup(&DVec2::new((last + 1) as f64, (y + 1) as f64));
        }
    }
    (low, high)
}

/// CIELAB's lightness plus part of its a*, of an encoded sRGB colour (white D65, CIE 15).
fn tone(code: [f32; 3]) -> f32 {
    let [r, g, b] = code.map(|c| srgb_to_linear(c / 255.0));
    let root = |t: f32| if t > 0.008_856 { cbrt(f64::from(t)) as f32 } else { 7.787 * t + 16.0 / 116.0 };
    let x = root((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505);
    let y = root(0.2126 * r + 0.7152 * g + 0.0722 * b);
    116.0 * y - 16.0 + REDNESS * 500.0 * (x - y)
}
