//! Model "shell": a thin elastic sheet that dries.
//!
//! Drying changes what each part of the blade would be if it stood alone: its lengths (the blade between the veins shrinks)
//! and its curvature (the faces shrink unequally). The shape is the one of least energy for that, so it depends on how dry
//! the leaf is and on nothing else: not on a number of steps, and little on the mesh.

mod alignment;
mod blade;
mod chart;
mod coarse;
mod drying;
mod energy;
mod fold;
mod level;
mod newton;
mod overlap;
mod path;
pub mod plates;
mod settings;
mod sheet;
mod tissue;

use crate::base::figures::{ErrorFigure, Figures};
use crate::base::flat_mesh::FlatMesh;
use crate::base::limits::{Limit, Limits};
use crate::base::vector::DVec3;
use crate::deform::{DeformError, Flat, Job};
pub(in crate::deform) use blade::Blade;
use drying::{Drying, Irregularity};
pub(in crate::deform) use energy::{Bent, Rest};
pub(in crate::deform) use fold::Fold;
use level::Level;
use newton::Outcome;
use path::{Path, Stuck};
use rayon::prelude::*;
pub use settings::Settings;
pub(in crate::deform) use sheet::{Plate, RIM, Sheet};
use std::collections::BTreeMap;
use tissue::Tissue;

/// Solvers whose memory is counted: as many as commonly run side by side, and the same on every machine.
const SIDE_BY_SIDE: usize = 8;

/// Share of its dryness by which a shape that passes through itself is taken back at a time, how often, and how often the
/// last of these is halved.
const HELD_BACK: f64 = 1.0 / 16.0;
const MOST_HELD_BACK: u32 = 8;
const HALVINGS: u32 = 3;

/// A shape with how it was reached.
struct Shape {
    positions: Vec<DVec3>,
    outcome: Outcome,
    strain: f64,
    /// Edges that pass through triangles.
    piercings: u64,
    /// Share of its dryness by which it was taken back because of such.
    held_back: f64,
}

/// Positions for each job, in the jobs' order, metres.
///
/// # Errors
/// [`DeformError`] for a degenerate mesh, a shape that is not reached, or when the memory limit refuses the factor.
pub fn shapes(
    settings: &Settings,
    flat: &Flat,
    jobs: &[Job],
    seed: u64,
    limits: &Limits,
) -> Result<(Vec<Vec<DVec3>>, Figures), DeformError> {
    let mesh = flat.mesh;
    let mut wanted: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (number, job) in jobs.iter().enumerate() {
        wanted.entry(job.variant).or_default().push(number);
    }
    let solvers = wanted.len().min(SIDE_BY_SIDE);
    limits.allow(Limit::Memory, "leaf.vertices", level::foreseen_bytes(mesh.positions.len()) * solvers as f64)?;
    let levels = Level::all(settings, flat);
    let Some(finest) = levels.first() else { return Err(DeformError::Empty) };
    let bytes: f64 = levels.iter().map(Level::bytes).sum();
    limits.allow(Limit::Memory, "leaf.vertices", bytes * solvers as f64)?;
    let variants: Vec<(Vec<(usize, Shape)>, Outcome)> = wanted
        .into_par_iter()
        .map(|(variant, numbers)| {
            let irregularity = Irregularity::new(settings, seed, variant);
            let dryings: Vec<Drying> = levels.iter().map(|level| level.drying(settings, &irregularity)).collect();
            variant_shapes(settings, &levels, &dryings, (jobs, &numbers))
        })
        .collect::<Result<_, _>>()?;
    let mut work = Outcome::default();
    let mut shapes: Vec<Option<Shape>> = jobs.iter().map(|_| None).collect();
    for (made, variant_work) in variants {
        work.add(variant_work);
        for (number, shape) in made {
            shapes[number] = Some(shape);
        }
    }
    let shapes: Vec<Shape> = shapes.into_iter().flatten().collect();
    let figures = figures(settings, &shapes, work);
    Ok((shapes.iter().map(|shape| in_metres(mesh, &finest.tissue, shape)).collect(), figures))
}

/// The shapes of one variant, with the numbers of their jobs, and the work they took.
fn variant_shapes(
    settings: &Settings,
    levels: &[Level],
    dryings: &[Drying],
    (jobs, numbers): (&[Job], &[usize]),
) -> Result<(Vec<(usize, Shape)>, Outcome), DeformError> {
    let mut path = Path::over(settings, levels, dryings)?;
    let mut made = Vec::with_capacity(numbers.len());
    for &number in numbers {
        let shape = free_shape(&levels[0].sheet, &dryings[0], &mut path, jobs[number].dryness.clamp(0.0, 1.0))?;
        made.push((number, shape));
    }
    Ok((made, path.all_work()))
}

/// The shape at a dryness. A leaf that touches itself is stopped by that; this one, which feels no touch, is taken back along
/// its path to where it does not pass through itself yet, if that is not too far.
fn free_shape(sheet: &Sheet, drying: &Drying, path: &mut Path, dryness: f64) -> Result<Shape, Stuck> {
    let mut at = |held_back: f64| -> Result<Shape, Stuck> {
        let dryness = dryness * (1.0 - held_back);
        let (mut positions, outcome) = path.at(dryness)?;
        if dryness > 0.0 && !sheet.held.contains(&true) {
            alignment::laid_onto(&sheet.places, &sheet.areas, &mut positions);
        }
        let strain = strain(sheet, &drying.rest(dryness, 1.0).lengths, &positions);
        let piercings = sheet.piercings(&positions);
        Ok(Shape { positions, outcome, strain, piercings, held_back })
    };
    let dry = at(0.0)?;
    if dry.piercings == 0 {
        return Ok(dry);
    }
    for number in 1..=MOST_HELD_BACK {
        let held_back = HELD_BACK * f64::from(number);
        let mut free = at(held_back)?;
        if free.piercings > 0 {
            continue;
        }
        // Halves the last part of the way, so that the place where it stops does not jump from mesh to mesh.
        let mut touching = held_back - HELD_BACK;
        for _ in 0..HALVINGS {
            let middle = at(0.5 * (free.held_back + touching))?;
            if middle.piercings == 0 {
                free = middle;
            } else {
                touching = middle.held_back;
            }
        }
        return Ok(free);
    }
    Ok(dry)
}

/// Largest strain of a spring, stretched or pressed, relative to its rest length.
fn strain(sheet: &Sheet, lengths: &[f64], positions: &[DVec3]) -> f64 {
    let strain = |(spring, rest): (&sheet::Spring, &f64)| {
        ((positions[spring.ends[1] as usize] - positions[spring.ends[0] as usize]).norm() / rest - 1.0).abs()
    };
    sheet.springs.iter().zip(lengths).map(strain).fold(0.0, f64::max)
}

/// The shape in metres; what did not move keeps its very coordinates.
fn in_metres(mesh: &FlatMesh, tissue: &Tissue, shape: &Shape) -> Vec<DVec3> {
    let place = |(p, flat): (&DVec3, &crate::base::vector::DVec2)| {
        let start = flat / tissue.extent;
        let moved = DVec3::new(p.x - start.x, p.y - start.y, p.z) * tissue.extent;
        DVec3::new(flat.x, flat.y, 0.0) + moved
    };
    shape.positions.iter().zip(&mesh.positions).map(place).collect()
}

fn figures(settings: &Settings, shapes: &[Shape], work: Outcome) -> Figures {
    let worst = |of: fn(&Shape) -> f64| shapes.iter().map(of).fold(0.0, f64::max);
    let mut figures = Figures::of(shapes.len() as u64)
        .with("shapes", shapes.len())
        .with("iterations", work.iterations)
        .with("factorisations", work.factorisations)
        .with("saddles_escaped", work.saddles)
        .with("residual", worst(|shape| shape.outcome.residual))
        .with("energy", worst(|shape| shape.outcome.energy))
        .with("overlapping_shapes", shapes.iter().filter(|shape| shape.piercings > 0).count())
        .with("held_back_shapes", shapes.iter().filter(|shape| shape.held_back > 0.0).count())
        .with("max_strain", worst(|shape| shape.strain));
    figures.error = Some(ErrorFigure {
        metric: "length of the solver's last step".to_owned(),
        value: worst(|shape| shape.outcome.step),
        unit: "extents of the blade".to_owned(),
        bound: Some(settings.tolerance),
        how: "the error of the step before it, largest over all shapes".to_owned(),
    });
    figures
}

#[cfg(test)]
mod tests;
