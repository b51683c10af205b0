//! Makes what leaves wear: the blade, its shapes and its textures, as far as the plan has jobs for them.

use super::fault;
use super::preparation::Prepared;
use super::stopwatch::timed;
use crate::base::blade::Blade;
use crate::base::diagnostic::Diagnostics;
use crate::base::figures::Figures;
use crate::base::limits::Limits;
use crate::base::mesh::Mesh;
use crate::base::picture::Picture;
use crate::colour::{self, Painted};
use crate::compose::{Form, Garment, Wardrobe, blade_area, largest_blade, texture_size};
use crate::deform;
use crate::leaf::{self, Chart, Fringe, Pictures};
use crate::plan;
use crate::report::Report;
use crate::scene::camera::Subject;
use crate::scene::image::Leaves;
use crate::scene::{self, Scene, Species, Standing};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// An item of a stage: a state's number and a variant's.
type Item = (u16, u32);

/// Blades that are seen shorter than this, in pixels, are drawn with the mesh that was bent.
const LARGE: f64 = 96.0;
/// How far the drawn margin may lie from the outline, pixels.
const TOLERANCE: f64 = 0.35;
/// Most triangles of a leaf on a tree that is drawn with its own margin, against those of the mesh that was bent.
const MORE: f64 = 1.25;

/// What cells of a contact sheet may share: the blade made last and the canvas laid out on it, with what they were made of. One of
/// each, since cells of a species stand together.
#[derive(Default)]
pub struct Atelier {
    blade: Option<(leaf::Settings, Arc<Blade>, Figures)>,
    canvas: Option<(colour::Settings, Arc<Blade>, colour::Canvas)>,
}

/// Makes the wardrobe of a plan, species by species; empty when no leaf is left.
///
/// # Errors
/// Pictures that cannot be read, outlines that cannot be meshed, steps that are not stable, limits.
pub fn wardrobe(
    prepared: &Prepared,
    limits: &Limits,
    atelier: &mut Atelier,
    report: &mut Report,
) -> Result<Wardrobe, Diagnostics> {
    let Prepared { scene, states, plan, stand, .. } = prepared;
    let fallen = plan.fallen.clone();
    let mut wardrobe = Wardrobe { states: states.clone(), fallen, is_worn: plan.is_worn, ..Wardrobe::default() };
    let mut leaf_area = Some(0.0);
    for (number, species) in scene.species.iter().enumerate() {
        let (garments, painted) = (plan.garments_of(number), plan.painted_of(number));
        let has_sites = stand.forms.iter().any(|form| form.species == number && !form.sites.is_empty());
        if garments.is_empty() {
            // Without a blade nothing is known of its area.
            leaf_area = leaf_area.filter(|_| !has_sites);
            continue;
        }
        let mut tailor =
            Tailor { scene, species, states, garments: &garments, painted: &painted, limits, atelier, report };
        let blade = tailor.blade()?;
        let area_of = |(form, _): (&Form, &Standing)| {
            if form.species == number { blade_area(&form.sites, &blade.mesh) } else { 0.0 }
        };
        leaf_area = leaf_area.map(|sum| sum + stand.standing().map(area_of).sum::<f64>());
        let shapes = tailor.shapes(&blade, largest_blade(scene, stand, number))?;
        let size = texture_size(scene, stand, number);
        let textures = if plan.has("colour") { tailor.textures(&blade, size)? } else { BTreeMap::new() };
        let chart = chart(scene.image.leaves).map(|chart| Arc::new(charted(chart, &blade)));
        for garment in &garments {
            let item = |count: u32| (garment.state, garment.variant % count.max(1));
            wardrobe.shapes.insert(*garment, shapes[&item(species.deform.shapes)].clone());
        }
        wardrobe.bare.extend(garments.iter().filter(|garment| !painted.contains(garment)));
        for garment in &painted {
            let item = |count: u32| (garment.state, garment.variant % count.max(1));
            if let Some(painted) = textures.get(&item(species.colour.variants)).or(chart.as_ref()) {
                wardrobe.textures.insert(*garment, painted.clone());
            }
        }
    }
    if let Some(area) = leaf_area {
        note_leaf_area(stand.leaf_ids.len(), area, report);
    }
    Ok(wardrobe)
}

/// Adds to the trees' figures what takes blades to know: the mean area of a blade, and the one-sided area of all blades in
/// full leaf over the ground below the crowns, m2/m2 (Watson 1947), crown by crown.
fn note_leaf_area(leaves: usize, area: f64, report: &mut Report) {
    let projection = report.figure("tree", "crown_projection_m2").and_then(Value::as_f64).unwrap_or(0.0);
    let index = area / projection;
    if index.is_finite() && index > 0.0 {
        report.note("tree", "leaf_area_index", index);
        report.note("tree", "mean_blade_area_cm2", area / leaves as f64 * 1e4);
    }
}

/// The chart that leaves show in place of their colours.
fn chart(leaves: Leaves) -> Option<Chart> {
    match leaves {
        Leaves::Lit | Leaves::White => None,
        Leaves::Mask => Some(Chart::Mask),
        Leaves::Outline => Some(Chart::Outline),
        Leaves::Veins => Some(Chart::Veins),
    }
}

/// A chart as an opaque texture.
fn charted(chart: Chart, blade: &Blade) -> Painted {
    let picture = leaf::chart(chart, blade);
    let reflected: Vec<[u8; 3]> = picture.pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
    let transmitted = Arc::new(vec![[0; 3]; reflected.len()]);
    Painted { size: picture.width, transmitted, reflected: Arc::new(reflected), ..Painted::default() }
}

/// Makes what leaves of one species wear.
struct Tailor<'a> {
    scene: &'a Scene,
    species: &'a Species,
    states: &'a [String],
    garments: &'a [Garment],
    painted: &'a [Garment],
    limits: &'a Limits,
    atelier: &'a mut Atelier,
    report: &'a mut Report,
}

impl Tailor<'_> {
    /// Runs a stage for the report; where there are several species, the figures of each are kept by its name.
    fn timed<T, E>(&mut self, stage: &str, work: impl FnOnce() -> Result<(T, Figures), E>) -> Result<T, E> {
        let mut figures = Figures::default();
        let made = timed(self.report, stage, || work().inspect(|(_, made)| figures = made.clone()))?;
        if self.scene.species.len() > 1 {
            self.report.note_of(stage, self.species.label(), figures);
        }
        Ok(made)
    }

    fn blade(&mut self) -> Result<Arc<Blade>, Diagnostics> {
        let is_painted =
            !["leaf.picture", "leaf.mask", "leaf.texture"].iter().any(|key| self.species.assets.contains_key(*key));
        if let Some((settings, blade, figures)) = &self.atelier.blade
            && is_painted
            && *settings == self.species.leaf
        {
            // What was made once is the blade of this species too.
            if self.scene.species.len() > 1 {
                self.report.note_of("leaf", self.species.label(), figures.clone());
            }
            return Ok(blade.clone());
        }
        let (blade, figures) = self.modelled()?;
        let blade = Arc::new(blade);
        self.atelier.blade = is_painted.then(|| (self.species.leaf.clone(), blade.clone(), figures));
        Ok(blade)
    }

    fn modelled(&mut self) -> Result<(Blade, Figures), Diagnostics> {
        let (species, limits) = (self.species, self.limits);
        let read = |key: &str| -> Result<Option<Picture>, Diagnostics> {
            let asset = species.assets.get(key);
            asset.map(|asset| scene::read_picture(asset, limits)).transpose().map_err(Diagnostics::from)
        };
        let (picture, mask, texture) = (read("leaf.picture")?, read("leaf.mask")?, read("leaf.texture")?);
        if let Some(picture) = &picture {
            let allowed = super::leaf::allow(picture, limits);
            allowed.map_err(|refusal| fault::refused(&species.places, "leaf.picture", &refusal))?;
        }
        let pictures = Pictures { picture: picture.as_ref(), mask: mask.as_ref(), texture: texture.as_ref() };
        let model = || leaf::model(&species.leaf, pictures, limits);
        self.timed("leaf", || model().map(|(blade, figures)| ((blade, figures.clone()), figures)))
            .map_err(|error| fault::leaf(species, &error))
    }

    fn shapes(&mut self, blade: &Blade, pixels: f64) -> Result<BTreeMap<Item, Arc<Mesh>>, Diagnostics> {
        let (scene, species, limits, states) = (self.scene, self.species, self.limits, self.states);
        let items = plan::items(self.garments, species.deform.shapes);
        let job = |&(state, variant): &Item| {
            let state = states[usize::from(state)].clone();
            let dryness = species.deform.states.get(&state).map_or(0.0, |shape| shape.dryness);
            deform::Job { state, variant, dryness }
        };
        let jobs: Vec<deform::Job> = items.iter().map(job).collect();
        let made = self.timed("deform", || deform::deform(&species.deform, blade, &jobs, scene.seed, limits));
        let mut made = made.map_err(|error| fault::deform(species, &error))?;
        if let Some(fringe) = self.fringe(blade, pixels) {
            made = made.iter().map(|shape| fringe.worn_by(&blade.mesh, shape)).collect();
        }
        Ok(items.into_iter().zip(made.into_iter().map(Arc::new)).collect())
    }

    /// The margin that leaves are drawn with, for a blade that is seen at most so many pixels long.
    fn fringe(&mut self, blade: &Blade, pixels: f64) -> Option<Fringe> {
        let by_itself = self.scene.camera.subject == Subject::Leaf;
        if pixels < LARGE || self.scene.image.wireframe > 0.0 {
            return None;
        }
        let most = if by_itself { usize::MAX } else { (blade.mesh.triangles.len() as f64 * MORE) as usize };
        let fringe = Fringe::new(blade, TOLERANCE * self.species.leaf.length * 1e-3 / pixels, most)?;
        self.report.note("leaf", "drawn_triangles", fringe.triangles());
        self.report.note("leaf", "drawn_margin_mm", fringe.tolerance * 1e3);
        Some(fringe)
    }

    fn textures(&mut self, blade: &Arc<Blade>, size: u32) -> Result<BTreeMap<Item, Arc<Painted>>, Diagnostics> {
        let (scene, species, states) = (self.scene, self.species, self.states);
        let items = plan::items(self.painted, species.colour.variants);
        let job = |&(state, variant): &Item| colour::Job { state: states[usize::from(state)].clone(), variant };
        let jobs: Vec<colour::Job> = items.iter().map(job).collect();
        let scans = self.scans(&jobs)?;
        let settings = colour::Settings { size: Some(size), ..species.colour.clone() };
        // A canvas with scans is of its own states only.
        let known = self.atelier.canvas.take().filter(|(laid, on, _)| *laid == settings && Arc::ptr_eq(on, blade));
        let known = known.filter(|_| scans.is_empty()).map(|(_, _, canvas)| canvas);
        let mut canvas = None;
        let made = self.timed("colour", || {
            let canvas = canvas.insert(known.unwrap_or_else(|| colour::Canvas::new(&settings, blade, &scans)));
            Ok::<_, std::convert::Infallible>(colour::paint_on(canvas, &settings, &jobs, scene.seed))
        });
        self.atelier.canvas = canvas.filter(|_| scans.is_empty()).map(|canvas| (settings, blade.clone(), canvas));
        let made = made.unwrap_or_else(|never| match never {});
        Ok(items.into_iter().zip(made.into_iter().map(Arc::new)).collect())
    }

    /// The scans of the states that are worn.
    fn scans(&self, jobs: &[colour::Job]) -> Result<colour::Scans, Diagnostics> {
        let mut scans = colour::Scans::new();
        for state in jobs.iter().map(|job| &job.state) {
            if let Some(asset) = self.species.assets.get(&format!("colour.scans.{state}"))
                && !scans.contains_key(state)
            {
                scans.insert(state.clone(), scene::read_picture(asset, self.limits)?);
            }
        }
        Ok(scans)
    }
}
