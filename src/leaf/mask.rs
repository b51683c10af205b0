//! The mask map without a painter: the law of the project's notes on the paper's first future work. Veins are white (heavy,
//! they stay); margin, tips, the petiole's neighbourhood and what lies far from the joint are dark (light, they move).

use crate::base::blade::Vein;
use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::{exp, sincos};
use crate::base::vector::DVec2;
use crate::leaf::polygon;
use crate::leaf::veins::from_vein;

/// Weights of margin, tips, petiole and distance in the curl, which is 0 (stays) to 1 (moves most).
const MARGIN: f64 = 0.45;
const TIPS: f64 = 0.35;
const PETIOLE: f64 = 0.25;
const DISTANCE: f64 = 0.15;

/// The grey of each vertex, 0 to 255.
pub fn greys(mesh: &FlatMesh, outline: &[DVec2], veins: &[Vein]) -> Vec<f64> {
    let size = mesh.area().sqrt();
    let depth: Vec<f64> = mesh.positions.iter().map(|&p| polygon::distance(outline, p)).collect();
    let deepest = depth.iter().copied().fold(0.0, f64::max).max(1e-300);
    let way = ways(mesh);
    let farthest = way.iter().copied().fold(0.0, f64::max).max(1e-300);
    let reach = vein_reach(mesh, size);
    let rim = mesh.rim.len();
    let grey = |v: usize| {
        let p = mesh.positions[v];
        let inwards = if v < rim { 0.0 } else { (depth[v] / deepest).min(1.0) };
        let outwards = 1.0 - inwards;
        let near = way[v] / (0.15 * size);
        let far = way[v] / farthest;
        let curl = MARGIN * outwards * outwards.sqrt()
            + TIPS * tipness(outline, p, 0.12 * size)
            + PETIOLE * exp(-near * near)
            + DISTANCE * far * far;
        255.0 * veinness(p, veins, reach).max(1.0 - curl.clamp(0.0, 1.0))
    };
    (0..mesh.positions.len()).map(grey).collect()
}

/// How far a vein's white reaches: a fiftieth of the blade, or half an edge where the mesh is coarser than that.
fn vein_reach(mesh: &FlatMesh, size: f64) -> f64 {
    let edges = mesh.edges();
    let length = |e: &[u32; 2]| (mesh.positions[e[0] as usize] - mesh.positions[e[1] as usize]).norm();
    let mean = edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64;
    (0.02 * size).max(0.5 * mean)
}

/// 1 on a main vein, less beside it and towards its end; thinner orders are narrower and less white.
fn veinness(p: DVec2, veins: &[Vein], reach: f64) -> f64 {
    let one = |vein: &Vein| {
        let share = match vein.order {
            1 => 1.0,
            2 => 0.6,
            _ => return 0.0,
        };
        let (distance, along) = from_vein(p, vein);
        let off = distance / (reach * share);
        let fading = 1.0 - 0.9 * along * along * along * along;
        (0.4 + 0.6 * share) * fading * exp(-off * off)
    };
    veins.iter().map(one).fold(0.0, f64::max)
}

/// 1 at a needle's point, 0 where half of a disc about the point or more lies in the blade.
fn tipness(outline: &[DVec2], p: DVec2, radius: f64) -> f64 {
    let rings = [(0.35, 6u32), (0.65, 10), (0.9, 16)];
    let (mut inside, mut count) = (0u32, 0u32);
    for (share, places) in rings {
        for i in 0..places {
            let (sine, cosine) = sincos(std::f64::consts::TAU * f64::from(i) / f64::from(places));
            let q = p + DVec2::new(cosine, sine) * (radius * share);
            inside += u32::from(polygon::contains(outline, q));
            count += 1;
        }
    }
    (1.0 - 2.0 * f64::from(inside) / f64::from(count)).clamp(0.0, 1.0)
}

/// Way from the joint to each vertex along edges, metres (Bellman and Ford: sweeps until nothing gets shorter).
pub fn ways(mesh: &FlatMesh) -> Vec<f64> {
    let edges = mesh.edges();
    let length = |e: &[u32; 2]| (mesh.positions[e[0] as usize] - mesh.positions[e[1] as usize]).norm();
    let lengths: Vec<f64> = edges.iter().map(length).collect();
    let mut way: Vec<f64> = mesh.positions.iter().map(|_| f64::INFINITY).collect();
    for &v in &mesh.held {
        way[v as usize] = mesh.positions[v as usize].norm();
    }
    loop {
        let mut shorter = false;
        let sweep = edges.iter().zip(&lengths);
        for (&[a, b], length) in sweep.clone().chain(sweep.rev()) {
            for (from, to) in [(a as usize, b as usize), (b as usize, a as usize)] {
                if way[from] + length < way[to] {
                    way[to] = way[from] + length;
                    shorter = true;
                }
            }
        }
        if !shorter {
            return way;
        }
    }
}
