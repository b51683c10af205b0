//! Model "paper": the improved mass-spring system of Tang, Wu and Fan 2013, section 4. Masses come from the mask map by
//! equation (3), springs are the mesh's edges (constraint step 3: each once), equation (1) is integrated with the step that
//! the stiffest spring allows, equation (2) bounds the stretch, and shapes are snapshots of one run from rest: a drier leaf is
//! a later snapshot. The paper names no force; the fields on offer are described in [`force`]. There is no bending stiffness, so
//! the shape is that of a transient and depends on mesh, force and step count, as the paper's does.

mod curl;
mod force;
pub mod masses;
mod projection;
pub mod springs;
mod stability;
mod system;

use crate::base::figures::{ErrorFigure, Figures};
use crate::base::flat_mesh::FlatMesh;
use crate::base::limits::{Limit, Limits};
use crate::base::settings::Complaint;
use crate::base::vector::DVec3;
use crate::deform::settings::{Field, Settings, Step};
use crate::deform::{DeformError, Job};
use force::Force;
use rayon::prelude::*;
use std::collections::BTreeMap;
use system::System;

/// Everything wrong with the model's settings that can be seen without a mesh.
pub fn check(settings: &Settings) -> Vec<Complaint> {
    // No mesh is slower than its heaviest vertex on one spring.
    let heaviest = masses::mass(255.0) * settings.mass_unit * 1e-6;
    let slowest = 2.0 * (heaviest / settings.stiffness).sqrt();
    let mut complaints = Vec::new();
    if let Step::Seconds(step) = settings.step
        && step > slowest
    {
        let message = format!("a time step of {step:e} s is unstable on every mesh with these springs and masses");
        complaints.push(Complaint::new("step", message, format!("take less than {slowest:.3e} s, or \"auto\"")));
    }
    if settings.field == Field::Constant && settings.direction == [0.0; 3] {
        let message = "a force of no direction pulls nowhere";
        complaints.push(Complaint::new(
            "direction",
            message,
            "give x, y and z of the direction, for example [0, 0, 1]",
        ));
    }
    complaints
}

/// Strain beyond the bound at which the leaf is refused: twice what the projection aims to hold.
const STRETCHED: f64 = 2.0 * projection::SLACK;

/// What one run of a variant gives: its snapshots by step, and the worst strain.
struct Run {
    snapshots: BTreeMap<u64, Vec<DVec3>>,
    max_strain: f64,
    steps: u64,
}

/// Positions for each job, in the jobs' order, metres.
///
/// # Errors
/// [`DeformError`] when the step is unstable, the leaf flies apart, or the steps limit refuses the runs.
pub fn shapes(
    settings: &Settings,
    mesh: &FlatMesh,
    jobs: &[Job],
    seed: u64,
    limits: &Limits,
) -> Result<(Vec<Vec<DVec3>>, Figures), DeformError> {
    let moment = |job: &Job| (job.dryness.clamp(0.0, 1.0) * f64::from(settings.steps)).round() as u64;
    let mut wanted: BTreeMap<u32, Vec<u64>> = BTreeMap::new();
    for job in jobs {
        wanted.entry(job.variant).or_default().push(moment(job));
    }
    let total: u64 = wanted.values().filter_map(|moments| moments.iter().max()).sum();
    limits.allow(Limit::Steps, "deform.steps", total as f64)?;
    let system = System::new(settings, mesh);
    let step = stable_step(settings, &system)?;
    let runs: Vec<(u32, Run)> = wanted
        .into_par_iter()
        .map(|(variant, moments)| {
            let force = Force::new(settings, mesh, seed, variant);
            run(&system, &force, step, settings.strain_limit, moments).map(|run| (variant, run))
        })
        .collect::<Result<_, _>>()?;
    let runs: BTreeMap<u32, Run> = runs.into_iter().collect();
    let strain = runs.values().map(|run| run.max_strain).fold(0.0, f64::max);
    let limit = settings.strain_limit;
    if strain > limit + STRETCHED {
        return Err(DeformError::Stretched { strain, limit });
    }
    let shapes = jobs.iter().map(|job| runs[&job.variant].snapshots[&moment(job)].clone()).collect();
    Ok((shapes, figures(settings, jobs.len(), &runs, step)))
}

fn stable_step(settings: &Settings, system: &System) -> Result<f64, DeformError> {
    let safe = stability::largest_step(system);
    match settings.step {
        Step::Seconds(step) if step >= safe => Err(DeformError::Unstable { step, safe }),
        Step::Seconds(step) => Ok(step),
        Step::Automatic(_) => Ok(0.7 * safe),
    }
}

/// Integrates one variant from rest and keeps the positions at the wanted steps.
fn run(system: &System, force: &Force, step: f64, limit: f64, mut wanted: Vec<u64>) -> Result<Run, DeformError> {
    wanted.sort_unstable();
    wanted.dedup();
    let mut state = system.at_rest();
    let mut done = Run { snapshots: BTreeMap::new(), max_strain: 0.0, steps: 0 };
    for moment in wanted {
        while done.steps < moment {
            let forces = system.forces(&state, force);
            system.accelerate(&mut state, &forces, step);
            projection::bound(system, &mut state, step, limit);
            system.displace(&mut state, step);
            done.steps += 1;
            done.max_strain = done.max_strain.max(system.strain(&state.positions));
            if !done.max_strain.is_finite() {
                return Err(DeformError::Diverged { step: done.steps });
            }
        }
        done.snapshots.insert(moment, state.positions.clone());
    }
    Ok(done)
}

fn figures(settings: &Settings, shapes: usize, runs: &BTreeMap<u32, Run>, step: f64) -> Figures {
    let max_strain = runs.values().map(|run| run.max_strain).fold(0.0, f64::max);
    let residual = (max_strain - settings.strain_limit).max(0.0);
    let mut figures = Figures::of(shapes as u64)
        .with("shapes", shapes)
        .with("iterations", runs.values().map(|run| run.steps).sum::<u64>())
        .with("step_s", step)
        .with("max_strain", max_strain)
        .with("residual", residual);
    figures.error = Some(ErrorFigure {
        metric: "stretch beyond the bound of equation (2)".to_owned(),
        value: residual,
        unit: "1".to_owned(),
        bound: Some(projection::SLACK),
        how: "largest over all springs and steps".to_owned(),
    });
    figures
}

#[cfg(test)]
mod extremes;
#[cfg(test)]
mod tests;
