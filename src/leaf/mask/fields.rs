//! What the law of the mask is made of, on the grid of the mask's pixels: depth, tipness, ways to the joint, nearness of veins.

use super::geodesic::ways;
use super::{Mask, SIDE};
use crate::base::blade::Vein;
use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::exp;
use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;
use crate::leaf::polygon;
use crate::leaf::raster::{filled, middle_of};

/// Share of a main vein's reach that a secondary has; veins of the third order are too slender to hold the blade.
const REACHES: [f64; 2] = [1.0, 0.7];
/// Beyond this many reaches a vein is not felt: exp(-5.8) is less than a grey.
const FELT: f64 = 2.4;
/// Points of a vein nearer together than this many reaches are left out: the white is too broad to show them.
const STRIDE: f64 = 0.5;
/// Tipness and ways are smooth: they are found on cells of two pixels a side.
const COARSE: usize = 2;

/// How the plane lies in the mask.
pub struct Layout<'a> {
    mesh: &'a FlatMesh,
    /// Pixels in a metre.
    pub scale: f64,
    /// Square root of the blade's area, pixels.
    pub size: f64,
}

impl<'a> Layout<'a> {
    /// That of the mesh's texture coordinates.
    pub fn new(mesh: &'a FlatMesh, outline: &[DVec2]) -> Self {
        let scale = mesh.uv_scale * SIDE as f64;
        Self { mesh, scale, size: (0.5 * polygon::doubled_area(outline).abs()).sqrt() * scale }
    }

    /// The place in the mask, pixels, of a place in the plane.
    fn place(&self, p: DVec2) -> DVec2 {
        let origin = self.mesh.uv_origin * SIDE as f64;
        DVec2::new(origin.x + self.scale * p.x, origin.y - self.scale * p.y)
    }
}

/// Values from 0 to 1 for each pixel; they mean something inside only.
pub struct Fields {
    /// Whether the pixel's middle lies in the blade.
    pub inside: Grid<bool>,
    /// Distance from the margin, 1 at the deepest place.
    pub depth: Grid<f32>,
    /// 1 at a needle's point, 0 where half of the disc about the place or more lies in the blade.
    pub tipness: Grid<f32>,
    /// Way to the joint within the blade, 1 at the farthest place.
    pub way: Grid<f32>,
    /// 1 at the joint, falling off as a Gaussian.
    pub nearness: Grid<f32>,
}

impl Fields {
    /// Finds all of them.
    pub fn new(layout: &Layout, outline: &[DVec2], holes: &[&[DVec2]], law: &Mask) -> Self {
        let inside = blade(layout, outline, holes);
        let coarse = coarsened(&inside);
        let to_fine = |coarse: &Grid<f32>| {
            let at = |i: usize| coarse.at(i % SIDE / COARSE, i / SIDE / COARSE);
            Grid { width: SIDE, height: SIDE, cells: (0..SIDE * SIDE).map(at).collect() }
        };
        let steps = ways(&coarse, joint(layout, &coarse));
        let farthest = steps.cells.iter().copied().filter(|s| s.is_finite()).fold(0.0f32, f32::max).max(1e-6);
        let reach = (law.petiole_reach * layout.size / COARSE as f64).max(1e-6);
        // Parts without a way to the joint count as far.
        let near = |s: f32| {
            let s = f64::from(s.min(1e6)) / reach;
            exp(-s * s) as f32
        };
        Self {
            depth: depth(&inside),
            tipness: to_fine(&tipness(&coarse, law.tip_radius * layout.size / COARSE as f64)),
            way: to_fine(&steps.map(|s| (s / farthest).min(1.0))),
            nearness: to_fine(&steps.map(near)),
            inside,
        }
    }
}

fn blade(layout: &Layout, outline: &[DVec2], holes: &[&[DVec2]]) -> Grid<bool> {
    let placed = |line: &[DVec2]| line.iter().map(|&p| layout.place(p)).collect::<Vec<DVec2>>();
    let mut inside = filled(&[&placed(outline)], SIDE, SIDE);
    for hole in holes {
        let hole = filled(&[&placed(hole)], SIDE, SIDE);
        inside.cells.iter_mut().zip(&hole.cells).for_each(|(inside, hole)| *inside = *inside && !hole);
    }
    inside
}

/// A cell is in the blade when any of its pixels is.
fn coarsened(inside: &Grid<bool>) -> Grid<bool> {
    let side = SIDE / COARSE;
    let any = |i: usize| {
        let (x, y) = (i % side * COARSE, i / side * COARSE);
        (0..COARSE * COARSE).any(|k| inside.at(x + k % COARSE, y + k / COARSE))
    };
    Grid { width: side, height: side, cells: (0..side * side).map(any).collect() }
}

/// The cell of the blade nearest to the joint.
fn joint(layout: &Layout, coarse: &Grid<bool>) -> usize {
    let place = layout.place(DVec2::zeros()) / COARSE as f64;
    let distance = |&i: &usize| (middle_of(coarse.width, i) - place).norm_squared();
    let inside = (0..coarse.cells.len()).filter(|&i| coarse.cells[i]);
    inside.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

fn depth(inside: &Grid<bool>) -> Grid<f32> {
    // The margin runs about half a pixel this side of the nearest pixel outside.
    let distances = inside.map(|c| !c).squared_distances().map(|d| (d.sqrt() - 0.5).max(0.0) as f32);
    let deepest = distances.cells.iter().copied().filter(|d| *d < 1e6).fold(0.0f32, f32::max).max(1e-6);
    distances.map(|d| (d / deepest).min(1.0))
}

/// 1 less twice the share of the disc of a radius (cells) about each cell that lies in the blade.
fn tipness(inside: &Grid<bool>, radius: f64) -> Grid<f32> {
    let sums = row_sums(inside);
    let (width, height, rows) = (inside.width as i64, inside.height as i64, radius.floor() as i64);
    let half = |dy: i64| (radius * radius - (dy * dy) as f64).max(0.0).sqrt().floor() as i64;
    let halves: Vec<i64> = (0..=rows).map(half).collect();
    let whole: i64 = (-rows..=rows).map(|dy| 2 * halves[dy.unsigned_abs() as usize] + 1).sum();
    let share = |i: usize| {
        let (x, y) = (i as i64 % width, i as i64 / width);
        let row = |dy: i64| {
            let half = halves[dy.unsigned_abs() as usize];
            let start = (y + dy) * (width + 1);
            let cut = |x: i64| (start + x.clamp(0, width)) as usize;
            i64::from(sums[cut(x + half + 1)] - sums[cut(x - half)])
        };
        let held: i64 = (-rows..=rows).filter(|dy| (0..height).contains(&(y + dy))).map(row).sum();
        (1.0 - 2.0 * held as f32 / whole as f32).max(0.0)
    };
    let value = |i: usize| if inside.cells[i] { share(i) } else { 0.0 };
    Grid { cells: (0..inside.cells.len()).map(value).collect(), width: inside.width, height: inside.height }
}

/// For each row the number of true cells before each column, one more column than the grid has.
fn row_sums(inside: &Grid<bool>) -> Vec<u32> {
    let mut sums = Vec::with_capacity((inside.width + 1) * inside.height);
    for row in inside.cells.chunks_exact(inside.width) {
        let mut sum = 0;
        sums.push(sum);
        for &cell in row {
            sum += u32::from(cell);
            sums.push(sum);
        }
    }
    sums
}

/// 1 on a vein that holds the blade, falling off beside it as a Gaussian of the reach (pixels).
pub fn whiteness(layout: &Layout, veins: &[Vein], reach: f64) -> Grid<f32> {
    let mut nearest = Grid { width: SIDE, height: SIDE, cells: vec![f32::INFINITY; SIDE * SIDE] };
    for vein in veins {
        if let Some(share) = REACHES.get(usize::from(vein.order.max(1)) - 1) {
            let reach = (reach * share).max(1e-6);
            let points = placed(layout, vein, STRIDE * reach);
            for ends in points.windows(2) {
                stamp(&mut nearest, ends[0], ends[1], reach);
            }
        }
    }
    nearest.map(|d| if d.is_finite() { exp(-f64::from(d)) as f32 } else { 0.0 })
}

/// A vein's points with half its width there, pixels; without those nearer than a distance to the last one kept, but with
/// both ends.
fn placed(layout: &Layout, vein: &Vein, apart: f64) -> Vec<(DVec2, f64)> {
    let last = vein.points.len().saturating_sub(1);
    let mut kept: Vec<(DVec2, f64)> = Vec::new();
    for (i, &p) in vein.points.iter().enumerate() {
        let place = layout.place(p);
        if i == last || kept.last().is_none_or(|(before, _)| (place - before).norm() >= apart) {
            let width = vein.width + (vein.end_width - vein.width) * i as f64 / last.max(1) as f64;
            kept.push((place, 0.5 * width * layout.scale));
        }
    }
    kept
}

/// Lowers the squared distances from the vein's edge, in reaches, of the pixels that feel a straight piece of vein.
fn stamp(nearest: &mut Grid<f32>, (a, half): (DVec2, f64), (b, half_b): (DVec2, f64), reach: f64) {
    let half = 0.5 * (half + half_b);
    let felt = DVec2::repeat(FELT * reach + half);
    let (low, high) = (a.inf(&b) - felt, a.sup(&b) + felt);
    let pixel = |x: f64, side: usize| x.clamp(0.0, side as f64) as usize;
    for y in pixel(low.y, nearest.height)..pixel(high.y + 1.0, nearest.height) {
        for x in pixel(low.x, nearest.width)..pixel(high.x + 1.0, nearest.width) {
            let place = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let distance = (polygon::segment_distance(place, a, b) - half).max(0.0) / reach;
            if distance < FELT {
                let cell = &mut nearest.cells[y * SIDE + x];
                *cell = cell.min((distance * distance) as f32);
            }
        }
    }
}
