//! The blade on a grid of cells, on which what the mask says is smoothed and differentiated: lengths here belong to the blade,
//! so that the tissue is the same whatever the mesh. All lengths are in extents of the blade.

use super::tissue::closed;
use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::exp;
use crate::base::vector::{DVec2, Vec2};
use crate::deform::Flat;

/// Cells along the longer side of the blade.
const CELLS: f64 = 128.0;
/// Places along each side of a cell at which a mask is read.
const READINGS: u32 = 4;
/// Kernels reach this many standard deviations.
const REACH: f64 = 3.0;
/// Weight of the blade below which a cell is too far from it to have a value.
const NOTHING: f64 = 1e-12;

/// The grid, and which of its cells lie in the blade.
pub struct Chart {
    /// Middle of the first cell.
    origin: DVec2,
    width: usize,
    height: usize,
    /// 1 in the blade, 0 beside it.
    inside: Vec<f64>,
}

impl Chart {
    /// That of a leaf whose coordinates are divided by `extent`, and the mask's grey in each of its cells.
    pub fn new(flat: &Flat, extent: f64) -> (Self, Vec<f64>) {
        let places: Vec<DVec2> = flat.mesh.positions.iter().map(|p| p / extent).collect();
        let [low, high] = flat.mesh.bounds().unwrap_or_default().map(|corner| corner / extent);
        // An odd number about the middle, so that a mirrored blade has the mirrored grid.
        let cells = |k: usize| 2 * ((high[k] - low[k]) * CELLS * 0.5).ceil().clamp(1.0, CELLS) as usize + 1;
        let (width, height) = (cells(0), cells(1));
        let origin = (low + high) * 0.5 - DVec2::new((width / 2) as f64, (height / 2) as f64) / CELLS;
        let mut chart = Self { origin, width, height, inside: vec![0.0; width * height] };
        let mut greys = vec![0.0f64; width * height];
        for (&place, grey) in places.iter().zip(&flat.mesh.greys) {
            let cell = chart.cell(place);
            chart.inside[cell] = 1.0;
            // Of several corners in a cell the lightest counts, whatever their order.
            greys[cell] = greys[cell].max(*grey);
        }
        for (cell, grey) in chart.covered(flat.mesh, &places) {
            chart.inside[cell] = 1.0;
            greys[cell] = grey;
        }
        if let Some(mask) = flat.mask {
            // A picture has greys beyond the mesh, so the blade need not end with its triangles.
            chart.enclose(&flat.mesh.lines, extent);
            let reading = |uv: Vec2| {
                let along = |at: f32, count: u32| (f64::from(at) * f64::from(count)).clamp(0.0, f64::from(count) - 1.0);
                let pixel = mask.at(along(uv.x, mask.width) as u32, along(uv.y, mask.height) as u32);
                f64::from(u32::from(pixel[0]) + u32::from(pixel[1]) + u32::from(pixel[2])) / 3.0
            };
            for cell in (0..greys.len()).filter(|&cell| chart.inside[cell] > 0.0) {
                let read = |k: u32| {
                    let part = |i: u32| (f64::from(i) + 0.5) / f64::from(READINGS) - 0.5;
                    let place = chart.middle(cell) + DVec2::new(part(k % READINGS), part(k / READINGS)) / CELLS;
                    reading(flat.mesh.uv(place * extent))
                };
                greys[cell] = (0..READINGS * READINGS).map(read).sum::<f64>() / f64::from(READINGS * READINGS);
            }
        }
        (chart, greys)
    }

    /// Takes the cells that lines pass or enclose for the blade, if there are lines.
    fn enclose(&mut self, lines: &[Vec<DVec2>], extent: f64) {
        if lines.is_empty() {
            return;
        }
        self.inside.fill(0.0);
        let mut crossings = vec![Vec::new(); self.height];
        for line in lines {
            let at = |p: DVec2| (p / extent - self.origin) * CELLS;
            for [a, b] in closed(line).map(|side| side.map(at)) {
                let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
                // Rows whose middles the side passes: from its lower end on, up to its upper one.
                let row = |y: f64| y.ceil().clamp(0.0, self.height as f64) as usize;
                for y in row(low.y)..row(high.y) {
                    crossings[y].push(low.x + (high.x - low.x) * ((y as f64 - low.y) / (high.y - low.y)));
                }
            }
        }
        for (y, crossings) in crossings.iter_mut().enumerate() {
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let column = |x: f64| x.ceil().clamp(0.0, self.width as f64) as usize;
                self.inside[y * self.width..][column(pair[0])..column(pair[1])].fill(1.0);
            }
        }
        // A blade may be thinner than a cell.
        for p in lines.iter().flatten() {
            let cell = self.cell(p / extent);
            self.inside[cell] = 1.0;
        }
    }

    /// The cells whose middles triangles cover, each with the grey there.
    fn covered(&self, mesh: &FlatMesh, places: &[DVec2]) -> Vec<(usize, f64)> {
        let mut covered = Vec::new();
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|v| places[v as usize]);
            let greys = corners.map(|v| mesh.greys[v as usize]);
            let area = (b - a).perp(&(c - a));
            let (first, last) = (self.cell(a.inf(&b).inf(&c)), self.cell(a.sup(&b).sup(&c)));
            for y in first / self.width..=last / self.width {
                for cell in y * self.width + first % self.width..=y * self.width + last % self.width {
                    let p = self.middle(cell);
                    let shares = [(c - b).perp(&(p - b)), (a - c).perp(&(p - c)), (b - a).perp(&(p - a))];
                    if shares.iter().all(|&share| share >= 0.0) {
                        covered.push((cell, (0..3).map(|i| shares[i] / area * greys[i]).sum()));
                    }
                }
            }
        }
        covered
    }

    /// The cell of a place; the nearest one for a place beside the grid.
    fn cell(&self, place: DVec2) -> usize {
        let [x, y] = self.within(place).map(|at| (at + 0.5) as usize);
        y * self.width + x
    }

    /// A place in cells from the first one's middle.
    fn within(&self, place: DVec2) -> [f64; 2] {
        let at = (place - self.origin) * CELLS;
        [at.x.clamp(0.0, (self.width - 1) as f64), at.y.clamp(0.0, (self.height - 1) as f64)]
    }

    /// The middle of a cell.
    pub fn middle(&self, cell: usize) -> DVec2 {
        self.origin + DVec2::new((cell % self.width) as f64, (cell / self.width) as f64) / CELLS
    }

    /// The cells in the blade.
    pub fn cells(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.inside.len()).filter(|&cell| self.inside[cell] > 0.0)
    }

    /// Mean of values over the blade.
    pub fn mean(&self, values: &[f64]) -> f64 {
        self.cells().map(|cell| values[cell]).sum::<f64>() / self.inside.iter().sum::<f64>().max(1.0)
    }

    /// Values blurred by a Gauss bell of this deviation, as far as it lies in the blade. They go on beyond its margin.
    pub fn smoothed(&self, values: &[f64], deviation: f64) -> Vec<f64> {
        let weighted = values.iter().zip(&self.inside).map(|(value, inside)| value * inside).collect();
        let (sums, weights) = (self.blurred(weighted, deviation), self.blurred(self.inside.clone(), deviation));
        sums.iter().zip(&weights).map(|(sum, weight)| if *weight > NOTHING { sum / weight } else { 0.0 }).collect()
    }

    fn blurred(&self, mut values: Vec<f64>, deviation: f64) -> Vec<f64> {
        let kernel = bell(deviation * CELLS);
        let mut line = Vec::new();
        for (lines, count, stride, next) in
            [(self.height, self.width, 1, self.width), (self.width, self.height, self.width, 1)]
        {
            for start in (0..lines).map(|i| i * next) {
                line.clear();
                line.extend((0..count).map(|i| values[start + i * stride]));
                for i in 0..count {
                    let after = kernel.iter().zip(&line[i..]).map(|(k, v)| k * v).sum::<f64>();
                    let before = kernel.iter().skip(1).zip(line[..i].iter().rev()).map(|(k, v)| k * v).sum::<f64>();
                    values[start + i * stride] = before + after;
                }
            }
        }
        values
    }

    /// A value at a place, between the cells' middles.
    pub fn at(&self, values: &[f64], place: DVec2) -> f64 {
        let [x, y] = self.within(place);
        let (left, low) = (x.floor() as usize, y.floor() as usize);
        let (right, high) = ((left + 1).min(self.width - 1), (low + 1).min(self.height - 1));
        let (u, v) = (x - x.floor(), y - y.floor());
        let row = |y: usize| values[y * self.width + left] * (1.0 - u) + values[y * self.width + right] * u;
        row(low) * (1.0 - v) + row(high) * v
    }

    /// Slope of smoothed values in a cell.
    pub fn slope(&self, values: &[f64], cell: usize) -> DVec2 {
        let (x, y) = (cell % self.width, cell / self.width);
        let between =
            |low: usize, high: usize, apart: usize| (values[high] - values[low]) * CELLS / apart.max(1) as f64;
        let (left, right) = (x.saturating_sub(1), (x + 1).min(self.width - 1));
        let (low, high) = (y.saturating_sub(1), (y + 1).min(self.height - 1));
        let row = y * self.width;
        DVec2::new(
            between(row + left, row + right, right - left),
            between(low * self.width + x, high * self.width + x, high - low),
        )
    }
}

/// Half of a Gauss bell from its middle outwards.
fn bell(deviation: f64) -> Vec<f64> {
    let weight = |i: u32| exp(-0.5 * f64::from(i * i) / (deviation * deviation));
    (0..=(REACH * deviation).ceil().max(1.0) as u32).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles with a grey that rises to the right and, three times as much, upwards.
    fn square(side: f64) -> FlatMesh {
        let positions: Vec<DVec2> =
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y) * side).to_vec();
        let greys = positions.iter().map(|p| 10.0 + 20.0 * p.x / side + 60.0 * p.y / side).collect();
        FlatMesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], greys, ..FlatMesh::default() }
    }

    #[test]
    fn a_plane_of_greys_keeps_its_values_and_slopes() {
        let mesh = square(0.07);
        let (chart, greys) = Chart::new(&Flat::from(&mesh), 0.07);
        assert_eq!(chart.cells().count(), greys.len(), "the square is all blade");
        let place = DVec2::new(0.31, 0.52);
        assert!((chart.at(&greys, place) - 10.0 - 20.0 * 0.31 - 60.0 * 0.52).abs() < 1e-9);
        // A blur changes no plane but at the margin.
        let smooth = chart.smoothed(&greys, 0.02);
        assert!((chart.at(&smooth, place) - chart.at(&greys, place)).abs() < 1e-3);
        let slope = chart.slope(&smooth, chart.cell(place));
        assert!((slope - DVec2::new(20.0, 60.0)).norm() < 0.05, "{slope}");
    }

    #[test]
    fn blurs_keep_what_is_even_and_have_their_width() {
        let mesh = square(1.0);
        let (chart, greys) = Chart::new(&Flat::from(&mesh), 1.0);
        let even = chart.smoothed(&vec![3.0; greys.len()], 0.06);
        assert!(even.iter().all(|v| (v - 3.0).abs() < 1e-12));
        let mut dot = vec![0.0; greys.len()];
        dot[chart.cell(DVec2::new(0.5, 0.5))] = 1.0;
        let bell = chart.smoothed(&dot, 0.05);
        let sum: f64 = bell.iter().sum();
        let spread = |cell: usize| (chart.middle(cell).x - 0.5) * (chart.middle(cell).x - 0.5);
        let variance = chart.cells().map(|cell| bell[cell] * spread(cell)).sum::<f64>() / sum;
        assert!((variance.sqrt() / 0.05 - 1.0).abs() < 0.03, "{variance}");
    }

    #[test]
    fn a_blade_thinner_than_a_cell_is_still_seen() {
        let positions = [(0.0, 0.0), (1e-4, 0.5), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        let mesh = FlatMesh { positions, triangles: vec![[0, 1, 2]], greys: vec![7.0; 3], ..FlatMesh::default() };
        let (chart, greys) = Chart::new(&Flat::from(&mesh), 1.0);
        let smooth = chart.smoothed(&greys, 0.02);
        assert!((chart.at(&smooth, DVec2::new(0.0, 0.5)) - 7.0).abs() < 1e-9);
    }
}
