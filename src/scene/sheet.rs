//! Contact sheets: `seeds` draws the scene once with each seed, in the cells of one picture.

use super::Scene;
use crate::base::diagnostic::Diagnostic;
use crate::base::settings::Complaint;

/// Most seeds of a sheet.
pub(super) const MOST_SEEDS: usize = 100;

/// Fewest pixels of a cell's sides: less shows nothing to choose from.
const SMALLEST_CELL: u32 = 16;

/// Columns and rows of a grid for so many cells, as square as can be.
#[must_use]
pub fn grid(count: usize) -> [u32; 2] {
    let count = count.max(1) as u32;
    let columns = (1..=count).find(|columns| columns * columns >= count).unwrap_or(count);
    [columns, count.div_ceil(columns)]
}

/// Takes away what a sheet cannot have, with a warning: seeds may come from the command line above any scene.
pub(super) fn settle(scene: &mut Scene) -> Option<Diagnostic> {
    if scene.seeds.is_empty() || scene.output.gltf.is_none() {
        return None;
    }
    scene.output.gltf = None;
    let what = "a contact sheet is a picture: no glTF file is written";
    Some(Diagnostic::warning(what, "choose one with `seed` to have its glTF file").at(scene.place("seeds")))
}

/// What is wrong with the seeds of a well-typed scene.
pub(super) fn check(scene: &Scene) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    if scene.seeds.is_empty() {
        return complaints;
    }
    let [columns, rows] = grid(scene.seeds.len());
    let (width, height) = (scene.image.width / columns, scene.image.height / rows);
    if width.min(height) < SMALLEST_CELL {
        let what = format!("cells of {width} by {height} pixels are too small to choose from");
        complaints.push(Complaint::new("seeds", what, "name fewer seeds, or enlarge image.width and image.height"));
    }
    complaints
}
