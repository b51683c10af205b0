//! Contact sheets: the scene several times in the cells of one picture, once with each of its `seeds`, or once with the
//! keys of each entry of `[[cells]]` laid over it.

use super::{Scene, image};
use crate::base::diagnostic::Diagnostic;
use crate::base::settings::Complaint;

/// Most cells of a sheet.
pub(super) const MOST_CELLS: usize = 100;

/// Fewest pixels of a cell's sides: less shows nothing to choose from.
const SMALLEST_CELL: u32 = 16;

/// Columns and rows of a grid for so many cells: of `columns`, or as square as can be when that is 0.
#[must_use]
pub fn grid(count: usize, columns: u32) -> [u32; 2] {
    let count = count.max(1) as u32;
    let square = || (1..=count).find(|columns| columns * columns >= count).unwrap_or(count);
    let columns = if columns == 0 { square() } else { columns.min(count) };
    [columns, count.div_ceil(columns)]
}

impl Scene {
    /// Cells of its contact sheet; 0 for a scene that is none.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.seeds.len().max(self.cells.len())
    }

    /// The scene of one of its cells, drawn in that many pixels.
    ///
    /// # Panics
    /// When there is no such cell.
    #[must_use]
    pub fn cell(&self, number: usize, [width, height]: [u32; 2]) -> Self {
        let image = |of: &image::Image| image::Image { width, height, ..of.clone() };
        match self.cells.get(number) {
            Some(cell) => Self { image: image(&cell.image), ..cell.clone() },
            None => Self { seed: self.seeds[number], seeds: Vec::new(), image: image(&self.image), ..self.clone() },
        }
    }

    /// How plans and tables call a cell.
    #[must_use]
    pub fn cell_name(&self, number: usize) -> String {
        match self.seeds.get(number) {
            Some(seed) => format!("seed {seed}"),
            None => format!("cell {number}"),
        }
    }

    /// The column that tells the cells of a sheet apart in tables: its seeds, or the cells' numbers.
    #[must_use]
    pub fn sheet_column(&self) -> Option<&'static str> {
        match (self.seeds.is_empty(), self.cells.is_empty()) {
            (true, true) => None,
            (false, _) => Some("seed"),
            _ => Some("cell"),
        }
    }

    /// The key that makes it a sheet.
    fn sheet_key(&self) -> &'static str {
        if self.cells.is_empty() { "seeds" } else { "cells" }
    }
}

/// Takes away what a sheet cannot have, with a warning: seeds may come from the command line above any scene.
pub(super) fn settle(scene: &mut Scene) -> Option<Diagnostic> {
    let is_sheet = scene.cell_count() > 0;
    let gltf = scene.output.gltf.take_if(|_| is_sheet);
    for cell in &mut scene.cells {
        cell.output = scene.output.clone();
    }
    gltf?;
    let what = "a contact sheet is a picture: no glTF file is written";
    let help = "choose one with `seed` to have its glTF file";
    Some(Diagnostic::warning(what, help).at(scene.place(scene.sheet_key())))
}

/// What is wrong with the cells of a well-typed scene.
pub(super) fn check(scene: &Scene) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    let count = scene.cell_count();
    if count == 0 {
        return complaints;
    }
    if scene.output.bits == 16 {
        complaints.push(Complaint::new(
            "output.bits",
            "a contact sheet has 8 bits",
            "write 8, or draw its cells one by one",
        ));
    }
    if !scene.seeds.is_empty() && !scene.cells.is_empty() {
        let help = "write `seed` into each cell, or take one of the two away";
        complaints.push(Complaint::new("cells", "a sheet of `seeds` has no [[cells]]", help));
    }
    let [columns, rows] = grid(count, scene.image.columns);
    let (width, height) = (scene.image.width / columns, scene.image.height / rows);
    if width.min(height) < SMALLEST_CELL {
        let what = format!("cells of {width} by {height} pixels are too small to choose from");
        let help = "name fewer of them, or enlarge image.width and image.height";
        complaints.push(Complaint::new(scene.sheet_key(), what, help));
    }
    for (number, cell) in scene.cells.iter().enumerate() {
        if !cell.time.is_single() && cell.time.count() != scene.time.count() {
            let what = format!("this cell has {} frames, the sheet has {}", cell.time.count(), scene.time.count());
            let help = "let a cell have one `day`, or as many frames as the sheet";
            complaints.push(Complaint::new(format!("cells.{number}.time"), what, help));
        }
    }
    complaints
}
