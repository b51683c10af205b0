//! The field "curl": a drying blade contracts more on its upper face than on its lower one,
//! least along the veins. Such contraction pushes nothing as a whole: its forces sum to nothing and turn nothing. So the
//! field is a smooth strength along each vertex's current upper normal (it follows the surface, so that a raised margin is
//! rolled further in), positive where the mask is dark (margins, lobe tips), negative along the veins, and at rest without
//! resultant or torque: its best plane is taken out.
//!
//! A variant has its own strength, sense (one in five curls down), side that curls more, twist along the midrib and slow
//! waves, all keyed by (seed, variant).

use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::{sin, sincos};
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DMat3, DVec2, DVec3};

/// Passes of averaging over neighbours: forces vary over several edges, never from vertex to vertex.
const SMOOTHING: u32 = 2;
/// Share of variants that curl down.
const DOWNWARDS: f64 = 0.2;

/// What tells one variant from another.
struct Irregularity {
    gain: f64,
    lean: DVec2,
    twist: f64,
    waves: [(DVec2, f64); 3],
}

impl Irregularity {
    fn new(seed: u64, variant: u32) -> Self {
        let mut stream = Stream::new(seed, Purpose::Deformation, u64::from(variant), 0);
        let gain = stream.range(0.85, 1.15) * if stream.uniform() < DOWNWARDS { -1.0 } else { 1.0 };
        let lean = DVec2::new(stream.range(-0.3, 0.3), stream.range(-0.15, 0.15));
        let twist = stream.range(-0.5, 0.5);
        let waves = [0, 1, 2].map(|_| {
            let (sine, cosine) = sincos(stream.range(0.0, std::f64::consts::TAU));
            (DVec2::new(cosine, sine) * stream.range(5.0, 10.0), stream.range(0.0, std::f64::consts::TAU))
        });
        Self { gain, lean, twist, waves }
    }

    /// Strength at a place (in sizes of the blade, from its middle) where the mask asks for `curl`.
    fn strength(&self, place: DVec2, curl: f64) -> f64 {
        let wave: f64 = self.waves.iter().map(|(ahead, phase)| sin(ahead.dot(&place) + phase)).sum();
        self.gain * (curl * (1.0 + self.lean.dot(&place)) + self.twist * place.x * place.y + 0.08 * wave)
    }
}

/// Strength of the force on each vertex along its normal for a variant, N: `force` where the leaf curls most.
pub fn strengths(mesh: &FlatMesh, force: f64, seed: u64, variant: u32) -> Vec<f64> {
    let irregularity = Irregularity::new(seed, variant);
    let count = mesh.positions.len() as f64;
    let middle = mesh.positions.iter().sum::<DVec2>() / count;
    let size = mesh.area().abs().sqrt().max(1e-300);
    let curls = smoothed(mesh, mesh.greys.iter().map(|grey| 1.0 - grey / 255.0).collect());
    let places: Vec<DVec2> = mesh.positions.iter().map(|p| (p - middle) / size).collect();
    let raw = places.iter().zip(&curls).map(|(&place, &curl)| irregularity.strength(place, curl)).collect();
    balanced(&places, raw).iter().map(|strength| strength * force).collect()
}

fn smoothed(mesh: &FlatMesh, mut values: Vec<f64>) -> Vec<f64> {
    let edges = mesh.edges();
    for _ in 0..SMOOTHING {
        let mut sums = values.clone();
        let mut counts = vec![1.0; values.len()];
        for &[a, b] in &edges {
            let (a, b) = (a as usize, b as usize);
            sums[a] += values[b];
            sums[b] += values[a];
            counts[a] += 1.0;
            counts[b] += 1.0;
        }
        values = sums.iter().zip(&counts).map(|(sum, count)| sum / count).collect();
    }
    values
}

/// Takes out the plane a + b x + c y of least squares: what is left has no sum and no torque.
fn balanced(places: &[DVec2], strengths: Vec<f64>) -> Vec<f64> {
    let (mut moments, mut sums) = (DMat3::zeros(), DVec3::zeros());
    for (place, strength) in places.iter().zip(&strengths) {
        let row = DVec3::new(1.0, place.x, place.y);
        moments += row * row.transpose();
        sums += row * *strength;
    }
    let plane = moments.try_inverse().map_or_else(DVec3::zeros, |inverse| inverse * sums);
    let above = |(place, strength): (&DVec2, f64)| strength - plane.dot(&DVec3::new(1.0, place.x, place.y));
    places.iter().zip(strengths).map(above).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_balanced_field_neither_pushes_nor_turns() {
        let places: Vec<DVec2> = (0..40).map(|i| DVec2::new(f64::from(i % 7), f64::from(i / 7))).collect();
        let strengths = balanced(&places, (0..40).map(|i| f64::from(i * i % 11)).collect());
        let moment = |weight: fn(&DVec2) -> f64| places.iter().zip(&strengths).map(|(p, s)| weight(p) * s).sum::<f64>();
        for sum in [moment(|_| 1.0), moment(|p| p.x), moment(|p| p.y)] {
            assert!(sum.abs() < 1e-10, "{sum}");
        }
    }
}
