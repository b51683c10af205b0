//! Draws the frames of a prepared scene and writes their files.

use super::finishing::{FrameFiles, Image, Made, Written};
use super::layers::Seen;
use super::manifest::Key;
use super::names::Names;
use super::preparation::Prepared;
use super::progress::{self, Event, Progress};
use super::signals::Signals;
use super::stopwatch::{self, timed};
use super::wardrobe::Atelier;
use super::{Options, Outcome, enlargement, fault, files, layers, leaf_falls, shares_chart, states_file, wardrobe};
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::figures::Figures;
use crate::base::picture::Picture;
use crate::compose::contact_sheet::Sheet;
use crate::compose::{self, Falls, Stock, picture_inset};
use crate::export::{self, ExportError};
use crate::fall::Counts;
use crate::frame::Frame;
use crate::plan::{self, PlannedFrame};
use crate::raster::{self, Drawing, Renderer, Wanted};
use crate::report::{FrameReport, Report, ViewReport};
use crate::scene::output::{Chart, Gltf};
use crate::scene::{Scene, camera::Subject};
use crate::season::{self, LeafStates};
use std::collections::BTreeMap;
use std::time::Instant;

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

/// What is told of a frame once its files are written.
struct Drawn {
    index: i64,
    states: CellStates,
    falls: CellFalls,
    view: Option<ViewReport>,
    /// Wall time of the drawing, seconds.
    seconds: f64,
}

/// What hears of a run.
struct Listeners<'a> {
    progress: &'a mut Progress,
    outcome: &'a mut Outcome,
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
                self.tell(told, written, is_repeated, &mut listeners)?;
            }
            match next {
                Ok(drawn) => last = Some(drawn),
                Err(fault) => self.failed(planned.index, fault, &mut listeners)?,
            }
            self.repeated.retain(|earlier, _| planned.same_as != Some(*earlier) || last_use[earlier] != planned.index);
        }
        self.finish(last, key, is_repeated, &mut listeners)
    }

    /// Writes a frame's files and tells of it.
    fn finish(
        &mut self,
        frame: Option<(Drawn, Made)>,
        key: &dyn Fn(i64) -> Key,
        is_repeated: impl Fn(i64) -> bool,
        listeners: &mut Listeners<'_>,
    ) -> Result<(), Diagnostics> {
        let Some((told, made)) = frame else { return Ok(()) };
        let written = made.written(&self.options.out, &self.names, key(told.index));
        self.tell(told, written, is_repeated, listeners)
    }

    /// Tells of a frame that is written, and keeps its files if others repeat it.
    fn tell(
        &mut self,
        frame: Drawn,
        written: Result<Written, Diagnostics>,
        is_repeated: impl Fn(i64) -> bool,
        listeners: &mut Listeners<'_>,
    ) -> Result<(), Diagnostics> {
        let written = match written {
            Ok(written) => written,
            Err(fault) => return self.failed(frame.index, fault, listeners),
        };
        if let Some((seconds, figures)) = written.encoding {
            self.report.add("png", seconds, figures);
        }
        self.note(&frame, frame.seconds + written.seconds);
        listeners.progress.tell(Event::Drawn { frame: frame.index });
        if is_repeated(frame.index) {
            self.repeated.insert(frame.index, written.files);
        }
        Ok(())
    }

    /// Notes a frame that failed, or ends the run with its fault.
    fn failed(&self, frame: i64, fault: Diagnostics, listeners: &mut Listeners<'_>) -> Result<(), Diagnostics> {
        if !self.options.keep_going {
            return Err(fault);
        }
        listeners.progress.tell(Event::Failed { frame, message: &fault.to_string() });
        listeners.outcome.failed.push((frame, fault));
        Ok(())
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

    /// The picture and the files of a frame; none when nothing is drawn. A cell without a stock in `stocks` gets one for the time being.
    fn made(
        &mut self,
        index: i64,
        stocks: &[Option<Stock>],
        (states, falls): (&CellStates, &CellFalls),
        view: &mut Option<ViewReport>,
    ) -> Result<Made, Diagnostics> {
        let mut pictures = Vec::new();
        let mut deep = None;
        let mut files = Vec::new();
        let mut layers = Vec::new();
        for (number, (states, falls)) in states.iter().zip(falls).enumerate() {
            let of_its_own = if number < stocks.len() { None } else { self.stock(number)? };
            let Some(stock) = stocks.get(number).and_then(Option::as_ref).or(of_its_own.as_ref()) else { continue };
            let Prepared { scene, stand, plan, ways, .. } = &self.cells[number];
            let layout = scene.output.gltf;
            let worn = states.as_ref().map_or_else(Vec::new, |states| plan::garments(scene, stand, states));
            let frame = timed(&mut self.report, "compose", || {
                let trees = stock.frame(scene, stand, &worn);
                let leaf = (scene.camera.subject == Subject::Leaf).then(|| stock.specimen(scene, &worn, &trees));
                let mut frame = leaf.flatten().unwrap_or(trees);
                frame.camera = compose::turned(scene, index, frame.camera);
                let instances = frame.instances.len() as u64;
                Ok::<_, Diagnostics>((frame, Figures::of(instances)))
            })?;
            let frame = match falls {
                Some(falls) if plan.has("fall") => {
                    let strewn = || {
                        let (frame, figures) = stock.strewn(scene, stand, falls, frame);
                        Ok::<_, Diagnostics>((frame, figures.with("ways", ways.found)))
                    };
                    timed(&mut self.report, "fall", strewn)?
                }
                _ => frame,
            };
            *view = (self.cells.len() == 1).then(|| view_of(&frame));
            // One thread writes the glTF file while the others draw.
            let name = self.names.gltf(index);
            let output = &self.scene.output;
            let wanted = Wanted {
                sites: !self.names.layers(index).is_empty(),
                radiance: output.bits == 16 || output.exr,
                ground_shadow: self.names.ground_shadow(index).is_some(),
            };
            let (drawing, glb) = rayon::join(
                || {
                    scene.output.png.then(|| {
                        let inset = self.scene.output.inset.then(|| stock.inset(&worn, &frame)).flatten();
                        let tools = (&mut self.report, &mut self.renderer);
                        rasterised(tools, &frame, (self.enlarged, inset.as_ref()), wanted)
                    })
                },
                || {
                    let start = Instant::now();
                    let glb = name.zip(layout).map(|(name, layout)| (name, export::glb(&frame, layout_of(layout))));
                    glb.map(|(name, glb)| (name, glb, start.elapsed().as_secs_f64()))
                },
            );
            if let Some(drawing) = drawing.transpose()? {
                if wanted.sites {
                    let seen = Seen { frame: &frame, sites: &drawing.sites, stand, states: states.as_ref() };
                    layers.extend(timed(&mut self.report, "png", || {
                        let made = layers::layers(&seen).map_err(|error| fault::export(&error))?;
                        Ok::<_, Diagnostics>((made, Figures::of(0)))
                    })?);
                }
                files.extend(self.beside(index, &frame, &drawing).map_err(|error| fault::export(&error))?);
                if self.scene.output.bits == 16 {
                    let size = [frame.view.width, frame.view.height];
                    deep = Some(Image::Sixteen { size, pixels: raster::developed(&frame.view, &drawing.radiance) });
                }
                pictures.push((self.scene.seeds.get(number).copied(), drawing.picture));
            }
            if let Some((name, glb, seconds)) = glb {
                let (bytes, figures) = glb.map_err(|error| fault::export(&error))?;
                self.report.add("gltf", seconds, figures);
                files.push((name, bytes));
            }
        }
        files.extend(self.names.layers(index).into_iter().zip(layers));
        let name = self.names.png(index).filter(|_| !pictures.is_empty());
        let picture = name.map(|name| (name, deep.unwrap_or_else(|| Image::Eight(self.assembled(pictures)))));
        Ok(Made { picture, files })
    }

    /// The files of a frame's light and of its shadow on the ground.
    fn beside(&self, index: i64, frame: &Frame, drawing: &Drawing) -> Result<FrameFiles, ExportError> {
        let (width, height) = (frame.view.width, frame.view.height);
        let mut files = Vec::new();
        if let Some(name) = self.names.exr(index) {
            files.push((name, export::exr(width, height, &drawing.radiance)?));
        }
        if let Some(name) = self.names.ground_shadow(index) {
            let pixels = drawing.ground_shadow.iter().map(|&alpha| [0, 0, 0, alpha]).collect();
            files.push((name, export::png(&Picture { width, height, pixels })?));
        }
        Ok(files)
    }

    /// The picture of a frame: the only one, or all of them as a contact sheet.
    fn assembled(&self, mut pictures: Vec<(Option<u64>, Picture)>) -> Picture {
        match pictures.pop() {
            Some((_, picture)) if self.scene.cell_count() == 0 => picture,
            last => {
                pictures.extend(last);
                let image = &self.scene.image;
                Sheet::in_columns(image.width, image.height, pictures.len(), image.columns).assemble(&pictures)
            }
        }
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

    /// Reports a frame that was there already.
    pub fn count_kept(&mut self, index: i64) {
        let states = self.states(index);
        let falls = self.falls(index, &states);
        self.note(&Drawn { index, states, falls, view: None, seconds: 0.0 }, 0.0);
    }

    /// Adds a frame to the report and to the file of states. The counts are of all trees, and of all cells.
    fn note(&mut self, drawn: &Drawn, seconds: f64) {
        let Drawn { index, states, falls, view, .. } = drawn;
        let index = *index;
        // A moment's day is known to the cells.
        let shown = self.cells.first().map_or(self.scene, |cell| &cell.scene);
        let day = shown.time.at(index);
        let mut frame = FrameReport {
            index,
            day,
            date: shown.weather.date(day).map(|date| date.to_string()),
            leaves: self.cells.iter().map(|cell| cell.stand.leaf_ids.len() as u64).sum(),
            states: BTreeMap::new(),
            expected: BTreeMap::new(),
            fallen: 0,
            fall: falls.iter().flatten().map(|falls| falls.counts).reduce(Counts::plus),
            png: self.names.png(index),
            gltf: self.names.gltf(index),
            view: *view,
            seconds,
        };
        let drawn: usize = states.iter().flatten().map(|states| states.states.len()).sum();
        for (number, (cell, states)) in self.cells.iter().zip(states).enumerate() {
            let Some(states) = states else { continue };
            let alone = states.states.len() == drawn;
            let weight = states.states.len() as f64 / drawn.max(1) as f64;
            for (place, name) in states.names.iter().enumerate() {
                let count = states.states.iter().filter(|&&state| usize::from(state) == place).count() as u64;
                *frame.states.entry(name.clone()).or_default() += count;
                let share = if alone { states.expected[place] } else { weight * states.expected[place] };
                *frame.expected.entry(name.clone()).or_default() += share;
            }
            if self.options.states.is_some() {
                let when = (index, cell.scene.time.at(index));
                let of_sheet =
                    self.scene.sheet_column().map(|_| self.scene.seeds.get(number).copied().unwrap_or(number as u64));
                states_file::append(&mut self.states_text, when, &cell.stand, states, of_sheet);
            }
        }
        frame.fallen = frame.states.get(season::FALLEN).copied().unwrap_or(0);
        self.report.frames.push(frame);
    }
}

/// A frame drawn, with another let into its picture.
fn rasterised(
    (report, renderer): (&mut Report, &mut Renderer),
    frame: &Frame,
    (enlarged, inset): (u32, Option<&Frame>),
    wanted: Wanted,
) -> Result<Drawing, Diagnostics> {
    timed(report, "raster", || {
        let before = stopwatch::processor_seconds();
        let mut drawing = enlargement::drawn(renderer, frame, enlarged, wanted);
        if let Some(inset) = inset {
            picture_inset::place(&mut drawing.picture, &renderer.draw(inset).0);
        }
        let figures = std::mem::take(&mut drawing.figures);
        Ok((drawing, figures.with("cpu_seconds", stopwatch::processor_seconds() - before)))
    })
}

fn view_of(frame: &Frame) -> ViewReport {
    ViewReport {
        position: frame.camera.position.into(),
        target: frame.camera.target.into(),
        field_of_view: frame.camera.field_of_view.to_degrees(),
        sun: frame.sun.direction.into(),
    }
}

fn layout_of(layout: Gltf) -> export::Layout {
    match layout {
        Gltf::Nodes => export::Layout::Nodes,
        Gltf::Merged => export::Layout::Merged,
        Gltf::Instanced => export::Layout::Instanced,
    }
}
