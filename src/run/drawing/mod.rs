//! Draws the frames of a prepared scene and writes their files.

mod picture;
mod telling;

use super::finishing::{FrameFiles, Made};
use super::manifest::Key;
use super::names::Names;
use super::preparation::Prepared;
use super::progress::{self, Progress};
use super::signals::Signals;
use super::wardrobe::Atelier;
use super::{Options, Outcome, fault, files, leaf_falls, shares_chart, states_file, wardrobe};
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::compose::{Falls, Stock};
use crate::plan::PlannedFrame;
use crate::raster::Renderer;
use crate::report::Report;
use crate::scene::Scene;
use crate::scene::output::Chart;
use crate::season::LeafStates;
use std::collections::BTreeMap;
use std::time::Instant;
use telling::{Drawn, Listeners};

/// The states of the leaves of every cell; none without seasons.
type CellStates = Vec<Option<LeafStates>>;
/// The fallen leaves of every cell; none where they are not asked for.
type CellFalls = Vec<Option<Falls>>;

/// A run under way.
pub struct Run<'a> {
    scene: &'a Scene,
    options: &'a Options,
    /// The scene, or the cells of its contact sheet.
    cells: Vec<Prepared>,
    names: Names,
    report: Report,
    states_text: String,
    renderer: Renderer,
    atelier: Atelier,
    /// How many times as large pictures are drawn before they are averaged.
    enlarged: u32,
    /// The files of frames that later frames repeat, until the last of them.
    repeated: BTreeMap<i64, FrameFiles>,
}

impl<'a> Run<'a> {
    /// A run that has drawn nothing yet.
    pub fn new(scene: &'a Scene, options: &'a Options, cells: Vec<Prepared>, names: Names, report: Report) -> Self {
        let trees = cells.iter().map(|cell| cell.stand.trees.len()).max().unwrap_or(0);
        let states_text = states_file::header(trees > 1, scene.sheet_column());
        let (renderer, atelier, repeated) = (Renderer::default(), Atelier::default(), BTreeMap::new());
        Self { scene, options, cells, names, report, states_text, renderer, atelier, enlarged: 1, repeated }
    }

    /// The same run with pictures that are drawn so many times as large.
    pub fn enlarged(self, enlarged: u32) -> Self {
        Self { enlarged, ..self }
    }

    /// The report and the text of the file of states.
    pub fn finished(self) -> (Report, String) {
        (self.report, self.states_text)
    }

    /// Draws every frame that is planned.
    ///
    /// # Errors
    /// The first fault; with `keep_going` only what stops every frame.
    pub fn draw_all(
        &mut self,
        progress: &mut Progress,
        signals: &Signals,
        key: &dyn Fn(i64) -> Key,
        outcome: &mut Outcome,
    ) -> Result<(), Diagnostics> {
        let mut stocks = Vec::new();
        // The cells of one picture are made one after another as it is drawn, so that their textures are not held together.
        let are_kept = self.cells.len() == 1 || self.cells.first().is_some_and(|cell| cell.plan.frames.len() > 1);
        for number in 0..if are_kept { self.cells.len() } else { 0 } {
            if signals.came() {
                outcome.interrupted = true;
                return Ok(());
            }
            stocks.push(self.stock(number)?);
        }
        if are_kept {
            self.atelier = Atelier::default();
        }
        if signals.came() {
            outcome.interrupted = true;
            return Ok(());
        }
        self.make_folder()?;
        files::clean(&self.options.out);
        let frames = self.cells.first().map_or_else(Vec::new, |cell| cell.plan.frames.clone());
        let last_use: BTreeMap<i64, i64> = frames.iter().filter_map(|f| Some((f.same_as?, f.index))).collect();
        let is_repeated = |index: i64| last_use.contains_key(&index);
        let mut listeners = Listeners { progress, outcome };
        let mut last: Option<(Drawn, Made)> = None;
        for planned in frames {
            if signals.came() {
                listeners.outcome.interrupted = true;
                break;
            }
            if planned.same_as.is_some() {
                // What it repeats may be the frame before it.
                self.finish(last.take(), key, is_repeated, &mut listeners)?;
            }
            // A frame is finished while the next is drawn.
            let (folder, names) = (&self.options.out, self.names.clone());
            let (told, made) = last.take().unzip();
            let before = made.zip(told.as_ref().map(|told| key(told.index)));
            let (next, written) = rayon::join(
                || self.draw(planned, &stocks),
                || before.map(|(made, key)| made.written(folder, &names, key)),
            );
            if let Some((told, written)) = told.zip(written) {
                self.tell(&told, written, is_repeated, &mut listeners)?;
            }
            match next {
                Ok(drawn) => last = Some(drawn),
                Err(fault) => self.failed(planned.index, fault, &mut listeners)?,
            }
            self.repeated.retain(|earlier, _| planned.same_as != Some(*earlier) || last_use[earlier] != planned.index);
        }
        self.finish(last, key, is_repeated, &mut listeners)
    }

    /// What a cell is drawn with in every frame; none when nothing is drawn.
    fn stock(&mut self, number: usize) -> Result<Option<Stock>, Diagnostics> {
        let cell = &self.cells[number];
        let wardrobe = wardrobe::wardrobe(cell, &self.options.limits, &mut self.atelier, &mut self.report)?;
        Ok(cell.plan.has("compose").then(|| {
            let start = Instant::now();
            let stock = Stock::new(&cell.scene, &cell.stand, &wardrobe);
            self.report.spend("compose", start.elapsed().as_secs_f64());
            stock
        }))
    }

    /// Writes the chart of the shares; a sheet of cells and trees without seasons have none.
    ///
    /// # Errors
    /// When it cannot be made or written.
    pub fn write_shares(&mut self, form: Chart) -> Result<(), Diagnostics> {
        let cell = match self.cells.as_slice() {
            [cell] if !cell.states.is_empty() => cell,
            _ => {
                let note = "output.shares draws nothing for a sheet of cells, nor without seasons";
                self.report.notes.push(note.to_owned());
                return Ok(());
            }
        };
        let (ending, bytes) = shares_chart::chart(cell, form).map_err(|error| fault::export(&error))?;
        self.make_folder()?;
        let path = self.options.out.join(format!("{}.shares.{ending}", self.names.scene));
        files::write(&path, &bytes).map_err(|error| fault::written(&error))
    }

    fn make_folder(&self) -> Result<(), Diagnostics> {
        let out = &self.options.out;
        std::fs::create_dir_all(out).map_err(|error| {
            let what = format!("cannot make the folder {}: {error}", progress::escaped(&out.to_string_lossy()));
            Diagnostic::error(Fault::Output, what, "name another folder with --out").into()
        })
    }

    /// Draws one frame, or takes the files of the one that it repeats.
    fn draw(&mut self, planned: PlannedFrame, stocks: &[Option<Stock>]) -> Result<(Drawn, Made), Diagnostics> {
        let start = Instant::now();
        let index = planned.index;
        let states = self.states(index);
        let falls = self.falls(index, &states);
        let mut view = None;
        let made = match planned.same_as.and_then(|earlier| self.repeated.get(&earlier)) {
            Some(files) => {
                let names = self.names.all(index);
                let files = names.into_iter().zip(files).map(|(name, (_, bytes))| (name, bytes.clone())).collect();
                Made { picture: None, files }
            }
            None => self.made(index, stocks, (&states, &falls), &mut view)?,
        };
        Ok((Drawn { index, states, falls, view, seconds: start.elapsed().as_secs_f64() }, made))
    }

    fn states(&mut self, index: i64) -> CellStates {
        self.cells.iter_mut().map(|cell| cell.assigned(index, &mut self.report)).collect()
    }

    fn falls(&mut self, index: i64, states: &CellStates) -> CellFalls {
        let start = Instant::now();
        let of_cell = |(cell, states): (&mut Prepared, &Option<LeafStates>)| {
            leaf_falls::falls((&cell.scene, &cell.stand), states.as_ref()?, index, &mut cell.ways)
        };
        let falls: CellFalls = self.cells.iter_mut().zip(states).map(of_cell).collect();
        if falls.iter().flatten().any(|falls| !falls.seen.is_empty()) {
            self.report.spend("fall", start.elapsed().as_secs_f64());
        }
        falls
    }
}
