//! Runs a scene: the part that touches disk, clock, threads and signals. Everything it calls is pure.

pub mod destination;
pub mod fault;
pub mod files;
pub mod frame_list;
mod leaf_area;
pub mod manifest;
pub mod memory;
mod picture_inset;
mod preparation;
pub mod progress;
pub mod signals;
mod states_file;
pub mod stopwatch;
pub mod verify;
mod wardrobe;

use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::figures::Figures;
use crate::base::limits::{Limit, Limits};
use crate::base::picture::Picture;
use crate::compose::{Garment, Stock};
use crate::export;
use crate::frame::Frame;
use crate::plan::{self, LeftOut, Plan, PlannedFrame, Reason};
use crate::raster;
use crate::report::{FrameReport, Report};
use crate::scene::{Scene, output::Gltf};
use crate::season::LeafStates;
use frame_list::{FrameList, Shard};
use manifest::{Key, Manifest};
use preparation::Prepared;
use progress::{Event, Progress};
use signals::Signals;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;
use stopwatch::timed;

/// How a scene is run; decides no byte of an output.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where the files go.
    pub out: PathBuf,
    /// The frames asked for; all when absent.
    pub frames: Option<FrameList>,
    /// The part of them that is this process's.
    pub shard: Option<Shard>,
    /// Whether other frames go on when one fails.
    pub keep_going: bool,
    /// Whether finished frames are drawn anew.
    pub force: bool,
    /// Where every leaf's state is written.
    pub states: Option<PathBuf>,
    /// The limits in force.
    pub limits: Limits,
    /// Whether what a scene does not need is left out; off only in tests.
    pub leave_out: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            out: PathBuf::from("out"),
            frames: None,
            shard: None,
            keep_going: false,
            force: false,
            states: None,
            limits: Limits::default(),
            leave_out: true,
        }
    }
}

/// How a run ended.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The report, also of an interrupted run.
    pub report: Report,
    /// Frames that failed, with the reason (only with `keep_going`).
    pub failed: Vec<(i64, Diagnostics)>,
    /// Whether a signal ended it.
    pub interrupted: bool,
}

/// Prints what would be done, without doing it: grows the tree, counts leaves, opens every picture.
///
/// # Errors
/// Faults of the scene, its files or limits.
pub fn plan(scene: &Scene, options: &Options) -> Result<Plan, Diagnostics> {
    let frames = asked(scene, options)?;
    let mut report = Report::default();
    for asset in scene.assets.values() {
        crate::scene::read_picture(asset, &options.limits)?;
    }
    Ok(preparation::prepare(scene, &frames, &options.limits, options.leave_out, &|| false, &mut report)?.plan)
}

/// Renders the frames that are asked for and not finished yet.
///
/// # Errors
/// The first fault; with `keep_going` only what stops every frame.
pub fn render(
    scene: &Scene,
    options: &Options,
    progress: &mut Progress,
    signals: &Signals,
) -> Result<Outcome, Diagnostics> {
    let start = Instant::now();
    let frames = asked(scene, options)?;
    destination::check(scene, &options.out, options.states.as_deref())?;
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        scene: scene.name.clone(),
        threads: rayon::current_num_threads() as u64,
        ..Report::default()
    };
    let names = Names::new(scene);
    let scene_hash = manifest::hash(scene.resolved().to_string().as_bytes());
    let key = |frame: i64| Key { build: manifest::BUILD.to_owned(), scene: scene_hash.clone(), frame };
    let kept = |&frame: &i64| {
        !options.force && manifest::is_done(&options.out, &scene.name, names.frames, &key(frame), &names.all(frame))
    };
    let (kept, to_do): (Vec<i64>, Vec<i64>) = frames.iter().copied().partition(kept);
    progress.tell(Event::Started { frames: frames.len() as u64 });
    let prepared =
        preparation::prepare(scene, &to_do, &options.limits, options.leave_out, &|| signals.came(), &mut report)?;
    report.left_out.clone_from(&prepared.plan.left_out);
    report.left_out.extend(
        kept.iter().map(|frame| LeftOut { what: format!("raster frame {frame}"), reason: Reason::AlreadyDone }),
    );
    let mut run = Run { scene, options, prepared, names, report, states_text: states_file::HEADER.to_owned() };
    for frame in kept {
        run.count_kept(frame);
        progress.tell(Event::Kept { frame });
    }
    let mut outcome = Outcome::default();
    if !to_do.is_empty() {
        run.draw_all(progress, signals, &key, &mut outcome)?;
    }
    if let Some(path) = options.states.as_ref().filter(|_| !outcome.interrupted) {
        files::write(path, run.states_text.as_bytes()).map_err(|error| fault::written(&error))?;
    }
    run.report.frames.sort_by_key(|frame| frame.index);
    run.report.seconds = start.elapsed().as_secs_f64();
    run.report.peak_memory_bytes = stopwatch::peak_memory();
    outcome.report = run.report;
    Ok(outcome)
}

/// The frames of a run, in order.
fn asked(scene: &Scene, options: &Options) -> Result<Vec<i64>, Diagnostics> {
    let count = scene.time.count();
    options
        .limits
        .allow(Limit::Frames, "the scene", count)
        .map_err(|refusal| fault::refused(scene, "time", &refusal))?;
    let list = options.frames.clone().unwrap_or_else(|| FrameList::whole(count as u64));
    if let Some(frame) = list.beyond(count as u64) {
        let what = format!("frame {frame} is asked for, but the scene has frames 0 to {}", count - 1.0);
        return Err(Diagnostic::error(Fault::Usage, what, "name frames of the scene with --frames").into());
    }
    let frames = list.frames(&options.limits).map_err(|error| fault::frame_list(&error))?;
    let single_before_start = scene.time.is_single() && frames.iter().any(|&frame| frame < 0);
    if single_before_start {
        let what = "negative frames lie before `time.from`, which this scene does not have";
        return Err(Diagnostic::error(Fault::Usage, what, "give time.from, time.to and time.step").into());
    }
    Ok(options.shard.map_or(frames.clone(), |shard| shard.take(&frames)))
}

/// The names of a scene's files.
struct Names {
    scene: String,
    frames: u64,
    png: bool,
    gltf: bool,
}

impl Names {
    fn new(scene: &Scene) -> Self {
        let frames = scene.time.count() as u64;
        Self { scene: scene.name.clone(), frames, png: scene.output.png, gltf: scene.output.gltf.is_some() }
    }

    fn png(&self, frame: i64) -> Option<String> {
        self.png.then(|| format!("{}.png", files::stem(&self.scene, frame, self.frames)))
    }

    fn gltf(&self, frame: i64) -> Option<String> {
        self.gltf.then(|| format!("{}.glb", files::stem(&self.scene, frame, self.frames)))
    }

    fn all(&self, frame: i64) -> Vec<String> {
        self.png(frame).into_iter().chain(self.gltf(frame)).collect()
    }
}

/// The files of a frame, by name.
type FrameFiles = Vec<(String, Vec<u8>)>;

struct Run<'a> {
    scene: &'a Scene,
    options: &'a Options,
    prepared: Prepared,
    names: Names,
    report: Report,
    states_text: String,
}

impl Run<'_> {
    fn draw_all(
        &mut self,
        progress: &mut Progress,
        signals: &Signals,
        key: &dyn Fn(i64) -> Key,
        outcome: &mut Outcome,
    ) -> Result<(), Diagnostics> {
        if signals.came() {
            outcome.interrupted = true;
            return Ok(());
        }
        let limits = &self.options.limits;
        let wardrobe = wardrobe::wardrobe(self.scene, &self.prepared, limits, &mut self.report)?;
        if signals.came() {
            outcome.interrupted = true;
            return Ok(());
        }
        let stock = self.prepared.plan.has("compose").then(|| {
            let start = Instant::now();
            let stock = Stock::new(self.scene, &self.prepared.tree, &wardrobe);
            self.report.spend("compose", start.elapsed().as_secs_f64());
            stock
        });
        self.make_folder()?;
        files::clean(&self.options.out);
        // Pictures that later frames repeat are kept until the last of them.
        let mut drawn: BTreeMap<i64, FrameFiles> = BTreeMap::new();
        let frames = self.prepared.plan.frames.clone();
        let last_use: BTreeMap<i64, i64> = frames.iter().filter_map(|f| Some((f.same_as?, f.index))).collect();
        for planned in frames {
            if signals.came() {
                outcome.interrupted = true;
                break;
            }
            match self.draw(planned, stock.as_ref(), &drawn, key) {
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
        stock: Option<&Stock>,
        drawn: &BTreeMap<i64, FrameFiles>,
        key: &dyn Fn(i64) -> Key,
    ) -> Result<FrameFiles, Diagnostics> {
        let start = Instant::now();
        let index = planned.index;
        let states = self.states(index);
        let earlier = planned.same_as.and_then(|earlier| drawn.get(&earlier));
        let files: FrameFiles = match (earlier, stock) {
            (Some(files), _) => {
                let names = self.names.all(index);
                names.into_iter().zip(files).map(|(name, (_, bytes))| (name, bytes.clone())).collect()
            }
            (None, Some(stock)) => {
                let worn = self.worn(states.as_ref());
                self.made(index, stock, &worn)?
            }
            (None, None) => Vec::new(),
        };
        for (name, bytes) in &files {
            files::write(&self.options.out.join(name), bytes).map_err(|error| fault::written(&error))?;
        }
        let listed: Vec<(String, &[u8])> = files.iter().map(|(name, bytes)| (name.clone(), bytes.as_slice())).collect();
        let manifest = Manifest::new(&self.names.scene, self.names.frames, key(index), &listed);
        manifest.write(&self.options.out).map_err(|error| fault::written(&error))?;
        self.note(index, states.as_ref(), start.elapsed().as_secs_f64());
        Ok(files)
    }

    fn made(&mut self, index: i64, stock: &Stock, worn: &[Option<Garment>]) -> Result<FrameFiles, Diagnostics> {
        let (scene, tree) = (self.scene, &self.prepared.tree);
        let frame = timed(&mut self.report, "compose", || {
            let frame = stock.frame(scene, tree, worn);
            let instances = frame.instances.len() as u64;
            Ok::<_, Diagnostics>((frame, Figures::of(instances)))
        })?;
        let mut files = Vec::new();
        if let Some(name) = self.names.png(index) {
            let picture = self.rasterised(&frame, worn, stock)?;
            let bytes = timed(&mut self.report, "png", || {
                let bytes = export::png(&picture).map_err(|error| fault::export(&error))?;
                let figures = Figures::of(1).with("bytes", bytes.len());
                Ok::<_, Diagnostics>((bytes, figures))
            })?;
            files.push((name, bytes));
        }
        if let (Some(name), Some(layout)) = (self.names.gltf(index), self.scene.output.gltf) {
            let layout = match layout {
                Gltf::Nodes => export::Layout::Nodes,
                Gltf::Merged => export::Layout::Merged,
                Gltf::Instanced => export::Layout::Instanced,
            };
            let bytes = timed(&mut self.report, "gltf", || export::glb(&frame, layout));
            files.push((name, bytes.map_err(|error| fault::export(&error))?));
        }
        Ok(files)
    }

    fn rasterised(&mut self, frame: &Frame, worn: &[Option<Garment>], stock: &Stock) -> Result<Picture, Diagnostics> {
        let inset = self.scene.output.inset.then(|| stock.inset(worn, frame)).flatten();
        timed(&mut self.report, "raster", || {
            let before = stopwatch::processor_seconds();
            let (mut picture, figures) = raster::draw(frame);
            if let Some(inset) = &inset {
                picture_inset::place(&mut picture, &raster::draw(inset).0);
            }
            Ok((picture, figures.with("cpu_seconds", stopwatch::processor_seconds() - before)))
        })
    }

    fn states(&mut self, index: i64) -> Option<LeafStates> {
        let has_season = !self.prepared.states.is_empty();
        has_season.then(|| preparation::assigned(self.scene, &self.prepared.leaf_ids, index, &mut self.report))
    }

    fn worn(&self, states: Option<&LeafStates>) -> Vec<Option<Garment>> {
        states.map_or_else(Vec::new, |states| plan::garments(self.scene, &self.prepared.leaf_ids, states))
    }

    fn count_kept(&mut self, index: i64) {
        let states = self.states(index);
        self.note(index, states.as_ref(), 0.0);
    }

    /// Adds a frame to the report and to the file of states.
    fn note(&mut self, index: i64, states: Option<&LeafStates>, seconds: f64) {
        let day = self.scene.time.at(index);
        let mut frame = FrameReport {
            index,
            day,
            date: None,
            leaves: self.prepared.leaf_ids.len() as u64,
            states: BTreeMap::new(),
            expected: BTreeMap::new(),
            fallen: 0,
            png: self.names.png(index),
            gltf: self.names.gltf(index),
            seconds,
        };
        if let Some(states) = states {
            for (number, name) in states.names.iter().enumerate() {
                let count = states.states.iter().filter(|&&state| usize::from(state) == number).count() as u64;
                frame.states.insert(name.clone(), count);
                frame.expected.insert(name.clone(), states.expected[number]);
            }
            frame.fallen = frame.states.get(plan::FALLEN).copied().unwrap_or(0);
            if self.options.states.is_some() {
                states_file::append(&mut self.states_text, index, day, &self.prepared.leaf_ids, states);
            }
        }
        self.report.frames.push(frame);
    }
}

/// Writes the report as JSON.
///
/// # Errors
/// When the file cannot be written.
pub fn write_report(path: &Path, report: &Report) -> Result<(), Diagnostics> {
    let mut text = serde_json::to_vec_pretty(report)
        .map_err(|error| Diagnostic::error(Fault::Bug, format!("the report cannot be written: {error}"), ""))?;
    text.push(b'\n');
    files::write(path, &text).map_err(|error| fault::written(&error))
}
