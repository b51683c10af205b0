//! A single mass on a spring, whose motion is known: the orders of integrators, measured where they show.

use super::numbers::slope;
use crate::base::maths::sincos;
use crate::base::vector::DVec3;
use crate::deform::Springs;
use std::f64::consts::TAU;

/// The share of a period after which errors are taken. At a whole period that of equation (1) vanishes to first order.
const SHARE: f64 = 0.37;
/// Steps up to there.
const STEPS: [u32; 4] = [50, 100, 200, 400];

/// Place and velocity over the frequency at the end of `steps` steps, by an integrator's own rule.
type Rule = fn(f64, u32) -> [f64; 2];

/// An integrator and the range of orders that passes.
pub struct Tried {
    /// For the table.
    pub name: &'static str,
    /// The order that was measured.
    pub order: f64,
    /// The range that it should lie in.
    pub asked: [f64; 2],
}

/// The orders of the integrators.
#[must_use]
pub fn orders() -> Vec<Tried> {
    let tried: [(&'static str, Rule, [f64; 2]); 3] = [
        ("equation (1)", semi_implicit, [0.9, 1.1]),
        ("Runge-Kutta 4", runge_kutta, [3.8, 4.2]),
        ("BDF2", two_step, [1.8, 2.2]),
    ];
    tried.map(|(name, rule, asked)| Tried { name, order: order(rule), asked }).into()
}

fn order(rule: Rule) -> f64 {
    let (sine, cosine) = sincos(TAU * SHARE);
    let error = |&steps: &u32| {
        let [x, v] = rule(SHARE / f64::from(steps), steps);
        [f64::from(steps), ((x - cosine) * (x - cosine) + (v + sine) * (v + sine)).sqrt()]
    };
    -slope(&STEPS.iter().map(error).collect::<Vec<_>>()).unwrap_or(0.0)
}

/// Equation (1) as the program has it. The amplitude is small, and the spring is along the motion, so that it is linear.
fn semi_implicit(step: f64, steps: u32) -> [f64; 2] {
    const AMPLITUDE: f64 = 0.25;
    let mut springs = Springs::oscillator(TAU);
    springs.displace(|number, _| DVec3::x() * (AMPLITUDE * number as f64));
    (0..steps).for_each(|_| springs.advance(step, None));
    [(springs.positions()[1].x - 1.0) / AMPLITUDE, springs.velocities()[1].x / (TAU * AMPLITUDE)]
}

/// The classical method of four stages, to see that the measuring is right.
fn runge_kutta(step: f64, steps: u32) -> [f64; 2] {
    let rate = |[x, v]: [f64; 2]| [TAU * v, -TAU * x];
    let along = |[x, v]: [f64; 2], [a, b]: [f64; 2], h: f64| [x + h * a, v + h * b];
    let mut state = [1.0, 0.0];
    for _ in 0..steps {
        let a = rate(state);
        let b = rate(along(state, a, step / 2.0));
        let c = rate(along(state, b, step / 2.0));
        let d = rate(along(state, c, step));
        state = [0, 1].map(|k| state[k] + step / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]));
    }
    state
}

/// The backward differentiation formula of two steps, begun with the exact first one.
fn two_step(step: f64, steps: u32) -> [f64; 2] {
    let h = TAU * step * 2.0 / 3.0;
    let (sine, cosine) = sincos(TAU * step);
    let (mut before, mut state) = ([1.0, 0.0], [cosine, -sine]);
    for _ in 1..steps {
        // (1 - h J) next = (4 state - before) / 3 with J the rotation of the oscillator.
        let [x, v] = [0, 1].map(|k| (4.0 * state[k] - before[k]) / 3.0);
        before = state;
        state = [(x + h * v) / (1.0 + h * h), (v - h * x) / (1.0 + h * h)];
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_those_of_the_theory() {
        for tried in orders() {
            assert!((tried.asked[0]..=tried.asked[1]).contains(&tried.order), "{}: {}", tried.name, tried.order);
        }
    }
}
