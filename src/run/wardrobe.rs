//! Makes what leaves wear: the blade, its shapes and its textures, as far as the plan has jobs for them.

use super::fault;
use super::leaf_area::leaf_area_index;
use super::preparation::Prepared;
use super::stopwatch::timed;
use crate::base::blade::Blade;
use crate::base::diagnostic::Diagnostics;
use crate::base::limits::{Limit, Limits};
use crate::base::mesh::Mesh;
use crate::base::picture::Picture;
use crate::colour::{self, Painted};
use crate::compose::Wardrobe;
use crate::deform;
use crate::leaf::{self, Pictures};
use crate::plan::{self, Plan};
use crate::report::Report;
use crate::scene::{self, Scene};
use serde_json::Value;
use std::collections::BTreeMap;

/// Memory for each pixel of a scan while it is traced, bytes (measured: 27).
const TRACED_BYTES: f64 = 32.0;

/// An item of a stage: a state's number and a variant's.
type Item = (u16, u32);

/// Makes the wardrobe of a plan; empty when no leaf is left.
///
/// # Errors
/// Pictures that cannot be read, outlines that cannot be meshed, steps that are not stable, limits.
pub fn wardrobe(
    scene: &Scene,
    prepared: &Prepared,
    limits: &Limits,
    report: &mut Report,
) -> Result<Wardrobe, Diagnostics> {
    let Prepared { states, plan, .. } = prepared;
    let mut wardrobe = Wardrobe { states: states.clone(), ..Wardrobe::default() };
    if !plan.has("leaf") {
        return Ok(wardrobe);
    }
    let blade = blade(scene, limits, report)?;
    note_leaf_area(prepared, &blade, report);
    if plan.has("deform") {
        let shapes = shapes(scene, states, plan, &blade, limits, report)?;
        for garment in &plan.garments {
            let item = (garment.state, garment.variant % scene.deform.shapes);
            wardrobe.shapes.insert(*garment, shapes[&item].clone());
        }
    }
    if plan.has("colour") {
        let textures = textures(scene, states, plan, &blade, report);
        for garment in &plan.garments {
            let item = (garment.state, garment.variant % scene.colour.variants);
            wardrobe.textures.insert(*garment, textures[&item].clone());
        }
    }
    Ok(wardrobe)
}

/// Adds to the tree's figures what takes a blade to know.
fn note_leaf_area(prepared: &Prepared, blade: &Blade, report: &mut Report) {
    let projection = report.figure("tree", "crown_projection_m2").and_then(Value::as_f64);
    let index = projection.and_then(|ground| leaf_area_index(&prepared.tree.sites, &blade.mesh, ground));
    if let Some(index) = index {
        report.note("tree", "leaf_area_index", index);
    }
}

fn blade(scene: &Scene, limits: &Limits, report: &mut Report) -> Result<Blade, Diagnostics> {
    let read = |key: &str| -> Result<Option<Picture>, Diagnostics> {
        let asset = scene.assets.get(key);
        asset.map(|asset| scene::read_picture(asset, limits)).transpose().map_err(Diagnostics::from)
    };
    let (picture, mask) = (read("leaf.picture")?, read("leaf.mask")?);
    if let Some(picture) = &picture {
        let wanted = f64::from(picture.width) * f64::from(picture.height) * TRACED_BYTES;
        let allowed = limits.allow(Limit::Memory, "leaf.picture", wanted);
        allowed.map_err(|refusal| fault::refused(scene, "leaf.picture", &refusal))?;
    }
    let pictures = Pictures { picture: picture.as_ref(), mask: mask.as_ref() };
    timed(report, "leaf", || leaf::model(&scene.leaf, pictures, limits)).map_err(|error| fault::leaf(scene, &error))
}

fn shapes(
    scene: &Scene,
    states: &[String],
    plan: &Plan,
    blade: &Blade,
    limits: &Limits,
    report: &mut Report,
) -> Result<BTreeMap<Item, Mesh>, Diagnostics> {
    let items = plan::items(&plan.garments, scene.deform.shapes);
    let job = |&(state, variant): &Item| {
        let state = states[usize::from(state)].clone();
        let dryness = scene.deform.states.get(&state).map_or(0.0, |shape| shape.dryness);
        deform::Job { state, variant, dryness }
    };
    let jobs: Vec<deform::Job> = items.iter().map(job).collect();
    let made = timed(report, "deform", || deform::deform(&scene.deform, &blade.mesh, &jobs, scene.seed, limits));
    let made = made.map_err(|error| fault::deform(scene, &error))?;
    Ok(items.into_iter().zip(made).collect())
}

fn textures(
    scene: &Scene,
    states: &[String],
    plan: &Plan,
    blade: &Blade,
    report: &mut Report,
) -> BTreeMap<Item, Painted> {
    let items = plan::items(&plan.garments, scene.colour.variants);
    let job = |&(state, variant): &Item| colour::Job { state: states[usize::from(state)].clone(), variant };
    let jobs: Vec<colour::Job> = items.iter().map(job).collect();
    let made = timed(report, "colour", || {
        Ok::<_, std::convert::Infallible>(colour::paint(&scene.colour, blade, &jobs, scene.seed))
    });
    items.into_iter().zip(made.unwrap_or_else(|never| match never {})).collect()
}
