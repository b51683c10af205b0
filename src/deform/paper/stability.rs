//! The largest stable step of equation (1): w dt < 2 for the fastest vibration w of the springs and masses, found by power
//! iteration on the linearised system at rest. With damping of rate g the condition is w^2 dt^2 / 4 + g dt / 2 < 1 (both roots
//! of z^2 - (2 - g dt - w^2 dt^2) z + 1 - g dt within the unit circle).

use crate::base::vector::DVec3;
use crate::deform::paper::system::System;

const ROUNDS: u32 = 120;
/// Power iteration approaches from below; the squared frequency is raised by this share.
const MARGIN: f64 = 1.03;

/// Seconds; infinite when nothing can move.
pub fn largest_step(system: &System) -> f64 {
    let squared = fastest(system) * MARGIN;
    let rate = damping_rate(system);
    // The positive root of w^2 dt^2 / 4 + g dt / 2 = 1, in the form that survives w = 0.
    2.0 / (rate * 0.5 + (rate * rate * 0.25 + squared).sqrt())
}

/// Largest eigenvalue of M^-1 K at rest, 1/s^2.
pub(super) fn fastest(system: &System) -> f64 {
    let count = system.rest.len();
    // A start that no symmetry of the leaf annuls.
    let mut shape: Vec<DVec3> = (0..count)
        .map(|i| DVec3::new(((i * 7919) % 101) as f64 - 50.3, ((i * 6007) % 103) as f64 - 51.7, 0.0))
        .collect();
    let mut value = 0.0;
    for _ in 0..ROUNDS {
        let size = shape.iter().map(DVec3::norm_squared).sum::<f64>().sqrt();
        if size == 0.0 {
            return 0.0;
        }
        shape.iter_mut().for_each(|s| *s /= size);
        shape = stiffened(system, &shape);
        value = shape.iter().map(DVec3::norm_squared).sum::<f64>().sqrt();
    }
    value
}

/// M^-1 K times a displacement; the springs are unstretched, so each resists along itself only.
fn stiffened(system: &System, shape: &[DVec3]) -> Vec<DVec3> {
    let mut product = vec![DVec3::zeros(); shape.len()];
    for (&[a, b], length) in system.springs.iter().zip(&system.lengths) {
        let (a, b) = (a as usize, b as usize);
        let along = (system.rest[b] - system.rest[a]) / *length;
        let pull = along * (system.stiffness * along.dot(&(shape[b] - shape[a])));
        product[a] -= pull * system.mobility[a];
        product[b] += pull * system.mobility[b];
    }
    product
}

/// Gershgorin's bound on drag and friction over mass, 1/s.
fn damping_rate(system: &System) -> f64 {
    let mut valence = vec![0.0; system.rest.len()];
    for &[a, b] in &system.springs {
        valence[a as usize] += 1.0;
        valence[b as usize] += 1.0;
    }
    let rate = |(valence, mobility): (&f64, &f64)| (system.drag + 2.0 * valence * system.friction) * mobility;
    valence.iter().zip(&system.mobility).map(rate).fold(0.0, f64::max)
}
