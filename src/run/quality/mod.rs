//! Chooses what a scene's pictures are made with so that they stay within an error at the least cost.
//!
//! Three parts make the error of a picture, and they are independent. The vertices of leaves: small pictures with leaves
//! of some vertices are held against those with finer ones (`worn`), which sees rims, shapes and the shading that follows from
//! them. The solver's tolerance: how far vertices may be off, in pixels, times how steep the picture is. And samples, levels of
//! detail and textures, which are measured on small pictures against one that is drawn many times as large (`probe`); a small
//! picture has more edges for its pixels, so that what is measured there is an upper estimate. The frames that are looked at
//! are the scene's first, middle and last, whichever are asked for, so that the choice is the same for every shard.

mod probe;
mod worn;

use super::prediction;
use super::still::Still;
use crate::base::diagnostic::Diagnostics;
use crate::base::limits::{Limit, Limits};
use crate::report::{ChosenLeaf, Reached};
use crate::scene::Scene;
use probe::Probe;
use std::collections::{BTreeMap, BTreeSet};
use worn::Worn;

/// The share of the error asked for that is planned with.
const PLANNED: f64 = 0.82;
/// The most that meshes, and the solver, may take of it.
const OF_SHAPE: f64 = 0.5;
const OF_SOLVER: f64 = 0.1;
/// Tolerances of the solver, extents; coarser ones are no cheaper.
const TOLERANCES: [f64; 6] = [1e-2, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6];

/// A scene with its settings chosen.
pub struct Chosen {
    /// The scene to be drawn.
    pub scene: Scene,
    /// What was chosen and is foreseen.
    pub reached: Reached,
}

impl Chosen {
    /// What the person should know when the error is out of reach.
    pub fn note(&self) -> Option<String> {
        let Reached { asked, reached, is_within, .. } = self.reached;
        (!is_within).then(|| {
            format!(
                "quality.error = {asked} is out of reach: about {reached:.2e} is the least that pictures come to here"
            )
        })
    }
}

/// Chooses for a scene, and keeps what it has measured for the next error.
pub struct Chooser {
    scene: Scene,
    limits: Limits,
    /// The moments that are looked at; none before the first choice.
    moments: Vec<(Still, Probe)>,
    /// Of each species.
    worn: Vec<Worn>,
}

impl Chooser {
    /// Of a scene; nothing is measured yet.
    #[must_use]
    pub fn new(scene: &Scene, limits: &Limits) -> Self {
        let worn = scene.species.iter().map(|_| Worn::default()).collect();
        Self { scene: scene.clone(), limits: limits.clone(), moments: Vec::new(), worn }
    }

    /// Chooses for the error that pictures may have.
    ///
    /// # Errors
    /// What stops a run of the scene.
    pub fn choose(&mut self, error: f64) -> Result<Chosen, Diagnostics> {
        let mut chosen = Chosen { scene: self.scene.clone(), reached: Reached { asked: error, ..Reached::default() } };
        if !self.scene.output.png {
            // Nothing is seen; a file of meshes keeps what the author set.
            chosen.reached.is_within = true;
            chosen.reached.samples = self.scene.image.samples;
            chosen.reached.lod_error_px = self.scene.image.lod_error;
            chosen.reached.enlarged = 1;
            return Ok(chosen);
        }
        self.look()?;
        let planned = error * PLANNED;
        let (shape_square, solver_square) = self.leaves(planned, &mut chosen)?;
        let room = (planned * planned - shape_square - solver_square).max(0.0).sqrt();
        let (scene, limits) = (&self.scene, &self.limits);
        let fits = |times: u32| {
            let pixels = scene.image.pixels() * f64::from(times * times);
            let memory = prediction::picture(scene, times);
            limits.allow(Limit::Pixels, "image", pixels).is_ok() && limits.allow(Limit::Memory, "image", memory).is_ok()
        };
        let mut probes: Vec<&mut Probe> = self.moments.iter_mut().map(|(_, probe)| probe).collect();
        let (sampling, raster) = probe::cheapest(&mut probes, room, fits);
        chosen.scene.image.samples = sampling.samples;
        chosen.scene.image.lod_error = f64::from(sampling.lod_error());
        let parts = [("leaf", shape_square.sqrt()), ("deform", solver_square.sqrt()), ("raster", raster)];
        let reached = &mut chosen.reached;
        reached.lod_error_px = f64::from(sampling.lod_error());
        reached.stages = parts.map(|(name, part)| (name.to_owned(), part)).into_iter().collect::<BTreeMap<_, _>>();
        (reached.samples, reached.enlarged) = (sampling.samples, sampling.enlarged);
        reached.reached = (shape_square + solver_square + raster * raster).sqrt();
        reached.is_within = reached.reached <= error;
        Ok(chosen)
    }

    /// Draws the small pictures of all moments.
    fn look(&mut self) -> Result<(), Diagnostics> {
        if self.moments.is_empty() {
            for index in frames(&self.scene) {
                let still = Still::new(&self.scene, index, &self.limits)?;
                let probe = Probe::new(&still, &self.scene)?;
                self.moments.push((still, probe));
            }
        }
        Ok(())
    }

    /// Chooses for the leaves of all species; the squares of what meshes and solver add.
    fn leaves(&mut self, planned: f64, chosen: &mut Chosen) -> Result<(f64, f64), Diagnostics> {
        let (mut of_shapes, mut of_solver) = (0.0, 0.0);
        for (number, worn) in self.worn.iter_mut().enumerate() {
            // The steepest picture with the nearest leaves decides.
            let of = |probe: &Probe| probe.sensitivity(number);
            let seen = self.moments.iter_mut().filter(|(_, probe)| of(probe) > 0.0);
            let Some((still, probe)) = seen.max_by(|a, b| of(&a.1).total_cmp(&of(&b.1))) else { continue };
            let (leaf, shape, solver) = leaf((still, probe), worn, number, planned)?;
            chosen.scene.species[number].leaf.vertices = leaf.vertices;
            chosen.scene.species[number].deform.shell.tolerance = leaf.tolerance;
            chosen.reached.leaves.push(leaf);
            of_shapes += shape * shape;
            of_solver += solver * solver;
        }
        Ok((of_shapes, of_solver))
    }
}

/// The frames that are looked at.
fn frames(scene: &Scene) -> BTreeSet<i64> {
    let last = (scene.time.count() as i64 - 1).max(0);
    [0, last / 2, last].into()
}

/// The leaves of a species: what is chosen, and the errors of meshes and solver in the picture.
fn leaf(
    (still, probe): (&mut Still, &mut Probe),
    worn: &mut Worn,
    number: usize,
    planned: f64,
) -> Result<(ChosenLeaf, f64, f64), Diagnostics> {
    let sensitivity = probe.sensitivity(number);
    let species = &still.scene().species[number];
    let (label, extent) = (species.label().to_owned(), species.leaf.length * 1e-3);
    let of_solver = |tolerance: f64| tolerance * extent * sensitivity;
    let fine = TOLERANCES.into_iter().find(|&tolerance| of_solver(tolerance) <= planned * OF_SOLVER);
    let tolerance = fine.unwrap_or(TOLERANCES[TOLERANCES.len() - 1]);
    let is_scan = species.leaf.picture.is_some() || species.assets.contains_key("leaf.picture");
    let (vertices, of_shape) = if is_scan {
        // A scan is traced anew for each mesh; its author's vertices stay.
        (species.leaf.vertices, 0.0)
    } else {
        worn.fewest((still, probe), number, planned * OF_SHAPE)?
    };
    let chosen = ChosenLeaf { species: label, vertices, tolerance };
    Ok((chosen, of_shape, of_solver(tolerance)))
}
