//! Extended position-based dynamics: each spring, and the three folds of each triangle together, pull their vertices to where
//! their own energy and the inertia balance, one after the other. With compliance M^-1 / dt^2 and multipliers l the folds'
//! system (M^-1 / dt^2 + J W J') dl = -r - M^-1 l / dt^2 is solved as (1 + dt^2 M J W J') dl = -dt^2 M r - l, since M is
//! singular at the rim.

use super::Motion;
use crate::base::vector::{DMat3, DVec3};
use crate::deform::shell::{Fold, Plate, RIM, Rest, Sheet};

/// Steps are this long over the slowest frequency.
const STEP: f64 = 0.02;

/// Integrates some steps of one sweep each; gives their number.
pub fn integrate(sheet: &Sheet, rest: &Rest, motion: &mut Motion, slowest: f64, steps: u32) -> u32 {
    let step = STEP / slowest;
    let kept = 1.0 / (1.0 + 2.0 * slowest * step);
    let mobility: Vec<f64> =
        (0..sheet.areas.len()).map(|v| if sheet.held[v] { 0.0 } else { 1.0 / sheet.areas[v] }).collect();
    for _ in 0..steps {
        let before = motion.positions.clone();
        for (v, mobility) in mobility.iter().enumerate().filter(|(_, mobility)| **mobility > 0.0) {
            let fall = DVec3::z() * (rest.weight * sheet.areas[v] * mobility * step);
            motion.velocities[v] = (motion.velocities[v] - fall) * kept;
            motion.positions[v] += motion.velocities[v] * step;
        }
        for (plate, folds0) in sheet.plates.iter().zip(&rest.folds) {
            relax_plate(sheet, plate, folds0, &mobility, step, &mut motion.positions);
        }
        relax_springs(sheet, rest, &mobility, step, &mut motion.positions);
        for ((velocity, now), before) in motion.velocities.iter_mut().zip(&motion.positions).zip(before) {
            *velocity = (now - before) / step;
        }
    }
    steps
}

fn relax_springs(sheet: &Sheet, rest: &Rest, mobility: &[f64], step: f64, positions: &mut [DVec3]) {
    for (spring, length) in sheet.springs.iter().zip(&rest.lengths) {
        let [a, b] = spring.ends.map(|v| v as usize);
        let side = positions[b] - positions[a];
        let stretched = side.norm();
        let both = mobility[a] + mobility[b];
        if both > 0.0 && stretched > 0.0 {
            let pull = side * ((stretched - length) / stretched / (both + 1.0 / (spring.stiffness * step * step)));
            positions[a] += pull * mobility[a];
            positions[b] -= pull * mobility[b];
        }
    }
}

fn relax_plate(sheet: &Sheet, plate: &Plate, folds0: &[f64; 3], mobility: &[f64], step: f64, positions: &mut [DVec3]) {
    let folds = [0, 1, 2].map(|i| {
        let hinge = (plate.hinges[i] != RIM).then(|| sheet.hinges[plate.hinges[i] as usize]);
        hinge.map(|hinge| (hinge, Fold::new(hinge.map(|v| positions[v as usize]))))
    });
    let difference = |i: usize| folds[i].as_ref().map_or(0.0, |(_, fold)| fold.value - folds0[i]);
    let coupling = |i: usize, j: usize| {
        let (Some((one, f)), Some((other, g))) = (&folds[i], &folds[j]) else { return 0.0 };
        let pairs = (0..4).flat_map(|p| (0..4).map(move |q| (p, q))).filter(|&(p, q)| one[p] == other[q]);
        pairs.map(|(p, q)| mobility[one[p] as usize] * f.gradient[p].dot(&g.gradient[q])).sum()
    };
    let stiffness = plate.form * (step * step);
    let system = DMat3::identity() + stiffness * DMat3::from_fn(coupling);
    let Some(inverse) = system.try_inverse() else { return };
    let pull = inverse * (stiffness * DVec3::from_fn(|i, _| -difference(i)));
    for (i, (hinge, fold)) in folds.iter().enumerate().filter_map(|(i, fold)| fold.as_ref().map(|fold| (i, fold))) {
        for (&v, gradient) in hinge.iter().zip(&fold.gradient) {
            positions[v as usize] += gradient * (pull[i] * mobility[v as usize]);
        }
    }
}
