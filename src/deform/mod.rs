//! The deformation stage: a flat leaf -> one curled shape for each state and variant that a leaf wears.
//!
//! Model "paper": the improved mass-spring system of Tang, Wu and Fan 2013, section 4. Masses come from the mask map by
//! equation (3), springs are the mesh's edges (constraint step 3: each once), equation (1) is integrated with the step that
//! the stiffest spring allows, equation (2) bounds the stretch, and shapes are snapshots of one run from rest: a drier leaf is
//! a later snapshot. The paper names no force; ours is described in [`field`]. There is no bending stiffness, so the
//! shape is that of a transient and depends on mesh, force and step count, as the paper's does.

pub mod field;
mod masses;
mod projection;
mod stability;
mod system;

use crate::base::figures::{ErrorFigure, Figures};
use crate::base::flat_mesh::FlatMesh;
use crate::base::limits::{Limit, Limits, Refusal};
use crate::base::mesh::Mesh;
use crate::base::settings::Complaint;
use crate::base::vector::{DVec3, Vec3};
use crate::{choice, settings};
use field::Field;
use rayon::prelude::*;
use std::collections::BTreeMap;
use system::System;
use thiserror::Error;

choice! {
    /// Which mechanics bends the leaf.
    pub enum Model {
        /// The mass-spring system of Tang, Wu and Fan 2013, equations (1) to (3).
        Paper = "paper",
    }
}

settings! {
    /// How a leaf in a state is bent.
    pub struct StateShape {
        /// How dry the leaf is: 0 flat, 1 as curled as the model makes it.
        dryness: f64 = 0.0, range 0.0 => 1.0;
    }
}

settings! {
    /// How leaves curl.
    pub struct Settings {
        /// The mechanics.
        model: Model = Model::Paper;
        /// Time step of equation (1); absent for 0.7 of the largest stable one.
        step: Option<f64> = None, unit "s", range 1e-9 => 1.0;
        /// Time steps to the driest shape; a state's shape is the snapshot at its dryness times these.
        steps: u32 = 500, range 1 => 4294967295u32;
        /// Stiffness of the springs.
        stiffness: f64 = 40.0, unit "N/m", range 1e-6 => 1e9;
        /// Largest stretch of a spring relative to its natural length, tau_c of equation (2).
        strain_limit: f64 = 0.1, range 0.0 => 1e6;
        /// External force on a vertex where the leaf curls most; it follows the upper normal. Negative curls downwards.
        force: f64 = 6e-3, unit "N", range -1e6 => 1e6;
        /// Mass that one unit of equation (3) stands for; the mask's masses are 0.5 to 5.55 of it.
        mass_unit: f64 = 1.0, unit "mg", range 1e-6 => 1e6;
        /// Drag of the air on a vertex (Provot 1995, viscous damping).
        drag: f64 = 1e-3, unit "N s/m", range 0.0 => 1e3;
        /// Internal friction of a spring against any relative velocity of its ends. It alone keeps the blade smooth, since
        /// springs do not resist bending: with less, neighbouring triangles fold over. The default suits about 220 vertices;
        /// force and friction belong to vertices and edges, so a finer mesh curls more and wants more of it.
        friction: f64 = 9e-3, unit "N s/m", range 0.0 => 1e3;
        /// Different shapes made for each state.
        shapes: u32 = 3, range 1 => 64;
        /// The states' shapes by name; a state without an entry is flat.
        states: BTreeMap<String, StateShape> = BTreeMap::new();
    }
}

/// A shape to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The state that wears it.
    pub state: String,
    /// Which of the state's shapes, from 0; jobs of one variant are snapshots of one run.
    pub variant: u32,
    /// How dry the leaf is, 0 to 1.
    pub dryness: f64,
}

/// Why shapes could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DeformError {
    /// The given step cannot be stable on this mesh.
    #[error("deform.step = {step:e} s blows up on this mesh; take at most {safe:.3e} s, or leave it out")]
    Unstable {
        /// The step asked for, seconds.
        step: f64,
        /// The largest stable one, seconds.
        safe: f64,
    },
    /// The numbers overflowed.
    #[error("the leaf flew apart at step {step}: deform.force is too large for deform.stiffness")]
    Diverged {
        /// When, in steps.
        step: u64,
    },
    /// The strain bound of equation (2) could not be held.
    #[error("springs stretch by {strain:.3} although deform.strain_limit is {limit}: deform.force is too large")]
    Stretched {
        /// The largest strain of any spring.
        strain: f64,
        /// The bound asked for.
        limit: f64,
    },
    /// A limit refused it.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// Everything wrong with well-typed settings that can be seen without a mesh.
#[must_use]
pub fn check(settings: &Settings) -> Vec<Complaint> {
    // No mesh is slower than its heaviest vertex on one spring.
    let heaviest = masses::mass(255.0) * settings.mass_unit * 1e-6;
    let slowest = 2.0 * (heaviest / settings.stiffness).sqrt();
    let step = settings.step.filter(|&step| step > slowest);
    let complaint = |step: f64| {
        let message = format!("a time step of {step:e} s is unstable on every mesh with these springs and masses");
        Complaint::new("step", message, format!("take less than {slowest:.3e} s, or leave it out"))
    };
    step.map(complaint).into_iter().collect()
}

/// Strain beyond the bound at which the leaf is refused: twice what the projection aims to hold.
const STRETCHED: f64 = 2.0 * projection::SLACK;

/// What one run of a variant gives: its snapshots by step, and the worst strain.
struct Run {
    snapshots: BTreeMap<u64, Vec<DVec3>>,
    max_strain: f64,
    steps: u64,
}

/// Makes a shape for each job, in the jobs' order. The same jobs give the same bytes on any thread count and in any company.
///
/// # Errors
/// [`DeformError`] when the step is unstable, the leaf flies apart, or the steps limit refuses the runs.
pub fn deform(
    settings: &Settings,
    mesh: &FlatMesh,
    jobs: &[Job],
    seed: u64,
    limits: &Limits,
) -> Result<(Vec<Mesh>, Figures), DeformError> {
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
            let field = Field::new(mesh, settings.force, seed, variant);
            run(&system, &field, step, settings.strain_limit, moments).map(|run| (variant, run))
        })
        .collect::<Result<_, _>>()?;
    let runs: BTreeMap<u32, Run> = runs.into_iter().collect();
    let strain = runs.values().map(|run| run.max_strain).fold(0.0, f64::max);
    let limit = settings.strain_limit;
    if strain > limit + STRETCHED {
        return Err(DeformError::Stretched { strain, limit });
    }
    let shapes = jobs.iter().map(|job| shape(mesh, &runs[&job.variant].snapshots[&moment(job)])).collect();
    Ok((shapes, figures(settings, jobs.len(), &runs, step)))
}

fn stable_step(settings: &Settings, system: &System) -> Result<f64, DeformError> {
    let safe = stability::largest_step(system);
    match settings.step {
        Some(step) if step >= safe => Err(DeformError::Unstable { step, safe }),
        Some(step) => Ok(step),
        None => Ok(0.7 * safe),
    }
}

/// Integrates one variant from rest and keeps the positions at the wanted steps.
fn run(system: &System, field: &Field, step: f64, limit: f64, mut wanted: Vec<u64>) -> Result<Run, DeformError> {
    wanted.sort_unstable();
    wanted.dedup();
    let mut state = system.at_rest();
    let mut done = Run { snapshots: BTreeMap::new(), max_strain: 0.0, steps: 0 };
    for moment in wanted {
        while done.steps < moment {
            let forces = system.forces(&state, field);
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

fn shape(flat: &FlatMesh, positions: &[DVec3]) -> Mesh {
    let mut mesh = Mesh {
        positions: positions.iter().map(|p| Vec3::new(p.x as f32, p.y as f32, p.z as f32)).collect(),
        uvs: flat.uvs.clone(),
        triangles: flat.triangles.clone(),
        normals: Vec::new(),
    };
    mesh.recompute_normals();
    mesh
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
mod tests;
