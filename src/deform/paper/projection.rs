//! Equation (2): |P_uv + V_uv dt| <= (1 + tau_c) L. The paper leaves the velocity as it was when the bound is broken, which
//! does not hold the bound. Here the relative velocity along the predicted spring is taken back to the bound by an impulse
//! on both ends (as Provot 1995 shares it): linear momentum is kept to rounding, angular momentum to the order of the step,
//! since the impulse acts along the predicted spring. Only stretch is bounded, as in the paper.

use crate::base::vector::DVec3;
use crate::deform::paper::system::{State, System};

/// The bound holds to this strain.
pub const SLACK: f64 = 0.01;
/// Most sweeps over all springs in a step.
const SWEEPS: u32 = 200;
/// Share of the slack at which the sweeps stop: a margin for the rounding of the step that follows.
const AIM: f64 = 0.5;

/// Changes the velocities so that the positions after `step` keep every spring within `limit`.
pub fn bound(system: &System, state: &mut State, step: f64, limit: f64) {
    for _ in 0..SWEEPS {
        let mut worst: f64 = 0.0;
        for (&[a, b], length) in system.springs.iter().zip(&system.lengths) {
            let strain = shorten(system, state, [a as usize, b as usize], *length, (step, limit));
            worst = worst.max(strain);
        }
        if worst <= limit + SLACK * AIM {
            return;
        }
    }
}

/// Takes one spring back to the bound; gives the strain that it had.
fn shorten(system: &System, state: &mut State, [a, b]: [usize; 2], length: f64, (step, limit): (f64, f64)) -> f64 {
    let moved = |v: usize| state.positions[v] + state.velocities[v] * step;
    let side: DVec3 = moved(b) - moved(a);
    let stretched = side.norm();
    let excess = stretched - (1.0 + limit) * length;
    let mobility = system.mobility[a] + system.mobility[b];
    if excess > 0.0 && mobility > 0.0 {
        let impulse = side * (excess / (stretched * mobility * step));
        state.velocities[a] += impulse * system.mobility[a];
        state.velocities[b] -= impulse * system.mobility[b];
    }
    if mobility > 0.0 { stretched / length - 1.0 } else { 0.0 }
}
