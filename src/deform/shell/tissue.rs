//! What the mask says of the blade's tissue: how much each place moves, how deep inside the blade it lies, which way the veins
//! run, and how stiff they are. All are smooth over lengths that belong to the blade and not to its mesh.

use super::chart::Chart;
use super::settings::Settings;
use super::sheet::{Rib, Tensor};
use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::{pow, smooth_step};
use crate::base::vector::DVec2;
use crate::deform::Flat;

/// Widths over which the mask and the direction of the veins are smoothed, extents.
const MASK_WIDTH: f64 = 0.025;
const DIRECTION_WIDTH: f64 = 0.05;
const RIB_WIDTH: f64 = 0.03;
/// Share of a mask's typical slope below which the veins' direction counts as unknown.
const FAINT: f64 = 0.1;
/// Power of the mask's darkness that tells how much a place moves: below 1 lifts the dim inner blade, which else stays flat.
const DARKNESS: f64 = 0.75;
/// Width of the surroundings than which a vein is brighter, extents.
const VEIN_WIDTH: f64 = 0.06;
/// Difference from the surroundings that is no vein yet.
const FAINT_VEIN: f64 = 0.03;
/// Distances from the joint, extents, to which the petiole's foot reaches whole, and at which it has ended.
const FOOT: [f64; 2] = [0.08, 0.25];
/// How many times stiffer than the blade the foot is.
const FOOT_STIFFNESS: f64 = 100.0;
/// Places along a line at which the tissue is asked.
const READINGS: u32 = 6;
/// Every so many-th cell is asked for the greatest depth.
const STRIDE: usize = 7;

/// The tissue of a blade.
pub struct Tissue {
    chart: Chart,
    lively: Vec<f64>,
    has_foot: bool,
    /// Extent of the blade: the longer side of its bounding box, metres.
    pub extent: f64,
    /// Middle of the bounding box, extents.
    pub middle: DVec2,
    /// How much each triangle moves, 0 to 1: the mask's darkness to the power of `DARKNESS`.
    pub liveliness: Vec<f64>,
    /// Depth of each vertex below the margin, 0 there and 1 where it is deepest.
    pub depth: Vec<f64>,
    /// For each triangle n n' of the unit direction n across the veins; half the identity where there is none.
    pub across: Vec<Tensor>,
    /// For each triangle its stiffening by veins.
    pub ribs: Vec<Rib>,
}

impl Tissue {
    /// Of a leaf.
    pub fn new(settings: &Settings, flat: &Flat) -> Self {
        let mesh = flat.mesh;
        let (extent, middle) = bounds(mesh);
        let (chart, greys) = Chart::new(flat, extent);
        let raw: Vec<f64> = greys.iter().map(|grey| pow(1.0 - grey.clamp(0.0, 255.0) / 255.0, DARKNESS)).collect();
        let lively = chart.smoothed(&raw, MASK_WIDTH);
        let around = chart.smoothed(&raw, VEIN_WIDTH);
        let vein = |(lively, around): (&f64, &f64)| ((around - lively) / (0.5 * around + FAINT_VEIN)).clamp(0.0, 1.0);
        let veins = chart.smoothed(&lively.iter().zip(&around).map(vein).collect::<Vec<f64>>(), RIB_WIDTH);
        let beside = Directions::new(&chart, &veins, RIB_WIDTH);
        let across = Directions::new(&chart, &lively, DIRECTION_WIDTH);
        let has_foot = !mesh.held.is_empty();
        let parts: Vec<Parts> = mesh.triangles.iter().map(|t| parts(mesh, *t, extent)).collect();
        let rib = |points: &Parts| {
            let a = beside.over(points);
            Rib {
                stiffness: settings.vein_stiffness * mean(points, |p| chart.at(&veins, p)),
                along: [1.0 - a[0], -a[1], 1.0 - a[2]],
                thickening: FOOT_STIFFNESS * mean(points, |p| if has_foot { foot(p) } else { 0.0 }),
            }
        };
        let across: Vec<Tensor> = parts.iter().map(|points| across.over(points)).collect();
        let ribs: Vec<Rib> = parts.iter().map(rib).collect();
        let liveliness =
            parts.iter().map(|points| mean(points, |p| liveliness(&chart, &lively, has_foot, p))).collect();
        let depth = depth(mesh, &chart, extent);
        Self { extent, middle: middle / extent, liveliness, depth, across, ribs, lively, has_foot, chart }
    }

    /// How much a line moves, 0 to 1, on the mean.
    pub fn liveliness_along(&self, [from, to]: [DVec2; 2]) -> f64 {
        let at = |i: u32| from + (to - from) * ((f64::from(i) + 0.5) / f64::from(READINGS));
        (0..READINGS).map(|i| liveliness(&self.chart, &self.lively, self.has_foot, at(i))).sum::<f64>()
            / f64::from(READINGS)
    }
}

/// Longer side of the bounding box (1 where there is none), and its middle.
fn bounds(mesh: &FlatMesh) -> (f64, DVec2) {
    let Some([low, high]) = mesh.bounds() else { return (1.0, DVec2::zeros()) };
    let side = (high - low).max();
    (if side > 0.0 { side } else { 1.0 }, (low + high) * 0.5)
}

/// How much a place belongs to the foot: the thick tissue where petiole and main veins meet. It neither curls nor shrinks nor
/// bends, so that it does not matter which of its vertices the petiole holds.
fn foot(place: DVec2) -> f64 {
    1.0 - f64::from(smooth_step(FOOT[0] as f32, FOOT[1] as f32, place.norm() as f32))
}

fn liveliness(chart: &Chart, lively: &[f64], has_foot: bool, place: DVec2) -> f64 {
    chart.at(lively, place) * if has_foot { 1.0 - foot(place) } else { 1.0 }
}

/// Places that are evenly spread over a triangle.
type Parts = [DVec2; 16];

/// The middles of the sixteen parts into which its sides' quarters divide a triangle, extents.
fn parts(mesh: &FlatMesh, triangle: [u32; 3], extent: f64) -> Parts {
    let corners = triangle.map(|v| mesh.positions[v as usize] / extent);
    let middle = |[a, b, c]: [DVec2; 3]| (a + b + c) / 3.0;
    let mut places = [DVec2::zeros(); 16];
    for (quarter, four) in quarters(corners).into_iter().zip(places.chunks_exact_mut(4)) {
        four.copy_from_slice(&quarters(quarter).map(middle));
    }
    places
}

/// The four triangles into which its sides' middles divide a triangle.
fn quarters([a, b, c]: [DVec2; 3]) -> [[DVec2; 3]; 4] {
    let [x, y, z] = [(b + c) * 0.5, (c + a) * 0.5, (a + b) * 0.5];
    [[a, z, y], [z, b, x], [y, x, c], [x, y, z]]
}

fn mean(points: &Parts, of: impl Fn(DVec2) -> f64) -> f64 {
    points.iter().map(|&p| of(p)).sum::<f64>() / points.len() as f64
}

/// Across the veins the mask changes, along them it does not: the smoothed tensor of its slope.
struct Directions<'a> {
    chart: &'a Chart,
    tensors: [Vec<f64>; 3],
    /// Trace below which the direction counts as unknown.
    floor: f64,
}

impl<'a> Directions<'a> {
    fn new(chart: &'a Chart, values: &[f64], width: f64) -> Self {
        let mut raw = [0, 1, 2].map(|_| vec![0.0; values.len()]);
        for cell in chart.cells() {
            let slope = chart.slope(values, cell);
            let product = [slope.x * slope.x, slope.x * slope.y, slope.y * slope.y];
            raw.iter_mut().zip(product).for_each(|(raw, product)| raw[cell] = product);
        }
        let tensors = raw.map(|raw| chart.smoothed(&raw, width));
        let floor = FAINT * (chart.mean(&tensors[0]) + chart.mean(&tensors[2]));
        Self { chart, tensors, floor }
    }

    /// The tensor with unit trace, mean over some points.
    fn over(&self, points: &Parts) -> Tensor {
        let [xx, xy, yy] = [0, 1, 2].map(|k: usize| mean(points, |p| self.chart.at(&self.tensors[k], p)));
        let trace = xx + yy + self.floor;
        if trace > 0.0 {
            return [(xx + 0.5 * self.floor) / trace, xy / trace, (yy + 0.5 * self.floor) / trace];
        }
        [0.5, 0.0, 0.5]
    }
}

/// Depth of each vertex below the margin (of holes too), over the greatest depth of the blade. A chord cuts bays off, so where
/// the lines are known they are the margin, not the rim.
fn depth(mesh: &FlatMesh, chart: &Chart, extent: f64) -> Vec<f64> {
    let margin: Vec<[DVec2; 2]> =
        if mesh.lines.is_empty() { rim(mesh) } else { mesh.lines.iter().flat_map(|line| closed(line)).collect() };
    let scaled = |side: &[DVec2; 2]| side.map(|p| p / extent);
    let margin: Vec<[DVec2; 2]> = margin.iter().map(scaled).collect();
    let nearest = |p: DVec2| margin.iter().map(|side| squared_distance(p, side)).fold(f64::INFINITY, f64::min).sqrt();
    let deepest = chart.cells().step_by(STRIDE).map(|cell| nearest(chart.middle(cell))).fold(0.0, f64::max);
    let share = |p: &DVec2| if deepest > 0.0 { (nearest(p / extent) / deepest).min(1.0) } else { 0.0 };
    mesh.positions.iter().map(share).collect()
}

/// The sides that have one triangle.
fn rim(mesh: &FlatMesh) -> Vec<[DVec2; 2]> {
    let mut sides: Vec<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    sides.sort_unstable();
    let once = sides.chunk_by(|x, y| x == y).filter(|same| same.len() == 1);
    once.map(|same| same[0].map(|v| mesh.positions[v as usize])).collect()
}

/// The sides of a closed line.
pub(super) fn closed(line: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    line.iter().zip(line.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
}

fn squared_distance(p: DVec2, [a, b]: &[DVec2; 2]) -> f64 {
    let side = b - a;
    let foot = ((p - a).dot(&side) / side.norm_squared()).clamp(0.0, 1.0);
    (p - a - side * foot).norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_from_a_side_is_that_from_its_nearest_point() {
        let side = [DVec2::zeros(), DVec2::new(2.0, 0.0)];
        let distance = |x: f64, y: f64| squared_distance(DVec2::new(x, y), &side).sqrt();
        assert!((distance(1.5, 0.5) - 0.5).abs() < 1e-15 && (distance(5.0, 4.0) - 5.0).abs() < 1e-15);
    }

    #[test]
    fn the_foot_is_whole_at_the_joint_and_ends() {
        assert_eq!((foot(DVec2::zeros()), foot(DVec2::new(0.0, FOOT[1]))), (1.0, 0.0));
    }
}
