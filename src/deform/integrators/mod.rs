//! Other ways to the shell's shapes, for comparison: the damped motion of the same sheet, integrated until it rests. All start
//! from the flat blade, take the states of one shape in turn, and have masses of unit density and the damping that suits the
//! slowest vibration. None of them makes a picture; the study draws their error against their work.
//!
//! Left out: fourth-order Runge-Kutta (four evaluations a step for a step 1.4 times as long, and the way to rest does not
//! matter here) and vertex block descent (no farther after ten times the time of Newton's method).

mod explicit;
mod implicit;
mod position_based;

use crate::base::vector::DVec3;
use crate::deform::shell::{self, Blade};
use crate::deform::{DeformError, Flat};

/// A way to integrate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Equation (1) of Tang, Wu and Fan 2013, with viscous damping; `steps` a state, each 0.9 of the largest stable one.
    Explicit {
        /// Steps for each state.
        steps: u32,
    },
    /// Implicit Euler, one linear solve a step (Baraff and Witkin 1998); steps of ten over the slowest frequency.
    Implicit {
        /// Steps for each state.
        steps: u32,
    },
    /// Extended position-based dynamics, one sweep a step (Macklin, Müller and Chentanez 2016); steps of a fiftieth over the
    /// slowest frequency.
    PositionBased {
        /// Steps for each state.
        steps: u32,
    },
    /// The shell's own solver, for the baseline.
    Newton,
}

/// What a run gave and took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Positions for each dryness, extents of the blade.
    pub shapes: Vec<Vec<DVec3>>,
    /// Steps (of Newton's method: iterations) of all states.
    pub steps: u64,
    /// Sparse factorisations of all states; none for the explicit ways.
    pub factorisations: u64,
    /// Energies at the ends, in bending stiffnesses.
    pub energies: Vec<f64>,
    /// Largest strain of an edge at the ends, stretched or pressed, relative to its length at rest.
    pub strains: Vec<f64>,
}

/// Positions and velocities.
struct Motion {
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
}

/// Integrates the shapes at rising drynesses, each from the one before.
///
/// # Errors
/// [`DeformError`] for a broken mesh, when Newton's method does not settle, or when a run flies apart.
pub fn run<'a>(
    settings: &shell::Settings,
    flat: impl Into<Flat<'a>>,
    drynesses: &[f64],
    seed: u64,
    method: Method,
) -> Result<Run, DeformError> {
    let blade = Blade::new(settings, &flat.into())?;
    let drying = blade.drying(settings, seed, 0);
    if method == Method::Newton {
        return blade.newton(settings, &drying, drynesses);
    }
    let slowest = blade.slowest_frequency(&drying);
    let mut motion = Motion { positions: blade.flat(), velocities: Vec::new() };
    let mut run = Run::default();
    for &dryness in drynesses {
        let rest = drying.rest(dryness, 1.0);
        motion.velocities = vec![DVec3::zeros(); motion.positions.len()];
        let taken = u64::from(match method {
            Method::Explicit { steps } => explicit::integrate(blade.sheet(), &rest, &mut motion, slowest, steps),
            Method::Implicit { steps } => implicit::integrate(&blade, &rest, &mut motion, slowest, steps),
            Method::PositionBased { steps } => {
                position_based::integrate(blade.sheet(), &rest, &mut motion, slowest, steps)
            }
            Method::Newton => 0,
        });
        run.steps += taken;
        run.factorisations += if matches!(method, Method::Implicit { .. }) { taken } else { 0 };
        let energy = blade.energy(&rest, &motion.positions);
        if !energy.is_finite() {
            return Err(DeformError::Diverged { step: run.steps });
        }
        run.energies.push(energy);
        run.strains.push(blade.strain(&rest, &motion.positions));
        run.shapes.push(motion.positions.clone());
    }
    Ok(run)
}

#[cfg(test)]
mod tests;
