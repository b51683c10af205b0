//! What the mask says of the blade's tissue: how much each place moves, how deep inside the blade it lies, which way the veins
//! run, and how stiff they are. All are smooth over lengths that belong to the blade and not to its mesh.

use super::settings::Settings;
use super::sheet::{Rib, Tensor};
use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::pow;
use crate::base::vector::DVec2;

/// Widths over which the mask and the direction of the veins are smoothed, extents.
const MASK_WIDTH: f64 = 0.02;
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
/// Variance in squares of an edge that one averaging over six neighbours and itself adds along an axis: 6 / 7 / 2.
const SPREAD: f64 = 3.0 / 7.0;
/// Most averagings; more are wanted by meshes of over 100,000 vertices only.
const MOST_PASSES: f64 = 1000.0;

/// The tissue of a blade.
#[derive(Clone, Debug, PartialEq)]
pub struct Tissue {
    /// Extent of the blade: the longer side of its bounding box, metres.
    pub extent: f64,
    /// Middle of the bounding box, extents.
    pub middle: DVec2,
    /// How much each vertex moves, 0 to 1: the mask's darkness to the power of `DARKNESS`.
    pub liveliness: Vec<f64>,
    /// Depth of each vertex below the margin, 0 there and 1 where it is deepest.
    pub depth: Vec<f64>,
    /// For each triangle n n' of the unit direction n across the veins; half the identity where there is none.
    pub across: Vec<Tensor>,
    /// For each triangle its stiffening by veins.
    pub ribs: Vec<Rib>,
}

impl Tissue {
    /// Of a mesh with its mask's greys.
    pub fn new(settings: &Settings, mesh: &FlatMesh) -> Self {
        let (extent, middle) = bounds(mesh);
        let neighbours = Neighbours::of(mesh, extent);
        let lively: Vec<f64> =
            mesh.greys.iter().map(|grey| pow(1.0 - grey.clamp(0.0, 255.0) / 255.0, DARKNESS)).collect();
        let liveliness = neighbours.smoothed(lively.clone(), MASK_WIDTH);
        let around = neighbours.smoothed(lively.clone(), VEIN_WIDTH);
        let vein = |(lively, around): (&f64, &f64)| ((around - lively) / (0.5 * around + FAINT_VEIN)).clamp(0.0, 1.0);
        let veins: Vec<f64> = neighbours.smoothed(liveliness.iter().zip(&around).map(vein).collect(), RIB_WIDTH);
        let beside = across(mesh, &neighbours, &veins, RIB_WIDTH);
        let across = across(mesh, &neighbours, &liveliness, DIRECTION_WIDTH);
        let corner_mean = |values: &[f64], t: &[u32; 3]| t.iter().map(|&v| values[v as usize]).sum::<f64>() / 3.0;
        let rib = |(t, a): (&[u32; 3], &Tensor)| Rib {
            stiffness: settings.vein_stiffness * corner_mean(&veins, t),
            along: [1.0 - a[0], -a[1], 1.0 - a[2]],
        };
        let ribs = mesh.triangles.iter().zip(&beside).map(rib).collect();
        Self { extent, middle: middle / extent, liveliness, depth: depth(mesh), across, ribs }
    }
}

/// Longer side of the bounding box (1 where there is none), and its middle.
fn bounds(mesh: &FlatMesh) -> (f64, DVec2) {
    let Some(&first) = mesh.positions.first() else { return (1.0, DVec2::zeros()) };
    let (low, high) = mesh.positions.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let side = (high - low).max();
    (if side > 0.0 { side } else { 1.0 }, (low + high) * 0.5)
}

/// The vertices joined to each by an edge.
struct Neighbours {
    edges: Vec<[u32; 2]>,
    extent: f64,
    /// Mean square of the edges' lengths, squares of the extent.
    mean_square: f64,
}

impl Neighbours {
    fn of(mesh: &FlatMesh, extent: f64) -> Self {
        let edges = mesh.edges();
        let square = |e: &[u32; 2]| (mesh.positions[e[0] as usize] - mesh.positions[e[1] as usize]).norm_squared();
        let mean_square = edges.iter().map(square).sum::<f64>() / edges.len().max(1) as f64 / (extent * extent);
        Self { edges, extent, mean_square }
    }

    /// Values averaged with their neighbours' until they are blurred by a Gauss bell of this width (extents); the last time
    /// only as far as is wanting.
    fn smoothed(&self, mut values: Vec<f64>, width: f64) -> Vec<f64> {
        let mut wanting = (width * width / (SPREAD * self.mean_square)).min(MOST_PASSES);
        while wanting > 0.0 {
            let mut sums = values.clone();
            let mut counts = vec![1.0; values.len()];
            for &[a, b] in &self.edges {
                let (a, b) = (a as usize, b as usize);
                sums[a] += values[b];
                sums[b] += values[a];
                counts[a] += 1.0;
                counts[b] += 1.0;
            }
            let share = wanting.min(1.0);
            for ((value, sum), count) in values.iter_mut().zip(sums).zip(counts) {
                *value += share * (sum / count - *value);
            }
            wanting -= 1.0;
        }
        values
    }
}

/// Across the veins the mask changes, along them it does not: the smoothed tensor of its slope, with unit trace.
fn across(mesh: &FlatMesh, neighbours: &Neighbours, values: &[f64], width: f64) -> Vec<Tensor> {
    let mut tensors = vec![[0.0; 3]; values.len()];
    let mut counts = vec![0.0; values.len()];
    for &triangle in &mesh.triangles {
        let slope = slope(mesh, triangle, values) * neighbours.extent;
        for v in triangle {
            let product = [slope.x * slope.x, slope.x * slope.y, slope.y * slope.y];
            tensors[v as usize].iter_mut().zip(product).for_each(|(t, p)| *t += p);
            counts[v as usize] += 1.0;
        }
    }
    let component = |k: usize| {
        let raw = tensors.iter().zip(&counts).map(|(t, count): (&Tensor, &f64)| t[k] / count.max(1.0)).collect();
        neighbours.smoothed(raw, width)
    };
    let [xx, xy, yy] = [0, 1, 2].map(component);
    let typical = xx.iter().zip(&yy).map(|(x, y)| x + y).sum::<f64>() / values.len().max(1) as f64;
    let floor = FAINT * typical;
    let unit = |triangle: &[u32; 3]| {
        let mean = |of: &[f64]| triangle.iter().map(|&v| of[v as usize]).sum::<f64>() / 3.0;
        let (xx, xy, yy) = (mean(&xx), mean(&xy), mean(&yy));
        let trace = xx + yy + floor;
        if trace > 0.0 { [(xx + 0.5 * floor) / trace, xy / trace, (yy + 0.5 * floor) / trace] } else { [0.5, 0.0, 0.5] }
    };
    mesh.triangles.iter().map(unit).collect()
}

/// The slope over a triangle of values given at its corners; nought for one without area.
fn slope(mesh: &FlatMesh, triangle: [u32; 3], values: &[f64]) -> DVec2 {
    let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
    let [x, y, z] = triangle.map(|v| values[v as usize]);
    let (u, v) = (b - a, c - a);
    let doubled_area = u.perp(&v);
    if doubled_area == 0.0 {
        return DVec2::zeros();
    }
    let turned = |w: DVec2| DVec2::new(-w.y, w.x);
    (turned(u) * (z - x) - turned(v) * (y - x)) / doubled_area
}

/// Depth of each vertex below the nearest vertex of a margin (of holes too), over the greatest depth.
fn depth(mesh: &FlatMesh) -> Vec<f64> {
    let mut sides: Vec<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    sides.sort_unstable();
    let once = sides.chunk_by(|x, y| x == y).filter(|same| same.len() == 1);
    let mut rim: Vec<u32> = once.flat_map(|same| same[0]).collect();
    rim.sort_unstable();
    rim.dedup();
    let nearest = |p: &DVec2| {
        let squared = |&v: &u32| (mesh.positions[v as usize] - p).norm_squared();
        rim.iter().map(squared).fold(f64::INFINITY, f64::min).sqrt()
    };
    let depths: Vec<f64> = mesh.positions.iter().map(nearest).collect();
    let deepest = depths.iter().copied().filter(|depth| depth.is_finite()).fold(0.0, f64::max);
    depths.iter().map(|depth| if deepest > 0.0 { (depth / deepest).min(1.0) } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_of_a_plane_are_exact() {
        let positions = [(0.2, 0.1), (1.3, 0.0), (0.4, 0.9)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        let mesh = FlatMesh { positions, ..FlatMesh::default() };
        let values: Vec<f64> = mesh.positions.iter().map(|p| 3.0 * p.x - 2.0 * p.y + 7.0).collect();
        assert!((slope(&mesh, [0, 1, 2], &values) - DVec2::new(3.0, -2.0)).norm() < 1e-12);
    }
}
