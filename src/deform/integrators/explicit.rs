//! Equation (1): v(t + dt) = v(t) + dt F(t) / m, P(t + dt) = P(t) + dt v(t + dt), with viscous damping.

use super::Motion;
use crate::base::vector::DVec3;
use crate::deform::shell::{Bent, Rest, Sheet};

/// Rounds of the power iteration for the fastest vibration; it approaches from below.
const ROUNDS: u32 = 60;
/// Displacement for differences of the gradient, extents.
const NUDGE: f64 = 1e-7;

/// Integrates some steps; gives their number.
pub fn integrate(sheet: &Sheet, rest: &Rest, motion: &mut Motion, slowest: f64, steps: u32) -> u32 {
    let step = 0.9 * 2.0 / (fastest(sheet, rest, &motion.positions) * 1.03);
    let kept = 1.0 / (1.0 + 2.0 * slowest * step);
    for _ in 0..steps {
        let gradient = Bent::new(sheet, rest, &motion.positions).gradient();
        for (v, g) in gradient.iter().enumerate().filter(|(v, _)| !sheet.held[*v]) {
            motion.velocities[v] = (motion.velocities[v] - g * (step / sheet.areas[v])) * kept;
            motion.positions[v] += motion.velocities[v] * step;
        }
    }
    steps
}

/// The fastest vibration at positions, radians over the unit of time.
fn fastest(sheet: &Sheet, rest: &Rest, positions: &[DVec3]) -> f64 {
    let mobility = |v: usize| if sheet.held[v] { 0.0 } else { 1.0 / sheet.areas[v].sqrt() };
    let rough = |v: usize, k: usize| ((v * 7919 + k * 104_729) % 101) as f64 - 50.3;
    let mut mode: Vec<DVec3> = (0..positions.len()).map(|v| DVec3::from_fn(|k, _| rough(v, k))).collect();
    let mut squared = 0.0;
    for _ in 0..ROUNDS {
        let size = mode.iter().map(DVec3::norm_squared).sum::<f64>().sqrt().max(1e-300);
        let moved = |sign: f64| -> Vec<DVec3> {
            let shift = |(v, m): (usize, &DVec3)| positions[v] + m * (sign * NUDGE / size * mobility(v));
            mode.iter().enumerate().map(shift).collect()
        };
        let (above, below) = (moved(1.0), moved(-1.0));
        let (above, below) = (Bent::new(sheet, rest, &above).gradient(), Bent::new(sheet, rest, &below).gradient());
        let stiffened = |v: usize| (above[v] - below[v]) * (mobility(v) / (2.0 * NUDGE));
        mode = (0..positions.len()).map(stiffened).collect();
        squared = mode.iter().map(DVec3::norm_squared).sum::<f64>().sqrt();
    }
    squared.sqrt()
}
