//! Draws the frames of a prepared scene and writes their files.

use super::layers::Seen;
use super::manifest::{Key, Manifest};
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
use crate::export;
use crate::fall::Counts;
use crate::frame::Frame;
use crate::plan::{self, PlannedFrame};
use crate::raster::{Renderer, Site};
use crate::report::{FrameReport, Report};
use crate::scene::output::{Chart, Gltf};
use crate::scene::{Scene, camera::Subject};
use crate::season::{self, LeafStates};
use std::collections::BTreeMap;
use std::time::Instant;

/// The files of a frame, by name.
type FrameFiles = Vec<(String, Vec<u8>)>;
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
}

impl<'a> Run<'a> {
    /// A run that has drawn nothing yet.
    pub fn new(scene: &'a Scene, options: &'a Options, cells: Vec<Prepared>, names: Names, report: Report) -> Self {
        let trees = cells.iter().map(|cell| cell.stand.trees.len()).max().unwrap_or(0);
        let states_text = states_file::header(trees > 1, scene.sheet_column());
        let (renderer, atelier) = (Renderer::default(), Atelier::default());
        Self { scene, options, cells, names, report, states_text, renderer, atelier, enlarged: 1 }
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
        // Pictures that later frames repeat are kept until the last of them.
        let mut drawn: BTreeMap<i64, FrameFiles> = BTreeMap::new();
        let frames = self.cells.first().map_or_else(Vec::new, |cell| cell.plan.frames.clone());
        let last_use: BTreeMap<i64, i64> = frames.iter().filter_map(|f| Some((f.same_as?, f.index))).collect();
        for planned in frames {
            if signals.came() {
                outcome.interrupted = true;
                break;
            }
            match self.draw(planned, &stocks, &drawn, key) {
                Ok(files) => {
                    progress.tell(Event::Drawn { frame: planned.index });
                    if last_use.contains_key(&planned.index) {
                        drawn.insert(planned.index, files);
                    }
                    drawn.retain(|earlier, _| planned.same_as != Some(*earlier) || last_use[earlier] != planned.index);
                }
                Err(fault) if self.options.keep_going => {
                    progress.tell(Event::Failed { frame: planned.index, message: &fault.to_string() });
                    outcome.failed.push((planned.index, fault));
                }
                Err(fault) => return Err(fault),
            }
        }
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

    /// Draws one frame and writes its files, the manifest last.
    fn draw(
        &mut self,
        planned: PlannedFrame,
        stocks: &[Option<Stock>],
        drawn: &BTreeMap<i64, FrameFiles>,
        key: &dyn Fn(i64) -> Key,
    ) -> Result<FrameFiles, Diagnostics> {
        let start = Instant::now();
        let index = planned.index;
        let states = self.states(index);
        let falls = self.falls(index, &states);
        let earlier = planned.same_as.and_then(|earlier| drawn.get(&earlier));
        let files: FrameFiles = match earlier {
            Some(files) => {
                let names = self.names.all(index);
                names.into_iter().zip(files).map(|(name, (_, bytes))| (name, bytes.clone())).collect()
            }
            None => self.made(index, stocks, &states, &falls)?,
        };
        for (name, bytes) in &files {
            files::write(&self.options.out.join(name), bytes).map_err(|error| fault::written(&error))?;
        }
        let listed: Vec<(String, &[u8])> = files.iter().map(|(name, bytes)| (name.clone(), bytes.as_slice())).collect();
        let manifest = Manifest::new(&self.names.scene, self.names.frames, key(index), &listed);
        manifest.write(&self.options.out).map_err(|error| fault::written(&error))?;
        self.note(index, &states, &falls, start.elapsed().as_secs_f64());
        Ok(files)
    }

    /// The files of a frame; none when nothing is drawn. A cell without a stock in `stocks` gets one for the time being.
    fn made(
        &mut self,
        index: i64,
        stocks: &[Option<Stock>],
        states: &CellStates,
        falls: &CellFalls,
    ) -> Result<FrameFiles, Diagnostics> {
        let mut pictures = Vec::new();
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
            if scene.output.png {
                let (picture, sites) = {
                    let inset = self.scene.output.inset.then(|| stock.inset(&worn, &frame)).flatten();
                    let wants_sites = !self.names.layers(index).is_empty();
                    let tools = (&mut self.report, &mut self.renderer);
                    rasterised(tools, &frame, (self.enlarged, inset.as_ref()), wants_sites)?
                };
                pictures.push((self.scene.seeds.get(number).copied(), picture));
                if let Some(sites) = sites {
                    let seen = Seen { frame: &frame, sites: &sites, stand, states: states.as_ref() };
                    layers.extend(timed(&mut self.report, "png", || {
                        let made = layers::layers(&seen).map_err(|error| fault::export(&error))?;
                        Ok::<_, Diagnostics>((made, Figures::of(0)))
                    })?);
                }
            }
            if let (Some(name), Some(layout)) = (self.names.gltf(index), layout) {
                let bytes = timed(&mut self.report, "gltf", || export::glb(&frame, layout_of(layout)));
                files.push((name, bytes.map_err(|error| fault::export(&error))?));
            }
        }
        if let Some(name) = self.names.png(index).filter(|_| !pictures.is_empty()) {
            let picture = self.assembled(pictures);
            let bytes = timed(&mut self.report, "png", || {
                let bytes = export::png(&picture).map_err(|error| fault::export(&error))?;
                let figures = Figures::of(1).with("bytes", bytes.len());
                Ok::<_, Diagnostics>((bytes, figures))
            })?;
            files.insert(0, (name, bytes));
        }
        files.extend(self.names.layers(index).into_iter().zip(layers));
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
        self.note(index, &states, &falls, 0.0);
    }

    /// Adds a frame to the report and to the file of states. The counts are of all trees, and of all cells.
    fn note(&mut self, index: i64, states: &CellStates, falls: &CellFalls, seconds: f64) {
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

/// The picture of a frame, with another let into it, and what is seen in its pixels if it is asked for.
fn rasterised(
    (report, renderer): (&mut Report, &mut Renderer),
    frame: &Frame,
    (enlarged, inset): (u32, Option<&Frame>),
    wants_sites: bool,
) -> Result<(Picture, Option<Vec<Site>>), Diagnostics> {
    timed(report, "raster", || {
        let before = stopwatch::processor_seconds();
        let (mut picture, sites, figures) = if wants_sites && enlarged <= 1 {
            let (picture, sites, figures) = renderer.draw_with_sites(frame);
            (picture, Some(sites), figures)
        } else {
            let sites = wants_sites.then(|| renderer.draw_with_sites(frame).1);
            let (picture, figures) = enlargement::drawn(renderer, frame, enlarged);
            (picture, sites, figures)
        };
        if let Some(inset) = inset {
            picture_inset::place(&mut picture, &renderer.draw(inset).0);
        }
        Ok(((picture, sites), figures.with("cpu_seconds", stopwatch::processor_seconds() - before)))
    })
}

fn layout_of(layout: Gltf) -> export::Layout {
    match layout {
        Gltf::Nodes => export::Layout::Nodes,
        Gltf::Merged => export::Layout::Merged,
        Gltf::Instanced => export::Layout::Instanced,
    }
}
