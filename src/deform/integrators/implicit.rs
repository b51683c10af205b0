//! Implicit Euler with one linear solve a step: (M (1 + c dt) / dt^2 + K) d = M v / dt - g, K the tamed Hessian.

use super::Motion;
use crate::base::vector::DVec3;
use crate::deform::shell::{Blade, Rest};

/// Steps are this long over the slowest frequency.
const STEP: f64 = 10.0;

/// Integrates some steps; gives the number of those whose matrix could be factored.
pub fn integrate(blade: &Blade, rest: &Rest, motion: &mut Motion, slowest: f64, steps: u32) -> u32 {
    let step = STEP / slowest;
    let inertia = (1.0 + 2.0 * slowest * step) / (step * step);
    let mut linear = blade.linear();
    for taken in 0..steps {
        let pull: Vec<DVec3> =
            motion.velocities.iter().zip(&blade.sheet().areas).map(|(v, area)| v * (area / step)).collect();
        let Some(moves) = linear.solved(rest, &motion.positions, inertia, &pull) else { return taken };
        for ((position, velocity), way) in motion.positions.iter_mut().zip(&mut motion.velocities).zip(moves) {
            *position += way;
            *velocity = way / step;
        }
    }
    steps
}
