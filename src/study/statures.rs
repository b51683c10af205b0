//! The family of the species as trees, of a scene or all built-in ones.

use super::desk::{Desk, bug};
use super::trees::{self, Failure};
use super::{csv, table};
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::family::Family;
use crate::base::message;
use crate::run::fault;
use crate::scene::{self, Scene};
use std::path::Path;

/// Runs the family. A scene whose leaf is a scan has none: the study measures leaves by their outline.
///
/// # Errors
/// What rules, outlines or limits refuse; files that cannot be written; a scan when nothing else is asked for.
pub fn study(desk: &mut Desk<'_>) -> Result<(), Diagnostics> {
    let request = desk.request;
    // Of a sheet the trees of its first cell.
    let scene = request.subject.as_ref().map(|subject| subject.scene.cells.first().unwrap_or(&subject.scene));
    let is_scanned = |scene: &&Scene| scene.species.iter().any(|species| species.assets.contains_key("leaf.picture"));
    if let Some(scene) = scene.filter(is_scanned) {
        let what = "the study of trees measures leaves by their outline, and here is a scan";
        if request.family == Family::All {
            desk.section("Trees", &format!("Left out: {what}."));
            return Ok(());
        }
        let place = scene.places.of("leaf.picture");
        return Err(Diagnostic::error(Fault::Scene, what, "trace it first and give leaf.outline").at(place).into());
    }
    let subjects = scene.map_or_else(trees::built_in, subjects);
    let lines = match trees::lines(&subjects, &request.limits, request.quick) {
        // Without a blade there is a tree to draw, but no leaves to measure.
        Err((_, Failure::Leaf(error))) if request.family == Family::All => {
            desk.section("Trees", &format!("Left out: {error}."));
            return Ok(());
        }
        lines => lines,
    };
    let lines = lines.map_err(|(number, failure)| match (failure, scene.map(|scene| &scene.species[number])) {
        (Failure::Tree(error), Some(species)) => fault::tree(species, &error),
        (Failure::Leaf(error), Some(species)) => fault::leaf(species, &error),
        (failure, None) => bug(&failure.to_string()),
    })?;
    for line in &lines {
        let value = line.value.map_or_else(|| "none".to_owned(), |value| format!("{value:.3}"));
        desk.tell(&format!("trees {}: {} {value}", line.subject, line.figure));
    }
    desk.write("trees.csv", csv(&lines).as_bytes())?;
    let missed = lines.iter().filter(|line| !line.is_met()).count();
    let found = format!("{} of {} figures", lines.len() - missed, lines.len());
    // Beside other families the figures are told: many of their ranges are judgements.
    if request.family != Family::All {
        desk.judge("T1", missed == 0, "the figures of trees lie in the ranges of floras and judgement", found.clone());
    }
    desk.section("Trees", &format!("{found} lie in their ranges.\n\n```text\n{}```", table(&lines)));
    Ok(())
}

/// A scene's species, in their order; a species file goes by its name without folder and ending.
fn subjects(scene: &Scene) -> Vec<trees::Subject> {
    let subject = |species: &scene::Species| {
        let name = species.name.as_deref().unwrap_or(&scene.name);
        let name = Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = message::shown(&name, 60);
        trees::Subject { name, seed: scene.seed, tree: species.tree.clone(), leaf: species.leaf.clone() }
    };
    scene.species.iter().map(subject).collect()
}
